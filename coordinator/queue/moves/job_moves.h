// Jobs come, move and end; what each of that means for followers, waiters, scenes and counters. All
// consequences of a move happen in the same call: followers are released, jobs that a success makes
// possible are inserted, lost scenes are noted as missing, counters are kept. No kind of job is
// named here: the KindRegistry knows the differences.
//
// Sharing of work. At most one attempt at a time does a given piece of work, or makes a group's
// part. When a job is leased, READY jobs that need the same become BLOCKED on it. When the lease
// ends, for whatever reason, each of them is settled again: done if there is a result, BLOCKED on
// another job that computes it, else READY. So such a BLOCKED job always awaits a LEASED one, and
// can't be stuck behind a paused study, a back-off or a worker that never comes.
//
// Used by the writing thread only. Errors of all functions: those of the database; kInternal for a
// job that is not there.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/base/status.h"
#include "coordinator/queue/tables/queue_tables.h"

namespace parallax {

class Waiters;

// The state in which a job without a lease belongs.
struct JobStanding {
  JobState state = JobState::kReady;
  bool part_missing = false;  // Its group's part does not exist yet.
  int64_t awaits_job = 0;
  std::string result;    // Set with kSucceeded; see KnownWork.
  std::string rejected;  // Set with kRejected: the reason.
};

// Returns the folder of the job's newest attempt in the store.
std::string AttemptFolder(const JobRow& job);

class JobMoves final : private WorkDesk {
 public:
  // Both arguments must outlive the object.
  JobMoves(Tables& tables, Waiters& waiters) : tables_(tables), waiters_(waiters) {}

  // Returns the desk for hooks of kinds: the reads and changes of tables that they may make.
  WorkDesk& desk() { return *this; }

  absl::StatusOr<int64_t> AddJob(const NewJob& asked) override;
  // Returns the next generation of a job, without its rigs and waits.
  NewJob NextOf(const JobRow& job) const;
  // Moves a job without a lease to the state where it belongs. `waits_met`: its waits are over.
  absl::Status Settle(int64_t job, bool waits_met = false);
  // Gives a job without a lease the keys that its work has by now: an upgrade changes them, also
  // those of what it has waited for. Returns whether they were others; then it must be settled.
  absl::StatusOr<bool> TakeNewKeys(JobRow& job);
  // Settles the jobs that are BLOCKED on a job whose lease has ended.
  absl::Status ReleaseFollowers(int64_t leader);
  // Blocks READY jobs on a job that is leased now.
  absl::Status BlockSiblings(const JobRow& leader, bool whole_group);
  // Returns BLOCKED if a leased job computes what this one needs, else READY.
  absl::StatusOr<JobStanding> StandingAmongLeased(const JobRow& job, bool whole_group);

  // Carry out the consequences of a job that has succeeded or was lost. Its row is written already.
  absl::Status EnterSuccess(const JobRow& job, Variant& variant, const Ending& ending,
                            bool by_own_attempt);
  absl::Status EnterLoss(const JobRow& job, Variant& variant, JobState state);
  // Cancels the unfinished jobs of a variant, or of the whole study if `variant` is 0.
  absl::Status CancelAll(int64_t study, int64_t variant, const std::string& reason,
                         bool only_of_scenes = false);
  absl::Status Cancel(const JobRow& job, const std::string& reason);
  // Makes litter of the folder of an attempt that will not win, or keeps it if later attempts may
  // continue from it.
  absl::Status Litter(const JobRow& job);

 private:
  const StageVersions& versions() const override { return tables_.options.versions; }
  absl::StatusOr<VariantFacts> VariantOf(int64_t variant) override;
  absl::StatusOr<SceneFacts> SceneOf(int64_t variant, uint32_t ordinal) override;
  absl::StatusOr<JobFacts> NewestOf(int64_t job) override;
  absl::StatusOr<std::optional<StoredResult>> FindResult(const Sha256Digest& key) override;
  absl::StatusOr<bool> HasResult(const Sha256Digest& key) override;
  absl::StatusOr<bool> PutResult(const JobFacts& by, std::string_view stage,
                                 const Sha256Digest& key, const StoredResult& result) override;
  absl::Status SetScene(const JobFacts& job, const Sha256Digest& scene_hash) override;
  absl::Status Publish(const JobFacts& job, std::span<const FrameLink> frames) override;
  absl::Status Discard(std::string_view path) override;
  // Returns whether the files of a stored result are there. If not, it is taken back at the end of
  // the command.
  bool FilesAreThere(const Sha256Digest& key, std::string_view stage, std::string_view bytes);

  absl::StatusOr<JobStanding> StandingOf(const JobRow& job);
  // Ends the variant if it has no prospect. `job` was lost or rejected last and says why.
  absl::Status GiveUpIfHopeless(Variant& variant, int64_t job);

  Tables& tables_;
  Waiters& waiters_;
};

}  // namespace parallax
