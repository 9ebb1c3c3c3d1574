#include "tests/faults/simulate/users/searcher.h"

#include <cmath>

#include "coordinator/study/keys.h"
#include "tests/coordinator/search/search_study.h"
#include "tests/faults/simulate/work.h"

namespace parallax::faults {
namespace {

constexpr char kSearch[] = "recipe";
constexpr int kTrials = 4;
constexpr int kMostListed = 10'000;

v1::StudySpec SearchedStudy(Rng dice) {
  v1::StudySpec study = SmallSearch(kTrials);
  study.set_seed(dice.Bits32());
  study.set_pairs(4);
  return study;
}

// Returns the parts that depend on the settings alone.
std::string FoundBy(const v1::SearchStatus& status) {
  v1::SearchStatus found;
  *found.mutable_trials() = status.trials();
  *found.mutable_confirmation() = status.confirmation();
  found.set_best(status.best());
  found.set_outcome(status.outcome());
  return DeterministicBytes(found);
}

std::string CalmlyFound(const v1::StudySpec& study, const std::string& db_path) {
  FakeClock clock;
  const auto queue = JobQueue::Open(
      {.db_path = db_path, .clock = &clock, .own_threads = false, .readers = 1, .kinds = &Kinds()});
  if (!queue.ok()) std::abort();
  SearchKeeper keeper(**queue, clock, ScorerOf(**queue));
  auto status = keeper.Open(study, "client");
  while (status.ok() && status->outcome().empty()) {
    const auto leases = (*queue)->Lease(LivingWorker("w"), 16);
    if (!leases.ok()) std::abort();
    for (const v1::Lease& lease : *leases) (void)(*queue)->Complete(AnswerOf(lease, "w"));
    if (leases->empty() && !keeper.Tick().ok()) std::abort();
    status = std::move((*keeper.List(kSearch))[0]);
  }
  return status.ok() ? FoundBy(*status) : status.status().ToString();
}

}  // namespace

TrialScorer ScorerOf(JobQueue& queue) {
  return [&queue](const ScoreQuery& query) -> absl::StatusOr<std::vector<TrialScore>> {
    ASSIGN_OR_RETURN(const v1::StudyStatus study, queue.GetStudy(StudyId{query.study}));
    std::vector<TrialScore> scores;
    for (const v1::VariantSpec& variant : study.spec().variants()) {
      TrialScore& score = scores.emplace_back();
      score.variant = variant.name();
      score.objective.set_value(20 +
                                std::abs(variant.config().floating().count().constant() - 30) / 10);
      score.difference.set_value(score.objective.value() - scores[0].objective.value());
      score.verdict = score.difference.value() < 0 ? "better" : "not significant";
    }
    return scores;
  };
}

SimSearcher::SimSearcher(World& world, SimCoordinator& coordinator, SimClient& client,
                         const std::string& folder)
    : world_(world),
      coordinator_(coordinator),
      client_(client),
      dice_(world.rng.Child("searcher")),
      study_(SearchedStudy(dice_.Child("study"))),
      calm_(CalmlyFound(study_, folder + "/calm.db")) {}

void SimSearcher::Start() {
  client_.CallUntilDone([this] {
    const auto status = coordinator_.searches().Open(study_, "client");
    if (!status.ok()) coordinator_.model().Expect(status.status(), "begin a search");
    return status.ok() && !(world_.has_faults && dice_.Bernoulli(world_.knobs.loss_p));
  });
  LookLater();
}

void SimSearcher::LookLater() {
  world_.schedule.After(world_.Next(world_.knobs.queue.lease_s), [this] {
    if (has_ended_) return;
    client_.Call([this] { Look(); });
    LookLater();
  });
}

void SimSearcher::Look() {
  const auto list = coordinator_.searches().List(kSearch);
  if (VfsHasEnded() || absl::IsNotFound(list.status())) return;  // Not begun yet.
  if (!list.ok()) return coordinator_.model().Expect(list.status(), "look at a search");
  const v1::SearchStatus& status = list->front();
  // Failed jobs wait for a person.
  for (const int64_t study : status.studies()) {
    if (!world_.has_faults) (void)coordinator_.queue().Retry(StudyId{study}, "client");
  }
  if (status.outcome().empty() || std::exchange(has_ended_, true)) return;
  world_.story.Tell("searcher: its search is {}", status.outcome());
  if (FoundBy(status) != calm_) {
    coordinator_.model().Complain("a search finds what a calm farm does not: " +
                                  status.ShortDebugString());
  }
  Remove();
}

void SimSearcher::Remove() {
  client_.CallUntilDone([this] {
    const auto stopped = coordinator_.searches().Stop(kSearch, "", /*forget=*/true);
    if (!stopped.ok() && !absl::IsNotFound(stopped.status())) {
      coordinator_.model().Expect(stopped.status(), "remove a search");
      return false;
    }
    const auto left = coordinator_.queue().ListSearches();
    const auto studies = coordinator_.queue().ListStudies(kMostListed);
    if (!left.ok() || !left->empty() || !studies.ok()) return false;
    for (const v1::StudyStatus& study : *studies) {
      if (study.name().starts_with(std::string(kSearch) + "-")) {
        coordinator_.model().Complain("search: " + study.name() + " is left");
      }
    }
    world_.story.Tell("searcher: its search is gone");
    return is_done_ = true;
  });
}

}  // namespace parallax::faults
