#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <thread>

#include "common/base/system/file.h"
#include "common/config/config.h"
#include "common/image/io.h"
#include "coordinator/client/preview/study_preview.h"
#include "coordinator/study/keys.h"
#include "parallax/v1/jobs.pb.h"
#include "tests/coordinator/client/command_test.h"
#include "worker/render/renderer.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/solve_scene.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

// An empty room and small pictures: solved and rendered in a moment.
constexpr char kStudy[] =
    "study: small\n"
    "pairs: 2\n"
    "set:\n"
    "  furniture: {enabled: false}\n"
    "  floating: {count: 0}\n"
    "  rigs: {count: 2, width_px: 64, height_px: 36}\n"
    "variants:\n"
    "  - {name: narrow, set: {rigs: {baseline_m: 0.005}}}\n"
    "  - {name: wide, set: {rigs: {baseline_m: 0.2}}}\n";

class PreviewCommandTest : public CommandTest {
 protected:
  std::string Sheet() const { return dir_ + "/sheet.png"; }
  Json PreviewJson(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "preview");
    arguments.insert(arguments.end(), {"--out", Sheet(), "--json"});
    const Outcome outcome = RunCommand(arguments);
    EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.err;
    return outcome.exit_code == kExitOk ? Json::parse(outcome.out) : Json();
  }
};

TEST_F(PreviewCommandTest, AStudyInAFolderWithSpacesBecomesASheet) {
  fs::create_directories(dir_ + "/my studies");
  const std::string file = WriteText("my studies/a study.yaml", kStudy);
  const std::string sheet = dir_ + "/my studies/a sheet.png";
  const Outcome outcome = RunCommand({"preview", file, "--out", sheet});
  ASSERT_EQ(outcome.exit_code, kExitOk) << outcome.err;
  EXPECT_THAT(outcome.out, EndsWith(sheet + "\n"));
  EXPECT_THAT(outcome.out, HasSubstr("below 1 px"));
  EXPECT_THAT(outcome.out, HasSubstr("narrow"));
  EXPECT_THAT(outcome.err, HasSubstr("2 variants in "));
  const auto picture = ReadPngRgb8(sheet);
  ASSERT_TRUE(picture.ok()) << picture.status();
  EXPECT_GT(picture->width(), 3 * 320);
  EXPECT_FALSE(fs::exists(sheet + ".part"));
}

TEST_F(PreviewCommandTest, JsonTellsTheFiguresOfEachVariant) {
  const Json json = PreviewJson({WriteText("s.yaml", kStudy)});
  EXPECT_EQ(json["name"], "small");
  EXPECT_EQ(json["seed"], 1);
  EXPECT_EQ(json["sheet"], Sheet());
  EXPECT_GT(json["seconds"], 0);
  EXPECT_TRUE(json["page"].is_null());
  EXPECT_TRUE(json["left_out"].empty());
  ASSERT_EQ(json["variants"].size(), 2u);
  const Json &narrow = json["variants"][0], &wide = json["variants"][1];
  EXPECT_EQ(narrow["name"], "narrow");
  EXPECT_EQ(narrow["width_px"], 64);
  EXPECT_EQ(wide["baseline_m"], 0.2);
  // The same room and place: disparities go with the baseline.
  EXPECT_NEAR(wide["disparity_mean_px"].get<double>(),
              40 * narrow["disparity_mean_px"].get<double>(), 0.01);
  EXPECT_EQ(narrow["share_below_1px"], 1);
  EXPECT_EQ(wide["share_below_1px"], 0);
  EXPECT_EQ(wide["share_beyond_192px"], 0);
  // Another seed is another room.
  const Json other = PreviewJson({dir_ + "/s.yaml", "--seed", "7"});
  EXPECT_EQ(other["seed"], 7);
  EXPECT_NE(other["variants"][1]["disparity_mean_px"], wide["disparity_mean_px"]);
}

// The pair is the one that the study itself has, in figures to half a percentage point (shares) and
// two percent (lengths) although its pictures have a quarter of the pixels.
TEST_F(PreviewCommandTest, FiguresAreThoseOfTheStudysOwnPairInFullSize) {
  const std::string file = WriteText("s.yaml",
                                     "study: s\n"
                                     "pairs: 2\n"
                                     "set:\n"
                                     "  solver: {mode: reduced}\n"
                                     "  floating: {count: 3}\n"
                                     "  rigs: {count: 2, width_px: 640, height_px: 360, "
                                     "baseline_m: 1.2, clearance_baseline_m: 0}\n"
                                     "variants: [{name: near}]\n");
  const Json json = PreviewJson({file});
  const auto study = LoadStudy(file);
  ASSERT_TRUE(study.ok()) << study.status();
  v1::SolveJob job;
  *job.mutable_config() = study->variants(0).config();
  std::optional<v1::Scene> scene;
  for (uint32_t ordinal = 0; !scene; ++ordinal) {
    job.set_scene_seed(SceneSeedOf(study->seed(), ordinal).value);
    auto solved = Solve(job, {});
    ASSERT_TRUE(solved.ok()) << solved.status();
    if (solved->has_scene()) scene = solved->scene();
    ASSERT_LT(ordinal, 5u);
  }
  v1::RenderConfig render = job.config().render();
  render.set_profile("preview");
  render.set_samples_per_pixel(1);
  auto geometry = BuildSceneGeometry(*scene);
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  const auto renderer = Renderer::Create(*scene, *std::move(geometry), render);
  ASSERT_TRUE(renderer.ok()) << renderer.status();
  const auto frame = (*renderer)->RenderRig(scene->rigs(0), {}, {});
  ASSERT_TRUE(frame.ok()) << frame.status();
  const DisparityFigures whole = FiguresOf(frame->left.disparity_px);
  const Json& figures = json["variants"][0];
  EXPECT_EQ(figures["width_px"], 640);
  EXPECT_GT(whole.share_beyond_192px, 0.02) << "the test would see nothing";
  EXPECT_NEAR(figures["share_below_1px"].get<double>(), whole.share_below_1px, 0.005);
  EXPECT_NEAR(figures["share_beyond_192px"].get<double>(), whole.share_beyond_192px, 0.005);
  EXPECT_NEAR(figures["share_no_surface"].get<double>(), whole.share_no_surface, 0.005);
  EXPECT_NEAR(figures["disparity_mean_px"].get<double>(), whole.mean_px, 0.02 * whole.mean_px);
  EXPECT_NEAR(figures["disparity_median_px"].get<double>(), whole.median_px,
              0.02 * whole.median_px);
}

TEST_F(PreviewCommandTest, RawCamerasHaveFiguresOfTheirRows) {
  const Json json = PreviewJson({WriteText(
      "s.yaml", std::string(kStudy) +
                    "  - name: raw\n"
                    "    set: {rigs: {camera: {lens: {model: brown_conrady, k1: -0.1}, "
                    "raw_right: {pitch_deg: 1}}}, render: {maps: [disparity, raw]}}\n")});
  EXPECT_FALSE(json["variants"][0].contains("raw"));
  const Json& raw = json["variants"][2]["raw"];
  EXPECT_GT(raw["rows_apart_mean_px"], 0.3);
  EXPECT_LT(raw["rectified_rows_apart_max_px"], 0.02);
}

TEST_F(PreviewCommandTest, ASceneFileAndABuiltInNameAreTakenToo) {
  const std::string scene = WriteText("my-room.yaml",
                                      "type: indoor\n"
                                      "furniture: {enabled: false}\n"
                                      "floating: {count: 0}\n"
                                      "rigs: {count: 1, width_px: 64, height_px: 36}\n");
  const Json json = PreviewJson({scene});
  ASSERT_EQ(json["variants"].size(), 1u);
  EXPECT_EQ(json["variants"][0]["name"], "my-room");
  EXPECT_THAT(RunCommand({"preview", "quickstar", "--out", Sheet()}).err,
              HasSubstr("did you mean quickstart?"));
}

TEST_F(PreviewCommandTest, VariantsAreChosenByNameAndTheOthersNamed) {
  std::string many = kStudy;
  for (int i = 0; i < 9; ++i) many += "  - {name: more-" + std::to_string(i) + "}\n";
  const std::string file = WriteText("s.yaml", many);
  const Json chosen = PreviewJson({file, "--variants", "more-8,wide"});
  ASSERT_EQ(chosen["variants"].size(), 2u);
  EXPECT_EQ(chosen["variants"][0]["name"], "wide");
  EXPECT_EQ(chosen["left_out"].size(), 9u);
  const Json first = PreviewJson({file});
  EXPECT_EQ(first["variants"].size(), 8u);
  EXPECT_THAT(first["left_out"].get<std::vector<std::string>>(),
              ElementsAre("more-6", "more-7", "more-8"));
  EXPECT_EQ(first["variants"][3]["note"], "the same pair as more-0");
  const Outcome unknown = RunCommand({"preview", file, "--variants", "wid", "--out", Sheet()});
  EXPECT_EQ(unknown.exit_code, kExitUsage);
  EXPECT_THAT(unknown.err,
              HasSubstr("s.yaml has no variant \"wid\", did you mean wide?; it has narrow, wide"));
}

TEST_F(PreviewCommandTest, MistakesAreNamedAsCheckNamesThem) {
  const std::string file = WriteText("s.yaml",
                                     "study: s\npairs: 2\nvariants:\n"
                                     "  - {name: a, set: {rigs: {with_px: 4}}}\n");
  const Outcome preview = RunCommand({"preview", file, "--out", Sheet()});
  EXPECT_EQ(preview.exit_code, kExitUsage);
  EXPECT_THAT(preview.err, HasSubstr("s.yaml:4: "));
  EXPECT_EQ(preview.err, RunCommand({"config", "check", file}).err);
  const std::string good = WriteText("good.yaml", kStudy);
  const struct {
    std::string out, error;
  } cases[] = {{good, "no name of a picture, allowed is one that ends with .png"},
               {dir_ + "/none/x.png", dir_ + "/none: no such folder"}};
  for (const auto& [out, error] : cases) {
    const Outcome outcome = RunCommand({"preview", good, "--out", out});
    EXPECT_EQ(outcome.exit_code, kExitUsage) << out;
    EXPECT_THAT(outcome.err, HasSubstr(error)) << out;
  }
  EXPECT_EQ(RunCommand({"preview", dir_ + "/gone.yaml", "--out", Sheet()}).exit_code, kExitUsage);
  EXPECT_EQ(RunCommand({"preview", good, "--out", Sheet(), "--page", "--page-listen", "0.0.0.0:0"})
                .exit_code,
            kExitUsage);
}

TEST_F(PreviewCommandTest, VariantsOfOneLayoutShareItsSolveAndASecondPreviewAsksForNothing) {
  const PreviewOptions options{.file = WriteText("s.yaml", kStudy)};
  std::vector<std::string> stages, files;
  PreviewWatcher watcher;
  watcher.stage = [&](const std::string& stage) { stages.push_back(stage); };
  watcher.files = [&](const std::vector<std::string>& paths) { files = paths; };
  StudyPreview maker;
  const auto first = maker.Make(options, watcher);
  ASSERT_TRUE(first.ok()) << first.status();
  // The layout with the first variant's scene, then the other's scene on that layout.
  EXPECT_THAT(stages, ElementsAre("solving 1 scene", "solving 1 scene", "rendering narrow (1 of 2)",
                                  "rendering wide (2 of 2)"));
  EXPECT_THAT(files, Contains(options.file));
  stages.clear();
  const auto second = maker.Make(options, watcher);
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_THAT(stages, Not(Contains(HasSubstr("solving"))));
  EXPECT_EQ(second->rows[1].pair->left, first->rows[1].pair->left);
}

TEST_F(PreviewCommandTest, FilesThatTheStudyNamesAreToldEvenIfTheyAreMissing) {
  WriteText("base.yaml", "type: indoor\n");
  const PreviewOptions options{
      .file = WriteText("s.yaml", "extends: other.yaml\nbase: base.yaml\nstudy: s\n")};
  std::vector<std::string> files;
  PreviewWatcher watcher;
  watcher.files = [&](const std::vector<std::string>& paths) { files = paths; };
  EXPECT_FALSE(StudyPreview().Make(options, watcher).ok());
  EXPECT_THAT(files, Contains(dir_ + "/other.yaml"));
  WriteText("other.yaml", kStudy);
  fs::create_directories(dir_ + "/pictures");
  WriteText("s.yaml",
            "extends: other.yaml\nbase: base.yaml\nset: {materials: {picture_dir: pictures}}\n");
  EXPECT_FALSE(StudyPreview().Make(options, watcher).ok()) << "a folder without pictures";
  for (const char* name : {"s.yaml", "other.yaml", "base.yaml", "pictures"}) {
    EXPECT_THAT(files, Contains(dir_ + "/" + name));
  }
}

TEST_F(PreviewCommandTest, WatchFollowsSavesThroughMistakesUntilCtrlC) {
  const std::string base = WriteText("base.yaml",
                                     "type: indoor\nfurniture: {enabled: false}\n"
                                     "floating: {count: 0}\n"
                                     "rigs: {count: 1, width_px: 64, height_px: 36}\n");
  const std::string file =
      WriteText("s.yaml", "study: s\nbase: base.yaml\npairs: 1\nvariants: [{name: a}]\n");
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  const auto wait_for = [&](const std::function<bool()>& done) {
    while (!done() && std::chrono::steady_clock::now() < deadline) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return done();
  };
  std::thread user([&] {
    EXPECT_TRUE(wait_for([&] { return fs::exists(Sheet()); }));
    fs::remove(Sheet());
    // A mistake in a file that it names makes no sheet; the mended one does.
    WriteText("base.yaml", "type: indoors\n");
    EXPECT_TRUE(wait_for([&] { return !ReadFile(dir_ + "/err").value().empty(); }));
    EXPECT_FALSE(fs::exists(Sheet()));
    WriteText("base.yaml",
              "type: indoor\nfurniture: {enabled: false}\nfloating: {count: 0}\n"
              "rigs: {count: 1, width_px: 96, height_px: 54}\n");
    EXPECT_TRUE(wait_for([&] { return fs::exists(Sheet()); }));
    raise(SIGINT);
  });
  std::ostringstream out;
  std::ofstream err(dir_ + "/err");
  Environment environment;
  environment.out.stream = &out;
  environment.err.stream = &err;
  EXPECT_EQ(
      RunClient({"preview", file, "--watch", "--page", "--out", Sheet(), "--json"}, environment),
      kExitOk);
  user.join();
  EXPECT_THAT(*ReadFile(dir_ + "/err"), HasSubstr("base.yaml:1: type: "));
  ASSERT_EQ(Lines(out.str()), 2) << out.str();
  const Json last = Json::parse(out.str().substr(out.str().find('\n') + 1));
  EXPECT_EQ(last["variants"][0]["width_px"], 96);
  EXPECT_THAT(last["page"].get<std::string>(), HasSubstr("http://127.0.0.1:"));
}

TEST_F(PreviewCommandTest, CtrlCLeavesNoSheet) {
  const std::string file =
      WriteText("s.yaml", "study: s\nbase: nature\npairs: 1\nvariants: [{name: a}]\n");
  struct sigaction ignore {
  }, before{};
  ignore.sa_handler = SIG_IGN;  // Of signals that come before or after the command listens.
  sigaction(SIGINT, &ignore, &before);
  std::atomic<bool> ended = false;
  std::thread user([&ended] {
    while (!ended) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      kill(getpid(), SIGINT);
    }
  });
  const Outcome outcome = RunCommand({"preview", file, "--out", Sheet()});
  ended = true;
  user.join();
  sigaction(SIGINT, &before, nullptr);
  EXPECT_EQ(outcome.exit_code, kExitInterrupted) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("stopped: no sheet was made"));
  EXPECT_FALSE(fs::exists(Sheet()));
}

}  // namespace
}  // namespace parallax::client
