// A worker's report, checked and packed before it reaches the writing thread: what can be judged
// without the job's row, and all hashing and compressing, happens here in the caller's thread.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "coordinator/queue/job_kind.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

struct CheckedReport {
  v1::AttemptId attempt;
  std::string worker;
  std::optional<KindId> kind;  // Empty: a kind that there isn't; `invalid` says so.
  std::shared_ptr<const CheckedResult> result;
  std::string invalid;  // Not empty: why no job can have this result.
};
CheckedReport CheckReport(const v1::CompleteRequest& request, const KindRegistry& kinds);

// True for a relative, normal path: no empty part, ".", "..", backslash or control character.
bool IsConfinedPath(std::string_view path);

bool IsSha256Hex(std::string_view text);

// Cleans and cuts a worker's message: at most 1,000 bytes, control characters as spaces.
std::string OneLine(std::string_view text);

// The last lines of a program's output, at most kMaxLogTail bytes: whole lines as far as they fit,
// with everything but line ends and tabs that a terminal could take for a command escaped.
inline constexpr size_t kMaxLogTail = 16'000;
std::string LogTail(std::string_view text);

}  // namespace parallax
