// `parallax run` of a study that trains networks: from nothing to its table, with a script as
// trainer and with the built-in one, whatever is killed on the way.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "common/base/hash.h"
#include "tests/e2e/process.h"

namespace parallax::e2e {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using Json = nlohmann::json;

constexpr char kPairs[] =
    "study: tiny\n"
    "seed: 5\n"
    "pairs: 4\n"
    "rigs_per_scene: 2\n"
    "variants:\n"
    "  - name: narrow\n"
    "    set:\n"
    "      floating: {count: 2}\n"
    "      rigs: {count: 4, width_px: 160, height_px: 96, baseline_m: {uniform: [0.04, 0.1]}}\n"
    "      render: {profile: preview, samples_per_pixel: 1}\n"
    "      filters: {min_mean_intensity: 0, min_depth_m: 0}\n"
    "  - name: wide\n"
    "    set:\n"
    "      floating: {count: 2}\n"
    "      rigs: {count: 4, width_px: 160, height_px: 96, baseline_m: {uniform: [0.2, 0.3]}}\n"
    "      render: {profile: preview, samples_per_pixel: 1}\n"
    "      filters: {min_mean_intensity: 0, min_depth_m: 0}\n";

class TrainTest : public ::testing::Test {
 protected:
  void SetUp() override {
    // With a blank, as in many a home folder: lists for trainers separate their fields by blanks.
    std::string name = fs::temp_directory_path() / "parallax train_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    dir_ = name;
    fs::create_directories(dir_ + "/trainers");
    std::ofstream(dir_ + "/trainers/script.yaml")
        << "trainer: script\nlayout: archive\ntrain: [" PYTHON ", -B, " SCRIPT_TRAINER
           ", train, '--data={data}={weight}', --out, '{out}', --seed, '{seed}', --steps, "
           "'{steps}',"
           " --every, '{checkpoint_every}']\n"
           "resume: [--resume, '{resume}']\nprogress: json\n"
           "leaves: {checkpoints: net-*.json, final: last.json}\n"
           "predict: [" PYTHON ", -B, " SCRIPT_TRAINER
           ", predict, --checkpoint, '{checkpoint}', --list, '{list}']\n";
    // The built-in trainer with small crops and many checkpoints.
    std::ofstream(dir_ + "/trainers/often.yaml")
        << "trainer: often\nlayout: archive\ntrain: [trainer, train, '--data={data}={weight}', "
           "--out,"
           " '{out}', --seed, '{seed}', --steps, '{steps}', --threads, '{threads}', --crop, 64x64,"
           " --batch, '1', --checkpoint-every, '3']\n"
           "resume: [--resume, '{resume}']\nenvironment: [OMP_WAIT_POLICY=passive]\nprogress: "
           "json\n"
           "leaves: {checkpoints: checkpoint-*.pt, final: final.pt}\n"
           "predict: [trainer, predict, --checkpoint, '{checkpoint}', --list, '{list}']\n";
  }
  void TearDown() override {
    if (HasFailure()) {
      for (const auto& entry : fs::recursive_directory_iterator(dir_)) {
        if (entry.path().extension() != ".log" && entry.path().filename() != "log.txt") continue;
        std::cerr << "---- " << entry.path() << "\n" << ReadText(entry.path());
      }
    }
    fs::remove_all(dir_);
  }

  std::unique_ptr<Process> Start(const std::string& training, const std::string& out) {
    const std::string study = dir_ + "/tiny.yaml";
    std::ofstream(study) << kPairs << training;
    return std::make_unique<Process>(
        std::vector<std::string>{PARALLAX_BINARY, "run", study, "--out", out, "--trainers",
                                 dir_ + "/trainers", "--allow-trainers", "often,script"});
  }

  // The process below `pid`, at any depth, whose command has `word` in it; 0: none.
  static pid_t Find(pid_t pid, const std::string& word) {
    std::ifstream children("/proc/" + std::to_string(pid) + "/task/" + std::to_string(pid) +
                           "/children");
    for (pid_t child; children >> child;) {
      std::string command = ReadText("/proc/" + std::to_string(child) + "/cmdline");
      std::replace(command.begin(), command.end(), '\0', ' ');
      if (command.find(word) != std::string::npos) return child;
      for (const auto& task : fs::directory_iterator("/proc/" + std::to_string(child) + "/task")) {
        std::ifstream below(task.path() / "children");
        for (pid_t grandchild; below >> grandchild;) {
          command = ReadText("/proc/" + std::to_string(grandchild) + "/cmdline");
          std::replace(command.begin(), command.end(), '\0', ' ');
          const bool is_it = command.find(word) != std::string::npos &&
                             command.find("/worker ") == std::string::npos;
          if (is_it) return grandchild;
          if (const pid_t found = Find(grandchild, word)) return found;
        }
      }
    }
    return 0;
  }

  // Checkpoints that running attempts have put into the store.
  static std::set<std::string> Checkpoints(const std::string& out) {
    std::set<std::string> found;
    std::error_code error;
    const fs::recursive_directory_iterator end;
    for (fs::recursive_directory_iterator it(out + "/.parallax/store", error); !error && it != end;
         it.increment(error)) {
      if (it->path().filename() == "facts.json") found.insert(it->path());
    }
    return found;
  }

  static std::map<std::string, std::string> Networks(const std::string& out, const char* name) {
    std::map<std::string, std::string> networks;
    for (const auto& entry : fs::recursive_directory_iterator(out + "/training")) {
      if (entry.path().filename() != name) continue;
      networks[fs::relative(entry.path(), out)] = Sha256Hex(ReadText(entry.path()));
    }
    return networks;
  }

  std::string dir_;
};

TEST_F(TrainTest, AStudyRunsFromNothingToItsTable) {
  constexpr char kTraining[] =
      "train:\n"
      "  trainer: script\n"
      "  steps: 6\n"
      "  seeds: 2\n"
      "  threads: 1\n"
      "  mixtures: [{name: both, parts: [{variant: narrow, weight: 3}, {variant: wide}]}]\n"
      "evaluate: {benchmarks: [shipped], max_pairs: 1, heldout_pairs: 2, checkpoints: 2}\n";
  const std::string out = dir_ + "/out";
  auto run = Start(kTraining, out);
  ASSERT_EQ(run->Wait(), 0) << run->Err();
  EXPECT_THAT(run->Out(), HasSubstr("6 trainings in "));
  EXPECT_EQ(Networks(out, "final.json").size(), 6u);
  EXPECT_EQ(Networks(out, "checkpoint-3.json").size(), 6u);
  const std::string training = out + "/training/both/script/seed-1/";
  for (const char* file : {"log.txt", "curve.csv", "training.json"}) {
    EXPECT_TRUE(fs::exists(training + file)) << file;
  }
  const Json card = Json::parse(ReadText(training + "training.json"));
  EXPECT_EQ(card["set"], "both");
  EXPECT_EQ(card["data"]["parts"][0]["weight"], 3);

  const Json table = Json::parse(ReadText(out + "/table.json"));
  std::map<std::string, int> seeds;
  for (const Json& row : table["rows"]) {
    seeds[row["variant"]] = row["seeds"];
    EXPECT_EQ(row["benchmarks"].size(), 2u) << row;
  }
  EXPECT_EQ(seeds,
            (std::map<std::string, int>{{"narrow", 2}, {"wide", 2}, {"both", 2}, {"sgbm", 0}}));
  EXPECT_THAT(run->Out(), HasSubstr(ReadText(out + "/table.txt")));
  EXPECT_TRUE(fs::exists(out + "/sheets/heldout.wide.script.seed-0.png"));
  EXPECT_TRUE(fs::exists(out + "/errors/wide.script.by_material.png"));
  EXPECT_TRUE(fs::exists(out + "/curves/heldout.png"));
  const std::string curves = ReadText(out + "/curves/learning_curves.csv");
  // Two benchmarks, three sets, two seeds, two checkpoints; and the head.
  EXPECT_EQ(std::count(curves.begin(), curves.end(), '\n'), 25) << curves;

  Process again({PARALLAX_BINARY, "table", out, "--json"});
  EXPECT_EQ(again.Wait(), 0) << again.Err();
  EXPECT_EQ(Json::parse(again.Out())["rows"], table["rows"]);
  run = Start(kTraining, out);
  EXPECT_EQ(run->Wait(), 0) << run->Err();
  EXPECT_THAT(run->Out(), HasSubstr("nothing to render"));
}

// Trainers run in folders of their own, where a relative path would lead elsewhere.
TEST_F(TrainTest, AWorkerWithRelativeFoldersTrainsAndEvaluates) {
  std::ofstream(dir_ + "/tiny.yaml")
      << kPairs
      << "train: {trainer: script, steps: 2, seeds: 1, threads: 1, variants: [wide]}\n"
         "evaluate: {benchmarks: [shipped], max_pairs: 1, heldout_pairs: 1}\n";
  const auto start = [this](std::vector<std::string> command) {
    command.insert(command.begin(), {"/bin/sh", "-c", "cd \"$0\" && exec \"$@\"", dir_});
    return std::make_unique<Process>(command);
  };
  const auto coordinator = start({PARALLAX_COORDINATOR, "serve", "--db", "q.db", "--store", "st",
                                  "--listen", "unix:" + dir_ + "/socket"});
  std::string line;
  ASSERT_TRUE(coordinator->ReadLine(&line)) << coordinator->Err();
  const std::vector<std::string> to = {"--coordinator", "unix:" + dir_ + "/socket"};
  std::vector<std::string> work = {PARALLAX_WORKER,
                                   "--role",
                                   "all",
                                   "--outbox",
                                   "ob",
                                   "--cache",
                                   "ca",
                                   "--trainers",
                                   "trainers",
                                   "--name",
                                   "w",
                                   "--allow-trainers",
                                   "script",
                                   "--cores-dir",
                                   "cores"};
  work.insert(work.end(), to.begin(), to.end());
  const auto worker = start(work);
  Process submit({PARALLAX_BINARY, "submit", dir_ + "/tiny.yaml", to[0], to[1]});
  ASSERT_EQ(submit.Wait(), 0) << submit.Err();
  Process watch({PARALLAX_BINARY, "watch", "1", to[0], to[1]});
  EXPECT_EQ(watch.Wait(), 0) << watch.Err() << worker->Err();
  worker->Signal(SIGTERM);
  EXPECT_EQ(worker->Wait(), 0) << worker->Err();
  EXPECT_TRUE(fs::is_directory(dir_ + "/ob")) << "it is not the outbox";
}

TEST_F(TrainTest, WhateverIsKilledTheNetworkIsTheSame) {
  constexpr char kTraining[] =
      "train: {trainer: often, steps: 60, seeds: 1, threads: 2, variants: [wide]}\n";
  auto calm = Start(kTraining, dir_ + "/calm");
  const std::string out = dir_ + "/killed";
  ASSERT_EQ(calm->Wait(), 0) << calm->Err();

  auto run = Start(kTraining, out);
  size_t seen = 0;
  const auto more_checkpoints = [&] { return Checkpoints(out).size() > seen; };
  ASSERT_TRUE(WaitUntil(*run, more_checkpoints)) << run->Err();
  const pid_t trainer = Find(run->pid(), "trainer train");
  ASSERT_GT(trainer, 0);
  kill(trainer, SIGKILL);
  seen = Checkpoints(out).size() + 2;  // The next attempt takes over the last one.
  ASSERT_TRUE(WaitUntil(*run, more_checkpoints)) << run->Err();
  const std::vector<pid_t> workers = run->Children();
  for (const pid_t worker : workers) kill(worker, SIGKILL);
  seen = Checkpoints(out).size() + 2;
  ASSERT_TRUE(WaitUntil(*run, more_checkpoints)) << run->Err();
  run->Signal(SIGKILL);
  run->Wait();

  run = Start(kTraining, out);
  ASSERT_EQ(run->Wait(), 0) << run->Err();
  const auto network = Networks(out, "final.pt");
  ASSERT_EQ(network.size(), 1u);
  EXPECT_EQ(network, Networks(dir_ + "/calm", "final.pt"));
  EXPECT_THAT(ReadText(out + "/training/wide/often/seed-0/log.txt"),
              HasSubstr("\"event\":\"start\""));
  const Json card = Json::parse(ReadText(out + "/training/wide/often/seed-0/training.json"));
  EXPECT_GT(card["trainer_says"]["resumed_from_step"], 0) << "it went on";
}

}  // namespace
}  // namespace parallax::e2e
