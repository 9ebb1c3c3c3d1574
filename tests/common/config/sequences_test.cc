// Several baselines, ways of the rig, motion and flow in configs and studies.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/config/check/rig_counts.h"
#include "common/config/config.h"

namespace parallax {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string WhyNot(const std::string& yaml) {
  const auto config = ParseSceneConfig(yaml, "c.yaml");
  return config.ok() ? "" : std::string(config.status().message());
}

TEST(Sequences, BaselinesAreAListOfNumbers) {
  const auto config =
      ParseSceneConfig("rigs: {count: 5, baselines_m: [0.06, 0.12, 0.24]}", "c.yaml");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_THAT(config->rigs().baselines_m(), ElementsAre(0.06, 0.12, 0.24));
  EXPECT_EQ(EyesOfLeft(config->rigs()), 3);
  EXPECT_EQ(PairsOfScene(config->rigs()), 15);
  EXPECT_EQ(EyesOfLeft(DefaultSceneConfig().rigs()), 1);
  EXPECT_EQ(PairsOfScene(DefaultSceneConfig().rigs()), 20);
}

TEST(Sequences, WrongOnesAreToldOf) {
  const struct {
    const char* yaml;
    const char* want;
  } rows[] = {
      {"rigs: {baselines_m: 0.1}", "c.yaml:1: rigs.baselines_m: 0.1, allowed is a list of numbers"},
      {"rigs: {baselines_m: [wide]}",
       "c.yaml:1: rigs.baselines_m[0]: wide is not a number, allowed 0.001 to 2 m"},
      {"rigs: {baselines_m: [0.1, 9]}", "c.yaml:1: rigs.baselines_m[1]: 9 is out of range"},
      {"rigs: {baselines_m: [0.1, 0.2, 0.1]}", "rigs.baselines_m: has one number twice"},
      {"rigs: {baselines_m: [.1, .2, .3, .4, .5, .6, .7, .8, .9]}",
       "rigs.baselines_m: a list of 9, allowed are at most 8"},
      {"rigs: {count: 600, baselines_m: [0.1, 0.2]}", "make 1200 pairs a scene"},
      {"type: dense\nrigs: {path: {paths: 1}}", "rigs.path.paths: camera paths are for rooms"},
      {"type: nature\nrigs: {path: {paths: 1}}", "landscapes have nature.walk.walks"},
      {"rigs: {count: 3, path: {paths: 4}}", "4 paths share 3 frames"},
      {"render: {maps: [depth, flow]}", "render.maps: flow without a sequence"},
      {"floating: {motion: {p: 0.5}}", "floating.motion.p: moves things, but there is no sequence"},
      {"rigs: {path: {fps: 0}}", "rigs.path.fps: 0 is out of range"},
      {"rigs: {baseline_m: 0.3, baselines_m: [0.06, 0.12]}",
       "c.yaml:1: rigs.baseline_m: given beside rigs.baselines_m, allowed is one of them"},
      {"rigs: {path: {fps: 5}}", "c.yaml:1: rigs.path.fps: given, but rigs.path.paths is 0"},
      {"rigs: {path: {speed_mps: 1, max_turn_dps: 9}}", "rigs.path.max_turn_dps: given, but"},
  };
  for (const auto& row : rows) {
    SCOPED_TRACE(row.yaml);
    EXPECT_THAT(WhyNot(row.yaml), HasSubstr(row.want));
  }
  EXPECT_EQ(WhyNot("type: nature\nrender: {maps: [depth, flow]}"), "");
  EXPECT_EQ(WhyNot("rigs: {count: 24, path: {paths: 2}}\nfloating: {motion: {p: 1}}\n"
                   "render: {maps: [depth, flow]}"),
            "");
}

TEST(Sequences, AVariantMayTurnOffWhatItsBaseHas) {
  const std::string base =
      "  - {name: a, set: {rigs: {count: 4, path: {paths: 2, fps: 5}}}}\n"
      "  - {name: b, set: {rigs: {count: 4, path: {paths: 0}}}}\n"
      "  - {name: c, set: {rigs: {camera: {preset: zed_2i}, baselines_m: [0.1, 0.2]}}}\n";
  const auto study = ParseStudy("study: s\npairs: 4\nvariants:\n" + base, "s.yaml");
  ASSERT_TRUE(study.ok()) << study.status();
  const auto again = ParseStudy(StudyToYaml(*study), "lock.yaml");
  EXPECT_TRUE(again.ok()) << again.status() << ": the lock has baseline_m and baselines_m";
}

TEST(Sequences, AStudyTakesAllPairsOfAScene) {
  const std::string head = "study: s\npairs: 60\n";
  const std::string variants =
      "variants:\n  - {name: a, set: {rigs: {count: 4, baselines_m: [0.1, 0.2, 0.3]}}}\n";
  const auto study = ParseStudy(head + variants, "s.yaml");
  ASSERT_TRUE(study.ok()) << study.status();
  EXPECT_EQ(study->rigs_per_scene(), 12);
  const auto again = ParseStudy(StudyToYaml(*study), "lock.yaml");
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->variants(0).config().SerializeAsString(),
            study->variants(0).config().SerializeAsString());
  const auto more = ParseStudy(head + "rigs_per_scene: 13\n" + variants, "s.yaml");
  EXPECT_THAT(std::string(more.status().message()),
              HasSubstr("allowed 1 to rigs.count x rigs.baselines_m = 12"));
}

}  // namespace
}  // namespace parallax
