// `parallax run` with the real worker: what a person gets, and what no crash may take away.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/e2e/run_fixture.h"
#include "tests/sqlite_by_hand.h"

namespace parallax::e2e {
namespace {

using ::testing::HasSubstr;

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
  EXPECT_THAT(run->Err(), HasSubstr("of 12 pairs are finished and kept; the same command resumes"));
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
  sqlite3* db = OpenByHand(out + "/.parallax/queue.db");
  ASSERT_NE(db, nullptr);
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
  EXPECT_THAT(run.Err(), HasSubstr("the same command resumes"));
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

// One variant's pictures need about 14.7 GB.
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

TEST_F(RunTest, AJobTooBigForTheMemoryFailsAloneAndItsWorkerGoesOn) {
  std::ofstream(study_) << kTooBig;
  const auto run = std::make_unique<Process>(Command(dir_ + "/out"),
                                             std::vector<std::string>{"PARALLAX_MEMORY_MB=900"});
  const auto says = [&](const char* text) { return run->Err().find(text) != std::string::npos; };
  ASSERT_TRUE(WaitUntil(*run, [&] { return says("RESOURCE_EXHAUSTED"); })) << run->Err();
  const std::vector<pid_t> daemons = run->Children();
  EXPECT_THAT(run->Err(), HasSubstr("huge scene"));
  EXPECT_THAT(run->Err(), HasSubstr("needs about 14681 MB"));
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
  EXPECT_THAT(run->Err(), HasSubstr("2 of 4 pairs are finished and kept"));
}

}  // namespace
}  // namespace parallax::e2e
