// Keeps searches going: submits their rungs one after the other, reads what the trials have shown,
// decides which go on, and confirms the best. Nothing of it is lost by a restart: all that was
// decided is in the queue's database, and each study is submitted under an idempotency key of its
// own, so that a restart finds it again. Every decision is a function of the record and of results,
// so that it is the same however often the coordinator dies on the way.
//
// Thread-safe. Blocks on the queue; only Tick waits for the store, whose scores it reads.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/ids.h"
#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "coordinator/queue/record_keeper.h"
#include "coordinator/search/samplers.h"
#include "coordinator/search/trial_scores.h"
#include "parallax/v1/search.pb.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

// A search, and what its keeper knows of it.
struct KeptSearch {
  v1::SearchRecord record;
  std::string needs;      // A person must do this before it goes on.
  std::string waits_for;  // Why the next step was not taken.
  bool has_failed = false;
  std::unique_ptr<SamplerRun> asking;  // The sampler is asked for trials.
  std::string sampler_problem;         // Why it was asked in vain.
  SteadyTime ask_after;                // It is not asked again before.
  std::optional<ScoreQuery> wanted;    // The next step needs these scores.
  std::optional<absl::StatusOr<std::vector<TrialScore>>> scores;  // The answer, for one step.
  std::string scores_problem;  // Why the last ones could not be read.
  // The settings' importances on the first rung; absent until it has ended and somebody asked.
  std::optional<std::vector<v1::SearchImportance>> importances;

  const v1::StudySpec& study() const { return record.study(); }
  const std::string& name() const { return record.study().name(); }
};

class SearchKeeper final : public RecordKeeper<KeptSearch, v1::SearchStatus> {
 public:
  // All that `scorer` refers to must outlive the keeper. Without a scorer no search begins or goes
  // on. `samplers` are those that searches may name, beside the built-in one.
  SearchKeeper(JobQueue& queue, Clock& clock, TrialScorer scorer,
               std::map<std::string, Sampler> samplers = {})
      : RecordKeeper(queue, clock, "search",
                     {&JobQueue::ListSearches, &JobQueue::KeepSearch, &JobQueue::RemoveSearch}),
        scorer_(std::move(scorer)),
        samplers_(std::move(samplers)) {}

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
  // Returns all searches whole, by name. Errors: the database's.
  absl::StatusOr<std::vector<v1::SearchStatus>> ListWhole();

  // Takes each search at most one step further. Call it every second or so, always from the same
  // thread, which lives as long as the keeper: samplers run as its children. Errors: the
  // database's; others are what `needs` of a status says.
  absl::Status Tick();

 private:
  using Search = KeptSearch;
  // A study of a search that has ended.
  struct Ended {
    // Trials that can't be scored, by the names of their variants, with the reason.
    std::map<std::string, std::string> failed;
  };

  // All need mu_.
  absl::StatusOr<bool> Advance(Search& search) override;
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
  // Returns the scores of the study's variants that have not failed; nothing if they are not read
  // yet, and are `wanted` then, or can't be, which is in `needs`.
  absl::StatusOr<std::optional<std::vector<TrialScore>>> Score(
      Search& search, int64_t study, const std::vector<std::string>& benchmarks,
      const Ended& ended);
  // Returns the core-hours of all of its studies that are there.
  absl::StatusOr<double> CoreHoursOf(const v1::SearchRecord& record);
  // Cancels what runs of a stopped search; if it is to be forgotten, removes its studies. Returns
  // whether they are gone.
  absl::StatusOr<bool> End(Search& search);
  // A whole one has its trials, importances and study.
  v1::SearchStatus StatusOf(Search& search, bool whole) const override;

  const TrialScorer scorer_;
  const std::map<std::string, Sampler> samplers_;
};

}  // namespace parallax
