#include "worker/agent/attempts/job_run.h"

#include <exception>
#include <filesystem>
#include <new>

#include "common/store/store.h"
#include "worker/agent/attempts/patient_store.h"

namespace parallax {
namespace {

// Leaves room for the envelope below the message limit of 64 MiB.
constexpr size_t kMaxResultBytes = (64u << 20) - (64u << 10);

absl::Status TooLarge(size_t bytes) {
  return OutOfRange("result of {} bytes does not fit into a message", bytes);
}

absl::Status SendFiles(const AttemptFolder& folder, const std::vector<OutputFile>& files,
                       const CancelToken& cancel) {
  for (const OutputFile& file : files) {
    if (file.sent) continue;
    if (cancel.cancelled()) return Cancelled("while its files were sent");
    const std::string path = folder.path + "/" + file.name;
    const absl::Status status = folder.send_to->PutFile(
        path, folder.dir + "/" + file.name, {file.size, file.sha256}, /*may_move=*/false);
    if (!status.ok()) return WithContext(status, "send " + path);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<JobOutcome> RunJob(JobHandler* handler, const v1::Lease& lease,
                                  const AttemptFolder& given, const CancelToken& cancel,
                                  const JobProgressFn& progress) {
  if (handler == nullptr) {
    return Unimplemented("a job of a kind that this worker does not know");
  }
  const auto alive = [&progress] { progress.Alive(); };
  AttemptFolder folder = given;
  folder.store = MakePatientStore(given.store, cancel, alive);
  folder.send_to = MakePatientStore(given.send_to, cancel, alive);
  try {
    ASSIGN_OR_RETURN(JobOutcome outcome, handler->Run(lease.spec(), folder, cancel, progress));
    if (outcome.result.size() > kMaxResultBytes) return TooLarge(outcome.result.size());
    if (folder.send_to != nullptr) {
      progress(1, "send");
      RETURN_IF_ERROR(SendFiles(folder, outcome.files, cancel));
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
