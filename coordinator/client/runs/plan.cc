#include "coordinator/client/runs/plan.h"

#include <algorithm>
#include <map>
#include <utility>

#include "common/config/check/rig_counts.h"
#include "common/config/config.h"
#include "common/config/frame_maps.h"
#include "common/config/training_plan.h"
#include "coordinator/client/runs/out_dir.h"
#include "coordinator/study/expansion.h"
#include "coordinator/study/keys.h"
#include "worker/dataset/archive/dataset_reader.h"
#include "worker/render/paths/profiles.h"
#include "worker/scene/types/scene_types.h"
#include "worker/train/network/settings.h"

namespace parallax::client {
namespace {

double Megapixels(const v1::SceneConfig& config) {
  return double{1e-6} * config.rigs().width_px() * config.rigs().height_px();
}

// Core-seconds of one pair, without its share of the scene.
absl::StatusOr<double> PairSeconds(const v1::SceneConfig& config, const SceneCosts& scene) {
  ASSIGN_OR_RETURN(const RenderProfile profile, ResolveProfile(config.render()));
  const Costs& costs = kMeasuredCosts;
  const int samples = profile.SamplesPerPixel(config.rigs().width_px(), config.rigs().height_px());
  double per_mpx =
      costs.fixed_s_per_mpx + scene.trace_times * costs.trace_s_per_mpx_sample * samples;
  switch (profile.denoise) {
    case DenoiseQuality::kOff:
      break;
    case DenoiseQuality::kFast:
      per_mpx += costs.denoise_fast_s_per_mpx;
      break;
    case DenoiseQuality::kBalanced:
      per_mpx += costs.denoise_balanced_s_per_mpx;
      break;
    case DenoiseQuality::kHigh:
      per_mpx += costs.denoise_high_s_per_mpx;
      break;
  }
  // The pair before rectification is traced and denoised like the rectified one.
  const bool raw = HasMap(config.render(), "raw");
  if (HasMap(config.render(), "flow")) per_mpx += costs.flow_s_per_mpx;
  // The left eye is traced once for all of its right ones.
  const double eyes = EyesOfLeft(config.rigs());
  return per_mpx * Megapixels(config) * ((raw ? 1 : 0) + (1 + eyes) / (2 * eyes));
}

// Core-seconds of the work that all pairs of a scene share.
absl::StatusOr<double> BuildSeconds(const v1::SceneConfig& config, const SceneCosts& costs) {
  ASSIGN_OR_RETURN(const RenderProfile profile, ResolveProfile(config.render()));
  const double build_s = kMeasuredCosts.build_s + costs.build_s;
  if (!costs.rigs_share_light) return build_s;
  return build_s + costs.trace_times * 1e-6 * static_cast<double>(profile.cache_paths) *
                       kMeasuredCosts.cache_s_per_mpath;
}

absl::StatusOr<SceneCosts> SceneCostsOf(const v1::SceneConfig& config) {
  ASSIGN_OR_RETURN(const SceneType* type, FindSceneType(config.type()));
  return type->costs(config);
}

// Returns the part of `wanted` beyond `had`, the largest number so far, and updates `had`.
int64_t TakeNew(int64_t& had, int64_t wanted) {
  const int64_t more = std::max<int64_t>(0, wanted - had);
  had = std::max(had, wanted);
  return more;
}

void AddTo(PlanRow& total, const PlanRow& row) {
  total.pairs += row.pairs;
  total.scenes += row.scenes;
  total.solve_jobs += row.solve_jobs;
  total.render_jobs += row.render_jobs;
  total.layouts_shared += row.layouts_shared;
  total.scenes_shared += row.scenes_shared;
  total.pairs_shared += row.pairs_shared;
  total.solve_core_s += row.solve_core_s;
  total.render_core_s += row.render_core_s;
  total.disk_bytes += row.disk_bytes;
}

// Core-seconds of one training; 0 if unknown.
double TrainingSeconds(const v1::TrainSpec& train) {
  if (train.minutes() > 0) return 60 * train.minutes() * train.threads();
  if (train.trainer() != "builtin") return 0;
  const TrainSettings own;  // The trainer's own, where the study says nothing.
  const auto given = [](int64_t value, int64_t otherwise) {
    return static_cast<double>(value > 0 ? value : otherwise);
  };
  const double mpx = 1e-6 * given(train.batch(), own.batch) *
                     given(train.width_px(), own.crop_width) *
                     given(train.height_px(), own.crop_height);
  return given(train.steps(), own.steps) * mpx * kMeasuredCosts.train_step_s_per_mpx;
}

// Core-seconds in which networks score the frames of curated sets, once for each training.
double ScoringSeconds(const v1::StudySpec& study) {
  double mpx = 0;
  for (const v1::Mixture& set : TrainingSetsOf(study)) {
    for (const v1::Mixture::Part& part : set.parts()) {
      for (const v1::VariantSpec& variant : study.variants()) {
        if (!set.curated() || part.weight() <= 0 || variant.name() != part.variant()) continue;
        const v1::RigConfig& rigs = variant.config().rigs();
        const int64_t pairs = variant.pairs() > 0 ? variant.pairs() : study.pairs();
        mpx += static_cast<double>(pairs) * SeenMpx(rigs.width_px(), rigs.height_px());
      }
    }
  }
  return mpx * study.train().seeds() * kMeasuredCosts.evaluate_s_per_mpx;
}

TrainingPlan PlanTraining(const v1::StudySpec& study, double factor, const BenchmarkSizes& own) {
  TrainingPlan plan;
  const v1::TrainSpec& train = study.train();
  plan.trainings = static_cast<int64_t>(TrainingSetsOf(study).size()) * train.seeds();
  const double one_s = factor * TrainingSeconds(train);
  plan.train_core_s = one_s * static_cast<double>(plan.trainings) + factor * ScoringSeconds(study);
  plan.longest_s = one_s / std::max(1, train.threads());
  if (plan.trainings > 0 && one_s == 0) plan.not_priced = train.trainer();
  if (!study.has_evaluate()) return plan;
  const v1::EvaluateSpec& evaluate = study.evaluate();
  const int64_t predictors = plan.trainings * evaluate.checkpoints() + evaluate.baselines_size();
  double mpx = 0;  // Megapixels that one predictor sees.
  for (const v1::VariantSpec& variant : study.variants()) {
    if (!variant.heldout()) continue;
    const v1::RigConfig& rigs = variant.config().rigs();
    mpx +=
        static_cast<double>(evaluate.heldout_pairs()) * SeenMpx(rigs.width_px(), rigs.height_px());
  }
  const auto see = [&](const BenchmarkSize& size) {
    const int64_t pairs =
        evaluate.max_pairs() > 0 ? std::min<int64_t>(size.pairs, evaluate.max_pairs()) : size.pairs;
    mpx += static_cast<double>(pairs) * SeenMpx(size.width_px, size.height_px);
  };
  for (const std::string& benchmark : evaluate.benchmarks()) see(SizeOfBenchmark(benchmark));
  for (const auto& [name, size] : own) see(size);
  plan.evaluations = predictors * (evaluate.benchmarks_size() + evaluate.own_benchmarks_size() +
                                   (WantsHeldout(study) ? 1 : 0));
  plan.evaluate_core_s =
      factor * kMeasuredCosts.evaluate_s_per_mpx * static_cast<double>(predictors) * mpx;
  return plan;
}

}  // namespace

double SeenMpx(int width_px, int height_px) {
  if (width_px <= 0) return 0;
  const double room = static_cast<double>(kNetworkWidth) / width_px;
  const double first = kFirstLook * std::min(1.0, room), second = std::min(kMostEnlarged, room);
  return 1e-6 * width_px * height_px * (first * first + second * second);
}

absl::StatusOr<StudyPlan> PlanStudy(const v1::StudySpec& study, double factor,
                                    const BenchmarkSizes& own) {
  StudyPlan plan;
  plan.factor = factor;
  // Scenes 0..n-1 asked for so far, by what they depend on.
  std::map<std::pair<uint64_t, std::vector<Sha256Digest>>, int64_t> layouts, scenes, pairs;
  for (const v1::VariantSpec& variant : study.variants()) {
    const v1::SceneConfig& config = variant.config();
    const ConfigDigests digests = DigestsOf(config);
    const uint64_t seed = SeedOf(study, variant);
    PlanRow row{.name = variant.name(), .pairs = PairsOf(study, variant)};
    const int64_t rigs = std::max(1, RigsPerSceneOf(study, variant));
    row.scenes = (row.pairs + rigs - 1) / rigs;
    row.solve_jobs = row.scenes;
    row.render_jobs = row.scenes;
    ASSIGN_OR_RETURN(const SceneCosts costs, SceneCostsOf(config));
    const bool solved = costs.layout_s > 0;
    const int64_t new_layouts = solved ? TakeNew(layouts[{seed, {digests.layout}}], row.scenes) : 0;
    const int64_t new_scenes = TakeNew(scenes[{seed, {digests.layout, digests.scene}}], row.scenes);
    const int64_t new_pairs =
        TakeNew(pairs[{seed, {digests.layout, digests.scene, digests.frame}}], row.pairs);
    row.layouts_shared = solved ? row.scenes - new_layouts : 0;
    row.scenes_shared = row.scenes - new_scenes;
    row.pairs_shared = row.pairs - new_pairs;
    plan.solves += new_layouts;
    plan.solves_without_sharing += solved ? row.scenes : 0;

    ASSIGN_OR_RETURN(const double pair_s, PairSeconds(config, costs));
    ASSIGN_OR_RETURN(const double build_s, BuildSeconds(config, costs));
    row.solve_core_s = factor * (static_cast<double>(new_layouts) * costs.layout_s +
                                 static_cast<double>(new_scenes) * costs.dress_s);
    const double builds = static_cast<double>((new_pairs + rigs - 1) / rigs);
    row.render_core_s = factor * (static_cast<double>(new_pairs) * pair_s + builds * build_s);
    v1::StudySpec alone;
    alone.set_pairs(new_pairs);  // Shared pairs are hard links.
    *alone.add_variants()->mutable_config() = config;
    row.disk_bytes = EstimateBytes(alone);
    AddTo(plan.total, row);
    plan.rows.push_back(std::move(row));
  }
  std::map<uint64_t, int64_t> layouts_of_seed;
  for (const auto& [of, count] : layouts) {
    plan.max_solves_per_seed = std::max(plan.max_solves_per_seed, ++layouts_of_seed[of.first]);
  }
  plan.training = PlanTraining(study, factor, own);
  plan.total.name = "total";
  return plan;
}

double WallClockS(const StudyPlan& plan, int cores) {
  const double core_s = plan.total.solve_core_s + plan.total.render_core_s +
                        plan.training.train_core_s + plan.training.evaluate_core_s;
  const double one_solve_s =
      plan.total.solve_core_s / static_cast<double>(std::max<int64_t>(1, plan.total.solve_jobs));
  return std::max({core_s / std::max(1, cores), one_solve_s, plan.training.longest_s});
}

absl::StatusOr<double> ReadMeasuredFactor(const std::string& archive_dir) {
  ASSIGN_OR_RETURN(const Dataset dataset, ReadDataset(archive_dir));
  ASSIGN_OR_RETURN(const v1::StudySpec study, LoadStudy(dataset.dir + "/study.lock.yaml"));
  double measured = 0, foretold = 0;
  for (const DatasetVariant& variant : dataset.variants) {
    for (const v1::VariantSpec& spec : study.variants()) {
      if (spec.name() != variant.name) continue;
      ASSIGN_OR_RETURN(const SceneCosts costs, SceneCostsOf(spec.config()));
      ASSIGN_OR_RETURN(double pair_s, PairSeconds(spec.config(), costs));
      ASSIGN_OR_RETURN(const double build_s, BuildSeconds(spec.config(), costs));
      pair_s += build_s / std::max(1, RigsPerSceneOf(study, spec));
      for (const DatasetFrame& frame : variant.frames) {
        if (!frame.line.contains("seconds") || !frame.line["seconds"].contains("cpu")) continue;
        measured += frame.line["seconds"]["cpu"].get<double>();
        foretold += pair_s;
      }
    }
  }
  if (!(measured > 0)) {
    return FailedPrecondition("{}: its index does not say what its pairs cost", archive_dir);
  }
  return measured / foretold;
}

}  // namespace parallax::client
