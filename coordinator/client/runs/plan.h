// Estimates the cost of a study before any work is done: scenes, jobs, savings by sharing,
// core-hours and disk. Pure functions, except that ReadMeasuredFactor reads files.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"

namespace parallax::client {

// Core-seconds of one step each, of all threads together. The cost of making a scene depends on its
// type (SceneType::costs); kMeasuredCosts has all other costs, each with the command that measured
// it.
struct Costs {
  double build_s;            // Meshes and acceleration structure, once a render job.
  double cache_s_per_mpath;  // One million paths of its radiance cache.
  // Costs of a pair for each megapixel of ONE image.
  double trace_s_per_mpx_sample;
  double denoise_high_s_per_mpx, denoise_balanced_s_per_mpx, denoise_fast_s_per_mpx;
  double fixed_s_per_mpx;  // Ground truth, statistics, encoding, writing.
  double flow_s_per_mpx;   // Both directions of both eyes, with occlusion, encoding and writing.
  // Cost of a step of the embedded trainer for each megapixel of one eye's crops in the batch.
  double train_step_s_per_mpx;
  // Cost of a benchmark's pair for each megapixel that the built-in network sees (SeenMpx).
  double evaluate_s_per_mpx;
};
extern const Costs kMeasuredCosts;

// The plan of one variant, or the sum of all.
struct PlanRow {
  std::string name;
  int64_t pairs = 0, scenes = 0;
  int64_t solve_jobs = 0, render_jobs = 0;
  int64_t layouts_shared = 0;  // Scenes whose room an earlier variant solves.
  int64_t scenes_shared = 0;   // Scenes that are the same as an earlier variant's.
  int64_t pairs_shared = 0;    // Pairs that an earlier variant renders.
  double solve_core_s = 0, render_core_s = 0;
  int64_t disk_bytes = 0;
};

// Numbers and costs of the study's trainings and evaluations. Equal ones are counted each time.
struct TrainingPlan {
  int64_t trainings = 0, evaluations = 0;
  double train_core_s = 0, evaluate_core_s = 0;
  double longest_s = 0;    // Wall time of the longest training on its number of threads.
  std::string not_priced;  // Name of a trainer whose step has no known cost.
};

// The plan of a whole study.
struct StudyPlan {
  std::vector<PlanRow> rows;
  PlanRow total;
  TrainingPlan training;
  int64_t solves_without_sharing = 0;  // Layouts to solve if variants shared none.
  int64_t solves = 0;                  // Layouts to solve.
  int64_t max_solves_per_seed = 0;     // Different layouts of one seed.
  double factor = 1;                   // Measured over estimated costs; scales all times.
  std::string costs_from;
};

// The number of a benchmark's pairs, and the size of a typical picture as networks get it.
struct BenchmarkSize {
  int64_t pairs = 0;
  int width_px = 0, height_px = 0;
  std::vector<int> units = {};  // Pairs of each group that intervals draw; empty: pairs are drawn.
};
using BenchmarkSizes = std::map<std::string, BenchmarkSize>;  // By the benchmark's name.
// Returns the size of a public benchmark; zeros for an unknown one.
BenchmarkSize SizeOfBenchmark(const std::string& name);

// Plans the study. A variant's row counts the work that it does not share with earlier variants.
// Rejected seeds, which cost a few percent more, are left out. `factor` scales all times. `own` are
// the sizes of the study's own benchmarks; those without one are counted and not priced. Errors:
// kInvalidArgument for an unknown render profile.
absl::StatusOr<StudyPlan> PlanStudy(const v1::StudySpec& study, double factor,
                                    const BenchmarkSizes& own = {});

// Returns the seconds that the plan takes on `cores` cores (at least 1) of one machine or many. All
// cores are busy, except during the last scene, whose room is solved on one core.
double WallClockS(const StudyPlan& plan, int cores);

// Returns the megapixels that the built-in network sees of one image of such a pair, in both looks
// together (worker/train/trained_predictor.h). Assumes the largest second look; near surfaces make
// it smaller.
double SeenMpx(int width_px, int height_px);

// Returns the measured core-seconds of the pairs in an archive over the estimate of kMeasuredCosts.
// Errors: kNotFound without an index; kFailedPrecondition if none of its lines has a cost.
absl::StatusOr<double> ReadMeasuredFactor(const std::string& archive_dir);

}  // namespace parallax::client
