#include "worker/agent/attempts/job_run.h"

#include <exception>
#include <filesystem>
#include <new>

#include "common/store/store.h"
#include "worker/agent/attempts/upload.h"

namespace parallax {
namespace {

// Leaves room for the envelope below the message limit of 64 MiB.
constexpr size_t kMaxResultBytes = (64u << 20) - (64u << 10);

absl::Status TooLarge(size_t bytes) {
  return OutOfRange("result of {} bytes does not fit into a message", bytes);
}

}  // namespace

absl::StatusOr<JobOutcome> RunJob(JobHandler* handler, const v1::Lease& lease,
                                  const AttemptFolder& folder, const CancelToken& cancel,
                                  const JobProgressFn& progress) {
  if (handler == nullptr) {
    return Unimplemented("a job of a kind that this worker does not know");
  }
  try {
    ASSIGN_OR_RETURN(JobOutcome outcome, handler->Run(lease.spec(), folder, cancel, progress));
    if (outcome.result.size() > kMaxResultBytes) return TooLarge(outcome.result.size());
    if (folder.send_to != nullptr) {
      progress(1, "send");
      RETURN_IF_ERROR(UploadFiles(*folder.send_to, folder.dir, folder.path, outcome.files, cancel));
    }
    return outcome;
  } catch (const std::bad_alloc&) {
    return ResourceExhausted("out of memory");
  } catch (const std::exception& error) {
    return Internal("exception: {}", error.what());
  } catch (...) {
    return Internal("exception of unknown type");
  }
}

void CleanUpAfter(const JobHandler* handler, const AttemptFolder& folder, bool kept) {
  std::error_code ignored;
  if (!folder.scratch.empty()) std::filesystem::remove_all(folder.scratch, ignored);
  if (folder.dir.empty()) return;
  const bool staged = folder.send_to != nullptr;
  const bool goes_on = !kept && handler != nullptr && handler->resumes();
  if (staged || (!kept && !goes_on)) std::filesystem::remove_all(folder.dir, ignored);
  // Best effort: the coordinator's janitor removes the rest later.
  if (staged && !kept && !goes_on) folder.send_to->RemoveTree(folder.path).IgnoreError();
}

}  // namespace parallax
