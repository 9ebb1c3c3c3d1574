#include "coordinator/client/runs/plan_power.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "common/config/content_folders.h"
#include "common/config/training_plan.h"
#include "common/image/jpeg.h"
#include "coordinator/client/content/study_options.h"
#include "coordinator/client/views/table_options.h"
#include "worker/evaluate/evaluation.h"
#include "worker/evaluate/own_benchmark.h"
#include "worker/evaluate/scores.h"

namespace parallax::client {
namespace {

constexpr double kConfidence = 0.95;

// Spread of bad-2 between variants of `table1-small` (three against the default, three seeds of 400
// steps) on thirty real pairs of Middlebury 2001 to 2006, ETH3D and KITTI. Seeds and what is left
// are not known apart there; the split makes little difference with as many pairs.
constexpr DifferenceSpread kMeasuredSpread = {.seeds = 5.0, .images = 19.0, .rest = 22.0};

// The spread of groups' figures, from that of pairs, where groups differ by no more than their
// pairs do.
DifferenceSpread OfGroups(DifferenceSpread spread, const std::vector<int>& sizes,
                          bool weigh_groups) {
  double pairs = 0, squares = 0, inverses = 0;
  for (const int size : sizes) {
    pairs += size;
    squares += static_cast<double>(size) * size;
    inverses += 1.0 / size;
  }
  const auto count = static_cast<double>(sizes.size());
  const double share = weigh_groups ? inverses / count : count / pairs;
  spread.images *= share;
  spread.rest *= share;
  if (!weigh_groups) spread.degrees_share = pairs * pairs / (count * squares);
  return spread;
}

}  // namespace

absl::StatusOr<BenchmarkSizes> SizesOfOwnBenchmarks(const v1::StudySpec& study) {
  BenchmarkSizes sizes;
  for (v1::OwnBenchmark own : study.evaluate().own_benchmarks()) {
    const std::string path = FromRoot(PathOfBenchmark(own));
    std::error_code error;
    if (!std::filesystem::exists(path, error)) continue;
    own.clear_sha256();  // HashContent has compared it.
    ASSIGN_OR_RETURN(Benchmark whole, OpenOwnBenchmark(own, path));
    const Benchmark benchmark = Thinned(std::move(whole), study.evaluate().max_pairs());
    if (benchmark.pairs.empty()) continue;
    ASSIGN_OR_RETURN(const ImageRgb8 picture, ReadPictureRgb8(benchmark.pairs[0].left));
    std::vector<std::string> groups;
    for (const BenchmarkPair& pair : benchmark.pairs) groups.push_back(pair.group);
    BenchmarkSize& size = sizes[own.name()] = {static_cast<int64_t>(benchmark.pairs.size()),
                                               picture.width(), picture.height()};
    for (const int unit : UnitsOf(groups)) {
      size.units.resize(std::max(size.units.size(), static_cast<size_t>(unit) + 1));
      ++size.units[static_cast<size_t>(unit)];
    }
  }
  return sizes;
}

absl::StatusOr<MeasuredSpreads> ReadSpreads(const std::string& dir, const v1::StudySpec& study) {
  MeasuredSpreads spreads;
  absl::StatusOr<std::vector<Evaluation>> scores = ReadEvaluations(dir);
  if (absl::IsNotFound(scores.status())) return spreads;
  RETURN_IF_ERROR(scores.status());
  if (study.has_search()) {  // Its error is the mean of pairs' bad-2.
    for (Evaluation& one : *scores) {
      one.headline = {.measure = BadAt(2), .region = one.headline.region};
    }
  }
  ASSIGN_OR_RETURN(const ResultTable table, MakeStudyTable(study, *scores));
  std::map<std::string, int> counts;
  for (const TableComparison& one : table.comparisons) {
    if (!one.of_trainings || !one.comparison.least_difference) continue;
    MeasuredSpread& measured = spreads[one.benchmark];
    measured.metric = one.decided_by;
    measured.units = one.comparison.images;
    const int before = counts[one.benchmark]++;
    const auto add = [&](double DifferenceSpread::*part) {
      double& mean = measured.spread.*part;
      mean += (one.comparison.spread.*part - mean) / (before + 1);
    };
    add(&DifferenceSpread::seeds);
    add(&DifferenceSpread::images);
    add(&DifferenceSpread::rest);
    add(&DifferenceSpread::degrees_share);
    add(&DifferenceSpread::widened);
  }
  return spreads;
}

std::vector<BenchmarkPower> PowerOf(const v1::StudySpec& study, const BenchmarkSizes& own,
                                    const MeasuredSpreads& spreads, int seeds) {
  std::vector<BenchmarkPower> powers;
  if (!study.has_evaluate() || TrainingSetsOf(study).size() < 2) return powers;
  const v1::EvaluateSpec& evaluate = study.evaluate();
  const auto add = [&](const std::string& name, const BenchmarkSize& size) {
    int64_t pairs = size.pairs;
    if (evaluate.max_pairs() > 0) pairs = std::min<int64_t>(pairs, evaluate.max_pairs());
    const auto found = spreads.find(name);
    const bool measured = found != spreads.end();
    const bool groups = !size.units.empty();
    const auto units = static_cast<int>(groups ? size.units.size() : pairs);
    // The project's own spread is that of pairs; those of scores are of what their table draws.
    DifferenceSpread spread = measured ? found->second.spread : kMeasuredSpread;
    if (!measured && groups) spread = OfGroups(spread, size.units, evaluate.weigh_groups());
    if (measured && found->second.units != units) spread.widened = 1;
    const std::optional<double> least =
        LeastDifference(spread, seeds > 0 ? seeds : study.train().seeds(), units, kConfidence);
    if (least) {
      powers.push_back({name, pairs, measured ? found->second.metric : "bad-2", *least, measured});
    }
  };
  for (const std::string& name : evaluate.benchmarks()) add(name, SizeOfBenchmark(name));
  for (const auto& [name, size] : own) add(name, size);
  return powers;
}

}  // namespace parallax::client
