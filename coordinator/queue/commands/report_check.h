// Checks and packs a worker's report before it reaches the writing thread. All checks that don't
// need the job's row, and all hashing and compressing, run here, in the caller's thread. Pure
// functions.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "coordinator/queue/job_kind.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

// A worker's report of a result, checked and packed for the database.
struct CheckedReport {
  v1::AttemptId attempt;
  std::string worker;
  std::optional<KindId> kind;  // Absent for an unknown kind; `invalid` then says so.
  std::shared_ptr<const CheckedResult> result;
  std::string invalid;  // Not empty: why no job can have this result.
  // `invalid` is of the files in the store: that may be a disk's fault, and not the job's.
  bool of_store = false;
};
// Checks and packs a report by the rules of its kind.
CheckedReport CheckReport(const v1::CompleteRequest& request, const KindRegistry& kinds);

// Returns whether a path is relative and normal: no empty part, ".", "..", backslash or control
// character.
bool IsConfinedPath(std::string_view path);

// Returns whether a text is a SHA-256 as 64 lower-case hex characters.
bool IsSha256Hex(std::string_view text);

// Returns a worker's message as one line of UTF-8 with at most 1,000 bytes; control characters
// become spaces.
std::string OneLine(std::string_view text);

// Returns the last whole lines of a program's output that fit in kMaxLogTail bytes. Escapes
// everything that a terminal could take for a command, except line ends and tabs.
inline constexpr size_t kMaxLogTail = 16'000;
std::string LogTail(std::string_view text);

}  // namespace parallax
