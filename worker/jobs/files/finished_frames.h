// Records of the frames that an attempt at a render job has finished, so that the next attempt can
// take them over: a killed worker loses only the pair at hand, not its whole job. The records stay
// when the job is done; the coordinator removes them once it has the result.
//
//   <attempt's folder>/003/...           the frame, whole and durable
//                      finished/003.pb   its FrameResult, written after that
//
// Not thread-safe.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "parallax/v1/jobs.pb.h"
#include "worker/agent/attempts/job_handler.h"

namespace parallax {

// The records of one attempt.
class FinishedFrames {
 public:
  // `folder` must outlive the object.
  explicit FinishedFrames(const AttemptFolder& folder) : folder_(folder) {}

  // Records a frame whose files are on disk below the attempt's folder; sends a frame in a staging
  // folder to the store first. Best effort: without its record, other attempts render the frame
  // again.
  void Note(const v1::FrameResult& frame);

  // Takes over the frames of `job` that earlier attempts recorded: links or copies them into this
  // attempt's folder and records them. Frames that lack one of the job's files, or whose hashes
  // differ, are ignored. Returns them by rig, as frames of this attempt. Errors: kCancelled; making
  // the folder.
  absl::StatusOr<std::vector<v1::FrameResult>> TakeOver(const v1::RenderJob& job,
                                                        const CancelToken& cancel);

  // Returns whether the frame is in the store already, although the folder is a staging folder.
  bool IsSent(uint32_t rig) const { return sent_.count(rig) > 0; }

  // Removes unrecorded files of an attempt that ends without result. Best effort.
  void RemoveUnfinished();

 private:
  absl::Status SendAndNote(const v1::FrameResult& frame);
  absl::StatusOr<v1::FrameResult> TakeOverFrom(const std::string& earlier, uint32_t rig,
                                               const v1::RenderConfig& render);

  const AttemptFolder& folder_;
  std::set<uint32_t> noted_;
  std::set<uint32_t> sent_;
};

}  // namespace parallax
