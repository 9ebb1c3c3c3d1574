// Keeps searches going: submits their rungs one after the other, reads what the trials have shown,
// decides which go on, and confirms the best. Nothing of it is lost by a restart: all that was
// decided is in the queue's database, and each study is submitted under an idempotency key of its
// own, so that a restart finds it again. Every decision is a function of the record and of results,
// so that it is the same however often the coordinator dies on the way.
//
// Thread-safe. Blocks on the queue, and on the store while scores are read.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/ids.h"
#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "coordinator/search/samplers.h"
#include "coordinator/search/trial_scores.h"
#include "parallax/v1/search.pb.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

class JobQueue;

class SearchKeeper {
 public:
  // Both must outlive the keeper, and all that `scorer` refers to. Without a scorer no search
  // begins or goes on. `samplers` are those that searches may name, beside the built-in one.
  SearchKeeper(JobQueue& queue, Clock& clock, TrialScorer scorer,
               std::map<std::string, Sampler> samplers = {})
      : queue_(queue), clock_(clock), scorer_(std::move(scorer)), samplers_(std::move(samplers)) {}

  // Begins a search, finds the one that was begun with the same study, or goes on with it if only
  // its trials are more, its core-hours others, or it was stopped: results that it has are taken
  // over by their keys. `actor` is who asks, for the audit table. Errors: kAlreadyExists for a name
  // that another search has; kInvalidArgument for a study that is no search, or has no valid trial;
  // kFailedPrecondition without a scorer; the database's.
  absl::StatusOr<v1::SearchStatus> Open(const v1::StudySpec& study, std::string_view actor);
  // Ends a search that runs: cancels its studies. With `forget`, all of it is removed by the next
  // calls of Tick. Errors: kNotFound; the database's.
  absl::StatusOr<v1::SearchStatus> Stop(const std::string& name, const std::string& reason,
                                        bool forget);
  // Returns the searches by name, without trials and studies' specs; or that of the name, with
  // both. Errors: kNotFound.
  absl::StatusOr<std::vector<v1::SearchStatus>> List(const std::string& name);
  // Returns who opened the search. Errors: kNotFound.
  absl::StatusOr<std::string> OpenedBy(const std::string& name);

  // Takes each search at most one step further. Call it every second or so, always from the same
  // thread, which lives as long as the keeper: samplers run as its children. Errors: the
  // database's; others are what `needs` of a status says.
  absl::Status Tick();

 private:
  struct Search {
    v1::SearchRecord record;
    std::string needs;      // What a person must do before it goes on.
    std::string waits_for;  // Why the next step was not taken.
    bool has_failed = false;
    std::unique_ptr<SamplerRun> asking;  // The sampler is asked for trials.
    std::string sampler_problem;         // Why it was asked in vain.
    SteadyTime ask_after;                // It is not asked again before.
    // The settings' importances on the first rung; absent until it has ended and somebody asked.
    std::optional<std::vector<v1::SearchImportance>> importances;

    const v1::StudySpec& study() const { return record.study(); }
    const std::string& name() const { return record.study().name(); }
  };
  // A study of a search that has ended.
  struct Ended {
    // Trials that can make no pairs, by the names of their variants, with the reason.
    std::map<std::string, std::string> failed;
  };

  // All need mu_.
  absl::Status Load();
  absl::StatusOr<Search*> Find(const std::string& name);
  absl::Status Keep(Search& search, v1::SearchRecord record);
  // `may_ask`: whether samplers may be started, which only the thread of Tick does.
  absl::Status Step(Search& search, bool may_ask = false);
  // Submits a study of the search. Returns its id; nothing if it can't be submitted now, which is
  // in `needs` then.
  absl::StatusOr<std::optional<int64_t>> Submit(Search& search,
                                                const absl::StatusOr<v1::StudySpec>& study);
  absl::Status BeginRung(Search& search);
  absl::Status LookAtRung(Search& search, bool may_ask);
  // Asks the sampler for more trials of the first rung, whose trials have these scores, and begins
  // the rung again with what it answers.
  absl::Status Ask(Search& search, const std::vector<TrialScore>& scores,
                   const std::map<std::string, std::string>& failed);
  absl::Status TakeAnswer(Search& search);
  absl::Status Confirm(Search& search);
  // Looks whether a study has ended well enough to be scored; else says why in the search.
  absl::StatusOr<std::optional<Ended>> LookAt(Search& search, int64_t study,
                                              const std::string& what);
  // Returns the scores of the study; nothing if they can't be read now, which is in `needs` then.
  absl::StatusOr<std::optional<std::vector<TrialScore>>> Score(
      Search& search, int64_t study, const std::vector<std::string>& benchmarks);
  // Returns the core-hours of all of its studies that are there.
  absl::StatusOr<double> CoreHoursOf(const v1::SearchRecord& record);
  // Cancels what runs of a stopped search; if it is to be forgotten, removes it. Returns whether it
  // is gone.
  absl::StatusOr<bool> End(Search& search);
  v1::SearchStatus StatusOf(Search& search, bool whole) const;

  JobQueue& queue_;
  Clock& clock_;
  const TrialScorer scorer_;
  const std::map<std::string, Sampler> samplers_;
  std::mutex mu_;
  // Guarded by mu_.
  bool loaded_ = false;
  std::map<std::string, Search> searches_;
};

}  // namespace parallax
