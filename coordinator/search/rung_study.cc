#include "coordinator/search/rung_study.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "common/base/rng.h"
#include "common/config/search/search_values.h"
#include "common/config/training_plan.h"

namespace parallax {
namespace {

constexpr int kFewestAtOnce = 4;  // A sampler begins with so many trials to learn from.
// A seed with this bit has trainings of its own; see TrainingSeed.
constexpr uint64_t kFreshTrainings = uint64_t{1} << 63;

using Names = std::vector<std::string>;

int32_t TrainingsOf(const v1::StudySpec& search) {
  return search.train().has_seeds() ? search.train().seeds() : 3;
}

bool Has(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Leaves of the benchmarks, also the own ones, those in `names`, and the held-out pairs if they are
// among them.
void KeepBenchmarks(const Names& names, v1::EvaluateSpec& evaluate) {
  const auto is_other = [&](const std::string& name) { return !Has(names, name); };
  auto& known = *evaluate.mutable_benchmarks();
  known.erase(std::remove_if(known.begin(), known.end(), is_other), known.end());
  auto& own = *evaluate.mutable_own_benchmarks();
  own.erase(std::remove_if(own.begin(), own.end(),
                           [&](const v1::OwnBenchmark& one) { return is_other(one.name()); }),
            own.end());
  if (is_other(kHeldoutName)) evaluate.set_heldout_pairs(0);
}

struct StudyPart {
  std::string suffix;
  uint64_t seed = 0;
  int64_t pairs = 0;
  double steps = 1;  // Share of the training's.
  int32_t seeds = 1;
  Names benchmarks;
};

absl::StatusOr<v1::StudySpec> StudyOf(const v1::StudySpec& search, const StudyPart& part,
                                      const std::vector<v1::SearchTrial>& trials) {
  v1::StudySpec study = search;
  study.clear_search();
  study.clear_source_yaml();
  study.clear_variants();
  study.set_name(search.name() + part.suffix);
  study.set_seed(part.seed);
  study.set_pairs(part.pairs);
  const v1::VariantSpec& base = DefaultOf(search);
  if (base.rigs_per_scene() > 0) study.set_rigs_per_scene(base.rigs_per_scene());
  for (const v1::SearchTrial& trial : trials) {
    v1::VariantSpec& variant = *study.add_variants();
    variant.set_name(TrialName(trial.number()));
    if (trial.number() == 0) {
      *variant.mutable_config() = base.config();
    } else {
      ASSIGN_OR_RETURN(*variant.mutable_config(), WithSearchValues(base.config(), trial.values()));
    }
  }
  v1::TrainSpec& train = *study.mutable_train();
  train.set_seeds(part.seeds);
  if (train.steps() > 0) {
    train.set_steps(
        std::max<int64_t>(1, std::llround(part.steps * static_cast<double>(train.steps()))));
  }
  if (train.minutes() > 0) train.set_minutes(part.steps * train.minutes());
  train.clear_variants();
  v1::EvaluateSpec& evaluate = *study.mutable_evaluate();
  evaluate.clear_baselines();
  evaluate.set_checkpoints(1);
  evaluate.set_reference(kDefaultTrial);
  KeepBenchmarks(part.benchmarks, evaluate);
  evaluate.set_heldout_variant(evaluate.heldout_pairs() > 0 ? kDefaultTrial : "");
  ResolveTraining(&study);
  return study;
}

}  // namespace

v1::SearchSpec SearchOf(const v1::StudySpec& search) {
  v1::SearchSpec spec = search.search();
  if (!spec.has_trials()) spec.set_trials(16);
  if (!spec.has_keep_one_of()) spec.set_keep_one_of(2);
  if (!spec.has_sampler()) spec.set_sampler("sobol");
  if (!spec.mutable_confirm()->has_enabled()) spec.mutable_confirm()->set_enabled(true);
  if (spec.rungs().empty()) {
    for (const double share : {0.25, 0.5, 1.0}) {
      v1::SearchRung& rung = *spec.add_rungs();
      rung.set_pairs(share);
      rung.set_steps(share);
    }
  }
  for (v1::SearchRung& rung : *spec.mutable_rungs()) {
    if (!rung.has_pairs()) rung.set_pairs(1);
    if (!rung.has_steps()) rung.set_steps(1);
  }
  return spec;
}

const v1::VariantSpec& DefaultOf(const v1::StudySpec& search) {
  return *std::find_if(search.variants().begin(), search.variants().end(),
                       [](const v1::VariantSpec& variant) { return !variant.heldout(); });
}

std::string TrialName(int number) {
  return number == 0 ? kDefaultTrial : fmt::format("trial-{:03}", number);
}

absl::Status CheckSearch(const v1::StudySpec& search) {
  if (!search.has_search()) {
    return InvalidArgument("study '{}' has no `search`, which says what is varied and how",
                           search.name());
  }
  const auto variants = std::count_if(search.variants().begin(), search.variants().end(),
                                      [](const v1::VariantSpec& one) { return !one.heldout(); });
  if (variants != 1) {
    return InvalidArgument(
        "study '{}': {} variants, wanted 1, the default that trials are compared with",
        search.name(), variants);
  }
  return absl::OkStatus();
}

int TrialsAtOnce(const v1::StudySpec& search) {
  const v1::SearchSpec spec = SearchOf(search);
  if (spec.sampler() == kSobolSampler) return spec.trials();
  return std::min(spec.trials(), std::max(kFewestAtOnce, (spec.trials() + 3) / 4));
}

Names SearchedBenchmarks(const v1::StudySpec& search) {
  const auto& given = search.search().benchmarks();
  if (!given.empty()) return {given.begin(), given.end()};
  const auto& confirm = search.search().confirm().benchmarks();
  const Names held(confirm.begin(), confirm.end());
  Names names;
  for (const std::string& name : search.evaluate().benchmarks()) {
    if (!Has(held, name)) names.push_back(name);
  }
  for (const v1::OwnBenchmark& own : search.evaluate().own_benchmarks()) {
    if (!Has(held, own.name())) names.push_back(own.name());
  }
  if (names.empty() && !Has(held, kHeldoutName)) names.push_back(kHeldoutName);
  return names;
}

Names ConfirmedBenchmarks(const v1::StudySpec& search) {
  const auto& given = search.search().confirm().benchmarks();
  return given.empty() ? SearchedBenchmarks(search) : Names(given.begin(), given.end());
}

int64_t PairsOfRung(const v1::StudySpec& search, int rung) {
  const v1::VariantSpec& base = DefaultOf(search);
  const int64_t pairs = base.pairs() > 0 ? base.pairs() : search.pairs();
  const int64_t rigs =
      std::max(1, base.rigs_per_scene() > 0 ? base.rigs_per_scene() : search.rigs_per_scene());
  const double share = SearchOf(search).rungs(rung).pairs();
  if (share >= 1) return pairs;
  const auto scenes = std::llround(share * static_cast<double>(pairs) / static_cast<double>(rigs));
  return std::min(pairs, std::max<int64_t>(1, scenes) * rigs);
}

int32_t SeedsOfRung(const v1::StudySpec& search, int rung) {
  const int32_t seeds = SearchOf(search).rungs(rung).seeds();
  return seeds > 0 ? seeds : TrainingsOf(search);
}

double StepsOfRung(const v1::StudySpec& search, int rung) {
  return SearchOf(search).rungs(rung).steps();
}

absl::StatusOr<v1::StudySpec> RungStudy(const v1::StudySpec& search, int rung,
                                        const std::vector<v1::SearchTrial>& trials) {
  return StudyOf(search,
                 {.suffix = fmt::format("-rung{}", rung + 1),
                  .seed = search.seed(),
                  .pairs = PairsOfRung(search, rung),
                  .steps = StepsOfRung(search, rung),
                  .seeds = SeedsOfRung(search, rung),
                  .benchmarks = SearchedBenchmarks(search)},
                 trials);
}

absl::StatusOr<v1::StudySpec> ConfirmStudy(const v1::StudySpec& search,
                                           const v1::SearchTrial& best) {
  const v1::VariantSpec& base = DefaultOf(search);
  const int32_t seeds = search.search().confirm().seeds();
  return StudyOf(search,
                 {.suffix = "-confirm",
                  .seed = Rng(SceneSeed{search.seed()}, "search/confirm").Seed() | kFreshTrainings,
                  .pairs = base.pairs() > 0 ? base.pairs() : search.pairs(),
                  .steps = 1,
                  .seeds = seeds > 0 ? seeds : TrainingsOf(search),
                  .benchmarks = ConfirmedBenchmarks(search)},
                 {v1::SearchTrial(), best});
}

}  // namespace parallax
