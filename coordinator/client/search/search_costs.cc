#include "coordinator/client/search/search_costs.h"

#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "coordinator/client/views/text.h"
#include "coordinator/client/views/text_table.h"
#include "coordinator/search/rung_study.h"
#include "coordinator/search/trial_space.h"
#include "coordinator/view/json_list.h"

namespace parallax::client {
namespace {

using Json = nlohmann::ordered_json;

// Returns the sizes of the own benchmarks that the rung has: it may leave some out.
BenchmarkSizes ScoredIn(const v1::StudySpec& rung, const BenchmarkSizes& own) {
  BenchmarkSizes scored;
  for (const v1::OwnBenchmark& one : rung.evaluate().own_benchmarks()) {
    if (own.count(one.name()) > 0) scored[one.name()] = own.at(one.name());
  }
  return scored;
}

absl::StatusOr<StudyPlan> PlanRung(const v1::StudySpec& rung, double factor,
                                   const BenchmarkSizes& own) {
  return PlanStudy(rung, factor, ScoredIn(rung, own));
}

RungCosts CostsOf(const StudyPlan& plan, int64_t trials, int64_t pairs) {
  return {.trials = trials,
          .pairs = pairs,
          .pairs_made = trials * pairs,
          .trainings = plan.training.trainings,
          .pairs_core_s = plan.total.solve_core_s + plan.total.render_core_s,
          .trained_core_s = plan.training.train_core_s + plan.training.evaluate_core_s};
}

void AddTo(RungCosts& total, const RungCosts& rung) {
  total.pairs_made += rung.pairs_made;
  total.trainings += rung.trainings;
  total.pairs_core_s += rung.pairs_core_s;
  total.trained_core_s += rung.trained_core_s;
}

Json RungJson(const RungCosts& rung) {
  return {{"trials", rung.trials},
          {"pairs", rung.pairs},
          {"pairs_made", rung.pairs_made},
          {"trainings", rung.trainings},
          {"pairs_core_hours", rung.pairs_core_s / 3600},
          {"trained_core_hours", rung.trained_core_s / 3600},
          {"core_hours", rung.core_hours()}};
}

std::string HoursText(double hours) { return FormatNumber(hours); }

}  // namespace

absl::StatusOr<SearchCosts> CostsOfSearch(const v1::StudySpec& search, double factor,
                                          const BenchmarkSizes& own) {
  const v1::SearchSpec spec = SearchOf(search);
  ASSIGN_OR_RETURN(std::vector<v1::SearchTrial> trials, ProposeTrials(search, spec.trials()));
  SearchCosts costs;
  for (int rung = 0; rung < spec.rungs_size() && trials.size() > 1; ++rung) {
    ASSIGN_OR_RETURN(const v1::StudySpec study, RungStudy(search, rung, trials));
    ASSIGN_OR_RETURN(const StudyPlan plan, PlanRung(study, factor, own));
    const auto count = static_cast<int64_t>(trials.size());
    RungCosts one = CostsOf(plan, count, PairsOfRung(search, rung));
    if (rung > 0) {  // Its first pairs are there already.
      ASSIGN_OR_RETURN(const v1::StudySpec before, RungStudy(search, rung - 1, trials));
      ASSIGN_OR_RETURN(const StudyPlan had, PlanRung(before, factor, own));
      one.pairs_core_s -= had.total.solve_core_s + had.total.render_core_s;
      one.pairs_made -= count * PairsOfRung(search, rung - 1);
    }
    if (!plan.training.not_priced.empty()) costs.not_priced = plan.training.not_priced;
    costs.rungs.push_back(one);
    AddTo(costs.total, one);
    const bool is_within = spec.core_hours() <= 0 || costs.total.core_hours() <= spec.core_hours();
    if (is_within || rung == 0) costs.rungs_within = rung + 1;
    // The default goes on beside the best.
    const int64_t keep = spec.keep_one_of();
    trials.resize(static_cast<size_t>(1 + (count - 1 + keep - 1) / keep));
  }
  if (spec.confirm().enabled() && trials.size() > 1) {
    ASSIGN_OR_RETURN(const v1::StudySpec study, ConfirmStudy(search, trials.back()));
    ASSIGN_OR_RETURN(const StudyPlan plan, PlanRung(study, factor, own));
    costs.confirmation = CostsOf(plan, 2, study.pairs());
    AddTo(costs.total, *costs.confirmation);
  }
  return costs;
}

absl::StatusOr<std::vector<SearchPower>> PowersOfSearch(const v1::StudySpec& search,
                                                        const SearchCosts& costs,
                                                        const BenchmarkSizes& own,
                                                        const MeasuredSpreads& spreads) {
  // Seeds and benchmarks decide, so a second trial with the default's values stands for any.
  v1::SearchTrial other;
  other.set_number(1);
  std::vector<SearchPower> powers;
  const auto add = [&](std::string part, const v1::StudySpec& study) {
    powers.push_back({.part = std::move(part),
                      .seeds = study.train().seeds(),
                      .benchmarks = PowerOf(study, ScoredIn(study, own), spreads)});
  };
  if (costs.rungs_within > 0) {
    ASSIGN_OR_RETURN(const v1::StudySpec rung,
                     RungStudy(search, costs.rungs_within - 1, {v1::SearchTrial(), other}));
    add(fmt::format("rung {}", costs.rungs_within), rung);
  }
  if (costs.confirmation) {
    ASSIGN_OR_RETURN(const v1::StudySpec study, ConfirmStudy(search, other));
    add("the confirmation", study);
  }
  return powers;
}

void PrintSearchCosts(const v1::StudySpec& search, const SearchCosts& costs, const Terminal& out) {
  const v1::SearchSpec spec = SearchOf(search);
  *out.stream << out.Paint(Tone::kBold, search.name()) << ": a search over "
              << Plural(spec.space_size(), "setting") << "\n";
  Table table({"rung", Right("trials"), Right("pairs of each"), Right("trainings"),
               Right("core-hours of pairs"), Right("of trainings")});
  const auto add = [&](const std::string& name, const RungCosts& rung) {
    table.AddRow({name, FormatCount(rung.trials), FormatCount(rung.pairs),
                  FormatCount(rung.trainings), HoursText(rung.pairs_core_s / 3600),
                  HoursText(rung.trained_core_s / 3600)});
  };
  for (size_t i = 0; i < costs.rungs.size(); ++i) add(fmt::format("{}", i + 1), costs.rungs[i]);
  if (costs.confirmation) add("confirmation", *costs.confirmation);
  table.Print(out, 2);
  const RungCosts& total = costs.total;
  *out.stream << "Search: " << HoursText(total.core_hours()) << " core-hours in all ("
              << Plural(total.pairs_made, "pair") << " " << HoursText(total.pairs_core_s / 3600)
              << ", " << Plural(total.trainings, "training") << " "
              << HoursText(total.trained_core_s / 3600) << ")";
  if (costs.confirmation) {
    *out.stream << ", the confirmation " << HoursText(costs.confirmation->core_hours())
                << " of them";
  }
  if (!costs.not_priced.empty()) {
    *out.stream << "; without trainings, because " << costs.not_priced << " has not been measured";
  }
  if (costs.rungs_within < static_cast<int>(costs.rungs.size())) {
    *out.stream << "; core_hours: " << HoursText(spec.core_hours()) << " ends it after "
                << (costs.rungs_within == 1 ? std::string("its first rung")
                                            : fmt::format("rung {}", costs.rungs_within));
  }
  // The default is one more.
  if (!costs.rungs.empty() && costs.rungs[0].trials <= spec.trials()) {
    *out.stream << "; its space has only " << costs.rungs[0].trials - 1 << " of the "
                << Plural(spec.trials(), "trial");
  }
  *out.stream << "\n";
}

Json SearchCostsJson(const SearchCosts& costs) {
  Json json = {{"rungs", JsonList(costs.rungs, RungJson)},
               {"confirmation", nullptr},
               {"total", RungJson(costs.total)}};
  if (costs.confirmation) json["confirmation"] = RungJson(*costs.confirmation);
  json["total"].erase("trials");
  json["total"].erase("pairs");
  json["rungs_within"] = costs.rungs_within;
  return json;
}

}  // namespace parallax::client
