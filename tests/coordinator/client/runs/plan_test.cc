#include "coordinator/client/runs/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "common/base/system/file.h"
#include "common/config/catalogue_names.h"
#include "common/config/config.h"
#include "common/config/training_plan.h"
#include "common/image/io.h"
#include "coordinator/client/runs/plan_power.h"
#include "tests/coordinator/client/command_test.h"
#include "tests/folder_test.h"
#include "tests/worker/evaluate/test_scores.h"
#include "worker/evaluate/score_table.h"
#include "worker/render/paths/profiles.h"
#include "worker/scene/types/indoor/indoor.h"
#include "worker/scene/types/nature/nature.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const PlanRow& RowOf(const StudyPlan& plan, const std::string& name) {
  return *std::find_if(plan.rows.begin(), plan.rows.end(),
                       [&](const PlanRow& row) { return row.name == name; });
}

TEST(Plan, Table1SolvesEachSeedsRoomsOnceForAll13Variants) {
  const StudyPlan plan = PlanStudy(LoadStudy("table1").value(), 1).value();
  ASSERT_EQ(plan.rows.size(), 13u);
  EXPECT_EQ(plan.total.pairs, 13 * 5000);
  EXPECT_EQ(plan.total.scenes, 13 * 250);
  EXPECT_EQ(plan.solves_without_sharing, 13 * 250);
  EXPECT_LE(plan.max_solves_per_seed, 2);
  EXPECT_EQ(plan.solves, plan.max_solves_per_seed * 250);
  EXPECT_EQ(RowOf(plan, "default").layouts_shared, 0);
  EXPECT_EQ(RowOf(plan, "floating-chairs").layouts_shared, 250);
  // The variants dress their layouts differently, so no scene is wholly another variant's.
  EXPECT_EQ(plan.total.scenes_shared, 0);
}

TEST(Plan, TheFirstVariantPaysForWhatTheNextShares) {
  v1::StudySpec study = LoadStudy("table1").value();
  study.set_pairs(40);
  const StudyPlan plan = PlanStudy(study, 1).value();
  const double first = RowOf(plan, "default").solve_core_s;
  const double later = RowOf(plan, "floating-chairs").solve_core_s;
  // Two scenes: the later one only dresses them.
  const SceneCosts costs = kIndoorScenes.costs(study.variants(0).config());
  EXPECT_NEAR(first - later, 2 * costs.layout_s, 1e-9);
  EXPECT_NEAR(later, 2 * costs.dress_s, 1e-9);
}

TEST(Plan, ATwinOfAVariantCostsNothing) {
  v1::StudySpec study = LoadStudy("table1").value();
  study.set_pairs(30);
  *study.add_variants() = study.variants(0);
  study.mutable_variants(13)->set_name("twin");
  const StudyPlan plan = PlanStudy(study, 1).value();
  const PlanRow& twin = RowOf(plan, "twin");
  EXPECT_EQ(twin.pairs, 30);
  EXPECT_EQ(twin.pairs_shared, 30);
  EXPECT_EQ(twin.scenes_shared, 2);
  EXPECT_EQ(twin.solve_core_s + twin.render_core_s, 0);
  EXPECT_EQ(twin.disk_bytes, 0);
}

TEST(Plan, LandscapesCostMoreThanRoomsByTheirBuildAndTheirTracing) {
  const StudyPlan plan = PlanStudy(LoadStudy("mix").value(), 1).value();
  const PlanRow &indoor = RowOf(plan, "indoor"), &nature = RowOf(plan, "nature");
  ASSERT_EQ(nature.pairs, indoor.pairs);
  EXPECT_EQ(nature.scenes, 100) << "of 50 frames";
  const SceneCosts costs = kNatureScenes.costs(LoadSceneConfig("nature").value());
  EXPECT_NEAR(nature.solve_core_s, 100 * (costs.layout_s + costs.dress_s), 1e-6);
  EXPECT_GT(costs.trace_times, 1);
  EXPECT_GT(nature.render_core_s, indoor.render_core_s + 100 * costs.build_s);
}

TEST(Plan, LayoutsArePricedByTheSolversModeAndTheRooms) {
  const auto solve_s = [](const std::string& set) {
    const auto study = ParseStudy(
        "study: s\nbase: indoor\npairs: 1\nset: {" + set + "}\nvariants: [{name: a}]\n", "s.yaml");
    EXPECT_TRUE(study.ok()) << study.status();
    return study.ok() ? PlanStudy(*study, 1)->total.solve_core_s : 0;
  };
  const double reduced = solve_s("solver: {mode: reduced}"), full = solve_s("solver: {mode: full}");
  EXPECT_GT(full, reduced);
  const std::string best = "solver: {mode: best, budget_s: 30}";
  EXPECT_NEAR(solve_s(best) - reduced, 30, 1e-9);
  EXPECT_NEAR(solve_s(best + ", room: {rooms: {uniform_int: [2, 4]}}") - solve_s(best), 2 * 30.26,
              1e-6);
  // A house of eight rooms took 3.0 s (worker/layout/README.md).
  EXPECT_NEAR(solve_s("solver: {mode: full}, room: {rooms: 8}"), 3.0, 0.05);
}

TEST(Plan, LandscapesArePricedByTheirBiomes) {
  const auto pair_s = [](const std::string& biomes) {
    const auto study = ParseStudy(
        "study: s\npairs: 50\nvariants: [{name: a, base: nature, set: "
        "{nature: {biomes: " +
            biomes + "}}}]",
        "s.yaml");
    return PlanStudy(study.value(), 1)->total.render_core_s / 50;
  };
  const double plain = pair_s("{plain: 1}"), desert = pair_s("{desert: 1}");
  EXPECT_GT(plain, 2 * desert) << "grass is what rays are spent on";
  EXPECT_NEAR(pair_s("{plain: 1, desert: 3}"), 0.25 * plain + 0.75 * desert, 1e-6);
}

TEST(Plan, VariantsOfOtherSeedsShareNothing) {
  v1::StudySpec study = LoadStudy("table1").value();
  study.set_pairs(30);
  *study.add_variants() = study.variants(0);
  study.mutable_variants(13)->set_name("other");
  study.mutable_variants(13)->set_seed(99);
  const StudyPlan plan = PlanStudy(study, 1).value();
  EXPECT_EQ(RowOf(plan, "other").pairs_shared, 0);
  EXPECT_EQ(RowOf(plan, "other").layouts_shared, 0);
  EXPECT_EQ(plan.max_solves_per_seed, 1) << "of one seed";
}

TEST(Plan, SaysWhichDifferencesAreSignificant) {
  v1::StudySpec study = LoadStudy("table1").value();
  study.mutable_train()->set_seeds(3);
  study.mutable_evaluate()->add_benchmarks("eth3d");
  study.mutable_evaluate()->add_benchmarks("shipped");  // One pair says nothing of others.
  ResolveTraining(&study);
  const auto powers = PowerOf(study, {{"mine", {30, 640, 480}}}, {{"mine", {.spread = {1, 1, 1}}}});
  ASSERT_EQ(powers.size(), 2u);
  EXPECT_EQ(powers[0].benchmark, "eth3d");
  EXPECT_EQ(powers[0].pairs, 27);
  EXPECT_FALSE(powers[0].measured_here);
  EXPECT_EQ(powers[1].benchmark, "mine");
  EXPECT_TRUE(powers[1].measured_here);
  EXPECT_EQ(powers[1].least_difference, *LeastDifference({1, 1, 1}, 3, 30, 0.95));
  EXPECT_LT(PowerOf(study, {}, {}, 12)[0].least_difference, powers[0].least_difference);
  EXPECT_TRUE(PowerOf(study, {}, {}, 1).empty());
}

TEST(Plan, GroupsOfPairsSayLessThanAsManyPairs) {
  v1::StudySpec study = LoadStudy("table1").value();
  study.mutable_train()->set_seeds(3);
  study.mutable_evaluate();
  ResolveTraining(&study);
  const auto least = [&](const std::vector<int>& units, bool weigh_groups = false) {
    study.mutable_evaluate()->set_weigh_groups(weigh_groups);
    return PowerOf(study, {{"mine", {30, 640, 480, units}}}, {}).back().least_difference;
  };
  const std::vector<int> ones(30, 1), threes(10, 3), unequal = {1, 1, 1, 2, 5, 3, 16, 1};
  EXPECT_DOUBLE_EQ(least(ones), least({}));
  EXPECT_DOUBLE_EQ(least(threes), least(threes, true));
  EXPECT_GT(least(threes), least({}));
  EXPECT_GT(least(unequal), 1.03 * least(threes));
  EXPECT_GT(least(unequal, true), least(unequal));  // Pairs that stand alone count most.
}

TEST(Plan, AFewPairsLessChangeLittle) {
  v1::StudySpec study = LoadStudy("table1").value();
  study.mutable_train()->set_seeds(12);
  study.mutable_evaluate();
  ResolveTraining(&study);
  const BenchmarkSizes own = {{"mine", {200, 640, 480, std::vector<int>(8, 25)}}};
  const double all = PowerOf(study, own, {}).back().least_difference;
  study.mutable_evaluate()->set_max_pairs(199);
  EXPECT_NEAR(PowerOf(study, own, {}).back().least_difference, all, 0.02 * all);
}

TEST(Plan, OwnPairsAreCountedAndPriced) {
  std::string dir = testing::TempDir() + "/plan_own_XXXXXX";
  ASSERT_NE(mkdtemp(dir.data()), nullptr);
  const std::string pair = dir + "/real/yard/";
  fs::create_directories(pair);
  for (const char* file : {"im0.png", "im1.png"}) {
    ASSERT_TRUE(WriteFile(pair + file, *EncodePng(ImageRgb8(40, 30))).ok());
  }
  ImageF truth(40, 30);
  truth.values().assign(truth.pixels(), 3.0f);
  ASSERT_TRUE(WritePfm(pair + "disp0GT.pfm", truth).ok());
  auto study = ParseStudy(
      "study: s\npairs: 1\nvariants: [{name: a}, {name: b}]\ntrain: {}\nevaluate:\n"
      "  benchmarks: [{name: yard, folder: real}]\n",
      dir + "/s.yaml");
  ASSERT_TRUE(study.ok()) << study.status();
  const auto sizes = SizesOfOwnBenchmarks(*study);
  ASSERT_TRUE(sizes.ok()) << sizes.status();
  ASSERT_EQ(sizes->size(), 1u);
  EXPECT_EQ(sizes->at("yard").pairs, 1);
  EXPECT_EQ(sizes->at("yard").width_px, 40);
  EXPECT_GT(PlanStudy(*study, 1, *sizes)->training.evaluate_core_s,
            PlanStudy(*study, 1)->training.evaluate_core_s);
  // Five of ten pairs in five sets: one of each.
  std::string list;
  for (const char* set : {"a", "b", "c", "d", "e"}) {
    const std::string line = "real/yard/im0.png real/yard/im1.png real/yard/disp0GT.pfm\n";
    list += "group: " + std::string(set) + "\n" + line + line;
  }
  ASSERT_TRUE(WriteFile(dir + "/pairs.txt", list).ok());
  study->mutable_evaluate()->mutable_own_benchmarks(0)->clear_folder();
  study->mutable_evaluate()->mutable_own_benchmarks(0)->set_list(dir + "/pairs.txt");
  EXPECT_EQ(SizesOfOwnBenchmarks(*study)->at("yard").units, std::vector<int>(5, 2));
  study->mutable_evaluate()->set_max_pairs(5);
  EXPECT_EQ(SizesOfOwnBenchmarks(*study)->at("yard").units, std::vector<int>(5, 1));
  fs::remove_all(dir);
  EXPECT_TRUE(SizesOfOwnBenchmarks(*study)->empty());
}

TEST(Plan, TrainingsAndEvaluationsHaveTheirPrice) {
  v1::StudySpec study = LoadStudy("table1").value();
  EXPECT_EQ(PlanStudy(study, 1)->training.trainings, 0);
  v1::TrainSpec& train = *study.mutable_train();
  train.set_seeds(3);
  v1::EvaluateSpec& evaluate = *study.mutable_evaluate();
  evaluate.add_benchmarks("shipped");
  evaluate.add_benchmarks("kitti2015");
  evaluate.add_baselines("sgbm");
  evaluate.set_max_pairs(20);
  evaluate.set_heldout_pairs(10);
  ResolveTraining(&study);
  const auto priced = [&study](double factor = 1) { return PlanStudy(study, factor)->training; };
  EXPECT_EQ(priced().trainings, 13 * 3);
  // 1,500 steps of the trainer's own batch and crops at 0.48 core-seconds.
  EXPECT_NEAR(priced().train_core_s, 39 * 1500 * 0.48, 1e-6);
  EXPECT_NEAR(priced().longest_s, 1500 * 0.48 / 2, 1e-9) << "on two threads";
  EXPECT_EQ(priced().evaluations, (39 + 1) * 3);
  // All are looked at twice: at 0.71 of their size, and 1280 px wide.
  const auto seen_mpx = [](double width, double height) {
    return 1e-6 * (0.5041 * width * height + 1280 * 1280 * height / width);
  };
  const double shipped_mpx = seen_mpx(741, 500), kitti_mpx = seen_mpx(1242, 375),
               heldout_mpx = seen_mpx(1280, 720);
  EXPECT_NEAR(priced().evaluate_core_s,
              40 * 3.9 * (1 * shipped_mpx + 20 * kitti_mpx + 10 * heldout_mpx), 1e-6);
  EXPECT_NEAR(priced(2).train_core_s, 2 * priced().train_core_s, 1e-6);
  // A curated set is one more, and its network looks at all pairs before, for each seed.
  const double before = priced().train_core_s;
  v1::Mixture* curated = train.add_mixtures();
  curated->set_curated(true);
  curated->add_parts()->set_variant(study.variants(0).name());
  curated->mutable_parts(0)->set_weight(1);
  const double looked = 3.0 * static_cast<double>(study.pairs()) * heldout_mpx;
  EXPECT_NEAR(priced().train_core_s, before + 3 * 1500 * 0.48 + 3.9 * looked, 1e-6 * before);
  train.clear_mixtures();
  train.set_steps(3000);
  train.set_batch(4);
  EXPECT_NEAR(priced().train_core_s, 39 * 3000 * 2 * 0.48, 1e-6);
  train.set_steps(0);
  train.set_minutes(2);
  EXPECT_NEAR(priced().train_core_s, 39 * 2 * 60 * 2, 1e-6);
  train.set_minutes(0);
  train.set_trainer("raft-stereo");
  EXPECT_EQ(priced().train_core_s, 0);
  EXPECT_EQ(priced().not_priced, "raft-stereo");
}

TEST(Plan, EveryBenchmarkHasASize) {
  for (const std::string& name : BenchmarkNames()) {
    EXPECT_GT(SizeOfBenchmark(name).pairs, 0) << name;
    EXPECT_GT(SeenMpx(SizeOfBenchmark(name).width_px, SizeOfBenchmark(name).height_px), 0) << name;
  }
  EXPECT_EQ(SizeOfBenchmark("nothing").pairs, 0);
  EXPECT_EQ(SeenMpx(0, 0), 0);
}

TEST(Plan, TheNetworkSeesPicturesTwiceReducedAndAsLargeAsItTakesThem) {
  EXPECT_NEAR(SeenMpx(1280, 720), 0.9216 * (0.5041 + 1), 1e-9);
  EXPECT_NEAR(SeenMpx(2560, 1440), 0.9216 * (0.5041 + 1), 1e-9);
  EXPECT_NEAR(SeenMpx(320, 180), 0.0576 * (0.5041 + 4), 1e-9);
}

TEST(Plan, SamplesAndPixelsCostWhatTheySay) {
  v1::StudySpec study = LoadStudy("table1").value();
  study.mutable_variants()->DeleteSubrange(1, 12);
  v1::RenderConfig& render = *study.mutable_variants(0)->mutable_config()->mutable_render();
  render.set_denoise(v1::RenderConfig::DENOISE_OFF);
  render.set_cache(v1::RenderConfig::CACHE_OFF);
  const auto cost = [&](int samples, int width, int height) {
    render.set_samples_per_pixel(samples);
    v1::RigConfig& rigs = *study.mutable_variants(0)->mutable_config()->mutable_rigs();
    rigs.set_width_px(width);
    rigs.set_height_px(height);
    const PlanRow row = PlanStudy(study, 1)->total;
    return (row.render_core_s - 250 * kMeasuredCosts.build_s) / 5000;
  };
  const double small = cost(8, 640, 360);
  EXPECT_NEAR(cost(8, 1280, 720), 4 * small, 1e-6);
  EXPECT_NEAR(cost(16, 640, 360) - small, 8 * kMeasuredCosts.trace_s_per_mpx_sample * 0.2304, 1e-6);
  render.clear_denoise();
  EXPECT_NEAR(cost(8, 640, 360) - small, kMeasuredCosts.denoise_balanced_s_per_mpx * 0.2304, 1e-6);
  render.set_denoise(v1::RenderConfig::DENOISE_ON);
  EXPECT_NEAR(cost(8, 640, 360) - small, kMeasuredCosts.denoise_high_s_per_mpx * 0.2304, 1e-6);
}

TEST(Plan, ARadianceCacheIsPaidOnceASceneAndNotByDenseScenes) {
  const auto cost = [](int variant, v1::RenderConfig::Cache cache) {
    v1::StudySpec study = LoadStudy("mix").value();
    study.mutable_variants()->SwapElements(0, variant);
    study.mutable_variants()->DeleteSubrange(1, study.variants_size() - 1);
    study.mutable_variants(0)->mutable_config()->mutable_render()->set_cache(cache);
    return PlanStudy(study, 1)->total.render_core_s;
  };
  constexpr int kIndoor = 0, kDense = 1;
  const auto on = v1::RenderConfig::CACHE_PROFILE, off = v1::RenderConfig::CACHE_OFF;
  const double paths = 1e-6 * static_cast<double>(ResolveProfile({})->cache_paths);
  ASSERT_GT(paths, 0);
  EXPECT_NEAR(cost(kIndoor, on) - cost(kIndoor, off),
              250 * paths * kMeasuredCosts.cache_s_per_mpath, 1e-6);
  EXPECT_EQ(cost(kDense, on), cost(kDense, off));
}

TEST(Plan, AFurtherRightEyeCostsHalfAPairAndFlowItsOwn) {
  const auto cost_of = [](const char* set) {
    const std::string yaml =
        "study: s\npairs: 240\nvariants: [{name: a, set: " + std::string(set) + "}]\n";
    const StudyPlan plan = PlanStudy(ParseStudy(yaml, "s.yaml").value(), 1).value();
    EXPECT_EQ(plan.total.scenes, 4);
    // Without what the pairs of a scene share.
    return plan.total.render_core_s;
  };
  const double shared = cost_of("{rigs: {count: 60, width_px: 16, height_px: 16}}");
  const double one = cost_of("{rigs: {count: 60}}") - shared;
  const double three = cost_of("{rigs: {count: 20, baselines_m: [0.1, 0.2, 0.3]}}") - shared;
  EXPECT_NEAR(three / one, 2.0 / 3, 0.01);
  const double still = cost_of("{rigs: {count: 60, path: {paths: 3}}}");
  const double flow =
      cost_of("{rigs: {count: 60, path: {paths: 3}}, render: {maps: [depth, objects, flow]}}");
  EXPECT_NEAR(flow - still, 240 * 0.9216 * kMeasuredCosts.flow_s_per_mpx, 1);
}

TEST(Plan, WallClockIsCoreTimeOverCoresUntilOneSceneIsTheLimit) {
  StudyPlan plan;
  plan.total.solve_jobs = 10;
  plan.total.solve_core_s = 20;
  plan.total.render_core_s = 980;
  EXPECT_DOUBLE_EQ(WallClockS(plan, 1), 1000);
  EXPECT_DOUBLE_EQ(WallClockS(plan, 4), 250);
  EXPECT_DOUBLE_EQ(WallClockS(plan, 100000), 2);
  EXPECT_DOUBLE_EQ(WallClockS(StudyPlan(), 2), 0);
}

TEST(Plan, AFactorScalesTimesOnly) {
  const v1::StudySpec study = LoadStudy("table1").value();
  const StudyPlan one = PlanStudy(study, 1).value(), three = PlanStudy(study, 3).value();
  EXPECT_NEAR(three.total.solve_core_s, 3 * one.total.solve_core_s, 1e-6);
  EXPECT_NEAR(three.total.render_core_s, 3 * one.total.render_core_s, 1e-3);
  EXPECT_EQ(three.total.disk_bytes, one.total.disk_bytes);
  EXPECT_EQ(three.solves, one.solves);
}

class MeasuredFactorTest : public FolderTest {
 protected:
  void SetUp() override {
    v1::StudySpec study = LoadStudy("table1").value();
    study.set_rigs_per_scene(1);
    study.set_pairs(2);
    std::ofstream(dir_ + "/study.lock.yaml") << StudyToYaml(study);
    fs::create_directories(dir_ + "/default");
  }

  void WriteIndex(const std::string& seconds) {
    std::ofstream out(dir_ + "/default/index.jsonl");
    for (int scene = 0; scene < 2; ++scene) {
      out << R"({"scene":)" << scene << R"(,"rig":0,"passed":true,"files":{},"seconds":)" << seconds
          << "}\n";
    }
  }
};

TEST_F(MeasuredFactorTest, IsWhatPairsTookOverWhatIsForetold) {
  v1::StudySpec study = LoadStudy("table1").value();
  study.mutable_variants()->DeleteSubrange(1, 12);
  study.set_rigs_per_scene(1);
  study.set_pairs(1);
  const double foretold = PlanStudy(study, 1)->total.render_core_s;
  WriteIndex(R"({"cpu":)" + std::to_string(2.5 * foretold) + "}");
  const auto factor = ReadMeasuredFactor(dir_);
  ASSERT_TRUE(factor.ok()) << factor.status();
  EXPECT_NEAR(*factor, 2.5, 1e-4);
}

TEST_F(MeasuredFactorTest, SaysWhenNothingWasMeasured) {
  WriteIndex("{}");
  const auto factor = ReadMeasuredFactor(dir_);
  EXPECT_EQ(factor.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(factor.status().message()),
              HasSubstr("does not say what its pairs cost"));
  EXPECT_EQ(ReadMeasuredFactor(dir_ + "/nowhere").status().code(), absl::StatusCode::kNotFound);
}

// Scores of eth3d of three trainings of three variants, each next one with larger differences.
std::vector<Evaluation> ScoresOfThreeVariants(const std::vector<std::string>& variants) {
  std::vector<Evaluation> all;
  for (int64_t seed = 1; seed <= 3; ++seed) {
    for (size_t v = 0; v < variants.size(); ++v) {
      std::vector<double> figures;
      for (int64_t i = 0; i < 27; ++i) {
        const auto of_both = static_cast<double>((i * seed + i * i + static_cast<int64_t>(v)) % 5);
        figures.push_back(10 + static_cast<double>(i % 7) + static_cast<double>(v) * of_both);
      }
      all.push_back(SyntheticEvaluation("eth3d", variants[v], seed, figures));
    }
  }
  return all;
}

class MeasuredSpreadsTest : public MeasuredFactorTest {
 protected:
  // Writes score files into a new folder.
  std::string Write(const std::vector<Evaluation>& evaluations) {
    const std::string dir = dir_ + "/scores" + std::to_string(++folders_);
    fs::create_directories(dir);
    for (size_t i = 0; i < evaluations.size(); ++i) {
      EXPECT_TRUE(WriteEvaluation(dir + "/" + std::to_string(i) + ".jsonl", evaluations[i]).ok());
    }
    return dir;
  }

  double LeastOf(const std::vector<Evaluation>& evaluations, const std::string& reference = "") {
    v1::StudySpec study = ParseStudy(kStudy, "s.yaml").value();
    study.mutable_evaluate()->set_reference(reference);
    const auto spreads = ReadSpreads(Write(evaluations), study);
    EXPECT_TRUE(spreads.ok()) << spreads.status();
    const auto powers = PowerOf(study, {}, *spreads);
    EXPECT_TRUE(powers.at(0).measured_here);
    return powers.at(0).least_difference;
  }

  static constexpr char kStudy[] =
      "study: s\npairs: 1\nvariants: [{name: a}, {name: b}]\ntrain: {seeds: 3}\n"
      "evaluate: {benchmarks: [eth3d]}\n";

 private:
  int folders_ = 0;
};

TEST_F(MeasuredSpreadsTest, AreOfTrainingsAgainstTheReference) {
  const std::vector<Evaluation> trained = ScoresOfThreeVariants({"default", "other", "wild"});
  std::vector<Evaluation> all = trained;
  all.push_back(trained[2]);
  all.back().run = {.variant = "sgbm", .trainer = "opencv"};
  EXPECT_DOUBLE_EQ(LeastOf(all), LeastOf(trained));
  EXPECT_NEAR(LeastOf(trained, "wild"),
              LeastOf(ScoresOfThreeVariants({"wild", "other", "default"})), 1e-9);
}

TEST_F(MeasuredSpreadsTest, StandForOtherNumbersOfPairs) {
  const auto scores = ScoresOfThreeVariants({"default", "other"});
  const DifferenceSpread spread = MakeTable(scores, {})->comparisons[0].comparison.spread;
  v1::StudySpec study = ParseStudy(kStudy, "s.yaml").value();
  study.mutable_evaluate()->set_max_pairs(5);
  const auto spreads = ReadSpreads(Write(scores), study);
  ASSERT_TRUE(spreads.ok()) << spreads.status();
  EXPECT_DOUBLE_EQ(PowerOf(study, {}, *spreads, 8).at(0).least_difference,
                   *LeastDifference({spread.seeds, spread.images, spread.rest}, 8, 5, 0.95));
}

TEST_F(MeasuredSpreadsTest, ThePlanNamesTheFigureOfTheScores) {
  WriteIndex(R"({"cpu":1})");
  std::vector<Evaluation> scores = ScoresOfThreeVariants({"default", "other"});
  for (Evaluation& one : scores) {
    one.headline = {.measure = BadAt(1), .region = "nocc"};
    for (Scores& image : one.images) image.regions["nocc"] = image.regions["all"];
  }
  Write(scores);
  const std::string file = dir_ + "/s.yaml";
  ASSERT_TRUE(WriteFile(file, kStudy).ok());
  const Outcome json = RunCommand({"plan", file, "--from", dir_, "--json"});
  ASSERT_EQ(json.exit_code, kExitOk) << json.err;
  EXPECT_EQ(nlohmann::json::parse(json.out)["power"][0]["metric"], "bad-1 nocc");
  EXPECT_THAT(RunCommand({"plan", file, "--from", dir_}).out,
              HasSubstr("differences of bad-1 nocc from "));
  std::string by_log = kStudy;
  by_log.insert(by_log.find("}\n", by_log.find("eth3d")), ", decides: log");
  ASSERT_TRUE(WriteFile(file, by_log).ok());
  const Outcome log = RunCommand({"plan", file, "--from", dir_});
  EXPECT_THAT(log.out, HasSubstr("differences of log nocc from ")) << log.err;
  EXPECT_THAT(log.out, testing::Not(HasSubstr("that it would tell")));
}

}  // namespace
}  // namespace parallax::client
