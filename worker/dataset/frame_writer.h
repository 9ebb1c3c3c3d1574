// A stereo pair in memory -> its folder on disk, exactly as dataset-format names and encodes it.
#pragma once

#include <string>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/jobs.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/render/stereo_frame.h"

namespace parallax {

struct FrameJob {
  const v1::Scene& scene;
  const v1::Rig& rig;  // A rig of `scene`.
  const StereoFrame& frame;
  const v1::RenderConfig& render;  // `maps`: which maps are written beside the images.
  std::string dir;         // Absolute; made anew: what an earlier try left there is removed.
  std::string store_path;  // FrameResult.path.
  CancelToken cancel;
};

// Encodes in parallel, writes and fsyncs every file and the folder; frame.json last. The result's
// files are sorted by name and carry size and SHA-256. Equal inputs give equal bytes of every file.
// stage_s gets trace, denoise, truth, statistics and write (seconds). Errors: kInvalidArgument when
// the frame's maps do not have the rig's size; kCancelled; writing as WriteFile. After an error the
// folder may hold some of the files.
absl::StatusOr<v1::FrameResult> WriteFrame(const FrameJob& job);

}  // namespace parallax
