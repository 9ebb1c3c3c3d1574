#include "coordinator/study/expansion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "common/base/rng.h"

namespace parallax {
namespace {

v1::StudySpec GoodSpec() {
  v1::StudySpec spec;
  spec.set_name("baseline");
  spec.set_pairs(10);
  spec.set_rigs_per_scene(4);
  for (const char* name : {"narrow", "wide"}) {
    v1::VariantSpec* variant = spec.add_variants();
    variant->set_name(name);
    variant->mutable_config()->mutable_rigs()->set_count(20);
  }
  return spec;
}

TEST(CheckStudySpec, NamesTheVariantWhoseExpansionWouldNotEnd) {
  ASSERT_TRUE(CheckStudySpec(GoodSpec()).ok());
  const struct {
    const char* message;
    void (*spoil)(v1::StudySpec&);
  } cases[] = {
      {"pairs: 0", [](v1::StudySpec& s) { s.set_pairs(0); }},
      {"pairs: 200000000", [](v1::StudySpec& s) { s.mutable_variants(1)->set_pairs(200'000'000); }},
      {"rigs_per_scene: 0", [](v1::StudySpec& s) { s.set_rigs_per_scene(0); }},
      {"study.variants", [](v1::StudySpec& s) { s.clear_variants(); }},
      {"\"narrow\": named twice",
       [](v1::StudySpec& s) { s.mutable_variants(1)->set_name("narrow"); }},
      {"pictures_sha256 is missing",
       [](v1::StudySpec& s) {
         s.mutable_variants(1)->mutable_config()->mutable_materials()->set_picture_dir("p");
       }},
      {"materials.textures_sha256 is missing",
       [](v1::StudySpec& s) {
         s.mutable_variants(1)->mutable_config()->mutable_materials()->set_texture_dir("p");
       }},
      {"lighting.hdris_sha256 is missing",
       [](v1::StudySpec& s) {
         s.mutable_variants(1)->mutable_config()->mutable_lighting()->set_hdri_dir("p");
       }},
      {"`parallax config meshes DIR` prints",
       [](v1::StudySpec& s) {
         s.mutable_variants(1)->mutable_config()->mutable_assets()->add_include("p");
       }},
  };
  for (const auto& c : cases) {
    v1::StudySpec spec = GoodSpec();
    c.spoil(spec);
    const absl::Status status = CheckStudySpec(spec);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << c.message;
    EXPECT_THAT(std::string(status.message()), testing::HasSubstr(c.message));
  }
}

VariantPlan Plan(int64_t wanted, uint32_t rigs) {
  return {.pairs_wanted = wanted, .rigs_per_scene = rigs, .scenes_ahead = 1000};
}

TEST(NextScenes, OnlyTheLastSceneIsPartial) {
  const Expansion expansion = NextScenes(Plan(10, 4), 100);
  ASSERT_EQ(expansion.scenes.size(), 3u);
  EXPECT_EQ(expansion.scenes[0].rigs, 4u);
  EXPECT_EQ(expansion.scenes[1].rigs, 4u);
  EXPECT_EQ(expansion.scenes[2].rigs, 2u);
  EXPECT_EQ(expansion.scenes[2].ordinal, 2u);
  EXPECT_FALSE(expansion.top_up);
}

TEST(NextScenes, KeepsWithinTheWindowAndTheLimit) {
  VariantPlan plan = Plan(1'000'000, 20);
  EXPECT_EQ(NextScenes(plan, 64).scenes.size(), 64u);
  plan.scenes_open = 990;
  EXPECT_EQ(NextScenes(plan, 64).scenes.size(), 10u);
  plan.scenes_open = 1500;
  EXPECT_TRUE(NextScenes(plan, 64).scenes.empty());
}

TEST(NextScenes, NothingIsAddedToAFullPlan) {
  VariantPlan plan = Plan(10, 4);
  plan.pairs_planned = 10;
  plan.next_ordinal = 3;
  plan.highest_living = ScenePlan{2, 2};
  const Expansion expansion = NextScenes(plan, 100);
  EXPECT_FALSE(expansion.top_up);
  EXPECT_TRUE(expansion.scenes.empty());
}

TEST(NextScenes, ThePartialSceneIsToppedUpBeforeANewOneBegins) {
  VariantPlan plan = Plan(10, 4);
  plan.pairs_planned = 6;  // Scene 0 was rejected.
  plan.next_ordinal = 3;
  plan.highest_living = ScenePlan{2, 2};
  const Expansion expansion = NextScenes(plan, 100);
  ASSERT_TRUE(expansion.top_up);
  EXPECT_EQ(expansion.top_up->ordinal, 2u);
  EXPECT_EQ(expansion.top_up->rigs, 4u);
  ASSERT_EQ(expansion.scenes.size(), 1u);
  EXPECT_EQ(expansion.scenes[0].ordinal, 3u);
  EXPECT_EQ(expansion.scenes[0].rigs, 2u);
}

// Plays a variant in which a seed is valid or not by its ordinal alone, with rejections coming to
// light in random order.
std::map<uint32_t, uint32_t> PlayVariant(uint64_t world, uint64_t order) {
  Rng orders(SceneSeed{order}, "order");
  const auto valid = [&](uint32_t ordinal) {
    return Rng(SceneSeed{world}, "valid").Child("scene", ordinal).Bernoulli(0.6);
  };
  VariantPlan plan = Plan(22, 5);
  plan.scenes_ahead = 3;
  std::map<uint32_t, uint32_t> living;
  std::vector<uint32_t> open;
  do {
    plan.scenes_open = static_cast<int64_t>(open.size());
    plan.highest_living.reset();
    if (!living.empty()) plan.highest_living = {living.rbegin()->first, living.rbegin()->second};
    const Expansion expansion = NextScenes(plan, 100);
    if (expansion.top_up) living[expansion.top_up->ordinal] = expansion.top_up->rigs;
    for (const ScenePlan& scene : expansion.scenes) {
      living[scene.ordinal] = scene.rigs;
      open.push_back(scene.ordinal);
      plan.next_ordinal = scene.ordinal + 1;
    }
    if (!open.empty()) {
      const auto at = open.begin() + orders.UniformInt(0, static_cast<int>(open.size()) - 1);
      if (!valid(*at)) living.erase(*at);
      open.erase(at);
    }
    plan.pairs_planned = 0;
    for (const auto& [ordinal, rigs] : living) plan.pairs_planned += rigs;
  } while (!open.empty() || plan.pairs_planned < plan.pairs_wanted);
  return living;
}

TEST(NextScenes, TheEndDoesNotDependOnTheOrderOfRejections) {
  for (uint64_t world = 0; world < 20; ++world) {
    const auto expected = PlayVariant(world, 0);
    int64_t pairs = 0;
    for (const auto& [ordinal, rigs] : expected) pairs += rigs;
    EXPECT_EQ(pairs, 22);
    for (uint64_t order = 1; order < 20; ++order) {
      EXPECT_EQ(PlayVariant(world, order), expected) << "world " << world << " order " << order;
    }
  }
}

TEST(GiveUpReason, SpeaksOnlyWhenGoingOnIsHopeless) {
  const struct {
    SceneTally tally;
    const char* reason;  // "" = goes on.
  } cases[] = {
      {{0, 0, 0}, ""},
      {{0, 49, 0}, ""},
      {{0, 50, 0}, "first 50 seeds"},
      {{1, 50, 0}, ""},
      {{0, 0, 9}, ""},
      {{0, 0, 10}, "first 10 scenes"},
      {{5, 0, 15}, ""},
      {{5, 0, 16}, "most scenes fail"},
      {{10'000, 0, 10}, ""},
      {{2, 91, 0}, "hardly"},
      {{1000, 9000, 0}, ""},
      // Every scene is solved, and no render succeeds.
      {{1000, 0, 9, 0}, ""},
      {{1000, 0, 10, 0}, "10 scenes failed and no pair was made"},
      {{1000, 0, 13, 1}, ""},
      {{1000, 0, 14, 1}, "hardly a pair: 14 scenes failed, pairs made: 1"},
      {{1000, 0, 900, 1000}, ""},
      {{1000, 0, 900}, ""},
  };
  for (const auto& c : cases) {
    const std::string reason = GiveUpReason(c.tally);
    if (*c.reason == 0) {
      EXPECT_EQ(reason, "");
    } else {
      EXPECT_THAT(reason, testing::HasSubstr(c.reason));
    }
  }
}

TEST(GiveUpReason, EndsWithTheLastReasonAndIsNotLong) {
  SceneTally tally{.solved = 20, .lost = 10, .pairs = 0, .last_reason = "a.png: broken PNG"};
  EXPECT_THAT(GiveUpReason(tally),
              testing::EndsWith("no pair was made; the last: a.png: broken PNG"));
  tally.last_reason = std::string(4000, 'x');
  EXPECT_LT(GiveUpReason(tally).size(), 700u);
  tally.lost = 0;
  EXPECT_EQ(GiveUpReason(tally), "") << "a reason alone is none to give up";
}

}  // namespace
}  // namespace parallax
