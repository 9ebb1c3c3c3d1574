// A worker's report, checked and packed before it reaches the writing thread: what can be judged
// without the job's row, and all hashing and compressing, happens here in the caller's thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/hash.h"
#include "coordinator/queue/job_state.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

struct CheckedFrame {
  uint32_t rig = 0;
  std::string path;
  std::string frame_z;
};

struct CheckedReport {
  v1::AttemptId attempt;
  std::string worker;
  std::string invalid;  // Not empty: why no job can have this result.
  WorkKind kind = WorkKind::kSolve;
  // Solve.
  bool rejected = false;
  std::string reject_reason;
  Sha256Digest scene_hash{};
  std::string scene_z;
  uint64_t scene_seed = 0;
  uint32_t scene_rigs = 0;
  std::string layout_z;  // Empty: the report has no layout.
  // Render, by ascending rig.
  std::vector<CheckedFrame> frames;
};
CheckedReport CheckReport(const v1::CompleteRequest& request);

// True for a relative, normal path: no empty part, ".", "..", backslash or control character.
bool IsConfinedPath(std::string_view path);

}  // namespace parallax
