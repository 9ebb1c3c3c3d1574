// Studies in any style of YAML, of several files, and what they name beside themselves.
#include <gmock/gmock.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "common/config/camera_text.h"
#include "common/config/config.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using google::protobuf::util::MessageDifferencer;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class StudyFilesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "/study_files_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    dir_ = fs::canonical(name);
  }
  void TearDown() override { fs::remove_all(dir_); }

  std::string Write(const std::string& name, const std::string& text) {
    fs::create_directories(fs::path(dir_ + "/" + name).parent_path());
    std::ofstream(dir_ + "/" + name) << text;
    return dir_ + "/" + name;
  }
  v1::StudySpec Load(const std::string& path) {
    auto study = LoadStudy(path);
    EXPECT_TRUE(study.ok()) << study.status();
    if (!study.ok()) return {};
    study->clear_source_yaml();
    return *study;
  }
  std::string ErrorOf(const std::string& text) {
    return std::string(LoadStudy(Write("bad.yaml", text)).status().message());
  }

  std::string dir_;
};

TEST_F(StudyFilesTest, VariantsThatAllHaveTheirOwnPairsNeedNoneAtTheTop) {
  const v1::StudySpec study =
      Load(Write("s.yaml", "study: s\nvariants: [{name: a, pairs: 40}, {name: b, pairs: 60}]\n"));
  EXPECT_EQ(study.pairs(), 60);
  EXPECT_EQ(study.variants(0).pairs(), 40);
}

TEST_F(StudyFilesTest, AStudyIsOneInEachStyleOfYaml) {
  const v1::StudySpec block =
      Load(Write("s.yaml",
                 "study: x\npairs: 4\nvariants:\n  - name: a\n    set:\n      rigs:\n"
                 "        count: 4\n"));
  const char* others[] = {
      R"({"study": "x", "pairs": 4, "variants": [{"name": "a", "set": {"rigs": {"count": 4}}}]})",
      "{\"variants\":[{\"name\":\"a\",\"set\":{\"rigs\":{\"count\":4}}}],\"pairs\":4,\"study\":"
      "\"x\"}",
      "{\n\t\"study\": \"x\",\n\t\"pairs\": 4,\n\t\"variants\": [\n\t\t{\"name\": \"a\", \"set\": "
      "{\"rigs\": {\"count\": 4}}}\n\t]\n}\n",
      "{study: x, pairs: 4, variants: [{name: a, set: {rigs: {count: 4}}}]}",
      "study : x\npairs : 4\nvariants : [{name: a, set: {rigs: {count: 4}}}]\n",
      "%YAML 1.2\n---\nstudy: x\npairs: 4\nvariants: [{name: a, set: {rigs: {count: 4}}}]\n",
      "\xef\xbb\xbfstudy: x\npairs: 4\nvariants: [{name: a, set: {rigs: {count: 4}}}]\n",
      "'variants': [{name: a, set: {rigs: {count: 4}}}]\n\"pairs\": 4\n? study\n: x\n",
  };
  for (const char* text : others) {
    const std::string file = Write("other.json", text);
    EXPECT_EQ(*IsStudy(file), true) << text;
    EXPECT_TRUE(MessageDifferencer::Equals(Load(file), block)) << text;
  }
  for (const char* text : {"{\"rigs\": {\"count\": 4}}", "type: indoor\n", "{}"}) {
    EXPECT_EQ(*IsStudy(Write("scene.yaml", text)), false) << text;
  }
  EXPECT_EQ(*IsStudy("table1"), true);
  EXPECT_EQ(*IsStudy("indoor"), false);
  EXPECT_EQ(IsStudy(dir_ + "/none.yaml").status().code(), absl::StatusCode::kNotFound);
}

TEST_F(StudyFilesTest, SetAtTheTopIsForAllVariants) {
  const v1::StudySpec study = Load(Write(
      "s.yaml",
      "study: s\npairs: 2\nvariants:\n  - {name: a}\n  - {name: b, set: {rigs: {count: 3}}}\n"
      "  - {name: c, base: dense}\nset: {render: {samples_per_pixel: 7}, rigs: {count: 5}}\n"));
  ASSERT_EQ(study.variants_size(), 3);
  for (const v1::VariantSpec& variant : study.variants()) {
    EXPECT_EQ(variant.config().render().samples_per_pixel(), 7) << variant.name();
    EXPECT_EQ(variant.config().rigs().count(), variant.name() == "b" ? 3 : 5);
  }
  EXPECT_EQ(study.variants(2).config().type(), v1::SCENE_TYPE_DENSE);
  // A wrong value is reported once, at its place.
  const std::string wrong = ErrorOf(
      "study: s\npairs: 2\nset: {rigs: {count: 0, basline_m: 1}}\nvariants: [{name: a}, {name: "
      "b}]\n");
  EXPECT_EQ(std::count(wrong.begin(), wrong.end(), '\n'), 1) << wrong;
  EXPECT_THAT(wrong, HasSubstr("bad.yaml:3: set.rigs.basline_m: no such field, did you mean"));
  EXPECT_THAT(wrong, HasSubstr("bad.yaml:3: set.rigs.count: 0 is out of range, allowed 1 to 1000"));
  // A field that no variant uses is refused, one that some use is not.
  EXPECT_THAT(ErrorOf("study: s\npairs: 2\nset: {sensor: {preset: machine_vision, shake_m_s: 1}, "
                      "render: {keep_hdr: true}}\nvariants: [{name: a}]\n"),
              HasSubstr("bad.yaml:3: set.sensor.shake_m_s: given, but sensor.exposure_ms is 0"));
}

TEST_F(StudyFilesTest, AStudyExtendsAnotherAndOverridesItsVariantsByName) {
  Write("lib/parent.yaml",
        "study: parent\nbase: ../scenes/mine.yaml\nseed: 3\npairs: 8\nrigs_per_scene: 4\n"
        "set: {render: {samples_per_pixel: 2}}\n"
        "variants:\n  - {name: a, set: {rigs: {count: 4}}}\n  - {name: b, pairs: 4}\n"
        "train: {steps: 10, seeds: 2}\nevaluate: {benchmarks: [shipped], baselines: []}\n");
  Write("scenes/mine.yaml", "rigs: {count: 6}\nroom: {width_m: 4}\n");
  const std::string child = Write(
      "child.yaml",
      "extends: lib/parent.yaml\nstudy: child\npairs: 16\nset: {render: {samples_per_pixel: 9}}\n"
      "variants:\n  - {name: b, pairs: 12, set: {rigs: {count: 8}}}\n  - {name: c}\n"
      "train: {seeds: 5}\n");
  const v1::StudySpec study = Load(child);
  EXPECT_EQ(study.name(), "child");
  EXPECT_EQ(study.seed(), 3u);
  EXPECT_EQ(study.pairs(), 16);
  EXPECT_EQ(study.train().steps(), 10);
  EXPECT_EQ(study.train().seeds(), 5);
  EXPECT_EQ(study.evaluate().baselines_size(), 0);
  ASSERT_EQ(study.variants_size(), 3);
  const struct {
    const char* name;
    int64_t pairs;
    int count;
  } wanted[] = {{"a", 0, 4}, {"b", 12, 8}, {"c", 0, 6}};
  for (int i = 0; i < 3; ++i) {
    const v1::VariantSpec& variant = study.variants(i);
    EXPECT_EQ(variant.name(), wanted[i].name);
    EXPECT_EQ(variant.pairs(), wanted[i].pairs) << variant.name();
    EXPECT_EQ(variant.config().rigs().count(), wanted[i].count) << variant.name();
    EXPECT_EQ(variant.config().render().samples_per_pixel(), 9) << variant.name();
    EXPECT_EQ(variant.config().room().width_m().constant(), 4) << variant.name();
  }
  // Places are those of the file where the text is.
  EXPECT_EQ(PlaceOfField(child, "train.seeds"), child + ":8");
  EXPECT_EQ(PlaceOfField(child, "train.steps"), dir_ + "/lib/parent.yaml:10");
  EXPECT_EQ(PlaceOfField(child, "train.minutes"), child);
  Write("lib/parent.yaml",
        "study: parent\npairs: 8\nvariants:\n  - {name: a, set: {rigs: {count: 0}}}\n");
  EXPECT_EQ(std::string(LoadStudy(child).status().message()),
            dir_ +
                "/lib/parent.yaml:4: variants[0].set.rigs.count: 0 is out of range, allowed 1 "
                "to 1000");
}

TEST_F(StudyFilesTest, ABuiltInStudyCanBeExtendedAndCopied) {
  const v1::StudySpec small = Load("table1-small");
  const v1::StudySpec extended = Load(Write("mine.yaml", "extends: table1-small\n"));
  EXPECT_TRUE(MessageDifferencer::Equals(extended, small));
  const v1::StudySpec copied =
      Load(Write("anywhere/copy.yaml", *BuiltinConfigText("studies/table1-small.yaml")));
  EXPECT_TRUE(MessageDifferencer::Equals(copied, small));
  const v1::StudySpec of_lock =
      Load(Write("again.yaml", "extends: lock.yaml\npairs: 3\nevaluate: {heldout_pairs: 5}\n" +
                                   (Write("lock.yaml", StudyToYaml(small)), std::string())));
  EXPECT_EQ(of_lock.pairs(), 3);
  EXPECT_EQ(of_lock.variants(of_lock.variants_size() - 1).pairs(), 5);
}

TEST_F(StudyFilesTest, WhatIsWrongWithExtendsIsSaid) {
  EXPECT_THAT(ErrorOf("extends: table1-smal\n"),
              HasSubstr("bad.yaml:1: extends: " + dir_ +
                        "/table1-smal: no such file, did you mean table1-small? Allowed is"));
  EXPECT_THAT(ErrorOf("extends: table1-smal\n"), Not(HasSubstr("missing")));
  Write("loop.yaml", "extends: bad.yaml\n");
  EXPECT_THAT(ErrorOf("extends: loop.yaml\n"),
              HasSubstr("loop.yaml:1: extends: \"bad.yaml\" extends this file itself"));
  EXPECT_THAT(ErrorOf("extends: [a]\n"), HasSubstr("bad.yaml:1: extends: a list"));
}

TEST_F(StudyFilesTest, NamesThatWereProbablyMeantAreSuggested) {
  EXPECT_THAT(std::string(LoadStudy("quikstart").status().message()),
              testing::StartsWith("quikstart: no such file, did you mean quickstart? Allowed is"));
  Write("mine.yaml", "study: s\n");
  EXPECT_THAT(std::string(LoadStudy(dir_ + "/mien.yaml").status().message()),
              HasSubstr("did you mean " + dir_ + "/mine.yaml?"));
  EXPECT_THAT(ErrorOf("study: s\npairs: 1\nbase: indor\nvariants: [{name: a}]\n"),
              HasSubstr("did you mean indoor? Allowed"));
}

TEST_F(StudyFilesTest, OwnContentIsCountedFromTheFileThatNamesIt) {
  fs::create_directories(dir_ + "/content/meshes");
  fs::create_directories(dir_ + "/lib/tex");
  Write("lib/scene.yaml", "materials: {texture_dir: tex}\n");
  const auto config_of = [&](const std::string& set) {
    const v1::StudySpec study =
        Load(Write("s.yaml",
                   "study: s\nbase: lib/scene.yaml\npairs: 1\nvariants:\n  - {name: a, "
                   "set: {" +
                       set + "}}\n"));
    return study.variants_size() > 0 ? study.variants(0).config() : v1::SceneConfig();
  };
  const std::string root = dir_.substr(1);
  const v1::SceneConfig own = config_of("assets: {include: [content/meshes/, " + dir_ +
                                        "/content/../content/meshes, ./content/meshes]}");
  EXPECT_THAT(
      own.assets().include(),
      ElementsAre(root + "/content/meshes", root + "/content/meshes", root + "/content/meshes"));
  EXPECT_EQ(own.materials().texture_dir(), root + "/lib/tex");
  // A folder that is not here may lie below the root of a farm's workers.
  EXPECT_EQ(config_of("materials: {texture_dir: farm/tex}").materials().texture_dir(), "farm/tex");
  // A lock file names paths below the root, and loads anywhere.
  const v1::StudySpec study = Load(dir_ + "/s.yaml");
  EXPECT_TRUE(MessageDifferencer::Equals(Load(Write("o/lock.yaml", StudyToYaml(study))), study));
}

TEST_F(StudyFilesTest, OwnPairsAreBenchmarksBesideTheKnownOnes) {
  Write("pairs.txt", "l.png r.png d.pfm\n");
  fs::create_directories(dir_ + "/real");
  const std::string head = "study: s\npairs: 1\nvariants: [{name: a}]\nevaluate:\n  benchmarks:\n";
  const v1::StudySpec study =
      Load(Write("s.yaml", head + "    - {name: mine, list: pairs.txt}\n    - shipped\n    - "
                                  "{name: real, folder: real}\n"));
  EXPECT_THAT(study.evaluate().benchmarks(), ElementsAre("shipped"));
  ASSERT_EQ(study.evaluate().own_benchmarks_size(), 2);
  EXPECT_EQ(study.evaluate().own_benchmarks(0).list(), dir_.substr(1) + "/pairs.txt");
  EXPECT_EQ(study.evaluate().own_benchmarks(1).folder(), dir_.substr(1) + "/real");
  EXPECT_TRUE(MessageDifferencer::Equals(Load(Write("lock.yaml", StudyToYaml(study))), study));
  const struct {
    const char* items;
    const char* wanted;
  } bad[] = {
      {"    - shipped\n    - {name: shipped, list: pairs.txt}\n",
       "bad.yaml:7: evaluate.benchmarks[1].name: \"shipped\" names another benchmark too"},
      {"    - {name: a b, list: pairs.txt}\n", "bad.yaml:6: evaluate.benchmarks[0].name: \"a b\""},
      {"    - {name: a}\n", "bad.yaml:6: evaluate.benchmarks[0]: neither list nor folder"},
      {"    - {name: a, list: pairs.txt, folder: real}\n",
       "bad.yaml:6: evaluate.benchmarks[0]: both list and folder"},
      {"    - {name: a, lst: pairs.txt}\n",
       "bad.yaml:6: evaluate.benchmarks[0].lst: no such field, did you mean list?"},
      {"    - kiti2015\n",
       "bad.yaml:6: evaluate.benchmarks[0]: \"kiti2015\" is not known, did you"},
  };
  for (const auto& row : bad) EXPECT_THAT(ErrorOf(head + row.items), HasSubstr(row.wanted));
  EXPECT_THAT(
      ErrorOf("study: s\npairs: 1\nvariants: [{name: a}]\nevaluate: {own_benchmarks: []}\n"),
      HasSubstr("own_benchmarks: no such field"));
}

TEST_F(StudyFilesTest, APictureOfAnotherShapeOrSizeThanItsCameraIsRefused) {
  const auto error = [&](const std::string& rigs) {
    return ErrorOf("study: s\npairs: 1\nvariants:\n  - {name: a, set: {rigs: {" + rigs + "}}}\n");
  };
  EXPECT_THAT(error("width_px: 640, height_px: 480, camera: {preset: zed_2i}"),
              HasSubstr("bad.yaml:4: variants[0].set.rigs.height_px: pictures of 640 x 480 px by a "
                        "camera of 1280 x 720 px, whose pixels they would stretch, allowed is its "
                        "shape, such as 640 x 360 px"));
  EXPECT_THAT(error("width_px: 320, height_px: 180, camera: {fx_px: 1400}"),
              HasSubstr("rigs.camera.fx_px: 1400 px on pictures of 320 px are 13 degrees; if the "
                        "numbers are of pictures of another size, give that size"));
  EXPECT_THAT(
      error("width_px: 320, height_px: 180, camera: {fx_px: 300, cx_px: 960, cy_px: 540}"),
      HasSubstr("rigs.camera.cx_px: reaches from 960 to 960, allowed 0 to 320 px: a point of the "
                "picture; if the numbers are of pictures of another size"));
  EXPECT_THAT(error("width_px: 1280, height_px: 720, camera: {fx_px: 1400, cx_px: 960}"),
              HasSubstr("rigs.camera.cx_px: 960 px is far from the middle of pictures of 1280 px"));
  EXPECT_THAT(error("width_px: 320"),
              HasSubstr("set.rigs.width_px: 320 px alone makes pictures of 320 x 720 px, up to 128 "
                        "degrees high, allowed are both sides: height_px: 180 keeps the shape"));
  for (const char* fine :
       {"width_px: 640, height_px: 360, camera: {preset: zed_2i}", "width_px: 320, height_px: 720",
        "width_px: 320, height_px: 180, camera: {fx_px: 1400, width_px: 1920, height_px: 1080}",
        "width_px: 320, height_px: 180, camera: {fx_px: 1400, width_px: 320, height_px: 180}"}) {
    EXPECT_EQ(error(fine), "") << fine;
  }
}

TEST_F(StudyFilesTest, TheCameraIsDescribedInALine) {
  const v1::StudySpec study =
      Load(Write("s.yaml",
                 "study: s\npairs: 1\nvariants:\n"
                 "  - {name: a, set: {rigs: {width_px: 640, height_px: 360, baseline_m: 0.1, "
                 "camera: {fx_px: 640, width_px: 1280, height_px: 720}}}}\n"
                 "  - {name: b, set: {rigs: {width_px: 640, height_px: 360, horizontal_fov_deg: "
                 "{uniform: [60, 90]}, baseline_m: {uniform: [0.05, 0.1]}}}}\n"));
  EXPECT_THAT(
      DescribeCameras(study),
      ElementsAre("Camera of a: 640x360 px, K fx 320 fy 320 cx 320 cy 180 px, field of view 90 x "
                  "58.72 deg, baseline 0.1 m, disparity 32 px at 1 m, 3.2 px at 10 m",
                  "Camera of b: 640x360 px, K fx 320 to 554.3 fy 320 to 554.3 cx 320 cy 180 px, "
                  "field of view 60 to 90 x 35.98 to 58.72 deg, baseline 0.05 to 0.1 m, disparity "
                  "16 to 55.43 px at 1 m, 1.6 to 5.543 px at 10 m"));
}

}  // namespace
}  // namespace parallax
