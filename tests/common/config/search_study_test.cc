// Studies with a search: how a file says what is searched, and what it may not say.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "common/base/system/file.h"
#include "common/config/config.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const char kSearchStudy[] =
    "study: camera\n"
    "pairs: 200\n"
    "rigs_per_scene: 10\n"
    "train: {steps: 400, seeds: 2}\n"
    "evaluate: {benchmarks: [shipped, middlebury2014-Q]}\n";

v1::StudySpec ParsedSearch(const std::string& search) {
  const auto study = ParseStudy(kSearchStudy + search, "camera.yaml");
  EXPECT_TRUE(study.ok()) << study.status();
  return study.ok() ? *study : v1::StudySpec();
}

std::string SearchError(const std::string& text) {
  const auto study = ParseStudy(text, "camera.yaml");
  return study.ok() ? "" : std::string(study.status().message());
}

TEST(SearchStudyTest, ChoicesAreAsLongAsTheyLook) {
  EXPECT_THAT(SearchError(kSearchStudy + std::string("search:\n  space:\n    rigs.baselines_m: "
                                                     "{choice: [[0.1], [&b 0.2, *b]]}\n")),
              HasSubstr("camera.yaml:8: search.space.rigs.baselines_m.choice[1]: \"[&1 0.2, *1]\" "
                        "repeats a part of itself (*)"));
  // One of another choice is written out.
  ParsedSearch(
      "search:\n  space:\n    rigs.baseline_m: {choice: [&b {uniform: [0.1, 0.2]}, 0.3]}\n"
      "    rigs.altitude_m: {choice: [*b, 2]}\n");
  v1::StudySpec study = ParsedSearch("search: {space: {rigs.baseline_m: {choice: [0.1, 0.2]}}}\n");
  for (int field = 0; field < 11; ++field) {
    v1::SearchField& many = *study.mutable_search()->add_space();
    for (int i = 0; i < 1000; ++i) many.add_choices(std::to_string(i));
  }
  EXPECT_THAT(std::string(ValidateStudy(study).message()),
              HasSubstr("search.space: 11002 choices in all, allowed are at most 10000"));
}

TEST(SearchStudyTest, AFileSaysWhatEachFieldMayBe) {
  const v1::StudySpec study = ParsedSearch(
      "set: {furniture: {enabled: false}}\n"
      "search:\n"
      "  space:\n"
      "    floating.count: {range: [0, 40]}\n"
      "    floating.size_m: {range: [0.05, 0.3], log: true}\n"
      "    materials.mode: {choice: [none, all, one_diffuse]}\n"
      "    materials.diffuse_material: {choice: [Wood, Plastic], when: {materials.mode: "
      "one_diffuse}}\n"
      "    rigs.baseline_m: {choice: [0.1, {uniform: [0.04, 0.4]}]}\n"
      "  trials: 8\n"
      "  confirm: {benchmarks: [shipped], seeds: 4}\n");
  ASSERT_EQ(study.variants_size(), 1);
  EXPECT_EQ(study.variants(0).name(), "default");
  EXPECT_FALSE(study.variants(0).config().furniture().enabled());
  const v1::SearchSpec& search = study.search();
  ASSERT_EQ(search.space_size(), 5);
  EXPECT_EQ(search.space(0).path(), "floating.count");
  EXPECT_EQ(search.space(0).high(), 40);
  EXPECT_TRUE(search.space(0).integer());
  EXPECT_TRUE(search.space(1).log());
  EXPECT_FALSE(search.space(1).integer());
  EXPECT_THAT(search.space(2).choices(), ElementsAre("none", "all", "one_diffuse"));
  EXPECT_EQ(search.space(3).when(0).path(), "materials.mode");
  EXPECT_THAT(search.space(3).when(0).values(), ElementsAre("one_diffuse"));
  EXPECT_THAT(search.space(4).choices(), ElementsAre("0.1", "{uniform: [0.04, 0.4]}"));
  EXPECT_EQ(search.trials(), 8);
  EXPECT_EQ(search.keep_one_of(), 2);
  EXPECT_EQ(search.sampler(), "sobol");
  EXPECT_THAT(search.confirm().benchmarks(), ElementsAre("shipped"));
  EXPECT_TRUE(search.confirm().enabled());
}

TEST(SearchStudyTest, TheLockFileReadsBackToTheSameStudy) {
  const v1::StudySpec study = ParsedSearch(
      "search:\n"
      "  space:\n"
      "    floating.size_m: {range: [0.05, 0.3], log: true}\n"
      "    floating.count: {range: [0, 40]}\n"
      "    materials.mode: {choice: [none, 'all', \"one_diffuse\"]}\n"
      "    floating.classes:\n"
      "      choice: [[chairs, \"shelves\"], []]\n"
      "      when: {materials.mode: [none, all]}\n"
      "    assets: {choice: [{glass_parts: true}, {glass_parts: false, include_p: 0.5}]}\n"
      "  rungs: [{pairs: 0.5, seeds: 1}, {}]\n"
      "  points_per_core_s: 0.25\n"
      "  sampler: optuna\n"
      "  confirm: {enabled: false}\n");
  ASSERT_EQ(study.search().space_size(), 5);
  EXPECT_EQ(study.search().rungs(1).pairs(), 1);
  auto again = ParseStudy(StudyToYaml(study), "study.lock.yaml");
  ASSERT_TRUE(again.ok()) << again.status() << StudyToYaml(study);
  again->set_source_yaml(study.source_yaml());
  EXPECT_EQ(again->SerializeAsString(), study.SerializeAsString());
}

// What `search:` says, and what its error is; "..." stands for the rest of a line.
TEST(SearchStudyTest, WhatIsWrongIsNamedByFileLineAndField) {
  const struct {
    const char* search;
    const char* want;
  } rows[] = {
      // The space.
      {"{}", "6: search.space: empty, allowed are fields and what they may be: ..."},
      {"{space: {}}", "6: search.space: empty, ..."},
      {"{space: [floating.count]}", "6: search.space: a list, allowed is a map of fields"},
      {"{spce: {floating.count: {range: [0, 4]}}}",
       "6: search.spce: no such field, did you mean space? ..."},
      {"{space: {floating.coun: {range: [0, 4]}}}",
       "6: search.space.floating.coun: no such field, did you mean count? ..."},
      {"{space: {floating.count.low: {range: [0, 4]}}}",
       "6: search.space.floating.count.low: floating.count has no fields below it, ..."},
      {"{space: {floating: {count: {range: [0, 4]}}}}",
       "6: search.space.floating.count: below its group, allowed is floating.count: {...}"},
      {"{space: {floating.count: 4}}", "6: search.space.floating.count: 4, allowed is a map ..."},
      {"{space: {floating.count: {}}}",
       "6: search.space.floating.count: neither range nor choice, allowed is one of them"},
      {"{space: {floating.count: {rang: [0, 4]}}}",
       "6: search.space.floating.count.rang: no such field, did you mean range? (allowed: range, "
       "choice, log, when)"},
      {"{space: {floating.count: {range: [0, 4], choice: [1, 2]}}}",
       "6: search.space.floating.count: both range and choice, allowed is one of them"},
      {"\n  space:\n    floating.count: {range: [0, 4]}\n    floating.count: {range: [0, 5]}",
       "9: search.space.floating.count: given twice, allowed once"},
      {"{space: {floating: {choice: [{count: 1}, {count: 2}]}, floating.count: {range: [0, 4]}}}",
       "6: search.space.floating.count: overlaps floating, allowed is one of them"},
      // Ranges.
      {"{space: {floating.count: {range: 4}}}",
       "6: search.space.floating.count.range: 4, allowed is [low, high]"},
      {"{space: {floating.count: {range: [4]}}}",
       "6: search.space.floating.count.range: a list of 1, allowed is [low, high]"},
      {"{space: {floating.count: {range: [a, 4]}}}",
       "6: search.space.floating.count.range[0]: a is not a number, allowed a number"},
      {"{space: {floating.count: {range: [4, b]}}}",
       "6: search.space.floating.count.range[1]: b is not a number, allowed a number"},
      {"{space: {floating.count: {range: [4, 4]}}}",
       "6: search.space.floating.count.range: [4, 4], allowed is [low, high] with low < high"},
      {"{space: {floating.count: {range: [0.5, 4]}}}",
       "6: search.space.floating.count.range: 0.5 is not a whole number, as the field's values "
       "are"},
      {"{space: {floating.count: {range: [0, 700]}}}",
       "6: search.space.floating.count.range: 700 is out of range, allowed 0 to 500"},
      {"{space: {floating.count: {range: [-1, 7]}}}",
       "6: search.space.floating.count.range: -1 is out of range, allowed 0 to 500"},
      {"{space: {floating.count: {range: [0, 7], log: true}}}",
       "6: search.space.floating.count.log: true, but the range begins at 0, allowed above 0"},
      {"{space: {floating.count: {range: [1, 7], log: 2}}}",
       "6: search.space.floating.count.log: 2, allowed is true or false"},
      {"{space: {materials.mode: {range: [0, 1]}}}",
       "6: search.space.materials.mode.range: a range of a field that holds no number, allowed is "
       "{choice: [...]}"},
      {"{space: {rigs.width_px: {range: [320, 640]}}}",
       "6: search.space.rigs.width_px.range: 320 px, allowed for the trainer builtin are 384 or "
       "more, ..."},
      {"{space: {rigs.count: {range: [5, 30]}}}",
       "6: search.space.rigs.count.range: with 5: rigs_per_scene: 10 is more than variant "
       "\"default\" has, ..."},
      // Choices.
      {"{space: {materials.mode: {choice: none}}}",
       "6: search.space.materials.mode.choice: none, allowed is a list of values"},
      {"{space: {materials.mode: {choice: [none]}}}",
       "6: search.space.materials.mode.choice: a list of 1, allowed are 2 to 1000 values to choose "
       "from"},
      {"{space: {materials.mode: {choice: [none, none]}}}",
       "6: search.space.materials.mode.choice[1]: none is there already, allowed is each value "
       "once"},
      {"\n  space:\n    materials.mode:\n      choice:\n        - none\n        - al",
       "11: search.space.materials.mode.choice[1]: al is not known, did you mean all? ..."},
      {"{space: {floating.count: {choice: [1, {uniform: [3]}]}}}",
       "6: search.space.floating.count.choice[1]: ..."},
      {"{space: {floating.placement: {choice: [box, street]}}}",
       "6: search.space.floating.placement.choice[1]: street, but that is for scenes of type "
       "dense; ..."},
      {"{space: {materials.mode: {choice: [none, all], log: true}}}",
       "6: search.space.materials.mode.log: true, but there is no range, allowed with one"},
      // Conditions.
      {"{space: {floating.count: {range: [0, 4], when: {materials.mode: none}}}}",
       "6: search.space.floating.count.when.materials.mode: no field of the space before this one, "
       "allowed is one of those"},
      {"{space: {floating.count: {range: [0, 4]}, materials.mode: {choice: [none, all], when: "
       "{floating.count: 2}}}}",
       "6: search.space.materials.mode.when.floating.count: a field with a range, allowed is one "
       "with choices"},
      {"{space: {materials.mode: {choice: [none, all]}, floating.count: {range: [0, 4], when: "
       "{materials.mode: al}}}}",
       "6: search.space.floating.count.when.materials.mode: \"al\" is not known, did you mean all? "
       "(allowed: none, all)"},
      // Fields on which nothing depends.
      {"{space: {materials.picture_dir: {choice: [a, b]}}}",
       "6: search.space.materials.picture_dir: says where files are, ..."},
      {"{space: {rigs.camera: {choice: [{calibration: /etc/passwd}, {preset: oak_d}]}}}",
       "6: search.space.rigs.camera.choice[0]: with {calibration: /etc/passwd}: "
       "rigs.camera.calibration: names files, allowed in a search are other fields"},
      {"{space: {render.maps: {choice: [[disparity, masks], [disparity, masks, depth]]}}}",
       "6: search.space.render.maps: says which files are written, and no training depends on it, "
       "..."},
      {"{space: {materials.diffuse_material: {choice: [Wood, Plastic]}}}",
       "6: search.space.materials.diffuse_material: no picture depends on it where materials.mode "
       "is all, allowed where it is one_diffuse"},
      {"{space: {materials.mode: {choice: [none, one_diffuse]}, materials.diffuse_material: "
       "{choice: [Wood, Plastic], when: {materials.mode: none}}}}",
       "6: search.space.materials.diffuse_material: no picture depends on it where materials.mode "
       "is none, allowed where it is one_diffuse"},
      {"{space: {nature.walk.fps: {range: [1, 9]}}}",
       "6: search.space.nature.walk.fps: no picture depends on it where type is indoor, allowed "
       "where it is nature"},
      {"{space: {room.landscape_p: {range: [0, 1]}, nature.density: {choice: [0.5, 1]}}}",
       "6: search.space.nature.density: no picture depends on it where type is indoor, ..."},
      {"{space: {sensor.white_e: {range: [100, 1000]}}}",
       "6: search.space.sensor.white_e.range: given, but sensor.preset is off, ..."},
      // Benchmarks.
      {"{space: {floating.count: {range: [0, 4]}}, benchmarks: [shiped]}",
       "6: search.benchmarks[0]: \"shiped\" is not known, did you mean shipped? (allowed: shipped, "
       "middlebury2014-Q)"},
      {"{space: {floating.count: {range: [0, 4]}}, benchmarks: [kitti2015]}",
       "6: search.benchmarks[0]: \"kitti2015\" is not known (allowed: shipped, middlebury2014-Q)"},
      {"{space: {floating.count: {range: [0, 4]}}, benchmarks: [shipped, shipped]}",
       "6: search.benchmarks[1]: \"shipped\" is there already, allowed is each benchmark once"},
      {"{space: {floating.count: {range: [0, 4]}}, benchmarks: [shipped], confirm: {benchmarks: "
       "[shipped]}}",
       "6: search.confirm.benchmarks[0]: \"shipped\" is searched on, too, ..."},
      {"{space: {floating.count: {range: [0, 4]}}, confirm: {benchmarks: [shipped, "
       "middlebury2014-Q]}}",
       "6: search.confirm.benchmarks: all benchmarks, so that none is left for the search, ..."},
      // Rungs and numbers.
      {"{space: {floating.count: {range: [0, 4]}}, rungs: [{pairs: 0.5}, {pairs: 0.25}, {}]}",
       "6: search.rungs[1].pairs: 0.25 is less than the 0.5 of the rung before, allowed is as much "
       "or more"},
      {"{space: {floating.count: {range: [0, 4]}}, rungs: [{steps: 0.5, seeds: 3}, {}]}",
       "6: search.rungs[1].seeds: 2 is less than the 3 of the rung before, ..."},
      {"{space: {floating.count: {range: [0, 4]}}, rungs: [{}, {seeds: 2}]}",
       "6: search.rungs[1]: as the rung before, allowed are more pairs, steps or seeds"},
      {"{space: {floating.count: {range: [0, 4]}}, rungs: [{pairs: 0.1}, {pairs: 0.5}]}",
       "6: search.rungs[1].pairs: 0.5, allowed in the last rung is 1: ..."},
      {"{space: {floating.count: {range: [0, 4]}}, rungs: [{pair: 0.1}]}",
       "6: search.rungs[0].pair: no such field, did you mean pairs? ..."},
      {"{space: {floating.count: {range: [0, 4]}}, trials: 0}",
       "6: search.trials: 0 is out of range, allowed 1 to 999"},
      {"{space: {floating.count: {range: [0, 4]}}, trials: 1000}",
       "6: search.trials: 1000 is out of range, allowed 1 to 999"},
      {"{space: {floating.count: {range: [0, 4]}}, sampler: a b}", "6: search.sampler: ..."},
  };
  for (const auto& row : rows) {
    SCOPED_TRACE(row.search);
    std::string want = "camera.yaml:" + std::string(row.want);
    std::string seen = SearchError(kSearchStudy + ("search: " + std::string(row.search)));
    if (want.ends_with("...")) {
      want.resize(want.size() - 3);
      EXPECT_EQ(seen.find('\n'), std::string::npos) << seen;
      seen.resize(std::min(seen.size(), want.size()));
    }
    EXPECT_EQ(seen, want);
  }
}

TEST(SearchStudyTest, WhatIsBesideASearchIsChecked) {
  const std::string search = "search: {space: {floating.count: {range: [0, 40]}}}\n";
  const std::string head = "study: s\npairs: 40\n";
  const std::string train = "train: {steps: 100}\n", evaluate = "evaluate: {}\n";
  const struct {
    std::string text, want;
  } rows[] = {
      {head + evaluate + search,
       "camera.yaml: train: missing, allowed in a search are its trainings: {steps: 2000, seeds: "
       "2}"},
      {head + train + search,
       "camera.yaml: evaluate: missing, allowed in a search are its benchmarks: {benchmarks: "
       "[shipped]}"},
      {head + "train: {}\n" + evaluate + search,
       "camera.yaml:3: train: neither steps nor minutes, allowed in a search is one of them: its "
       "rungs train for a share of it"},
      {head + train + evaluate + search + "variants: [{name: a}]\n",
       "camera.yaml:6: variants: beside a search, allowed is none: base and set are its only "
       "variant"},
      {head + "train: {steps: 9, variants: [default]}\n" + evaluate + search,
       "camera.yaml:3: train.variants: given, allowed in a search is none: each trial is a "
       "training set"},
      {head + train + "evaluate: {decides: log}\n" +
           "search: {space: {floating.count: {range: [0, 40]}}, points_per_core_s: 0.25}\n",
       "camera.yaml:5: search.points_per_core_s: 0.25 beside evaluate.decides: log, whose "
       "differences are no points, allowed is 0"},
      {"study: s\npairs: endless\n" + search, "beside `pairs: endless`, allowed is one of them"},
      {"study: " + std::string(51, 's') + "\npairs: 40\n" + train + evaluate + search,
       "camera.yaml:1: study: 51 letters, allowed in a study with a search are at most 50: its "
       "rungs have the name and a number"},
  };
  for (const auto& row : rows) EXPECT_THAT(SearchError(row.text), HasSubstr(row.want));
}

// As a coordinator has it of a program that writes no files.
TEST(SearchStudyTest, AMessageIsCheckedByTheSameRules) {
  v1::StudySpec study = ParsedSearch("search: {space: {floating.count: {range: [0, 40]}}}\n");
  EXPECT_TRUE(ValidateStudy(study).ok()) << ValidateStudy(study);
  v1::SearchField& field = *study.mutable_search()->mutable_space(0);
  const auto error = [&] { return std::string(ValidateStudy(study).message()); };
  field.set_integer(false);
  EXPECT_EQ(error(), "search.space[0].integer: false, but the field is a whole number");
  field.set_integer(true);
  field.set_high(700);
  EXPECT_EQ(error(), "search.space[0].high: 700 is out of range, allowed 0 to 500");
  field.set_high(std::numeric_limits<double>::infinity());
  EXPECT_EQ(error(), "search.space[0].high: inf is not a number, allowed a number");
  field.clear_low();
  field.clear_high();
  field.add_choices("1");
  field.add_choices("2], log: [3");
  EXPECT_EQ(error(),
            "search.space[0].choices[1]: \"2], log: [3\" is not YAML as a list on one line has it");
  field.set_choices(1, "2, 3");
  EXPECT_THAT(error(), HasSubstr("is not YAML as a list on one line has it"));
  field.set_choices(1, "2");
  EXPECT_EQ(error(), "");
  study.add_variants()->set_name("other");
  EXPECT_THAT(error(), HasSubstr("variants: beside a search, allowed is none"));
}

// The check tries the values of a conditional field together with a value of its condition.
TEST(SearchStudyTest, ValuesAreTriedUnderTheirConditions) {
  ParsedSearch(
      "set: {render: {keep_hdr: true}}\n"
      "search:\n"
      "  space:\n"
      "    sensor.preset: {choice: ['off', webcam]}\n"
      "    sensor.white_e: {range: [100, 1000], when: {sensor.preset: webcam}}\n");
}

// Each field is varied under conditions on all before it: a chain of 40 is checked at once.
TEST(SearchStudyTest, ConditionsOnConditionsAreFollowedOnce) {
  std::string space, when;
  int fields = 0;
  const google::protobuf::Descriptor& scene = *v1::SceneConfig::descriptor();
  for (int i = 0; i < scene.field_count(); ++i) {
    const google::protobuf::Descriptor* part = scene.field(i)->message_type();
    for (int j = 0; part != nullptr && j < part->field_count() && fields < 40; ++j) {
      if (part->field(j)->message_type() != v1::Distribution::descriptor()) continue;
      const std::string path = scene.field(i)->name() + "." + part->field(j)->name();
      space += "    " + path + ": {choice: [1, 2]" +
               (when.empty() ? "" : ", when: {" + when + "}") + "}\n";
      when += (when.empty() ? "" : ", ") + path + ": 1";
      ++fields;
    }
  }
  ASSERT_EQ(fields, 40);
  EXPECT_THAT(SearchError(kSearchStudy + ("search:\n  space:\n" + space)),
              HasSubstr("search.space"));
}

TEST(SearchStudyTest, AFieldMayCountForSomeTrialsOnly) {
  ParsedSearch(
      "search:\n"
      "  space:\n"
      "    materials.mode: {choice: [none, one_diffuse]}\n"
      "    materials.diffuse_material: {choice: [Wood, Plastic]}\n");
}

class ExtendedSearchTest : public FolderTest {};

TEST_F(ExtendedSearchTest, AFileMayNarrowTheSearchOfAnotherOrHaveVariantsInstead) {
  const std::string search =
      "search:\n  trials: 9\n  space:\n    floating.count: {range: [0, 40]}\n"
      "    furniture.enabled: {choice: [true, false]}\n";
  ASSERT_TRUE(WriteFile(dir_ + "/camera.yaml", kSearchStudy + search).ok());
  const auto narrow =
      ParseStudy("extends: camera.yaml\nsearch: {space: {floating.count: {range: [5, 10]}}}\n",
                 dir_ + "/narrow.yaml");
  ASSERT_TRUE(narrow.ok()) << narrow.status();
  ASSERT_EQ(narrow->search().space_size(), 2);
  EXPECT_EQ(narrow->search().space(0).low(), 5);
  EXPECT_EQ(narrow->search().space(1).path(), "furniture.enabled");
  EXPECT_EQ(narrow->search().trials(), 9);
  const auto chosen =
      ParseStudy("extends: camera.yaml\nsearch: {space: {floating.count: {choice: [5, 10]}}}\n",
                 dir_ + "/chosen.yaml");
  ASSERT_TRUE(chosen.ok()) << chosen.status();
  EXPECT_FALSE(chosen->search().space(0).has_low());
  const auto best =
      ParseStudy("extends: camera.yaml\nvariants: [{name: best, set: {floating: {count: 7}}}]\n",
                 dir_ + "/best.yaml");
  ASSERT_TRUE(best.ok()) << best.status();
  EXPECT_FALSE(best->has_search());
  EXPECT_EQ(best->variants(0).name(), "best");
  const auto bad =
      ParseStudy("extends: camera.yaml\n\nsearch: {space: {floating.count: {range: [0, 501]}}}\n",
                 dir_ + "/bad.yaml");
  EXPECT_EQ(std::string(bad.status().message()),
            dir_ +
                "/bad.yaml:3: search.space.floating.count.range: 501 is out of range, allowed 0 "
                "to 500");
}

TEST_F(ExtendedSearchTest, AFieldOfAnotherFilesSpaceIsRemovedByNull) {
  const std::string search =
      "search:\n  space:\n    floating.count: {range: [0, 40]}\n"
      "    materials.mode: {choice: [none, one_diffuse]}\n"
      "    materials.diffuse_material: {choice: [Wood, Plastic], when: {materials.mode: "
      "one_diffuse}}\n"
      "    floating.size_m: {range: [0.05, 0.3]}\n";
  ASSERT_TRUE(WriteFile(dir_ + "/camera.yaml", kSearchStudy + search).ok());
  const auto read = [&](const std::string& space) {
    return ParseStudy("extends: camera.yaml\nsearch:\n  space:\n" + space, dir_ + "/own.yaml");
  };
  const auto paths = [](const v1::SearchSpec& read) {
    std::vector<std::string> paths;
    for (const v1::SearchField& field : read.space()) paths.push_back(field.path());
    return paths;
  };
  const auto fewer = read("    floating.count: null\n");
  ASSERT_TRUE(fewer.ok()) << fewer.status();
  EXPECT_THAT(paths(fewer->search()),
              ElementsAre("materials.mode", "materials.diffuse_material", "floating.size_m"));
  // A removed field may be added again; it then comes last.
  ASSERT_TRUE(WriteFile(dir_ + "/fewer.yaml",
                        "extends: camera.yaml\nsearch: {space: {floating.count: null}}\n")
                  .ok());
  const auto again =
      ParseStudy("extends: fewer.yaml\nsearch: {space: {floating.count: {choice: [1, 2]}}}\n",
                 dir_ + "/again.yaml");
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(paths(again->search()).back(), "floating.count");

  const std::string own = dir_ + "/own.yaml:", camera = dir_ + "/camera.yaml:";
  const struct {
    const char* space;
    std::string want;
  } rows[] = {
      {"    floating.coun: null\n",
       own + "4: search.space.floating.coun: nothing, which removes a field that the search has "
             "before, did you mean floating.count? (allowed: floating.count, materials.mode, "
             "materials.diffuse_material, floating.size_m)"},
      {"    floating.count:\n    materials.mode:\n    materials.diffuse_material: ~\n"
       "    floating.size_m: null\n",
       own + "4: search.space: empty, allowed are fields and what they may be: "},
      // Places of those that stay are still those of their file.
      {"    floating.count: null\n    materials.mode: null\n",
       camera + "10: search.space.materials.diffuse_material.when.materials.mode: no field of the "
                "space before this one, allowed is one of those"},
  };
  for (const auto& row : rows) {
    SCOPED_TRACE(row.space);
    const auto study = read(row.space);
    EXPECT_THAT(std::string(study.status().message()), testing::StartsWith(row.want));
  }
  EXPECT_EQ(SearchError(kSearchStudy + std::string("search: {space: {floating.count: null}}\n")),
            "camera.yaml:6: search.space.floating.count: nothing, allowed is a map of fields");
}

}  // namespace
}  // namespace parallax
