// Lands as files: what is refused and how, formulas, and how a config takes those of the user.
#include "common/config/files/land_files.h"

#include <gmock/gmock.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/config/config.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

using google::protobuf::util::MessageDifferencer;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr char kHeath[] =
    "landform: plain\n"
    "values: [{let: far_m, is: 60}, {choose: [tree], of: [pines, oaks], weights: [2, 1]}]\n"
    "ground:\n"
    "  - {material: Soil}\n"
    "  - {material: Rock, where: {slope: [0.75, 99, 0.2]}}\n"
    "trees:\n"
    "  - {name: pines, class: Conifer/pine, crown_m: 2, per_m2: 0.01, spacing_m: 3, reach_m: 200,\n"
    "     size: [0.6, 1]}\n"
    "  - {name: oaks, class: BroadleafTree/oak, crown_m: 3, per_m2: 0.01, spacing_m: 4,\n"
    "     reach_m: 200, size: [0.6, 1]}\n"
    "layers:\n"
    "  - {trees: tree, where: {height_m: [-9000, middle_m + 0.5 * relief_m, 3]}}\n"
    "  - {name: heather, class: Shrub, winter_class: DryBush, per_m2: {uniform: [0.2, 0.4]},\n"
    "     reach_m: far_m, when: {season: [summer], chosen: [pines]}, chance: 0.5}\n";

// Replaces a part of kHeath.
std::string Heath(const std::string& part, const std::string& by) {
  std::string text = kHeath;
  const size_t at = text.find(part);
  EXPECT_NE(at, std::string::npos) << part;
  return text.replace(at, part.size(), by);
}

TEST(Biomes, BuiltInOnesAreReadInOrderOfName) {
  const std::vector<v1::Biome>& biomes = BuiltinBiomes();
  ASSERT_EQ(biomes.size(), 11u);
  for (size_t i = 1; i < biomes.size(); ++i) EXPECT_LT(biomes[i - 1].name(), biomes[i].name());
  EXPECT_TRUE(LoadBiome("forest")->woods());
}

TEST(Biomes, EachWrongFileNamesLineFieldAndWhatIsAllowed) {
  const struct {
    const char* part;
    const char* by;
    const char* want;  // The beginning of the message.
  } rows[] = {
      {"landform: plain\n", "landform: plane\n",
       "heath.yaml:1: landform: \"plane\" is not known, did you mean plain? (allowed: arctic, "},
      {"landform: plain\n", "", "heath.yaml: no landform, allowed is one"},
      {"landform: plain\n", "landforn: plain\n",
       "heath.yaml:1: landforn: no such field, did you mean landform?"},
      {"{material: Soil}", "{material: Soul}",
       "heath.yaml:4: ground[0].material: \"Soul\" is not known, did you mean Soil?"},
      {"{material: Soil}", "{material: Soil, where: {slope: [0, 1, 0.1]}}",
       "heath.yaml:4: ground[0]: the first rule of the ground, allowed is one that covers"},
      {"  - {material: Soil}\n  - {material: Rock, where: {slope: [0.75, 99, 0.2]}}\n", "  []\n",
       "heath.yaml: 0 rules of the ground, allowed are 1 to 12"},
      {"slope: [0.75, 99, 0.2]", "slope: [99, 0.75, 0.2]",
       "heath.yaml:5: ground[1].where.slope: low 99 is above high 0.75, allowed is the lower one"},
      {"slope: [0.75, 99, 0.2]", "slope: [0.75, 99]",
       "heath.yaml:5: ground[1].where.slope: a list of 2, allowed is [low, high, soft]"},
      {"slope: [0.75, 99, 0.2]", "slope: [0.75, 99, -1]",
       "heath.yaml:5: ground[1].where.slope.soft: -1 is out of range, allowed 0 to 1000000"},
      {"Conifer/pine", "Conifer/pin",
       "heath.yaml:7: trees[0].class: \"Conifer/pin\" is not known, did you mean Conifer/pine?"},
      {"crown_m: 2, ", "",
       "heath.yaml:7: trees[0]: no crown_m, allowed is with all of name, class"},
      {"{trees: tree,", "{trees: trees,",
       "heath.yaml:12: layers[0].trees: \"trees\" is not known, did you mean tree? (allowed: "
       "pines"},
      {"{trees: tree,", "{trees: tree, per_m2: 1,",
       "heath.yaml:12: layers[0].per_m2: given, but the kind of tree says it, allowed beside"},
      {"0.5 * relief_m", "0.5 * relif_m",
       "heath.yaml:12: layers[0].where.height_m.high: \"relif_m\" is not known, did you mean "
       "relief"},
      {"0.5 * relief_m", "0.5 / relief_m",
       "heath.yaml:12: layers[0].where.height_m.high: \"middle_m + 0.5 / relief_m\" is no formula"},
      {"class: Shrub", "class: Shrubb",
       "heath.yaml:13: layers[1].class: \"Shrubb\" is not known, did you mean Shrub?"},
      {"name: heather, ", "", "heath.yaml:13: layers[1]: no name, allowed is one"},
      {"{uniform: [0.2, 0.4]}", "-0.2",
       "heath.yaml:13: layers[1].per_m2: -0.2 is out of range, allowed 0 to 60 1/m2"},
      {"{uniform: [0.2, 0.4]}", "{uniform: [0.2, 90]}",
       "heath.yaml:13: layers[1].per_m2: reaches from 0.2 to 90, allowed 0 to 60 1/m2"},
      {"per_m2: {uniform: [0.2, 0.4]},", "", "heath.yaml:13: layers[1]: no per_m2, allowed is"},
      {"season: [summer]", "season: [sumer]",
       "heath.yaml:14: layers[1].when.season[0]: \"sumer\" is not known, did you mean summer?"},
      {"chosen: [pines]", "chosen: [pine]",
       "heath.yaml:14: layers[1].when.chosen[0]: \"pine\" is not known, did you mean pines?"},
      {"weights: [2, 1]", "weights: [2]",
       "heath.yaml:2: values[1].weights: 1 weights, allowed are as many as in `of`, 2"},
      {"chance: 0.5", "hangs: true",
       "heath.yaml:14: layers[1].hangs: given, but there is no roof, allowed with one"},
  };
  for (const auto& row : rows) {
    const absl::Status status = ParseBiome(Heath(row.part, row.by), "heath.yaml").status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << row.want;
    EXPECT_THAT(std::string(ToStd(status.message())), StartsWith(row.want));
  }
  EXPECT_TRUE(ParseBiome(kHeath, "heath.yaml").ok()) << ParseBiome(kHeath, "heath.yaml").status();
}

TEST(Biomes, FormulasAreSumsOfProducts) {
  const auto find = [](std::string_view name) {
    return name == "a" ? std::optional<double>(5) : std::nullopt;
  };
  EXPECT_EQ(ValueOfFormula("a", find).value(), 5);
  EXPECT_EQ(ValueOfFormula("2 * a - 0.5*a*2 + 1", find).value(), 6);
  EXPECT_EQ(ValueOfFormula("b", find).status().code(), absl::StatusCode::kNotFound);
  for (const char* wrong : {"", "a a", "a +", "* a", "1.2.3", "(a)", "2a"}) {
    EXPECT_EQ(ValueOfFormula(wrong, find).status().code(), absl::StatusCode::kInvalidArgument)
        << wrong;
  }
}

class OwnBiomes : public FolderTest {
 protected:
  void Write(const std::string& name, const std::string& text) {
    std::ofstream(dir_ + "/" + name) << text;
  }
  absl::StatusOr<v1::StudySpec> Study(const std::string& nature) {
    return ParseStudy(
        "study: s\npairs: 4\nvariants: [{name: a, base: nature, set: {nature: " + nature + "}}]",
        dir_ + "/s.yaml");
  }
};

TEST_F(OwnBiomes, StandInTheConfigWithTheirWeightAndReadBackWithoutTheirFile) {
  Write("heath.yaml", kHeath);
  const auto study = Study("{biome_files: [heath.yaml], biomes: {heath: 3, forest: 1}}");
  ASSERT_TRUE(study.ok()) << study.status();
  const v1::NatureConfig& nature = study->variants(0).config().nature();
  ASSERT_EQ(nature.own_biomes_size(), 1);
  EXPECT_EQ(nature.own_biomes(0).weight(), 3);
  EXPECT_EQ(nature.own_biomes(0).biome().name(), "heath");
  EXPECT_EQ(nature.biomes().forest(), 1);
  EXPECT_EQ(nature.biomes().river(), 0);
  EXPECT_EQ(nature.biome_files_size(), 0);

  std::filesystem::remove(dir_ + "/heath.yaml");
  auto again = ParseStudy(StudyToYaml(*study), dir_ + "/lock.yaml");
  ASSERT_TRUE(again.ok()) << again.status();
  again->set_source_yaml(study->source_yaml());
  EXPECT_TRUE(MessageDifferencer::Equals(*study, *again)) << StudyToYaml(*study);
  EXPECT_TRUE(ValidateStudy(*study).ok()) << ValidateStudy(*study);
}

TEST_F(OwnBiomes, AreRefusedWithFileAndLineAndAsMessagesWithTheirPath) {
  Write("heath.yaml", Heath("class: Shrub", "class: Shrubb"));
  const std::string seen(
      ToStd(Study("{biome_files: [heath.yaml], biomes: {heath: 1}}").status().message()));
  EXPECT_EQ(seen.rfind(dir_ + "/heath.yaml:13: layers[1].class: \"Shrubb\" is not known", 0), 0u)
      << seen;
  Write("heath.yaml", kHeath);
  const auto message = [&](const std::string& nature) {
    return std::string(ToStd(Study(nature).status().message()));
  };
  EXPECT_THAT(message("{biome_files: [heath.yaml], biomes: {heat: 1}}"),
              HasSubstr("nature.biomes.heat: no such field, did you mean heath?"));
  EXPECT_THAT(message("{biome_files: [heat.yaml], biomes: {heat: 1}}"),
              HasSubstr("biome_files[0]: " + dir_ + "/heat.yaml: no such file, did you mean"));
  EXPECT_THAT(message("{biome_files: [heath.yaml], biomes: {heath: -1}}"),
              HasSubstr("s.yaml:3: variants[0].set.nature.biomes.heath: -1 is out of range"));
  Write("forest.yaml", kHeath);
  EXPECT_THAT(message("{biome_files: [forest.yaml], biomes: {forest: 1}}"),
              HasSubstr("\"forest\" is the name of another land"));

  auto study = Study("{biome_files: [heath.yaml], biomes: {heath: 1}}").value();
  v1::NatureConfig& nature = *study.mutable_variants(0)->mutable_config()->mutable_nature();
  nature.mutable_own_biomes(0)->mutable_biome()->mutable_layers(1)->set_class_("Shrubb");
  EXPECT_THAT(std::string(ToStd(ValidateStudy(study).message())),
              StartsWith("variants[0].config.nature.own_biomes[0].biome.layers[1].class: "
                         "\"Shrubb\" is not known, did you mean Shrub?"));
  nature.clear_own_biomes();
  nature.mutable_biomes()->set_forest(1);
  nature.add_biome_files("heath.yaml");
  EXPECT_THAT(std::string(ToStd(ValidateStudy(study).message())),
              HasSubstr("nature.biome_files[0]: \"heath.yaml\" is a file"));
}

}  // namespace
}  // namespace parallax
