#include <gmock/gmock.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/base/system/file.h"
#include "common/config/config.h"
#include "parallax/v1/scene.pb.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

using google::protobuf::util::MessageDifferencer;
using ::testing::HasSubstr;

const std::string kConfigs = PARALLAX_CONFIGS;

// A folder of its own for each test.
class LoadTest : public FolderTest {
 protected:
  std::string Write(const std::string& name, const std::string& text) {
    const std::string path = dir_ + "/" + name;
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    EXPECT_TRUE(WriteFile(path, text).ok());
    return path;
  }
};

TEST(SceneConfigYaml, AnEmptyFileHasEveryFieldAtItsDefault) {
  const auto config = ParseSceneConfig("", "f");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_TRUE(MessageDifferencer::Equals(*config, DefaultSceneConfig()));
  EXPECT_EQ(config->type(), v1::SCENE_TYPE_INDOOR);
  EXPECT_EQ(config->rigs().count(), 20);
  EXPECT_TRUE(config->room().has_window_glass());
  EXPECT_EQ(config->room().kinds_size(), 4);
  EXPECT_EQ(config->rigs().baseline_m().uniform().high(), 0.4);
  EXPECT_EQ(config->materials().mode(), v1::MaterialConfig::MODE_ALL);
  EXPECT_EQ(config->render().denoise(), v1::RenderConfig::DENOISE_PROFILE);
  EXPECT_EQ(config->filters().min_mean_intensity(), 10);
}

TEST(SceneConfigYaml, IndoorWritesOutEveryDefault) {
  const auto config = LoadSceneConfig(kConfigs + "/scenes/indoor.yaml");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_TRUE(MessageDifferencer::Equals(*config, DefaultSceneConfig()));
  const auto nature = LoadSceneConfig(kConfigs + "/scenes/nature.yaml");
  ASSERT_TRUE(nature.ok()) << nature.status();
  EXPECT_TRUE(MessageDifferencer::Equals(nature->nature(), DefaultSceneConfig().nature()));
  // Every field of the message stands in the file; those of nature in nature.yaml.
  const std::string indoor = *ReadFile(kConfigs + "/scenes/indoor.yaml");
  const std::string of_nature = *ReadFile(kConfigs + "/scenes/nature.yaml");
  const auto& type = *v1::SceneConfig::descriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    const std::string& text = type.field(i)->name() == "nature" ? of_nature : indoor;
    EXPECT_THAT(text, HasSubstr("\n" + type.field(i)->name() + ":"));
    const auto* part = type.field(i)->message_type();
    for (int j = 0; part != nullptr && j < part->field_count(); ++j) {
      // A distribution without a default can only be absent.
      const bool absent = part->field(j)->message_type() == v1::Distribution::descriptor() &&
                          part->field(j)->options().GetExtension(v1::rule).default_yaml().empty();
      EXPECT_THAT(text, HasSubstr((absent ? "\n  # " : "\n  ") + part->field(j)->name() + ":"));
    }
  }
}

TEST(SceneConfigYaml, WrittenConfigReadsBackEqual) {
  const auto config = ParseSceneConfig(
      "type: nature\nroom: {doors: {choice: [0, 3]}, width_m: 3.1415926535897931, kinds: "
      "[office]}\n"
      "floating: {classes: [], count: {bernoulli: 0.1}}\nrender: {denoise: off, maps: []}\n"
      "materials: {picture_dir: 'a \"b\"\\c #: é'}\nassets: {exclude: [\"TV\", Vase]}",
      "f");
  ASSERT_TRUE(config.ok()) << config.status();
  const std::string text = MessageToYaml(*config);
  const auto again = ParseSceneConfig(text, "f");
  ASSERT_TRUE(again.ok()) << again.status() << text;
  EXPECT_TRUE(MessageDifferencer::Equals(*config, *again)) << text;
  EXPECT_THAT(text, HasSubstr("  width_m: 3.141592653589793\n"));
  EXPECT_THAT(text, HasSubstr("  count: {bernoulli: 0.1}\n"));
}

TEST(MessageYaml, RecipesReadAsText) {
  v1::Scene scene;
  scene.set_scene_seed(7);
  auto* object = scene.add_objects();
  object->set_name("Chair_1");
  object->mutable_world_from_object()->set_tx(1.5);
  scene.add_objects();
  const std::string text = MessageToYaml(scene);
  EXPECT_THAT(text, HasSubstr("scene_seed: 7\n"));
  EXPECT_THAT(text, HasSubstr("objects:\n  - index: 0\n    name: Chair_1\n"));
  EXPECT_THAT(text, HasSubstr("    world_from_object: {tx: 1.5, ty: 0, "));
}

TEST_F(LoadTest, VariantsMergeOntoTheBaseFieldByField) {
  Write("scenes/base.yaml",
        "rigs: {count: 7, baseline_m: 0.1, width_px: 640}\nroom: {kinds: [office]}\n");
  const std::string path =
      Write("studies/s.yaml",
            "study: s\nbase: ../scenes/base.yaml\nseed: 18446744073709551615\npairs: 12\n"
            "variants:\n  - name: plain\n  - name: wide\n    set:\n      rigs: {baseline_m: "
            "{uniform: [0.2, 0.3]}}\n      room: {kinds: [bedroom, office]}\n");
  const auto study = LoadStudy(path);
  ASSERT_TRUE(study.ok()) << study.status();
  EXPECT_EQ(study->name(), "s");
  EXPECT_EQ(study->seed(), 18446744073709551615u);
  EXPECT_EQ(study->pairs(), 12);
  EXPECT_EQ(study->rigs_per_scene(), 7);  // Absent: all that every variant has.
  EXPECT_EQ(study->source_yaml(), *ReadFile(path));
  ASSERT_EQ(study->variants_size(), 2);
  const v1::SceneConfig& plain = study->variants(0).config();
  const v1::SceneConfig& wide = study->variants(1).config();
  EXPECT_EQ(plain.rigs().baseline_m().constant(), 0.1);
  EXPECT_EQ(wide.rigs().baseline_m().uniform().low(), 0.2);
  EXPECT_FALSE(wide.rigs().baseline_m().has_constant());
  EXPECT_EQ(wide.rigs().width_px(), 640);
  EXPECT_EQ(wide.rigs().height_px(), 720);
  EXPECT_EQ(plain.room().kinds_size(), 1);
  ASSERT_EQ(wide.room().kinds_size(), 2);
  EXPECT_EQ(wide.room().kinds(0), "bedroom");
}

TEST_F(LoadTest, AnErrorNamesTheFileInWhichTheValueStands) {
  const std::string base = Write("base.yaml", "# x\nrigs:\n  count: 0\n");
  const std::string path =
      Write("s.yaml",
            "study: s\nbase: base.yaml\npairs: 1\nvariants:\n  - name: a\n    set: {type: q}\n");
  const absl::Status status = LoadStudy(path).status();
  EXPECT_THAT(std::string(status.message()), HasSubstr(base + ":3: rigs.count: 0 is out of range"));
  EXPECT_THAT(std::string(status.message()), HasSubstr(path + ":6: variants[0].set.type: q"));
}

TEST_F(LoadTest, TheLockFileLoadsAsTheSameStudy) {
  for (const char* name : {"quickstart", "baseline"}) {
    auto study = LoadStudy(kConfigs + "/studies/" + name + ".yaml");
    ASSERT_TRUE(study.ok()) << study.status();
    const std::string lock = StudyToYaml(*study);
    auto again = LoadStudy(Write("study.lock.yaml", lock));
    ASSERT_TRUE(again.ok()) << again.status();
    EXPECT_EQ(again->source_yaml(), lock);
    again->set_source_yaml(study->source_yaml());
    EXPECT_TRUE(MessageDifferencer::Equals(*study, *again));
    EXPECT_TRUE(ValidateStudy(*study).ok());
  }
}

TEST_F(LoadTest, AStudySaysWhatItsWorkersMustHave) {
  const std::string head = "study: s\npairs: 1\nvariants:\n  - name: a\n";
  auto study = LoadStudy(Write("s.yaml", head + "tags: [bigmem, avx512]\nmemory_mb: 8000\n"));
  ASSERT_TRUE(study.ok()) << study.status();
  EXPECT_THAT(study->tags(), ::testing::ElementsAre("avx512", "bigmem"));
  EXPECT_EQ(study->memory_mb(), 8000);
  const auto again = LoadStudy(Write("study.lock.yaml", StudyToYaml(*study)));
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_THAT(again->tags(), ::testing::ElementsAre("avx512", "bigmem"));
  EXPECT_EQ(again->memory_mb(), 8000);
  for (const char* wrong :
       {"tags: bigmem\n", "tags: [a, a]\n", "tags: [A b]\n", "memory_mb: -1\n"}) {
    EXPECT_EQ(LoadStudy(Write("s.yaml", head + wrong)).status().code(),
              absl::StatusCode::kInvalidArgument)
        << wrong;
  }
}

TEST_F(LoadTest, BuiltInStudiesEqualTheFiles) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(kConfigs + "/studies")) {
    files.push_back(entry.path().stem());
  }
  EXPECT_THAT(BuiltinStudies(), ::testing::UnorderedElementsAreArray(files)) << "run cmake again";
  EXPECT_THAT(files, ::testing::Contains("table1"));
  for (const std::string& name : BuiltinStudies()) {
    const auto built_in = LoadStudy(name);
    const auto file = LoadStudy(kConfigs + "/studies/" + name + ".yaml");
    ASSERT_TRUE(built_in.ok()) << built_in.status();
    ASSERT_TRUE(file.ok()) << file.status();
    EXPECT_TRUE(MessageDifferencer::Equals(*built_in, *file));
  }
  const auto study =
      LoadStudy(Write("s.yaml", "study: s\nbase: indoor\npairs: 1\nvariants: [{name: a}]"));
  EXPECT_TRUE(study.ok()) << study.status();
}

TEST(BaselineStudy, HasThePapersThreeRangesAndNothingElseDiffers) {
  const auto study = LoadStudy("baseline");
  ASSERT_TRUE(study.ok()) << study.status();
  EXPECT_EQ(study->pairs(), 5000);
  EXPECT_EQ(study->rigs_per_scene(), 20);
  const struct {
    const char* name;
    double low, high;
  } want[] = {{"narrow", 0.04, 0.1}, {"wide", 0.2, 0.3}, {"full", 0.04, 0.4}};
  ASSERT_EQ(study->variants_size(), 3);
  for (int i = 0; i < 3; ++i) {
    v1::SceneConfig config = study->variants(i).config();
    EXPECT_EQ(study->variants(i).name(), want[i].name);
    EXPECT_EQ(config.rigs().baseline_m().uniform().low(), want[i].low);
    EXPECT_EQ(config.rigs().baseline_m().uniform().high(), want[i].high);
    *config.mutable_rigs()->mutable_baseline_m() = DefaultSceneConfig().rigs().baseline_m();
    EXPECT_TRUE(MessageDifferencer::Equals(config, DefaultSceneConfig()));
  }
}

TEST(MixStudy, VariantsHaveTheirOwnBaseNumberOfPairsAndRigs) {
  const auto study = LoadStudy("mix");
  ASSERT_TRUE(study.ok()) << study.status();
  ASSERT_GE(study->variants_size(), 5);
  EXPECT_EQ(study->rigs_per_scene(), 20);
  const v1::VariantSpec& indoor = study->variants(0);
  const v1::VariantSpec& part = study->variants(4);
  EXPECT_EQ(indoor.pairs(), 0);
  EXPECT_EQ(indoor.rigs_per_scene(), 0);
  EXPECT_EQ(part.name(), "m-10-80-10_dense");
  EXPECT_EQ(part.pairs(), 4000);
  EXPECT_EQ(part.rigs_per_scene(), 200);
  EXPECT_TRUE(MessageDifferencer::Equals(part.config(), *LoadSceneConfig("dense")));
  EXPECT_TRUE(MessageDifferencer::Equals(part.config(), study->variants(1).config()));
}

TEST(MixStudy, EachMixtureIsFiveThousandPairsOfAllThreeTypesDrawnAsOftenAsThereAreOf) {
  const auto study = LoadStudy("mix");
  ASSERT_TRUE(study.ok()) << study.status();
  std::map<std::string, v1::VariantSpec> variants;
  for (const v1::VariantSpec& variant : study->variants()) variants[variant.name()] = variant;
  ASSERT_EQ(study->train().mixtures_size(), 4);
  for (const v1::Mixture& mixture : study->train().mixtures()) {
    int64_t pairs = 0;
    std::set<v1::SceneType> types;
    for (const v1::Mixture::Part& part : mixture.parts()) {
      ASSERT_TRUE(variants.contains(part.variant())) << part.variant();
      const v1::VariantSpec& variant = variants[part.variant()];
      pairs += variant.pairs();
      types.insert(variant.config().type());
      EXPECT_EQ(part.weight(), variant.pairs()) << part.variant();
    }
    EXPECT_EQ(pairs, 5000) << mixture.name();
    EXPECT_EQ(types.size(), 3u) << mixture.name();
  }
}

TEST(Biomes, AFileThatNamesSomeMeansTheseAlone) {
  const auto biomes_of = [](const std::string& weights) {
    const auto study = ParseStudy(
        "study: s\npairs: 4\nvariants: [{name: a, base: nature, set: {nature: {biomes: " + weights +
            "}}}]",
        "s");
    EXPECT_TRUE(study.ok()) << study.status();
    return study.ok() ? study->variants(0).config().nature().biomes() : v1::BiomeWeights();
  };
  const v1::BiomeWeights some = biomes_of("{forest: 2, plain: 1}");
  EXPECT_EQ(some.forest(), 2);
  EXPECT_EQ(some.plain(), 1);
  EXPECT_TRUE(some.has_river());
  EXPECT_EQ(some.river(), 0);
  EXPECT_EQ(some.snowy_mountain(), 0);

  const v1::BiomeWeights without = biomes_of("{forest: 0}");
  EXPECT_EQ(without.forest(), 0);
  EXPECT_EQ(without.river(), 8);

  const auto none = ParseStudy(
      "study: s\npairs: 4\nvariants: [{name: a, base: nature, set: {nature: {biomes: {plain: 0, "
      "forest: 0, mountain: 0, river: 0, desert: 0, canyon: 0, cliff: 0, coast: 0, cave: 0, "
      "arctic: 0, snowy_mountain: 0}}}}]",
      "s");
  EXPECT_THAT(std::string(none.status().message()),
              HasSubstr("nature.biomes: all weights are 0, allowed is one above 0 at least"));
}

TEST(VariantBase, IsReadBeforeSetWhereverItStands) {
  const auto study = ParseStudy(
      "study: s\npairs: 4\nvariants:\n  - {name: a, set: {rigs: {count: 7}}, base: dense}", "s");
  ASSERT_TRUE(study.ok()) << study.status();
  EXPECT_EQ(study->variants(0).config().type(), v1::SCENE_TYPE_DENSE);
  EXPECT_EQ(study->variants(0).config().rigs().count(), 7);
  EXPECT_EQ(study->rigs_per_scene(), 7);
}

TEST_F(LoadTest, TheLockFileOfManyVariantsIsReadBack) {
  std::string yaml = "study: many\npairs: 1\nvariants:\n";
  for (int i = 0; i < 150; ++i) yaml += "  - {name: v" + std::to_string(i) + "}\n";
  const auto study = ParseStudy(yaml, "s.yaml");
  ASSERT_TRUE(study.ok()) << study.status();
  const std::string lock = StudyToYaml(*study);
  ASSERT_GT(lock.size(), size_t{512} << 10);
  // Longer than that of any study with as many variants as may be.
  const std::string rest(size_t{4} << 20, '#');
  auto again = LoadStudy(Write("study.lock.yaml", lock + rest + "\n"));
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->source_yaml(), "") << "a small file only is kept as it is";
  again->set_source_yaml(study->source_yaml());
  EXPECT_TRUE(MessageDifferencer::Equals(*again, *study));
}

TEST(LoadStudy, AMissingFileIsToldWithTheBuiltInNames) {
  const absl::Status status = LoadStudy("no/such.yaml").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(
      std::string(status.message()),
      "no/such.yaml: no such file, allowed is a path or a built-in name: baseline, cameras, "
      "controls, cost, cost-small, curation, depth, endless, landscapes, mix, mix-small, network, "
      "profiles, quickstart, released, scaling, scaling-small, search-known, search-small, sensor, "
      "sequences, table1, table1-small, wmg150k, wmg150k-500th");
}

TEST(ValidateStudy, TellsWhatAMessageBreaks) {
  auto study = *LoadStudy("quickstart");
  study.mutable_variants(0)->mutable_config()->mutable_rigs()->set_count(3);
  EXPECT_THAT(std::string(ValidateStudy(study).message()), HasSubstr("rigs_per_scene: 4 is more"));
  study.clear_variants();
  EXPECT_THAT(std::string(ValidateStudy(study).message()), HasSubstr("variants: an empty list"));
}

}  // namespace
}  // namespace parallax
