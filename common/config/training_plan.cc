#include "common/config/training_plan.h"

#include <fmt/core.h>

#include <algorithm>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "common/base/hash.h"
#include "common/config/defaults.h"

namespace parallax {
namespace {

// Lists have no absence: an empty one is meant.
void FillIn(v1::TrainSpec* train) {
  const auto variants = train->variants();
  config_internal::ApplyDefaults(train);
  *train->mutable_variants() = variants;
}

void FillIn(v1::EvaluateSpec* evaluate) {
  const v1::EvaluateSpec given = *evaluate;
  config_internal::ApplyDefaults(evaluate);
  *evaluate->mutable_benchmarks() = given.benchmarks();
  *evaluate->mutable_own_benchmarks() = given.own_benchmarks();
  *evaluate->mutable_baselines() = given.baselines();
  *evaluate->mutable_group_by() = given.group_by();
}

// A function of the study's seed, so that a study's pairs are the same wherever it is resolved.
uint64_t HeldoutSeed(const v1::StudySpec& study) {
  std::set<uint64_t> used = {0};
  for (const v1::VariantSpec& variant : study.variants()) used.insert(SeedOf(study, variant));
  for (int salt = 0;; ++salt) {
    const Sha256Digest digest = Sha256Of(fmt::format("heldout-seed {} {}", study.seed(), salt));
    uint64_t seed = 0;
    for (int i = 0; i < 8; ++i) {
      seed |= static_cast<uint64_t>(digest[static_cast<size_t>(i)]) << (8 * i);
    }
    if (used.count(seed) == 0) return seed;
  }
}

void ResolveHeldout(v1::StudySpec* study) {
  auto& variants = *study->mutable_variants();
  for (int i = variants.size(); i-- > 0;) {
    if (variants[i].heldout()) variants.DeleteSubrange(i, 1);
  }
  if (!WantsHeldout(*study) || variants.empty()) return;
  const v1::VariantSpec* source = &variants[0];
  for (const v1::VariantSpec& variant : variants) {
    if (variant.name() == study->evaluate().heldout_variant()) source = &variant;
  }
  v1::VariantSpec heldout = *source;
  heldout.set_name(kHeldoutName);
  heldout.set_pairs(study->evaluate().heldout_pairs());
  heldout.set_seed(HeldoutSeed(*study));
  heldout.set_heldout(true);
  *study->add_variants() = std::move(heldout);
}

// The set's data: variants with weights that sum to 1, how much of them, the share of mismatched
// pairs and which truth.
using SetData =
    std::tuple<std::vector<std::pair<std::string, double>>, double, double, std::string>;

SetData DataOf(const v1::Mixture& set) {
  double sum = 0;
  for (const v1::Mixture::Part& part : set.parts()) sum += part.weight();
  std::vector<std::pair<std::string, double>> parts;
  for (const v1::Mixture::Part& part : set.parts()) {
    if (part.weight() > 0) parts.emplace_back(part.variant(), part.weight() / sum);
  }
  return {std::move(parts), set.share(), MismatchedShareOf(set), set.truth()};
}

}  // namespace

void ResolveTraining(v1::StudySpec* study) {
  if (study->has_train()) FillIn(study->mutable_train());
  if (study->has_evaluate()) FillIn(study->mutable_evaluate());
  ResolveHeldout(study);
}

std::vector<v1::Mixture> TrainingSetsOf(const v1::StudySpec& study) {
  std::vector<v1::Mixture> sets;
  if (!study.has_train()) return sets;
  const v1::TrainSpec& train = study.train();
  const auto add = [&sets](const std::string& variant) {
    v1::Mixture set;
    set.set_name(variant);
    set.add_parts()->set_variant(variant);
    set.mutable_parts(0)->set_weight(1);
    set.set_share(1);
    sets.push_back(std::move(set));
  };
  if (!train.only_mixtures()) {
    for (const std::string& name : train.variants()) add(name);
    for (const v1::VariantSpec& variant : study.variants()) {
      if (train.variants().empty() && !variant.heldout()) add(variant.name());
    }
  }
  sets.insert(sets.end(), train.mixtures().begin(), train.mixtures().end());
  for (v1::Mixture& set : sets) {
    if (set.truth().empty()) set.set_truth(train.truth());
  }
  return sets;
}

double MismatchedShareOf(const v1::Mixture& set) {
  return set.mismatched() ? set.mismatched_share() : 0;
}

std::string TruthOfHeldout(const v1::StudySpec& study) {
  const std::string& own = study.evaluate().truth();
  return own.empty() ? study.train().truth() : own;
}

int PlainTwinOf(const v1::Mixture& curated, const std::vector<v1::Mixture>& sets) {
  const auto twin = std::find_if(sets.begin(), sets.end(), [&](const v1::Mixture& set) {
    return !set.curated() && DataOf(set) == DataOf(curated);
  });
  return twin == sets.end() ? -1 : static_cast<int>(twin - sets.begin());
}

}  // namespace parallax
