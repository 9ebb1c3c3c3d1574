// Scores of an evaluation: the errors of one predictor on the images of one benchmark, as a file
// of JSON lines. Its first line says what was evaluated and how; each further line is one image.
// The schema is in README.md.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "worker/evaluate/metrics.h"

namespace parallax {

using Tallies = std::map<std::string, ErrorTally>;

// One image.
struct Scores {
  std::string pair;
  std::string pair_group;  // BenchmarkPair::group.
  int width_px = 0, height_px = 0;
  Tallies regions;                        // "all" always; "nocc" and others where they are known.
  std::map<std::string, Tallies> groups;  // "class" and "material" of our own archives.
};

// Whose predictions were evaluated. A row of a table is a (variant, trainer); its runs differ in
// the seed. A predictor that needs no training has no seed.
struct RunIdentity {
  std::string variant;
  std::string trainer;
  std::optional<int64_t> seed;
  std::string checkpoint;  // SHA-256 of the file; empty without one.
  int looks = 0;           // Looks at a pair; 0: as many as the predictor takes by itself.
};

// All scores of one run on one benchmark.
struct Evaluation {
  std::string benchmark;
  Metric headline;              // The figure that the benchmark is quoted with.
  std::vector<Metric> figures;  // Others worth printing beside it.
  std::string mimics;           // The implementation whose masks and means the headline follows.
  int pairs_published = 0;      // Pairs of the whole benchmark; 0 where that isn't fixed.
  RunIdentity run;
  std::string predictor;  // "sgbm", or the command.
  double seconds = 0;     // Time that the predictor took for all pairs.
  std::vector<Scores> images;
};

// Returns the content of a score file. The same evaluation gives the same bytes.
std::string EncodeEvaluation(const Evaluation& evaluation);
// Errors: kDataLoss for a file that ends early or is not one of ours, naming the line.
absl::StatusOr<Evaluation> DecodeEvaluation(std::string_view text);

// Errors: as WriteFileAtomically.
absl::Status WriteEvaluation(const std::string& path, const Evaluation& evaluation);
// Errors: those of ReadFile and DecodeEvaluation, naming the path.
absl::StatusOr<Evaluation> ReadEvaluation(const std::string& path);

// Reads all score files (*.jsonl with our schema) in `dir` and the folders below it (not in
// "frames", "curves" and hidden ones), in order of their paths. Errors: kNotFound when there is
// none; as ReadEvaluation; kFailedPrecondition when two files hold the same run of the same
// benchmark with different scores.
absl::StatusOr<std::vector<Evaluation>> ReadEvaluations(const std::string& dir);

// Returns the metric over all images that have its region: in percent or pixels; NaN if none has.
double FigureOf(const Metric& metric, const Evaluation& evaluation);

}  // namespace parallax
