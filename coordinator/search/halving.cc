#include "coordinator/search/halving.h"

#include <fmt/core.h>

#include <algorithm>
#include <numeric>

#include "coordinator/search/rung_study.h"

namespace parallax {
namespace {

const TrialScore* ScoreNamed(const std::vector<TrialScore>& scores, const std::string& name) {
  const auto found = std::find_if(scores.begin(), scores.end(),
                                  [&](const TrialScore& score) { return score.variant == name; });
  return found == scores.end() ? nullptr : &*found;
}

// Returns why the trial may not go on, from its interval alone; empty if it may.
std::string WhyDropped(const TrialScore& score, const std::string& best) {
  if (score.verdict == "worse") return "significantly worse than the default";
  if (score.worse_than_best) return "significantly worse than " + best;
  return "";
}

}  // namespace

int EndedRungs(const v1::SearchRecord& record) {
  return record.trials().empty() ? 0 : record.trials(0).scores_size();
}

std::vector<v1::SearchTrial> Entrants(const v1::SearchRecord& record) {
  std::vector<v1::SearchTrial> entrants;
  for (const v1::SearchTrial& trial : record.trials()) {
    if (trial.ended().empty()) entrants.push_back(trial);
  }
  return entrants;
}

v1::SearchScore ScoreOf(const TrialScore& score, int rung) {
  v1::SearchScore kept;
  kept.set_rung(rung);
  *kept.mutable_objective() = score.objective;
  *kept.mutable_difference() = score.difference;
  kept.set_verdict(score.verdict);
  if (score.log_difference) *kept.mutable_log_difference() = *score.log_difference;
  kept.set_core_s_per_pair(score.core_s_per_pair);
  return kept;
}

absl::Status EndRung(const std::vector<TrialScore>& scores,
                     const std::map<std::string, std::string>& failed, v1::SearchRecord& record) {
  const int rung = EndedRungs(record);
  const v1::SearchSpec spec = SearchOf(record.study());
  v1::SearchRecord ended = record;
  std::vector<std::pair<const TrialScore*, v1::SearchTrial*>> trials;
  for (v1::SearchTrial& trial : *ended.mutable_trials()) {
    if (!trial.ended().empty()) continue;
    const std::string name = TrialName(trial.number());
    const auto why_failed = failed.find(name);
    if (why_failed != failed.end() && trial.number() != 0) {
      trial.set_ended(fmt::format("rung {}: {}", rung + 1, why_failed->second));
      continue;
    }
    const TrialScore* score = ScoreNamed(scores, name);
    if (score == nullptr) {
      return FailedPrecondition("rung {}: {} has no scores", rung + 1, name);
    }
    *trial.add_scores() = ScoreOf(*score, rung);
    if (trial.number() != 0) trials.emplace_back(score, &trial);
  }
  // Equal objectives: the earlier trial, so that the order is always the same.
  std::stable_sort(trials.begin(), trials.end(), [](const auto& a, const auto& b) {
    return a.first->objective.value() < b.first->objective.value();
  });
  if (rung + 1 < spec.rungs_size()) {
    const auto keep = (trials.size() + static_cast<size_t>(spec.keep_one_of()) - 1) /
                      static_cast<size_t>(spec.keep_one_of());
    size_t kept = 0;
    for (const auto& [score, trial] : trials) {
      std::string why = WhyDropped(*score, trials.front().first->variant);
      if (why.empty() && kept == keep) {
        why = fmt::format("not among the best {} of {}", keep, trials.size());
      }
      if (why.empty()) {
        ++kept;
      } else {
        trial->set_ended(fmt::format("rung {}: {}", rung + 1, why));
      }
    }
  }
  record = std::move(ended);
  return absl::OkStatus();
}

double NextCoreHours(const v1::SearchRecord& record, const StudyCosts& costs) {
  const int next = EndedRungs(record), last = next - 1;
  const v1::StudySpec& search = record.study();
  if (next >= SearchOf(search).rungs_size() || last < 0) return 0;
  double pairs_core_s = 0;
  const std::vector<v1::SearchTrial> entrants = Entrants(record);
  for (const v1::SearchTrial& trial : entrants) {
    const auto found = costs.variants.find(TrialName(trial.number()));
    if (found == costs.variants.end() || found->second.pairs == 0) continue;
    const int64_t more =
        std::max<int64_t>(0, PairsOfRung(search, next) - PairsOfRung(search, last));
    pairs_core_s +=
        found->second.core_s / static_cast<double>(found->second.pairs) * static_cast<double>(more);
  }
  const auto before =
      std::count_if(record.trials().begin(), record.trials().end(),
                    [&](const v1::SearchTrial& trial) { return trial.scores_size() == next; });
  const double trainings = static_cast<double>(entrants.size()) / static_cast<double>(before) *
                           SeedsOfRung(search, next) / SeedsOfRung(search, last);
  const double steps = StepsOfRung(search, next) / StepsOfRung(search, last);
  return (pairs_core_s + trainings * (steps * costs.train_core_s + costs.evaluate_core_s)) /
         kSecondsPerHour;
}

std::string WhyOver(const v1::SearchRecord& record) {
  const v1::SearchSpec spec = SearchOf(record.study());
  const int next = EndedRungs(record);
  if (next >= spec.rungs_size()) return "all rungs have ended";
  if (Entrants(record).size() < 2) return "no trial goes on";
  const double needed = record.core_hours() + record.next_core_hours();
  if (next > 0 && spec.core_hours() > 0 && needed > spec.core_hours()) {
    return fmt::format("rung {} would take it to {:.3g} core-hours, core_hours is {:.3g}", next + 1,
                       needed, spec.core_hours());
  }
  return "";
}

std::optional<int> BestOf(const v1::SearchRecord& record) {
  const int rungs = EndedRungs(record);
  if (rungs == 0) return std::nullopt;
  const v1::SearchTrial* best = nullptr;
  for (const v1::SearchTrial& trial : record.trials()) {
    if (trial.scores_size() != rungs || trial.scores(rungs - 1).verdict() == "worse") continue;
    if (best == nullptr ||
        trial.scores(rungs - 1).objective().value() < best->scores(rungs - 1).objective().value()) {
      best = &trial;
    }
  }
  return best == nullptr ? 0 : best->number();
}

}  // namespace parallax
