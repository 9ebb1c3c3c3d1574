// Compares right images, warped by the left disparity, with left images outside of occlusions.
//   warp_check DIR...
// Prints one JSON line a frame (8-bit steps) and one for all.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "common/base/status.h"
#include "worker/dataset/frame/frame_reader.h"
#include "worker/dataset/frame/frame_statistics.h"
#include "worker/dataset/sheets/contact_sheet.h"

namespace parallax {
namespace {

absl::Status Run(const std::vector<std::string>& dirs) {
  std::vector<double> medians;
  for (const std::string& dir : dirs) {
    ASSIGN_OR_RETURN(const std::vector<std::string> frames, FindFrames(dir));
    for (const std::string& path : frames) {
      ASSIGN_OR_RETURN(const FrameOnDisk frame, ReadFrame(path));
      const WarpDifference warp =
          WarpCheck(frame.left, frame.right, frame.left_disparity_px, frame.left_occlusion);
      std::cout << nlohmann::ordered_json{{"frame", path},
                                          {"median", warp.median},
                                          {"mean", warp.mean},
                                          {"p90", warp.p90},
                                          {"pixels", warp.pixels}}
                       .dump()
                << "\n";
      medians.push_back(warp.median);
    }
  }
  if (medians.empty()) return NotFound("no frame found");
  std::sort(medians.begin(), medians.end());
  std::cout << nlohmann::ordered_json{{"bench", "warp_check"},
                                      {"frames", medians.size()},
                                      {"median_of_medians", medians[medians.size() / 2]},
                                      {"worst_median", medians.back()}}
                   .dump()
            << "\n";
  return absl::OkStatus();
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  CLI::App app("Warps right images onto left ones and prints the difference");
  std::vector<std::string> dirs;
  app.add_option("dir", dirs, "Datasets or folders of frames")->required();
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = parallax::Run(dirs);
  if (!status.ok()) std::cerr << status << "\n";
  return status.ok() ? 0 : 1;
}
