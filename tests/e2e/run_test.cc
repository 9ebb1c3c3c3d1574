// `parallax run` with the real worker: what a person gets, and what no crash may take away.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tests/e2e/process.h"

namespace parallax::e2e {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using Json = nlohmann::json;

// Small, but with all parts: furniture, floating objects, materials, lights, every map.
constexpr char kStudy[] =
    "study: tiny\n"
    "seed: 5\n"
    "pairs: 2\n"
    "rigs_per_scene: 2\n"
    "variants:\n"
    "  - name: narrow\n"
    "    set:\n"
    "      floating: {count: 2}\n"
    "      rigs: {count: 4, width_px: 64, height_px: 48, baseline_m: {uniform: [0.04, 0.1]}}\n"
    "      render: {profile: preview, samples_per_pixel: 1}\n"
    "  - name: wide\n"
    "    set:\n"
    "      floating: {count: 2}\n"
    "      rigs: {count: 4, width_px: 64, height_px: 48, baseline_m: {uniform: [0.2, 0.3]}}\n"
    "      render: {profile: preview, samples_per_pixel: 1}\n";

constexpr const char* kTruth[] = {
    "depth_left.exr",     "depth_right.exr",     "disparity_left.exr", "disparity_right.exr",
    "occlusion_left.png", "occlusion_right.png", "objects_left.png",   "objects_right.png",
    "materials_left.png", "materials_right.png", "normals_left.exr",   "normals_right.exr",
    "masks_left.png",     "masks_right.png"};

// One variant's pictures want 26 GB.
constexpr char kTooBig[] =
    "study: memory\n"
    "seed: 5\n"
    "pairs: 2\n"
    "rigs_per_scene: 2\n"
    "variants:\n"
    "  - name: huge\n"
    "    set:\n"
    "      floating: {count: 2}\n"
    "      rigs: {count: 4, width_px: 7680, height_px: 4320}\n"
    "      render: {profile: preview, samples_per_pixel: 1}\n"
    "  - name: small\n"
    "    set:\n"
    "      floating: {count: 2}\n"
    "      rigs: {count: 4, width_px: 64, height_px: 48}\n"
    "      render: {profile: preview, samples_per_pixel: 1}\n";

class RunTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = fs::temp_directory_path() / "parallax_e2e_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    dir_ = name;
    study_ = dir_ + "/tiny.yaml";
    std::ofstream(study_) << kStudy;
  }
  void TearDown() override {
    if (HasFailure()) {
      for (const auto& entry : fs::recursive_directory_iterator(dir_)) {
        if (entry.path().extension() != ".log") continue;
        std::cerr << "---- " << entry.path() << "\n" << ReadText(entry.path());
      }
    }
    fs::remove_all(dir_);
  }

  std::vector<std::string> Command(const std::string& out, std::vector<std::string> more = {}) {
    std::vector<std::string> command = {PARALLAX_BINARY, "run", study_, "--out", out, "--json"};
    command.insert(command.end(), more.begin(), more.end());
    return command;
  }
  std::unique_ptr<Process> Start(const std::string& out, std::vector<std::string> more = {}) {
    return std::make_unique<Process>(Command(out, std::move(more)));
  }
  // Runs to the end, which must be a success; its report.
  Json Run(const std::string& out, std::vector<std::string> more = {}) {
    const auto process = Start(out, std::move(more));
    EXPECT_EQ(process->Wait(), 0) << process->Err();
    return Json::parse(process->Out(), nullptr, false);
  }

  static std::vector<Json> Index(const std::string& out, const std::string& variant) {
    std::vector<Json> lines;
    std::istringstream text(ReadText(out + "/" + variant + "/index.jsonl"));
    for (std::string line; std::getline(text, line);) lines.push_back(Json::parse(line));
    return lines;
  }

  // Every frame wanted is in the index once, complete on disk.
  static void ExpectComplete(const std::string& out, size_t pairs) {
    for (const char* variant : {"narrow", "wide"}) {
      const std::vector<Json> index = Index(out, variant);
      EXPECT_EQ(index.size(), pairs) << variant;
      std::set<std::pair<int, int>> seen;
      for (const Json& line : index) {
        const auto key = std::make_pair(line["scene"].get<int>(), line["rig"].get<int>());
        EXPECT_TRUE(seen.insert(key).second) << line;
        char folder[32];
        std::snprintf(folder, sizeof folder, "/%06d/%03d/", key.first, key.second);
        const std::string frame = out + "/" + variant + "/frames" + folder;
        for (const char* name : kTruth) EXPECT_TRUE(fs::exists(frame + name)) << frame << name;
        for (const char* name : {"left.png", "right.png", "frame.json"}) {
          EXPECT_TRUE(fs::exists(frame + name)) << frame << name;
        }
      }
      size_t folders = 0;
      for (const auto& entry : fs::recursive_directory_iterator(out + "/" + variant + "/frames")) {
        folders += entry.path().filename() == "frame.json";
      }
      EXPECT_EQ(folders, pairs) << variant;
    }
  }

  // An attempt to render has begun, and is not published yet.
  static bool Rendering(const std::string& out) {
    std::error_code error;
    const fs::recursive_directory_iterator end;
    for (fs::recursive_directory_iterator it(out + "/.parallax/store", error); !error && it != end;
         it.increment(error)) {
      if (it->path().filename().string().rfind(".attempt-", 0) == 0) return true;
    }
    return false;
  }

  // Content of the files that must be the same, by path.
  static std::map<std::string, std::string> Content(const std::string& out) {
    std::map<std::string, std::string> content;
    for (const auto& entry : fs::recursive_directory_iterator(out)) {
      const std::string path = fs::relative(entry.path(), out);
      if (!entry.is_regular_file() || path.rfind(".parallax", 0) == 0) continue;
      const std::string name = entry.path().filename();
      const bool truth = std::find(std::begin(kTruth), std::end(kTruth), name) != std::end(kTruth);
      if (truth || entry.path().extension() == ".pb") content[path] = ReadText(entry.path());
    }
    return content;
  }

  std::string dir_;
  std::string study_;
};

TEST_F(RunTest, MakesADatasetAndNeverRendersItAgain) {
  const std::string out = dir_ + "/out";
  Json report = Run(out);
  EXPECT_EQ(report["state"], "succeeded");
  EXPECT_EQ(report["pairs_rendered"], 4);
  EXPECT_EQ(report["layouts_reused"], 1) << "two variants share a room";
  EXPECT_GT(report["core_seconds_per_pair"].get<double>(), 0);
  ExpectComplete(out, 2);
  EXPECT_TRUE(fs::exists(report["contact_sheet"].get<std::string>()));
  EXPECT_EQ(ReadText(out + "/study.yaml"), kStudy);
  // Hard links: the dataset costs no second copy.
  struct stat file {};
  ASSERT_EQ(stat((out + "/narrow/frames/000000/000/left.png").c_str(), &file), 0);
  EXPECT_GT(file.st_nlink, 1u);

  report = Run(out);
  EXPECT_EQ(report["pairs_rendered"], 0);
  EXPECT_EQ(report["state"], "succeeded");
  Process again({PARALLAX_BINARY, "run", study_, "--out", out});
  EXPECT_EQ(again.Wait(), 0);
  EXPECT_THAT(again.Out(), HasSubstr("nothing to render: all 4 pairs were there already"));

  const auto before = Content(out);
  report = Run(out, {"--pairs", "4"});
  EXPECT_EQ(report["pairs_rendered"], 4) << "two more of each variant";
  ExpectComplete(out, 4);
  const auto after = Content(out);
  for (const auto& [path, bytes] : before) EXPECT_EQ(after.at(path), bytes) << path;
}

TEST_F(RunTest, GivesTheSameBytesWithOneWorkerAndWithThree) {
  Run(dir_ + "/one", {"--workers", "1", "--pairs", "4"});
  Run(dir_ + "/three", {"--workers", "3", "--pairs", "4"});
  const auto one = Content(dir_ + "/one");
  const auto three = Content(dir_ + "/three");
  // Four pairs and two recipes of two variants.
  EXPECT_EQ(one.size(), 2 * (4 * std::size(kTruth) + 2));
  ASSERT_EQ(one.size(), three.size());
  for (const auto& [path, bytes] : one) {
    ASSERT_EQ(three.count(path), 1u) << path;
    EXPECT_TRUE(three.at(path) == bytes) << path << " differs";
  }
}

TEST_F(RunTest, AKilledWorkerCostsNothingButTime) {
  const std::string out = dir_ + "/out";
  const auto run = Start(out, {"--pairs", "6", "--workers", "1"});
  ASSERT_TRUE(WaitUntil(*run, [&] { return Rendering(out); })) << run->Err();
  const std::vector<pid_t> workers = run->Children();
  ASSERT_EQ(workers.size(), 1u);
  kill(workers[0], SIGKILL);
  EXPECT_EQ(run->Wait(), 0) << run->Err();
  EXPECT_EQ(Json::parse(run->Out())["worker_crashes"], 1);
  EXPECT_THAT(run->Err(), HasSubstr("a worker crashed"));
  ExpectComplete(out, 6);
}

// The attempt that renders has noted so many pairs as finished.
int FinishedPairs(const std::string& out) {
  int notes = 0;
  std::error_code error;
  const fs::recursive_directory_iterator end;
  for (fs::recursive_directory_iterator it(out + "/.parallax/store", error); !error && it != end;
       it.increment(error)) {
    notes += it->path().parent_path().filename() == "finished" && it->path().extension() == ".pb";
  }
  return notes;
}

// "3 of 8": what a worker's log says of pairs that it took over; "" if it took none.
std::string TakenOver(const std::string& out) {
  std::string taken;
  for (const auto& entry : fs::recursive_directory_iterator(out + "/.parallax")) {
    if (entry.path().extension() != ".log") continue;
    std::istringstream text(ReadText(entry.path()));
    for (std::string line; std::getline(text, line);) {
      const size_t at = line.find("pairs of earlier attempts are taken over");
      if (at == std::string::npos) continue;
      std::istringstream fields(line.substr(at));
      std::string pairs, of;
      for (std::string field; fields >> field;) {
        if (field.rfind("pairs=", 0) == 0) pairs = field.substr(6);
        if (field.rfind("of=", 0) == 0) of = field.substr(3);
      }
      taken = pairs + " of " + of;
    }
  }
  return taken;
}

TEST_F(RunTest, AKilledWorkerCostsThePairAtHandAndNotItsJob) {
  constexpr int kPairs = 8;
  std::ofstream(study_) << "study: tiny\nseed: 5\npairs: 8\nrigs_per_scene: 8\nvariants:\n"
                           "  - name: narrow\n    set:\n      floating: {count: 2}\n"
                           "      rigs: {count: 8, width_px: 160, height_px: 96}\n"
                           "      render: {profile: preview, samples_per_pixel: 1}\n";
  const std::string calm = dir_ + "/calm", out = dir_ + "/out";
  Run(calm, {"--workers", "1"});
  EXPECT_EQ(TakenOver(calm), "");
  const auto run = Start(out, {"--workers", "1"});
  ASSERT_TRUE(WaitUntil(*run, [&] { return FinishedPairs(out) >= 3; })) << run->Err();
  const std::vector<pid_t> workers = run->Children();
  ASSERT_EQ(workers.size(), 1u);
  kill(workers[0], SIGKILL);
  while (IsAlive(workers[0])) usleep(1000);
  const int finished = FinishedPairs(out);
  ASSERT_LT(finished, kPairs) << "it was too quick";
  EXPECT_EQ(run->Wait(), 0) << run->Err();
  EXPECT_EQ(Json::parse(run->Out())["worker_crashes"], 1);
  EXPECT_EQ(TakenOver(out), std::to_string(finished) + " of " + std::to_string(kPairs));
  const auto want = Content(calm);
  EXPECT_EQ(want.size(), kPairs * std::size(kTruth) + 1);
  EXPECT_EQ(Content(out), want);
}

// The worker dies between the end of its job and the coordinator's answer, and its report with it.
// The run dies too, so that it can't hear what was in the socket; another one goes on.
TEST_F(RunTest, AWorkerThatDiesUnheardCostsNoPairOfItsJob) {
  constexpr int kPairs = 8;
  std::ofstream(study_) << "study: tiny\nseed: 5\npairs: 8\nrigs_per_scene: 8\nvariants:\n"
                           "  - name: narrow\n    set:\n      floating: {count: 2}\n"
                           "      rigs: {count: 8, width_px: 160, height_px: 96}\n"
                           "      render: {profile: preview, samples_per_pixel: 1}\n";
  const std::string out = dir_ + "/out";
  auto run = Start(out, {"--workers", "1"});
  ASSERT_TRUE(WaitUntil(*run, [&] { return FinishedPairs(out) >= 1; })) << run->Err();
  const std::vector<pid_t> workers = run->Children();
  ASSERT_EQ(workers.size(), 1u);
  // The coordinator, which is in the same process as the run, answers nothing from now on.
  run->Signal(SIGSTOP);
  const auto reports = [&] {
    std::vector<fs::path> found;
    std::error_code error;
    const fs::recursive_directory_iterator end;
    for (fs::recursive_directory_iterator it(out + "/.parallax/outbox", error); !error && it != end;
         it.increment(error)) {
      if (it->path().extension() == ".complete") found.push_back(it->path());
    }
    return found;
  };
  for (int i = 0; i < 3000 && reports().empty(); ++i) usleep(10000);
  ASSERT_EQ(FinishedPairs(out), kPairs);
  kill(workers[0], SIGKILL);
  run->Signal(SIGKILL);
  run->Wait();
  while (IsAlive(workers[0])) usleep(1000);
  ASSERT_EQ(reports().size(), 1u);
  fs::remove(reports().front());
  run = Start(out, {"--workers", "1"});
  EXPECT_EQ(run->Wait(), 0) << run->Err();
  EXPECT_EQ(TakenOver(out), std::to_string(kPairs) + " of " + std::to_string(kPairs));
  EXPECT_EQ(Content(out).size(), kPairs * std::size(kTruth) + 1);
}

TEST_F(RunTest, AKilledRunTakesItsWorkersAlongAndGoesOnLater) {
  const std::string out = dir_ + "/out";
  std::vector<pid_t> workers;
  {
    const auto run = Start(out, {"--pairs", "6"});
    ASSERT_TRUE(WaitUntil(*run, [&] { return Rendering(out); })) << run->Err();
    workers = run->Children();
    run->Signal(SIGKILL);
    run->Wait();
  }
  ASSERT_FALSE(workers.empty());
  for (const pid_t worker : workers) {
    while (IsAlive(worker)) usleep(1000);
  }
  const std::string socket_folder = ReadText(out + "/.parallax/socket");
  EXPECT_TRUE(fs::exists(socket_folder)) << socket_folder;
  Run(out, {"--pairs", "6"});
  EXPECT_FALSE(fs::exists(socket_folder)) << "what the killed run left is cleared away";
  ExpectComplete(out, 6);
}

TEST_F(RunTest, CtrlCDrainsAndTheSameCommandGoesOn) {
  const std::string out = dir_ + "/out";
  const auto run = Start(out, {"--pairs", "6"});
  ASSERT_TRUE(WaitUntil(*run, [&] { return Rendering(out); })) << run->Err();
  run->Signal(SIGINT);
  EXPECT_EQ(run->Wait(), 130) << run->Err();
  EXPECT_THAT(run->Err(), HasSubstr("\nstopped: "));
  EXPECT_THAT(run->Err(), HasSubstr("of 12 pairs are done and kept; the same command again"));
  Run(out, {"--pairs", "6"});
  ExpectComplete(out, 6);
}

TEST_F(RunTest, OneRunAFolderAtATime) {
  const std::string out = dir_ + "/out";
  const auto first = Start(out, {"--pairs", "6"});
  ASSERT_TRUE(WaitUntil(*first, [&] { return !first->Children().empty(); })) << first->Err();
  const auto second = Start(out);
  EXPECT_EQ(second->Wait(), 2);
  EXPECT_THAT(second->Err(), HasSubstr("in use by another parallax (process " +
                                       std::to_string(first->pid()) + ")"));
  first->Signal(SIGINT);
  first->Signal(SIGTERM);
  EXPECT_EQ(first->Wait(), 130);
}

TEST_F(RunTest, AnotherStudyDoesNotMoveIntoADataset) {
  const std::string out = dir_ + "/out";
  Run(out);
  const auto other = Start(out, {"--seed", "6"});
  EXPECT_EQ(other->Wait(), 2);
  EXPECT_THAT(other->Err(), HasSubstr("seed"));
  ExpectComplete(out, 2);
}

TEST_F(RunTest, AStudyThatGrowsOrChangesRendersOnlyWhatIsNew) {
  const std::string out = dir_ + "/out";
  EXPECT_EQ(Run(out)["pairs_rendered"], 4);
  const std::string third =
      "  - name: third\n"
      "    set:\n"
      "      floating: {count: 1}\n"
      "      rigs: {count: 4, width_px: 64, height_px: 48}\n"
      "      render: {profile: preview, samples_per_pixel: 2}\n";
  std::ofstream(study_) << kStudy << third;
  Json report = Run(out);
  EXPECT_EQ(report["pairs_rendered"], 2) << "the third variant's";
  EXPECT_EQ(report["set_aside"], Json::array());
  EXPECT_EQ(Index(out, "third").size(), 2u);
  ExpectComplete(out, 2);

  // Other settings of one variant: its old pairs stay, elsewhere.
  std::string changed = third;
  changed.replace(changed.find("samples_per_pixel: 2"), 20, "samples_per_pixel: 3");
  std::ofstream(study_) << kStudy << changed;
  report = Run(out);
  EXPECT_EQ(report["pairs_rendered"], 2);
  ASSERT_EQ(report["set_aside"].size(), 1u) << report;
  EXPECT_THAT(report["set_aside"][0].get<std::string>(),
              HasSubstr("variant third: other settings"));
  const std::string aside = out + "/.parallax/aside/001";
  EXPECT_EQ(Index(aside, "third").size(), 2u);
  EXPECT_TRUE(fs::exists(aside + "/third/frames/000000/000/left.png"));
  EXPECT_EQ(Index(out, "third").size(), 2u);
  ExpectComplete(out, 2);

  // Back to the first form: all of it is known.
  std::ofstream(study_) << kStudy;
  report = Run(out);
  EXPECT_EQ(report["pairs_rendered"], 0);
  EXPECT_FALSE(fs::exists(out + "/third"));
  ExpectComplete(out, 2);
  Process verify({PARALLAX_BINARY, "verify", out});
  EXPECT_EQ(verify.Wait(), 0) << verify.Out() << verify.Err();
}

TEST_F(RunTest, DatasetsThatShareAStoreUseEachOthersPairs) {
  const std::string store = dir_ + "/shared";
  EXPECT_EQ(Run(dir_ + "/one", {"--store", store})["pairs_rendered"], 4);
  EXPECT_FALSE(fs::exists(dir_ + "/one/.parallax/store"));
  const Json report = Run(dir_ + "/two", {"--store", store, "--pairs", "3"});
  EXPECT_EQ(report["pairs_rendered"], 2) << "one pair more of each variant";
  EXPECT_EQ(report["frames_in_dataset"], 6);
  // The folder knows its store.
  EXPECT_EQ(Run(dir_ + "/one")["pairs_rendered"], 0);
  EXPECT_FALSE(fs::exists(dir_ + "/one/.parallax/queue.db"));
  // A dataset stays whole without its store.
  fs::remove_all(store);
  Process verify({PARALLAX_BINARY, "verify", dir_ + "/two"});
  EXPECT_EQ(verify.Wait(), 0) << verify.Out() << verify.Err();
}

TEST_F(RunTest, OwnPairsAreABenchmarkOfAStudy) {
  fs::create_directories(dir_ + "/pairs");
  ASSERT_EQ(Run(dir_ + "/out")["pairs_rendered"], 4);
  const std::string frame = dir_ + "/out/narrow/frames/000000/000/";
  fs::copy_file(frame + "left.png", dir_ + "/pairs/l.png");
  fs::copy_file(frame + "right.png", dir_ + "/pairs/r.png");
  fs::copy_file(frame + "disparity_left.exr", dir_ + "/pairs/d.exr");
  std::ofstream(dir_ + "/pairs/list.txt") << "l.png r.png d.exr\n";
  std::ofstream(study_) << kStudy
                        << "evaluate:\n  benchmarks: [{name: mine, list: pairs/list.txt}]\n";
  const Json report = Run(dir_ + "/out");
  EXPECT_EQ(report["pairs_rendered"], 0);
  EXPECT_EQ(report["evaluations"], 1);
  const std::string scores = dir_ + "/out/scores/mine.sgbm.opencv.jsonl";
  EXPECT_TRUE(fs::exists(scores));
  // Other content is another benchmark: scored anew, the old scores are kept.
  fs::copy_file(frame + "left.png", dir_ + "/pairs/r.png", fs::copy_options::overwrite_existing);
  const Json again = Run(dir_ + "/out");
  EXPECT_EQ(again["set_aside"].size(), 1u) << again;
  EXPECT_NE(ReadText(scores),
            ReadText(dir_ + "/out/.parallax/aside/001/scores/mine.sgbm.opencv.jsonl"));
}

TEST_F(RunTest, OtherFiltersRenderNothingAndRewriteTheVerdicts) {
  const std::string out = dir_ + "/out";
  EXPECT_EQ(Run(out)["pairs_rendered"], 4);
  const auto before = Content(out);
  for (const Json& line : Index(out, "narrow")) EXPECT_EQ(line["filters"]["near"]["passed"], true);

  // No surface of a room is 50 m away.
  std::string strict = kStudy;
  const std::string render = "      render: {profile: preview, samples_per_pixel: 1}\n";
  const size_t narrow = strict.find(render);
  strict.insert(narrow, "      filters: {min_depth_m: 50, min_distance_m: 60}\n");
  std::ofstream(study_) << strict;
  const Json report = Run(out);
  EXPECT_EQ(report["state"], "succeeded");
  EXPECT_EQ(report["pairs_rendered"], 0);
  EXPECT_LT(report["elapsed_s"].get<double>(), 30);
  EXPECT_EQ(Content(out), before);
  ExpectComplete(out, 2);
  for (const Json& line : Index(out, "narrow")) {
    EXPECT_EQ(line["passed"], false);
    EXPECT_EQ(line["filters"]["near"]["passed"], false);
    EXPECT_EQ(line["filters"]["near"]["threshold"], 50);
    EXPECT_EQ(line["filters"]["close"]["threshold"], 60);
  }
  for (const Json& line : Index(out, "wide")) {
    EXPECT_EQ(line["passed"], true);
    EXPECT_EQ(line["filters"].count("close"), 0u);
  }
  const Json card = Json::parse(ReadText(out + "/narrow/dataset.json"));
  EXPECT_EQ(card["pairs_passing_filters"], 0);
  EXPECT_EQ(card["filters_failed"]["close"], 2);
  EXPECT_THAT(ReadText(out + "/narrow/README.md"), HasSubstr("| passing all | 0 |"));
  EXPECT_EQ(ReadText(out + "/study.yaml"), strict);
  // Exports follow the verdicts.
  Process exported({PARALLAX_BINARY, "export", out + "/narrow", "--layout", "middlebury", "--out",
                    dir_ + "/exported"});
  EXPECT_NE(exported.Wait(), 0);
  EXPECT_THAT(exported.Err(), HasSubstr("no pair is left (2 fail a filter"));
}

TEST_F(RunTest, AnotherSensorRendersNothingAndMakesOtherPictures) {
  const std::string out = dir_ + "/out";
  const auto with_sensor = [&](const std::string& preset) {
    std::string text = kStudy;
    const std::string render = "render: {profile: preview, samples_per_pixel: 1}";
    for (size_t at = text.find(render); at != std::string::npos; at = text.find(render, at + 1)) {
      text.replace(at, render.size(),
                   "sensor: {preset: " + preset + "}\n" +
                       "      render: {profile: preview, samples_per_pixel: 1, keep_hdr: true}");
    }
    std::ofstream(study_) << text;
  };
  const auto picture = [&] { return ReadText(out + "/narrow/frames/000000/000/left.png"); };
  with_sensor("'off'");
  EXPECT_EQ(Run(out)["pairs_rendered"], 4);
  const auto truth = Content(out);
  const std::string rendered = picture();
  with_sensor("webcam");
  Json report = Run(out);
  EXPECT_EQ(report["state"], "succeeded");
  EXPECT_EQ(report["pairs_rendered"], 0);
  EXPECT_EQ(Content(out), truth);
  const std::string webcam = picture();
  EXPECT_NE(webcam, rendered);
  Process verified({PARALLAX_BINARY, "verify", out});
  EXPECT_EQ(verified.Wait(), 0) << verified.Out() << verified.Err();
  // A new folder has no earlier results, and still gets the same pictures.
  const std::string fresh = dir_ + "/fresh";
  EXPECT_EQ(Run(fresh)["pairs_rendered"], 4);
  EXPECT_EQ(ReadText(fresh + "/narrow/frames/000000/000/left.png"), webcam);
  with_sensor("'off'");
  EXPECT_EQ(Run(out)["pairs_rendered"], 0);
  EXPECT_EQ(picture(), rendered);
}

TEST_F(RunTest, WorkersThatCrashForEverEndTheRunWithTheirLog) {
  const std::string script = dir_ + "/worker.sh";
  std::ofstream(script) << "#!/bin/sh\necho the disk melted >&2\nexit 9\n";
  fs::permissions(script, fs::perms::owner_all);
  Process run(Command(dir_ + "/out"), {"PARALLAX_WORKER=" + script});
  EXPECT_EQ(run.Wait(), 1);
  EXPECT_THAT(run.Err(), HasSubstr("workers keep crashing"));
  EXPECT_THAT(run.Err(), HasSubstr("| the disk melted"));
}

TEST_F(RunTest, ADatabaseFromTheFutureIsRefusedInOneLine) {
  const std::string out = dir_ + "/out";
  Run(out);
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open((out + "/.parallax/queue.db").c_str(), &db), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(db, "PRAGMA user_version = 9999", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(db);
  const auto run = Start(out);
  EXPECT_EQ(run->Wait(), 2);
  const std::string error = run->Err();
  EXPECT_EQ(std::count(error.begin(), error.end(), '\n'), 1) << error;
  EXPECT_THAT(error, HasSubstr("9999"));
}

TEST_F(RunTest, AFullDiskStopsTheRunWhichThenGoesOn) {
  // A small disk of its own, in a name space where mounting is allowed.
  const std::string out = dir_ + "/disk";
  fs::create_directories(out);
  const std::string mount = "mount -t tmpfs -o size=120m none " + out + " && ";
  Process probe({"/usr/bin/unshare", "-Urm", "/bin/sh", "-c", mount + "true"});
  if (probe.Wait() != 0) GTEST_SKIP() << "mounting is not allowed here";
  std::string command;
  for (const std::string& word : Command(out, {"--pairs", "6", "--yes"})) command += word + " ";
  const std::string script = mount + command + "& run=$!; " +
                             // The disk fills up in the middle of the run.
                             "until [ -n \"$(find " + out +
                             "/.parallax/store -name '.attempt-*' 2>/dev/null)\" ] || "
                             "! kill -0 $run 2>/dev/null; do sleep 0.02; done; "
                             "dd if=/dev/zero of=" +
                             out +
                             "/filler bs=1M 2>/dev/null; "
                             "wait $run; echo stopped with $?; rm " +
                             out + "/filler; " + command + "; echo ended with $?";
  Process run({"/usr/bin/unshare", "-Urm", "/bin/sh", "-c", script});
  EXPECT_EQ(run.Wait(), 0);
  EXPECT_THAT(run.Out(), HasSubstr("stopped with 4"));
  EXPECT_THAT(run.Out(), HasSubstr("ended with 0"));
  EXPECT_THAT(run.Err(), HasSubstr("the same command again goes on from there"));
  EXPECT_THAT(run.Out(), HasSubstr("\"pairs_done\": 12"));
}

TEST_F(RunTest, ATooSmallDiskIsRefusedBeforeAnythingIsMade) {
  const std::string out = dir_ + "/disk";
  fs::create_directories(out);
  std::string command;
  for (const std::string& word : Command(out)) command += word + " ";
  const std::string mount = "mount -t tmpfs -o size=8m none " + out + " && ";
  Process probe({"/usr/bin/unshare", "-Urm", "/bin/sh", "-c", mount + "true"});
  if (probe.Wait() != 0) GTEST_SKIP() << "mounting is not allowed here";
  Process small({"/usr/bin/unshare", "-Urm", "/bin/sh", "-c", mount + command});
  EXPECT_EQ(small.Wait(), 4);
  EXPECT_THAT(small.Err(), HasSubstr("is full: "));
  Process read_only({"/usr/bin/unshare", "-Urm", "/bin/sh", "-c",
                     mount + "mount -o remount,ro " + out + " && " + command});
  EXPECT_EQ(read_only.Wait(), 4);
  EXPECT_THAT(read_only.Err(), HasSubstr("Read-only file system"));
}

TEST_F(RunTest, AJobTooBigForTheMemoryFailsAloneAndItsWorkerGoesOn) {
  std::ofstream(study_) << kTooBig;
  const auto run = std::make_unique<Process>(Command(dir_ + "/out"),
                                             std::vector<std::string>{"PARALLAX_MEMORY_MB=900"});
  const auto says = [&](const char* text) { return run->Err().find(text) != std::string::npos; };
  ASSERT_TRUE(WaitUntil(*run, [&] { return says("RESOURCE_EXHAUSTED"); })) << run->Err();
  const std::vector<pid_t> daemons = run->Children();
  EXPECT_THAT(run->Err(), HasSubstr("huge scene"));
  EXPECT_THAT(run->Err(), HasSubstr("needs about 12656 MB"));
  EXPECT_THAT(run->Err(), HasSubstr("the limit is 900 MB"));
  // The other variant is rendered, and the failures go on, by the same processes.
  const auto failures = [&] {
    size_t count = 0;
    const std::string text = run->Err();
    for (size_t at = 0; (at = text.find("RESOURCE_EXHAUSTED", at)) != std::string::npos; ++at) {
      ++count;
    }
    return count;
  };
  ASSERT_TRUE(WaitUntil(*run, [&] { return says(" 2/4 pairs") && failures() >= 2; })) << run->Err();
  EXPECT_THAT(run->Children(), ::testing::UnorderedElementsAreArray(daemons));
  run->Signal(SIGINT);
  run->Wait();
  EXPECT_THAT(run->Err(), HasSubstr("2 of 4 pairs are done and kept"));
}

}  // namespace
}  // namespace parallax::e2e
