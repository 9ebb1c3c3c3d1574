// What a search will take, before it begins. Pure and thread-safe.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/client/runs/plan.h"
#include "coordinator/client/runs/plan_power.h"
#include "coordinator/client/views/terminal.h"
#include "parallax/v1/study.pb.h"

namespace parallax::client {

// The work of one rung, or of the confirmation.
struct RungCosts {
  int64_t trials = 0;         // With the default.
  int64_t pairs = 0;          // Pairs of each.
  int64_t pairs_made = 0;     // In all, without those that the rung before has.
  int64_t trainings = 0;      // In all.
  double pairs_core_s = 0;    // To make pairs.
  double trained_core_s = 0;  // To train and to evaluate.

  double core_hours() const { return (pairs_core_s + trained_core_s) / 3600; }
};

struct SearchCosts {
  std::vector<RungCosts> rungs;
  std::optional<RungCosts> confirmation;
  RungCosts total;         // Sum of all rungs and the confirmation; its pairs are 0.
  int rungs_within = 0;    // Rungs that begin within the search's core_hours.
  std::string not_priced;  // Name of a trainer whose step has no known cost.
};

// Plans each rung as PlanStudy plans a study, with as many trials as may go on, of those that are
// proposed first. Errors: those of PlanStudy and ProposeTrials.
absl::StatusOr<SearchCosts> CostsOfSearch(const v1::StudySpec& search, double factor,
                                          const BenchmarkSizes& own);

// The differences between two trials that a part of the search can show.
struct SearchPower {
  std::string part;                        // "rung 3", or "the confirmation".
  int seeds = 0;                           // Trainings of each trial.
  std::vector<BenchmarkPower> benchmarks;  // Empty below two seeds.
};

// Returns the power of the last rung that begins within core_hours, and of the confirmation.
// Errors: those of RungStudy.
absl::StatusOr<std::vector<SearchPower>> PowersOfSearch(const v1::StudySpec& search,
                                                        const SearchCosts& costs,
                                                        const BenchmarkSizes& own,
                                                        const MeasuredSpreads& spreads);

// Prints a table of the rungs, and a line that sums them up.
void PrintSearchCosts(const v1::StudySpec& search, const SearchCosts& costs, const Terminal& out);
nlohmann::ordered_json SearchCostsJson(const SearchCosts& costs);

}  // namespace parallax::client
