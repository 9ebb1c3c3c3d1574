// Studies and variants in memory, with their counters. Commands change the counters here. The
// changes of a group of commands are written once, before its COMMIT, so a thousand completions in
// a variant cost one UPDATE. The changes of a failed command are undone. The database has the
// truth: after a failed group, everything is dropped and read again on demand.
//
// Used by the writing thread only.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "common/config/check/limit_rules.h"
#include "coordinator/queue/database/sqlite.h"
#include "coordinator/queue/job_kind.h"
#include "coordinator/study/keys.h"
#include "parallax/v1/study.pb.h"

namespace parallax {

// Numbers of jobs by kind's id and state. Counts of unused ids stay 0.
using JobCounts = std::array<std::array<int64_t, kJobStates>, kMostKinds>;

// The part of a variant that changes.
struct VariantTally {
  JobCounts jobs{};
  int64_t next_ordinal = 0;
  int64_t pairs_planned = 0;
  int64_t pairs_done = 0;
  int64_t scenes_open = 0;
  int64_t solves_reused = 0;
  int64_t layouts_reused = 0;
  int64_t frames_reused = 0;
  int64_t scenes_rejected = 0;
  int64_t tally_solved = 0;
  int64_t tally_rejected = 0;
  int64_t tally_lost = 0;
  // Pairs of before the last retry. Not stored: after a restart all pairs count as new again.
  int64_t pairs_before = 0;
  int64_t others_lost = 0;  // Jobs without a scene whose newest generation ended without a result.
  std::string problem;

  // Returns the number of jobs that have not ended.
  int64_t OpenJobs() const;
};
struct Variant {
  int64_t id = 0;
  int64_t study = 0;
  std::string name;
  uint64_t seed = 0;
  int64_t pairs_wanted = 0;
  uint32_t rigs_per_scene = 1;
  std::shared_ptr<const v1::SceneConfig> config;
  ConfigDigests digests;
  VariantTally tally;
};

// The sums over all studies of one user.
struct UserShare {
  UserLimits limits;
  int64_t running = 0;  // LEASED jobs.

  bool IsFull() const { return limits.max_running > 0 && running >= limits.max_running; }
};

struct StudyTally {
  bool paused = false;
  bool cancelled = false;
  bool finished = false;
  bool forgotten = false;  // Its rows are being removed; no reply shows it.
  std::array<int64_t, kMostKinds> ready{};
  int64_t running = 0;      // LEASED jobs.
  int64_t max_running = 0;  // 0: no limit of its own.
  int priority = 0;

  bool IsFull() const { return max_running > 0 && running >= max_running; }
};
struct Study {
  int64_t id = 0;
  std::string name;
  std::string user;
  UserShare* share = nullptr;  // The user's; owned by the ledger.
  uint64_t seed = 0;
  int64_t needs_memory_mb = 0;
  std::vector<std::string> needs_tags;
  std::vector<int64_t> variants;
  StudyTally tally;
  // State of the scheduler: forgotten at a restart, never undone.
  double pass = 0;
  // Steady time in seconds since when it has had READY jobs and was not served; < 0: not hungry.
  double hungry_since_s = -1;

  // Returns its priority among all studies: its own with its user's.
  int Priority() const { return tally.priority + static_cast<int>(share->limits.priority); }
  // Returns how many more of its jobs may be leased now, by its own limit and its user's.
  int64_t Room() const {
    return std::min(RoomUnder(tally.max_running, tally.running),
                    RoomUnder(share->limits.max_running, share->running));
  }
};

class Ledger {
 public:
  // All arguments must outlive the ledger.
  Ledger(SqliteConnection& db, const KindRegistry& kinds, const LimitRules& limits)
      : db_(db), kinds_(kinds), limits_(limits) {}

  // Return a study or variant, read from the database if necessary. Pointers are valid until Drop
  // or Forget. Errors: kNotFound; the database's.
  absl::StatusOr<Study*> FindStudy(int64_t id);
  absl::StatusOr<Variant*> FindVariant(int64_t id);
  // Reads all studies that are not finished. Errors: the database's.
  absl::Status LoadUnfinished();
  std::map<int64_t, Study>& loaded_studies() { return studies_; }
  // Returns whether the study of this variant, or its user, has as many running jobs as allowed.
  bool IsFull(const Variant& variant) const;

  // Notes that the current command has inserted this study, so that undoing forgets it.
  void NoteCreated(int64_t study) { created_.push_back(study); }
  // Return the counters to be changed, and remember their old values for undoing.
  VariantTally& Change(Variant& variant);
  StudyTally& Change(Study& study);
  // Count a new job, or a job's move between states.
  void CountNew(Variant& variant, KindId kind, JobState state);
  void CountMove(Variant& variant, KindId kind, JobState from, JobState to);

  // Begin a command, and undo all changes since its begin.
  void BeginCommand();
  void UndoCommand();
  // Returns the studies that were changed, or whose variants were, since the last Flush.
  const std::set<int64_t>& changed_studies() const { return dirty_studies_; }
  // Writes all changed counters. Errors: the database's.
  absl::Status Flush();
  // Drops everything from memory, after a failed group.
  void Drop();
  // Drops a study from memory until it is asked for again. Requires that its counters are flushed.
  void Forget(int64_t study);

  const JobCounts& totals() const { return totals_; }  // Sums over all loaded variants.

 private:
  absl::Status LoadVariants(Study& study);
  absl::Status LoadCounts(Variant& variant);
  void Count(Variant& variant, KindId kind, JobState state, int64_t change);

  SqliteConnection& db_;
  const KindRegistry& kinds_;
  const LimitRules& limits_;
  std::map<std::string, UserShare> users_;  // By user; as long as studies point to them.
  std::map<int64_t, Study> studies_;
  std::map<int64_t, Variant> variants_;
  std::map<int64_t, JobCounts> written_;  // Each variant's rows of job_counts.
  std::set<int64_t> dirty_studies_;
  std::set<int64_t> dirty_variants_;
  std::map<int64_t, VariantTally> undo_variants_;
  std::map<int64_t, StudyTally> undo_studies_;
  std::vector<int64_t> created_;
  JobCounts totals_{};
  JobCounts undo_totals_{};
};

}  // namespace parallax
