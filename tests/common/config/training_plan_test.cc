// `train` and `evaluate` of studies: as files, as messages, resolved, and what wrong ones are told.
#include "common/config/training_plan.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/config/catalogue_names.h"
#include "common/config/check/limits.h"
#include "common/config/config.h"
#include "google/protobuf/util/message_differencer.h"

namespace parallax {
namespace {

using ::google::protobuf::util::MessageDifferencer;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr char kHead[] = R"(study: s
pairs: 40
rigs_per_scene: 2
variants:
  - name: wide
  - name: narrow
    set: {rigs: {baseline_m: 0.1}}
  - name: dense
    base: dense
    pairs: 10
)";

absl::StatusOr<v1::StudySpec> ParseTraining(const std::string& training) {
  return ParseStudy(kHead + training, "s.yaml");
}
v1::StudySpec ParsedTraining(const std::string& training) {
  const auto study = ParseTraining(training);
  EXPECT_TRUE(study.ok()) << study.status();
  return study.ok() ? *study : v1::StudySpec();
}

std::vector<std::string> SetNames(const v1::StudySpec& study) {
  std::vector<std::string> names;
  for (const v1::Mixture& set : TrainingSetsOf(study)) names.push_back(set.name());
  return names;
}

TEST(Training, AbsentNothingIsTrainedAndTheLockSaysNothingOfIt) {
  const v1::StudySpec study = ParsedTraining("");
  EXPECT_FALSE(study.has_train());
  EXPECT_FALSE(study.has_evaluate());
  EXPECT_THAT(TrainingSetsOf(study), IsEmpty());
  EXPECT_THAT(StudyToYaml(study), testing::Not(HasSubstr("train:")));
  EXPECT_EQ(study.variants_size(), 3);
}

TEST(Training, EmptyMapsMeanEveryDefault) {
  const v1::StudySpec study = ParsedTraining("train: {}\nevaluate: {}\n");
  EXPECT_EQ(study.train().trainer(), "builtin");
  EXPECT_EQ(study.train().seeds(), 3);
  EXPECT_EQ(study.train().threads(), 2);
  EXPECT_THAT(study.evaluate().benchmarks(), ElementsAre("shipped"));
  EXPECT_THAT(study.evaluate().baselines(), ElementsAre("sgbm"));
  EXPECT_THAT(study.evaluate().group_by(), ElementsAre("class", "material"));
  EXPECT_THAT(SetNames(study), ElementsAre("wide", "narrow", "dense"));
}

TEST(Training, AMixtureIsASetOfItsOwnBesideTheVariants) {
  const v1::StudySpec study = ParsedTraining(R"(train:
  steps: 100
  variants: [narrow]
  mixtures:
    - name: both
      share: 0.5
      mismatched: true
      parts:
        - {variant: wide, weight: 2}
        - {variant: dense}
)");
  EXPECT_THAT(SetNames(study), ElementsAre("narrow", "both"));
  const v1::Mixture both = TrainingSetsOf(study)[1];
  EXPECT_EQ(both.share(), 0.5);
  EXPECT_TRUE(both.mismatched());
  ASSERT_EQ(both.parts_size(), 2);
  EXPECT_EQ(both.parts(0).weight(), 2);
  EXPECT_EQ(both.parts(1).weight(), 1) << "the default";
  EXPECT_THAT(SetNames(ParsedTraining("train: {only_mixtures: true, mixtures: [{name: m, parts: "
                                      "[{variant: wide}]}]}\n")),
              ElementsAre("m"));
}

TEST(Training, AShareOfAMixturesPairsMayBeMismatchedAndTheLockKeepsIt) {
  const v1::StudySpec study = ParsedTraining(R"(train:
  variants: [wide]
  mixtures:
    - {name: tenth, mismatched: true, mismatched_share: 0.1, parts: [{variant: wide}]}
    - {name: control, mismatched: true, parts: [{variant: wide}]}
)");
  const auto shares = [](const v1::StudySpec& of) {
    std::vector<double> all;
    for (const v1::Mixture& set : TrainingSetsOf(of)) all.push_back(MismatchedShareOf(set));
    return all;
  };
  EXPECT_THAT(shares(study), ElementsAre(0, 0.1, 1));
  const auto again = ParseStudy(StudyToYaml(study), "study.lock.yaml");
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_THAT(shares(*again), ElementsAre(0, 0.1, 1));
  // Sets of other shares are other data: neither's networks score the other's frames.
  v1::Mixture curated = TrainingSetsOf(study)[1];
  curated.set_curated(true);
  EXPECT_EQ(PlainTwinOf(curated, TrainingSetsOf(study)), 1);
}

TEST(Training, AnEmptyListIsMeant) {
  const v1::StudySpec study =
      ParsedTraining("train: {}\nevaluate: {baselines: [], group_by: []}\n");
  EXPECT_THAT(study.evaluate().baselines(), IsEmpty());
  EXPECT_THAT(study.evaluate().group_by(), IsEmpty());
}

TEST(Heldout, IsAVariantOfTheChosenParametersWithASeedOfItsOwn) {
  const v1::StudySpec study =
      ParsedTraining("train: {}\nevaluate: {heldout_pairs: 7, heldout_variant: dense}\n");
  ASSERT_EQ(study.variants_size(), 4);
  const v1::VariantSpec& heldout = study.variants(3);
  EXPECT_EQ(heldout.name(), "heldout");
  EXPECT_TRUE(heldout.heldout());
  EXPECT_EQ(heldout.pairs(), 7);
  EXPECT_TRUE(MessageDifferencer::Equals(heldout.config(), study.variants(2).config()));
  EXPECT_NE(heldout.seed(), 0u);
  EXPECT_NE(heldout.seed(), study.seed());
  EXPECT_THAT(SetNames(study), ElementsAre("wide", "narrow", "dense")) << "never trained on";
  // It copies the first variant unless told, and gets the same seed wherever it is resolved.
  const v1::StudySpec other = ParsedTraining("evaluate: {heldout_pairs: 7}\n");
  EXPECT_EQ(other.variants(3).seed(), heldout.seed());
  EXPECT_TRUE(MessageDifferencer::Equals(other.variants(3).config(), study.variants(0).config()));
}

TEST(Heldout, HasASeedThatNoVariantHas) {
  v1::StudySpec study = ParsedTraining("evaluate: {heldout_pairs: 7}\n");
  const uint64_t seed = study.variants(3).seed();
  study.mutable_variants(1)->set_seed(seed);
  ResolveTraining(&study);
  ASSERT_EQ(study.variants_size(), 4);
  EXPECT_NE(study.variants(3).seed(), seed);
  EXPECT_TRUE(ValidateStudy(study).ok()) << ValidateStudy(study);
}

TEST(Training, TheLockLoadsAsTheSameStudyAndResolvingAgainChangesNothing) {
  v1::StudySpec study = ParsedTraining(R"(train:
  minutes: 1.5
  mixtures: [{name: both, parts: [{variant: wide}, {variant: narrow, weight: 0.25}]}]
  needs: {gpus: 1, memory_mb: 2000, tags: [fast]}
evaluate: {heldout_pairs: 5, checkpoints: 4, reference: both}
)");
  const std::string lock = StudyToYaml(study);
  auto again = ParseStudy(lock, "study.lock.yaml");
  ASSERT_TRUE(again.ok()) << again.status() << "\n" << lock;
  study.clear_source_yaml();
  again->clear_source_yaml();
  EXPECT_TRUE(MessageDifferencer::Equals(study, *again)) << lock << "\n" << StudyToYaml(*again);
  ResolveTraining(&*again);
  EXPECT_TRUE(MessageDifferencer::Equals(study, *again));
}

TEST(Training, AVariantsOwnSeedIsKept) {
  const auto study = ParseStudy(
      "study: s\npairs: 1\nvariants: [{name: a, seed: 18446744073709551615}, {name: b}]", "s.yaml");
  ASSERT_TRUE(study.ok()) << study.status();
  EXPECT_EQ(SeedOf(*study, study->variants(0)), 18446744073709551615u);
  EXPECT_EQ(SeedOf(*study, study->variants(1)), study->seed());
  const auto again = ParseStudy(StudyToYaml(*study), "study.lock.yaml");
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->variants(0).seed(), 18446744073709551615u);
}

TEST(Training, DefaultsOfAMessageAreFilledInOnlyWhereItHasTheParts) {
  v1::StudySpec study = ParsedTraining("");
  study.mutable_train()->set_steps(5);
  study.mutable_train()->add_mixtures()->set_name("m");
  study.mutable_train()->mutable_mixtures(0)->add_parts()->set_variant("wide");
  EXPECT_TRUE(ValidateStudy(study).ok()) << ValidateStudy(study);
  ResolveTraining(&study);
  EXPECT_EQ(study.train().seeds(), 3);
  EXPECT_EQ(study.train().mixtures(0).share(), 1);
  EXPECT_EQ(study.train().mixtures(0).parts(0).weight(), 1);
  EXPECT_FALSE(study.has_evaluate());
}

struct BadTraining {
  std::string yaml;
  std::string want;  // The whole message, or its beginning when it ends with "...".
};

TEST(Training, PicturesThatCannotBeTrainedOnAreToldBeforeTheyAreRendered) {
  const auto study = [](const std::string& set, const std::string& training) {
    const std::string text = "study: s\npairs: 4\nvariants:\n  - name: a\n    set:\n      " + set +
                             "\n  - name: b\n" + training + "\n";
    return std::string(ParseStudy(text, "s.yaml").status().message());
  };
  EXPECT_EQ(study("rigs: {width_px: 160, height_px: 96}", ""), "");
  const std::string small = study("rigs: {width_px: 160, height_px: 96}", "train: {}");
  EXPECT_THAT(small, HasSubstr("s.yaml:6: variants[0].set.rigs.width_px: 160 px, allowed for the "
                               "trainer builtin are 384 or more"));
  EXPECT_THAT(small, HasSubstr("rigs.height_px: 96 px, allowed for the trainer builtin are 192"));
  const std::string rigs = "rigs: {width_px: 160, height_px: 96}";
  EXPECT_EQ(study(rigs, "train: {width_px: 160, height_px: 96}"), "");
  EXPECT_EQ(study(rigs, "train: {trainer: script}"), "");
  EXPECT_EQ(study(rigs, "train: {variants: [b]}"), "");
  const std::string maps = "render: {maps: [depth]}";
  EXPECT_EQ(study(maps, ""), "");
  EXPECT_THAT(study(maps, "train: {trainer: script}"),
              HasSubstr("s.yaml:6: variants[0].set.render.maps: without disparity, masks, which"));
  EXPECT_THAT(study("render: {maps: [disparity]}", "evaluate: {heldout_pairs: 2}"),
              HasSubstr("render.maps: without masks, which"));
  EXPECT_EQ(study(maps, "evaluate: {heldout_pairs: 2, heldout_variant: b}"), "");
  EXPECT_EQ(study(maps, "evaluate: {}"), "");
  const std::string first = "render: {maps: [disparity, masks]}";
  const std::string layers =
      "render: {maps: [depth, disparity, occlusion, objects, materials, masks, layers]}";
  EXPECT_EQ(study(first, "train: {}"), "");
  EXPECT_THAT(study(first, "train: {truth: behind}"),
              HasSubstr("render.maps: without layers, which `truth: behind` is made of"));
  EXPECT_EQ(study(layers, "train: {truth: behind, variants: [a]}"), "");
  EXPECT_THAT(study(first, "evaluate: {heldout_pairs: 2, truth: behind}"),
              HasSubstr("render.maps: without layers"));
  EXPECT_THAT(study("render: {maps: [disparity, masks, layers]}", "train: {}"),
              HasSubstr("render.maps: layers without depth, allowed with both"));
}

TEST(Training, EachSetHasTheTruthOfItsOwnOrTheTrainings) {
  const auto study = ParseStudy(
      "study: s\npairs: 4\nvariants:\n  - name: a\n    set: {render: {maps: [depth, disparity, "
      "objects, materials, masks, layers]}}\ntrain:\n  truth: behind\n  mixtures:\n"
      "  - {name: first, truth: first, parts: [{variant: a}]}\nevaluate: {heldout_pairs: 2}\n",
      "s.yaml");
  ASSERT_TRUE(study.ok()) << study.status();
  v1::StudySpec resolved = *study;
  ResolveTraining(&resolved);
  const auto sets = TrainingSetsOf(resolved);
  ASSERT_EQ(sets.size(), 2u);
  EXPECT_EQ(sets[0].truth(), "behind");
  EXPECT_EQ(sets[1].truth(), "first");
  EXPECT_EQ(TruthOfHeldout(resolved), "behind");
  resolved.mutable_evaluate()->set_truth("first");
  EXPECT_EQ(TruthOfHeldout(resolved), "first");
}

TEST(Training, EachWrongValueIsToldAlikeForFilesAndMessages) {
  const std::string mixture = "train: {mixtures: [{name: m, parts: [{variant: wide}]";
  const BadTraining rows[] = {
      {"train: 3", "s.yaml:11: train: 3, allowed is a map of fields"},
      {"train: {stpes: 3}", "s.yaml:11: train.stpes: no such field, did you mean steps? ..."},
      {"train: {steps: -1}", "s.yaml:11: train.steps: -1 is out of range, allowed 0 to 100000000"},
      {"train: {seeds: 0}", "s.yaml:11: train.seeds: 0 is out of range, allowed 1 to 100"},
      {"train: {trainer: ../x}", "s.yaml:11: train.trainer: \"../x\" is not a name, ..."},
      {"train:\n  steps: 3\n  minutes: 1",
       "s.yaml:13: train.minutes: both steps and minutes, allowed is one: steps follow from "
       "minutes"},
      {"train: {width_px: 64}",
       "s.yaml:11: train.width_px: one side of a crop alone, allowed are both or neither"},
      {"train: {width_px: 64, height_px: 50}",
       "s.yaml:11: train.height_px: 50 px, allowed for the trainer builtin are multiples of 32"},
      {"train: {needs: {tags: ['a b']}}", "s.yaml:11: train.needs.tags[0]: \"a b\" is not a ..."},
      {"train: {variants: [wied]}",
       "s.yaml:11: train.variants[0]: \"wied\" is no variant of the study, did you mean wide? "
       "(allowed: wide, narrow, dense)"},
      {"train: {variants: [wide, wide]}",
       "s.yaml:11: train.variants[1]: \"wide\" is there already, allowed is each variant once"},
      {"train: {only_mixtures: true}",
       "s.yaml:11: train.only_mixtures: nothing to train: there are no mixtures"},
      {mixture + "}], only_mixtures: true, variants: [wide]}",
       "s.yaml:11: train.variants: a list beside only_mixtures, allowed is one of them"},
      {"train: {mixtures: {a: 1}}",
       "s.yaml:11: train.mixtures: a map, allowed is a list of {name, parts, share, mismatched, "
       "mismatched_share, curated, truth}"},
      {"train: {mixtures: [3]}", "s.yaml:11: train.mixtures[0]: 3, allowed is a map of fields"},
      {"train: {mixtures: [{name: wide, parts: [{variant: wide}]}]}",
       "s.yaml:11: train.mixtures[0].name: \"wide\" names another variant too, allowed is a name "
       "of its own"},
      {mixture + "}, {name: m, parts: [{variant: wide}]}]}",
       "s.yaml:11: train.mixtures[1].name: \"m\" names another mixture too, ..."},
      {mixture + ", curated: true, share: 0.5}]}",
       "s.yaml:11: train.mixtures[0].curated: true, but no training set has the same parts without "
       "curation, ..."},
      {mixture + ", curated: true}]}",
       "s.yaml:11: train.mixtures[0].parts[0].variant: \"wide\" has filters.max_ambiguous_share "
       "1, ..."},
      {"train: {mixtures: [{name: heldout, parts: [{variant: wide}]}]}",
       "s.yaml:11: train.mixtures[0].name: \"heldout\" is reserved, allowed is another name"},
      {"train: {mixtures: [{name: m}]}",
       "s.yaml:11: train.mixtures[0].parts: an empty list, allowed is a list of at least one "
       "{variant, weight}"},
      {"train:\n  mixtures:\n    - name: m\n      parts:\n        - {variant: narow}",
       "s.yaml:15: train.mixtures[0].parts[0].variant: \"narow\" is no variant of the study, did "
       "you mean narrow? (allowed: wide, narrow, dense)"},
      {"train: {mixtures: [{name: m, parts: [{variant: wide, weight: -1}]}]}",
       "s.yaml:11: train.mixtures[0].parts[0].weight: -1 is out of range, allowed 0 to 1000000"},
      {"train: {mixtures: [{name: m, parts: [{variant: wide, weight: 0}]}]}",
       "s.yaml:11: train.mixtures[0].parts: all weights are 0, allowed is one above 0 at least"},
      {"train: {mixtures: [{name: m, parts: [{variant: wide}, {variant: wide}]}]}",
       "s.yaml:11: train.mixtures[0].parts[1].variant: \"wide\" is there already, ..."},
      {mixture + ", share: 0}]}",
       "s.yaml:11: train.mixtures[0].share: 0, allowed is more: of no pairs nothing can be "
       "learnt"},
      {mixture + ", mismatched_share: 0.1}]}",
       "s.yaml:11: train.mixtures[0].mismatched_share: 0.1 has no effect without mismatched: true, "
       "allowed are both or neither"},
      {mixture + ", mismatched: true, mismatched_share: 0}]}",
       "s.yaml:11: train.mixtures[0].mismatched_share: 0, allowed is more, or no mismatched"},
      {mixture + ", mismatched: true, mismatched_share: 1.1}]}",
       "s.yaml:11: train.mixtures[0].mismatched_share: 1.1 is out of range, allowed 0 to 1"},
      {mixture + ", share: 1.5}]}",
       "s.yaml:11: train.mixtures[0].share: 1.5 is out of range, allowed 0 to 1"},
      {"evaluate: {benchmarks: [shiped]}",
       "s.yaml:11: evaluate.benchmarks[0]: \"shiped\" is not known, did you mean shipped? ..."},
      {"evaluate: {benchmarks: [shipped, shipped]}",
       "s.yaml:11: evaluate.benchmarks[1]: \"shipped\" is there already, allowed is each "
       "benchmark once"},
      {"evaluate: {benchmarks: []}",
       "s.yaml:11: evaluate.benchmarks: an empty list, allowed is at least one benchmark, or "
       "heldout_pairs"},
      {"train: {start: netwrok}",
       "s.yaml:11: train.start: \"netwrok\" is not known, did you mean "
       "network? (allowed: scratch, network)"},
      {"evaluate: {looks: 3}", "s.yaml:11: evaluate.looks: 3 is out of range, allowed 1 to 2"},
      {"evaluate: {decides: epe}",
       "s.yaml:11: evaluate.decides: \"epe\" is not known (allowed: shown, log)"},
      {"evaluate: {baselines: [bm]}",
       "s.yaml:11: evaluate.baselines[0]: \"bm\" is not known, did you mean sgbm? (allowed: "
       "sgbm)"},
      {"evaluate: {baselines: []}",
       "s.yaml:11: evaluate.baselines: nothing to evaluate: the study has no train and the list "
       "is empty"},
      {"evaluate: {group_by: [colour]}",
       "s.yaml:11: evaluate.group_by[0]: \"colour\" is not known ..."},
      {"evaluate: {heldout_variant: wide}",
       "s.yaml:11: evaluate.heldout_variant: no effect without heldout_pairs, allowed are both or "
       "neither"},
      {"evaluate: {heldout_pairs: 3, heldout_variant: wid}",
       "s.yaml:11: evaluate.heldout_variant: \"wid\" is no variant of the study, did you mean "
       "wide? (allowed: wide, narrow, dense)"},
      {"train: {}\nevaluate: {reference: wid}",
       "s.yaml:12: evaluate.reference: \"wid\" is no training set of the study, did you mean "
       "wide? (allowed: wide, narrow, dense)"},
      {"train: {steps: 3}\nevaluate: {checkpoints: 4}",
       "s.yaml:12: evaluate.checkpoints: 4 are more than the training's steps, allowed 1 to 3"},
  };
  for (const BadTraining& row : rows) {
    SCOPED_TRACE(row.yaml);
    const auto study = ParseTraining(row.yaml);
    ASSERT_EQ(study.status().code(), absl::StatusCode::kInvalidArgument);
    const std::string message(ToStd(study.status().message()));
    const bool cut = row.want.size() > 3 && row.want.substr(row.want.size() - 3) == "...";
    const std::string want = cut ? row.want.substr(0, row.want.size() - 3) : row.want;
    EXPECT_EQ(cut ? message.substr(0, want.size()) : message, want);
  }
}

TEST(Training, TheNameHeldoutIsReserved) {
  const auto study = ParseStudy("study: s\npairs: 1\nvariants: [{name: heldout}]", "s.yaml");
  EXPECT_THAT(std::string(ToStd(study.status().message())),
              HasSubstr("s.yaml:3: variants[0].name: \"heldout\" is reserved for the pairs of "
                        "evaluate.heldout_pairs, allowed is another name"));
}

TEST(Training, NamesOfResultFoldersAreReservedWhereThereAreResults) {
  for (const std::string_view folder : kResultFolders) {
    const std::string head =
        "study: s\npairs: 1\nvariants:\n  - name: a\n  - name: " + std::string(folder) + "\n";
    EXPECT_TRUE(ParseStudy(head, "s.yaml").ok()) << folder;
    for (const char* part : {"train: {}\n", "evaluate: {heldout_pairs: 2}\n"}) {
      const auto study = ParseStudy(head + part, "s.yaml");
      EXPECT_EQ(std::string(ToStd(study.status().message())),
                "s.yaml:5: variants[1].name: \"" + std::string(folder) +
                    "\" is reserved for the results of a study that trains or evaluates, allowed "
                    "is another name");
    }
  }
}

TEST(Training, MessagesAreHeldToTheSameRules) {
  const v1::StudySpec good = ParsedTraining("train: {}\nevaluate: {heldout_pairs: 5}\n");
  ASSERT_TRUE(ValidateStudy(good).ok()) << ValidateStudy(good);
  const struct {
    std::function<void(v1::StudySpec&)> breaks;
    const char* want;
  } cases[] = {
      {[](auto& s) { s.mutable_train()->set_seeds(0); },
       "train.seeds: 0 is out of range, allowed 1 to 100"},
      {[](auto& s) { s.mutable_train()->add_variants("wied"); },
       "train.variants[0]: \"wied\" is no variant of the study, did you mean wide? (allowed: "
       "wide, narrow, dense)"},
      {[](auto& s) { s.mutable_train()->add_variants("heldout"); },
       "train.variants[0]: \"heldout\" is no variant of the study (allowed: wide, narrow, dense)"},
      {[](auto& s) { s.mutable_variants(0)->set_heldout(true); },
       "variants[0].name: \"wide\" is held out, which only \"heldout\" can be"},
      {[](auto& s) { s.mutable_variants(3)->set_pairs(6); },
       "variants[3].pairs: 6 pairs are held out, allowed are as many as evaluate.heldout_pairs "
       "says: 5"},
      {[](auto& s) { s.mutable_variants(3)->set_seed(s.seed()); },
       "variants[3].seed: 1 is the seed of variant \"wide\" too, allowed is one that no variant "
       "trains on"},
      {[](auto& s) { s.clear_evaluate(); },
       "variants[3].pairs: 5 pairs are held out, allowed are as many as evaluate.heldout_pairs "
       "says: 0"},
      {[](auto& s) {
         s.set_pairs(kMaxTrainingPairs + 1);
         s.mutable_train()->add_variants("wide");
       },
       "train: training set \"wide\" has 400001 pairs, allowed are at most 400000"},
      {[](auto& s) {
         s.mutable_train()->set_seeds(100);
         s.mutable_evaluate()->set_checkpoints(100);
       },
       "evaluate: 60002 evaluations, allowed are at most 20000"},
  };
  for (const auto& c : cases) {
    v1::StudySpec study = good;
    c.breaks(study);
    EXPECT_EQ(ToStd(ValidateStudy(study).message()), c.want);
  }
}

TEST(Training, AThousandVariantsAndTheOneThatIsHeldOutAreOneTooMany) {
  v1::StudySpec study = ParsedTraining("");
  while (study.variants_size() < kMaxVariants) {
    v1::VariantSpec* variant = study.add_variants();
    variant->set_name(fmt::format("v{}", study.variants_size()));
  }
  EXPECT_TRUE(ValidateStudy(study).ok()) << ValidateStudy(study);
  study.mutable_evaluate()->set_heldout_pairs(5);
  study.mutable_evaluate()->add_baselines("sgbm");
  EXPECT_EQ(ToStd(ValidateStudy(study).message()),
            "variants: a list of 1000, allowed are at most 999");
}

}  // namespace
}  // namespace parallax
