// What a study of a search has shown of its variants. It is read from score files by a function
// that the coordinator's program brings, because only it knows of evaluations.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/search.pb.h"

namespace parallax {

class JobQueue;
class Store;

// One variant's objective: the mean over benchmarks of bad-2 in %, with its penalty.
struct TrialScore {
  std::string variant;
  v1::SearchFigure objective;
  v1::SearchFigure difference;  // From the default's; below 0 is better.
  std::string verdict;          // "better", "worse" or "not significant" than the default.
  // Difference of the mean log error in octaves, where the verdict is by it.
  std::optional<v1::SearchFigure> log_difference;
  bool worse_than_best = false;  // Significantly worse than the variant with the least objective.
  double core_s_per_pair = 0;
};

// Which study is scored, and how.
struct ScoreQuery {
  int64_t study = 0;
  std::vector<std::string> benchmarks;   // Each counts alike.
  std::set<std::string> without;         // Variants that failed, and have no scores or not all.
  bool weigh_groups = false;             // As `evaluate.weigh_groups` of a study.
  std::map<std::string, double> points;  // Added to the objective of a variant; absent: 0.
  // Verdicts are by the mean log error; the objective and its difference stay what they are.
  bool decide_by_log = false;

  friend bool operator==(const ScoreQuery&, const ScoreQuery&) = default;
};

// Returns the scores of the study's trained variants; those without any score are absent. Errors:
// those of the queue and the store; kFailedPrecondition if a variant lacks scores of a benchmark
// that another has.
using TrialScorer = std::function<absl::StatusOr<std::vector<TrialScore>>(const ScoreQuery&)>;

}  // namespace parallax
