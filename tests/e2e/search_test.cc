// `parallax search` with a coordinator and a worker: from a study file to a confirmed recipe,
// though the coordinator is killed on the way.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/e2e/process.h"
#include "tests/folder_test.h"

namespace parallax::e2e {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;

// Rigs with a narrow baseline make pairs with small disparities, which train the better networks.
constexpr char kNarrow[] =
    "study: narrow\n"
    "seed: 5\n"
    "pairs: 4\n"
    "rigs_per_scene: 2\n"
    "set:\n"
    "  furniture: {enabled: false}\n"
    "  floating: {count: 1}\n"
    "  rigs: {count: 2, width_px: 64, height_px: 48, baseline_m: 0.4}\n"
    "  render: {profile: preview, samples_per_pixel: 1}\n"
    "  filters: {min_mean_intensity: 0, min_depth_m: 0}\n"
    "search:\n"
    "  space:\n"
    "    rigs.baseline_m: {choice: [0.05, 0.5]}\n"
    "    materials.mode: {choice: [none, all]}\n"
    "  trials: 4\n"
    "  rungs: [{pairs: 0.5}, {}]\n"
    "train: {trainer: near, steps: 1, seeds: 3, threads: 1}\n"
    "evaluate: {benchmarks: [shipped]}\n";

class SearchTest : public FolderTest {
 protected:
  void SetUp() override {
    FolderTest::SetUp();
    std::ofstream(dir_ + "/near.yaml")
        << "trainer: near\nlayout: archive\ntrain: [" PYTHON ", -B, " NEAR_TRAINER
           ", train, '--data={data}={weight}', --out, '{out}', --seed, '{seed}']\n"
           "progress: json\nleaves: {checkpoints: net-*.json, final: last.json}\n"
           "predict: [" PYTHON ", -B, " NEAR_TRAINER
           ", predict, --checkpoint, '{checkpoint}', --list, '{list}']\n";
    std::ofstream(dir_ + "/narrow.yaml") << kNarrow;
    Serve();
    worker_ = std::make_unique<Process>(std::vector<std::string>{
        PARALLAX_WORKER_PROGRAM, "--role", "all", "--coordinator", Address(), "--name", "w",
        "--outbox", dir_ + "/outbox", "--cache", dir_ + "/cache", "--trainers", dir_,
        "--allow-trainers", "near", "--cores-dir", dir_ + "/cores"});
  }

  std::string Address() const { return "unix:" + dir_ + "/socket"; }

  void Serve() {
    coordinator_ = std::make_unique<Process>(std::vector<std::string>{
        PARALLAX_COORDINATOR_PROGRAM, "serve", "--db", dir_ + "/queue.db", "--store",
        dir_ + "/store", "--listen", Address(), "--reconnect-s", "0.2"});
    std::string line;
    ASSERT_TRUE(coordinator_->ReadLine(&line)) << coordinator_->Err();
  }

  std::unique_ptr<Process> Search(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {PARALLAX_CLIENT_PROGRAM, "search"});
    arguments.insert(arguments.end(), {"--coordinator", Address()});
    return std::make_unique<Process>(arguments);
  }
  Json Status() {
    auto search = Search({"narrow", "--json"});
    EXPECT_EQ(search->Wait(), 0) << search->Err();
    return Json::parse(search->Out());
  }

  std::unique_ptr<Process> coordinator_, worker_;
};

TEST_F(SearchTest, TheKnownDirectionIsFoundAndConfirmedThoughTheCoordinatorIsKilled) {
  auto watch = Search({dir_ + "/narrow.yaml", "--watch"});
  // In the middle of the first rung, and of the second.
  for (const char* state : {"running, rung 1 of 2", "running, rung 2 of 2"}) {
    ASSERT_TRUE(WaitUntil(*watch, [&] { return watch->Out().find(state) != std::string::npos; }))
        << watch->Out() << watch->Err() << worker_->Err();
    coordinator_->Signal(SIGKILL);
    coordinator_->Wait();
    Serve();
  }
  ASSERT_EQ(watch->Wait(), 0) << watch->Out() << watch->Err() << worker_->Err();
  EXPECT_THAT(watch->Out(), HasSubstr("\nConfirmed with fresh scenes and trainings on shipped"));

  const Json search = Status();
  EXPECT_EQ(search["state"], "ended");
  EXPECT_EQ(search["outcome"], "confirmed");
  EXPECT_EQ(search["studies"].size(), 3u) << "two rungs and the confirmation";
  ASSERT_GE(search["trials"].size(), 3u);
  for (const Json& trial : search["trials"]) {
    if (trial["number"] == 0) continue;
    const bool is_narrow = trial["values"]["rigs.baseline_m"] == "0.05";
    EXPECT_EQ(trial["scores"][0]["verdict"] == "better", is_narrow) << trial;
  }
  const Json& best = search["trials"][search["best"].get<size_t>()];
  EXPECT_EQ(best["values"]["rigs.baseline_m"], "0.05");
  EXPECT_EQ(search["importances"].size(), 2u);

  const std::string recipe = dir_ + "/best.yaml", picture = dir_ + "/narrow.svg";
  auto written = Search({"narrow", "--best", recipe, "--picture", picture});
  EXPECT_EQ(written->Wait(), 0) << written->Err();
  EXPECT_THAT(ReadText(recipe), HasSubstr("rigs: {baseline_m: 0.05}"));
  EXPECT_THAT(ReadText(picture), HasSubstr("</svg>"));
  Process check({PARALLAX_CLIENT_PROGRAM, "config", "check", recipe});
  EXPECT_EQ(check.Wait(), 0) << check.Err();

  // The same file again finds it; what it has made goes with it.
  auto again = Search({dir_ + "/narrow.yaml", "--json"});
  EXPECT_EQ(again->Wait(), 0) << again->Err();
  EXPECT_EQ(Json::parse(again->Out()), search);
  auto forget = Search({"narrow", "--forget", "--yes"});
  EXPECT_EQ(forget->Wait(), 0) << forget->Err();
  EXPECT_TRUE(WaitUntil(*coordinator_, [&] {
    auto gone = Search({"narrow"});
    return gone->Wait() == 2;
  }));
}

}  // namespace
}  // namespace parallax::e2e
