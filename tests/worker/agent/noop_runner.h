// Jobs without work: a solve gives a scene of as many rigs as asked for, a render small files for
// each pair. Equal jobs give equal bytes.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "common/base/hash.h"
#include "common/base/status.h"
#include "common/config/frame_files.h"
#include "test_runner.h"

namespace parallax {

class NoopRunner : public TestRunner {
 public:
  absl::StatusOr<v1::SolveResult> Solve(const v1::SolveJob& job, const CancelToken& cancel,
                                        const JobProgressFn& progress) override {
    progress(0.5, "noop");
    if (cancel.cancelled()) return Cancelled("cancelled");
    v1::SolveResult result;
    v1::Scene& scene = *result.mutable_scene();
    scene.set_scene_seed(job.scene_seed());
    const int rigs = job.config().rigs().has_count() ? job.config().rigs().count() : 20;
    for (int i = 0; i < rigs; ++i) scene.add_rigs()->set_index(static_cast<uint32_t>(i));
    if (!job.has_layout())
      result.mutable_layout()->mutable_place()->mutable_house()->add_rooms()->set_kind("office");
    return result;
  }

  absl::StatusOr<v1::RenderResult> Render(const v1::RenderJob& job, const AttemptFolder& folder,
                                          const CancelToken& cancel,
                                          const JobProgressFn& progress) override {
    v1::RenderResult result;
    for (int i = 0; i < job.rigs_size(); ++i) {
      if (cancel.cancelled()) return Cancelled("cancelled");
      char rig[8];
      std::snprintf(rig, sizeof rig, "%03u", job.rigs(i));
      const std::string pixels =
          "seed " + std::to_string(job.scene().scene_seed()) + " rig " + rig + "\n";
      std::filesystem::create_directories(folder.dir + "/" + rig);
      v1::FrameResult& frame = *result.add_frames();
      frame.set_rig(job.rigs(i));
      (*frame.mutable_statistics())["mean_intensity"] = 100;  // It passes the filters.
      (*frame.mutable_statistics())["min_depth_m"] = 1;
      frame.set_path(folder.path + "/" + rig);
      for (const std::string& name : FrameFileNames(job.render())) {
        std::ofstream(folder.dir + "/" + rig + "/" + name) << pixels;
        v1::FileEntry& file = *frame.add_files();
        file.set_name(name);
        file.set_size(static_cast<int64_t>(pixels.size()));
        file.set_sha256(Sha256Hex(pixels));
      }
      progress(static_cast<double>(i + 1) / job.rigs_size(), "noop");
    }
    return result;
  }
};

}  // namespace parallax
