// Time and size of each map's encoding on the maps of a real frame.
//   bench_image_io FRAME_DIR
#include <iostream>
#include <nlohmann/json.hpp>

#include "common/base/seconds.h"
#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "common/image/io.h"
#include "worker/dataset/frame/frame_reader.h"

namespace parallax {
namespace {

void Report(const std::string& name, const auto& encode) {
  constexpr int kRounds = 5;
  double best = 1e9;
  size_t size = 0;
  for (int i = 0; i < kRounds; ++i) {
    const SteadyTime begin = Clock::System().Steady();
    const absl::StatusOr<std::string> bytes = encode();
    const double seconds = SecondsSince(begin);
    best = std::min(best, seconds);
    size = bytes.ok() ? bytes->size() : 0;
  }
  std::cout << nlohmann::ordered_json{{"bench", "image_io"},
                                      {"map", name},
                                      {"seconds", best},
                                      {"bytes", size}}
                   .dump()
            << "\n";
}

absl::Status Run(const std::string& dir) {
  ASSIGN_OR_RETURN(const FrameOnDisk frame, ReadFrame(dir));
  ASSIGN_OR_RETURN(const ImageF depth, ReadExrY(dir + "/depth_left.exr"));
  for (const int level : {1, 2, 3}) {
    const std::string suffix = " level " + std::to_string(level);
    Report("color" + suffix, [&] { return EncodePng(frame.left, level); });
    Report("objects" + suffix, [&] { return EncodePng(frame.left_objects, level); });
    Report("occlusion" + suffix, [&] { return EncodePng(frame.left_occlusion, level); });
  }
  Report("depth", [&] { return EncodeExrY(depth); });
  Report("disparity", [&] { return EncodeExrY(frame.left_disparity_px); });
  Report("normals", [&] { return EncodeExrHalfRgb(frame.left_normals); });
  return absl::OkStatus();
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  const absl::Status status =
      argc == 2 ? parallax::Run(argv[1]) : InvalidArgument("usage: bench_image_io FRAME_DIR");
  if (!status.ok()) std::cerr << status << "\n";
  return status.ok() ? 0 : 1;
}
