// What a study will take before anything is made: scenes, jobs, what sharing saves, core-hours,
// disk. Pure but for ReadMeasuredFactor.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"

namespace parallax::client {

// Core-seconds of one step each, all threads together. Making scenes costs what their type says
// (SceneType::costs); kMeasuredCosts has the rest. Each figure stands with the command that
// measured it.
struct Costs {
  double build_s;            // Meshes, acceleration structure: once a render job.
  double cache_s_per_mpath;  // A million paths of its radiance cache.
  // For each pair, by megapixels of ONE image.
  double trace_s_per_mpx_sample;
  double denoise_high_s_per_mpx, denoise_balanced_s_per_mpx, denoise_fast_s_per_mpx;
  double fixed_s_per_mpx;  // Ground truth, statistics, encoding, writing.
  double flow_s_per_mpx;   // Both directions of both eyes, with occlusion, encoding and writing.
  // A step of the embedded trainer, by megapixels of its crops of one eye, the whole batch.
  double train_step_s_per_mpx;
  // A pair of a benchmark, by megapixels of one image that the built-in network sees (SeenMpx).
  double evaluate_s_per_mpx;
};
extern const Costs kMeasuredCosts;

struct PlanRow {
  std::string name;
  int64_t pairs = 0, scenes = 0;
  int64_t solve_jobs = 0, render_jobs = 0;
  int64_t layouts_shared = 0;  // Scenes whose room another variant above solves.
  int64_t scenes_shared = 0;   // Scenes that are wholly those of a variant above.
  int64_t pairs_shared = 0;    // Pairs that a variant above renders.
  double solve_core_s = 0, render_core_s = 0;
  int64_t disk_bytes = 0;
};

// How many trainings and evaluations the study has, and their cost. Equal ones count each time.
struct TrainingPlan {
  int64_t trainings = 0, evaluations = 0;
  double train_core_s = 0, evaluate_core_s = 0;
  double longest_s = 0;    // Wall time of the longest training, on the threads that it has.
  std::string not_priced;  // A trainer whose cost of a step is unknown.
};

struct StudyPlan {
  std::vector<PlanRow> rows;
  PlanRow total;
  TrainingPlan training;
  int64_t solves_without_sharing = 0;  // Layouts to solve if variants shared none.
  int64_t solves = 0;                  // Layouts to solve.
  int64_t max_solves_per_seed = 0;     // Different layouts of one seed.
  double factor = 1;                   // By which the costs were scaled to what was measured.
  std::string costs_from;
};

// Rejected seeds, which cost a few percent more, are not foreseen. A variant's figures count what
// it does not share with the variants above it. `factor` scales all times. Errors: kInvalidArgument
// for an unknown render profile.
absl::StatusOr<StudyPlan> PlanStudy(const v1::StudySpec& study, double factor);

// Seconds that the plan takes on `cores` cores (at least 1) of one machine or many: all cores are
// busy but for the last scene, whose room is solved on one core.
double WallClockS(const StudyPlan& plan, int cores);

// The whole benchmark, and the size of a typical picture as it is predicted. Zeros for one that
// nobody knows.
struct BenchmarkSize {
  int64_t pairs = 0;
  int width_px = 0, height_px = 0;
};
BenchmarkSize SizeOfBenchmark(const std::string& name);

// Megapixels of one image that the built-in network sees of such a pair, in both looks together
// (worker/train/predictor.h). A second look as large as it may be: near surfaces make it
// smaller.
double SeenMpx(int width_px, int height_px);

// Measured core-seconds of the pairs in an archive over what kMeasuredCosts foretells for them.
// Errors: kNotFound without an index; kFailedPrecondition when no line says what it cost.
absl::StatusOr<double> ReadMeasuredFactor(const std::string& archive_dir);

}  // namespace parallax::client
