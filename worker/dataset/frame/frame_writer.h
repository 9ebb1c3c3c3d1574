// Writes a stereo pair to its folder, with the names and encodings of the dataset format.
#pragma once

#include <string>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/jobs.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/render/camera/stereo_frame.h"

namespace parallax {

// A frame to be written.
struct FrameJob {
  const v1::Scene& scene;
  const v1::Rig& rig;  // A rig of `scene`.
  const StereoFrame& frame;
  const v1::RenderConfig& render;  // `maps`: which maps are written beside the images.
  std::string dir;                 // Absolute; made anew: files of an earlier try are removed.
  std::string store_path;          // FrameResult.path.
  CancelToken cancel;
};

// Encodes in parallel, then writes and fsyncs every file and the folder; frame.json last. The
// result's files are sorted by name and carry size and SHA-256. Equal inputs give equal bytes of
// every file. stage_s gets trace, denoise, truth, statistics and write (seconds). Errors:
// kInvalidArgument when a map's size is not the rig's; kCancelled; writing as WriteFile. After an
// error the folder may hold some of the files.
absl::StatusOr<v1::FrameResult> WriteFrame(const FrameJob& job);

}  // namespace parallax
