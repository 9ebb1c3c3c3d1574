// The whole job `render`: builds the scene once, renders its rigs, writes each frame's folder, and
// returns what was written.
#pragma once

#include <functional>
#include <string>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "parallax/v1/jobs.pb.h"
#include "worker/render/renderer.h"

namespace parallax {

struct RenderJobContext {
  std::string attempt_dir;   // Absolute local folder of this attempt; made by the callee, files and
                             // folders fsynced.
  std::string attempt_path;  // The same folder's path in the store: prefix of FrameResult.path.
  CancelToken cancel;
  ProgressFn progress;
  // If set, called for each frame as soon as its files are on disk, one call at a time, on another
  // thread. A frame that is being written when the job is cancelled is then finished.
  std::function<void(const v1::FrameResult&)> finished;
};

// Runs the job. Errors: kCancelled; kResourceExhausted (disk full, memory); kPermissionDenied;
// kInvalidArgument for a broken recipe; kNotFound and kDataLoss for a user's picture that is gone
// or has changed.
absl::StatusOr<v1::RenderResult> RunRenderJob(const v1::RenderJob& job,
                                              const RenderJobContext& context);

}  // namespace parallax
