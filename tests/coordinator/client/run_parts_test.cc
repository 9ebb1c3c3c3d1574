#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/base/system/file.h"
#include "common/config/config.h"
#include "coordinator/client/connection.h"
#include "coordinator/client/content/machine_check.h"
#include "coordinator/client/content/study_options.h"
#include "coordinator/client/exit_code.h"
#include "coordinator/client/interrupt.h"
#include "coordinator/client/runs/embedded_coordinator.h"
#include "coordinator/client/runs/embedded_run.h"
#include "coordinator/client/runs/shared_store.h"
#include "coordinator/client/views/run_report.h"
#include "tests/folder_test.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(DiskErrors, AreToldFromThoseOfTheWork) {
  const struct {
    const char* error;
    bool disk;
  } cases[] = {{"RESOURCE_EXHAUSTED: write /a/left.png: No space left on device", true},
               {"PERMISSION_DENIED: open /a: Read-only file system", true},
               {"UNAVAILABLE: write /a: Input/output error", true},
               {"RESOURCE_EXHAUSTED: out of memory", false},
               {"INTERNAL: Embree: invalid argument", false},
               {"", false}};
  for (const auto& c : cases) {
    const absl::Status status = CheckDiskError(c.error);
    EXPECT_EQ(ExitCodeOf(status), c.disk ? kExitDisk : kExitOk) << c.error;
  }
}

TEST(MemoryErrors, EndARunWhoseAddressSpaceIsLimitedAtTheSecondAttempt) {
  constexpr int64_t kLimit = int64_t{1000} << 20;
  const std::string error =
      "RESOURCE_EXHAUSTED: out of memory; no worker for it has more than 9 MB";
  const absl::Status ended = CheckMemoryError(error, 2, kLimit);
  EXPECT_EQ(ExitCodeOf(ended), kExitFailed);
  EXPECT_THAT(std::string(ended.message()), HasSubstr(error + "; the address space of a process is "
                                                              "limited to 1000 MB (ulimit -v)"));
  EXPECT_TRUE(CheckMemoryError(error, 1, kLimit).ok());
  EXPECT_TRUE(CheckMemoryError(error, 2, 0).ok());
  EXPECT_TRUE(CheckMemoryError("INTERNAL: Embree: invalid argument", 2, kLimit).ok());
  EXPECT_TRUE(CheckMemoryError("RESOURCE_EXHAUSTED: CUDA out of memory", 2, kLimit).ok());
}

// Returns what a machine lacks for the study in `text`; its worker is there.
std::vector<std::string> Missing(const std::string& text, const MachineOptions& options = {},
                                 const std::string& gpu = "/nowhere/nvidia0") {
  const std::string file = testing::TempDir() + "/machine.yaml";
  std::ofstream(file) << text;
  const auto study = LoadStudy(file);
  EXPECT_TRUE(study.ok()) << study.status();
  setenv("PARALLAX_WORKER", "/bin/true", 1);
  std::vector<std::string> missing = WhatIsMissing(*study, file, options, gpu);
  unsetenv("PARALLAX_WORKER");
  const std::string dir = testing::TempDir() + "/";
  for (std::string& text : missing) {
    if (text.starts_with(dir)) text.erase(0, dir.size());
  }
  return missing;
}

TEST(Machine, WhatAStudyNeedsAndIsNotHereIsSaidWithItsRemedy) {
  const std::string head = "study: s\npairs: 1\nvariants: [{name: a}]\n";
  EXPECT_THAT(Missing(head), testing::IsEmpty());
  EXPECT_THAT(Missing(head + "evaluate: {benchmarks: [eth3d]}\n"),
              testing::ElementsAre(testing::AllOf(
                  HasSubstr("machine.yaml:4: evaluate.benchmarks: \"eth3d\": eth3d: the folder of"),
                  HasSubstr("by --benchmarks or $PARALLAX_BENCHMARKS"))));
  EXPECT_THAT(
      Missing(head + "evaluate: {benchmarks: [eth3d]}\n", {.benchmarks_dir = testing::TempDir()}),
      testing::ElementsAre(HasSubstr("two_view_training")));
  EXPECT_THAT(Missing(head + "train: {trainer: raftstereo}\n"),
              testing::ElementsAre(
                  "machine.yaml:4: train.trainer: \"raftstereo\" may not run here, did you mean "
                  "raft-stereo? Allowed by --allow-trainers: builtin"));
  setenv("PARALLAX_TRAINER", "/nowhere/trainer", 1);
  EXPECT_THAT(Missing(head + "train: {steps: 3}\n"),
              testing::ElementsAre(HasSubstr("machine.yaml: train.trainer: $PARALLAX_TRAINER: ")));
  setenv("PARALLAX_TRAINER", "/bin/true", 1);
  EXPECT_THAT(Missing(head + "train: {steps: 3}\n"), testing::IsEmpty());
  setenv("PARALLAX_NETWORK", "/nowhere/network.pt", 1);
  EXPECT_THAT(
      Missing(head + "train: {start: network}\nevaluate: {looks: 1}\n"),
      testing::ElementsAre(HasSubstr("machine.yaml:4: train.start: $PARALLAX_NETWORK: /nowhere")));
  setenv("PARALLAX_NETWORK", "/bin/true", 1);
  EXPECT_THAT(Missing(head + "train: {start: network}\n"), testing::IsEmpty());
  unsetenv("PARALLAX_NETWORK");
  const std::string trainers = testing::TempDir() + "trainers_" + std::to_string(getpid());
  fs::create_directories(trainers);
  std::ofstream(trainers + "/mine.yaml")
      << "trainer: mine\nlayout: archive\ntrain: [/bin/true, '{seed}']\nprogress: json\n"
         "leaves: {final: x}\npredict: [/bin/true]\n";
  EXPECT_THAT(
      Missing(head + "train: {trainer: mine, start: network}\nevaluate: {looks: 1}\n",
              {.allow_trainers = "mine", .trainers_dir = trainers}),
      testing::ElementsAre("machine.yaml:4: train.start: network, but trainer \"mine\" can't start "
                           "from one: its file has no list `start`",
                           "machine.yaml:5: evaluate.looks: 1, but trainer \"mine\" has no option "
                           "for it: its file has no list `looks`"));
  fs::remove_all(trainers);
  const std::string gpu = head + "train:\n  needs: {gpus: 1}\n";
  EXPECT_THAT(Missing(gpu), testing::ElementsAre(HasSubstr(
                                "machine.yaml:5: train.needs.gpus: 1, but this machine has no")));
  EXPECT_THAT(Missing(gpu, {}, "/dev/null"), testing::IsEmpty());
  unsetenv("PARALLAX_TRAINER");
}

using LocalStoreTest = FolderTest;

TEST_F(LocalStoreTest, IsTheDatasetsOwnUnlessTheUserSharesOne) {
  const std::string one = dir_ + "/one/.parallax", two = dir_ + "/two/.parallax";
  fs::create_directories(one);
  fs::create_directories(two);
  setenv("XDG_CACHE_HOME", (dir_ + "/cache").c_str(), 1);
  unsetenv("PARALLAX_STORE");
  EXPECT_EQ(*ChooseStore("", one), one);
  EXPECT_THAT(DescribeUsersStore(), HasSubstr("in the dataset's own folder"));
  std::ofstream(one + "/queue.db") << "x";  // It began there.
  fs::create_directories(dir_ + "/cache/parallax/store");
  EXPECT_EQ(*ChooseStore("", one), one);
  EXPECT_EQ(*ChooseStore("", two), dir_ + "/cache/parallax/store");
  EXPECT_THAT(DescribeUsersStore(), testing::StartsWith(dir_ + "/cache/parallax/store"));
  setenv("PARALLAX_STORE", (dir_ + "/shared").c_str(), 1);
  EXPECT_EQ(*ChooseStore("", two), dir_ + "/cache/parallax/store") << "the folder knows its store";
  EXPECT_EQ(*ChooseStore(dir_ + "/other/", two), dir_ + "/other");
  EXPECT_EQ(StoreOf(two), dir_ + "/other");
  const auto first = FolderLock::Take(dir_ + "/other", "the store", "or not");
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_THAT(FolderLock::Take(dir_ + "/other", "the store", "or not").status().ToString(),
              HasSubstr("the store is in use by another parallax (process "));
  unsetenv("PARALLAX_STORE");
  unsetenv("XDG_CACHE_HOME");
}

// ---- view --page
std::map<std::string, fs::file_time_type> FilesBelow(const std::string& dir) {
  std::map<std::string, fs::file_time_type> files;
  for (const auto& entry : fs::recursive_directory_iterator(dir)) {
    files[entry.path()] = entry.last_write_time();
  }
  return files;
}

using ViewPage = FolderTest;

TEST_F(ViewPage, ServesTheFolderOfARunAndWritesNothingThere) {
  EXPECT_EQ(EmbeddedCoordinator::StartToView(dir_).status().code(), absl::StatusCode::kNotFound);
  {
    const auto run = EmbeddedCoordinator::Start(dir_);
    ASSERT_TRUE(run.ok()) << run.status();
    const auto address = AddressOfRun(dir_);
    ASSERT_TRUE(address.ok()) << address.status();
    EXPECT_EQ(*address, (*run)->address());
    const auto connection = Connection::Open(*address);
    ASSERT_TRUE(connection.ok()) << connection.status();
    const auto link = (*connection)->OpenPage();
    ASSERT_TRUE(link.ok()) << link.status();
    EXPECT_THAT(*link, HasSubstr("http://127.0.0.1:"))
        << "the run serves the page when it is asked";
    EXPECT_THAT(*link, HasSubstr("/#code="));
  }
  EXPECT_EQ(AddressOfRun(dir_).status().code(), absl::StatusCode::kNotFound);
  // A run that was killed leaves the note of its socket behind.
  ASSERT_TRUE(WriteFile(dir_ + "/socket", dir_ + "/parallax-gone").ok());
  EXPECT_EQ(AddressOfRun(dir_).status().code(), absl::StatusCode::kNotFound);
  const auto before = FilesBelow(dir_);
  {
    const auto view = EmbeddedCoordinator::StartToView(dir_);
    ASSERT_TRUE(view.ok()) << view.status();
    const auto link = (*view)->ServePage("127.0.0.1:0");
    ASSERT_TRUE(link.ok()) << link.status();
    EXPECT_THAT(*link, HasSubstr("/#code="));
  }
  EXPECT_EQ(FilesBelow(dir_), before);
}

using EmbeddedRunTest = FolderTest;

TEST_F(EmbeddedRunTest, GoesOnWithAStudyThatWasCancelled) {
  const auto study = ParseStudy("study: s\npairs: 2\nvariants:\n  - name: a\n", "s.yaml");
  ASSERT_TRUE(study.ok()) << study.status();
  const auto out = OutDir::Open(dir_ + "/out");
  ASSERT_TRUE(out.ok()) << out.status();
  std::ostringstream text;
  Environment environment;
  environment.out.stream = environment.err.stream = &text;
  std::vector<v1::StudyState> states;
  for (int run = 0; run < 3; ++run) {
    // It ends at once, as after an interrupt.
    ASSERT_TRUE(EmbeddedRun::Open({.study = *study}, **out, environment).ok());
    const auto coordinator = EmbeddedCoordinator::Start((*out)->work_dir());
    ASSERT_TRUE(coordinator.ok()) << coordinator.status();
    const auto connection = Connection::Open((*coordinator)->address());
    ASSERT_TRUE(connection.ok()) << connection.status();
    if (run == 0) {
      ASSERT_TRUE((*connection)->Cancel(1, "by mistake").ok());
    }
    states.clear();
    const auto studies = (*connection)->ListStudies();
    ASSERT_TRUE(studies.ok()) << studies.status();
    for (const auto& one : studies->studies()) states.push_back(one.state());
  }
  EXPECT_THAT(states, testing::ElementsAre(v1::STUDY_STATE_RUNNING, v1::STUDY_STATE_CANCELLED));
}

TEST(SocketFolder, IsPrivateAndShort) {
  const std::string longest = "/tmp/" + std::string(120, 'x');
  setenv("XDG_RUNTIME_DIR", longest.c_str(), 1);
  setenv("TMPDIR", "relative", 1);
  const auto folder = MakeSocketFolder();
  unsetenv("XDG_RUNTIME_DIR");
  unsetenv("TMPDIR");
  ASSERT_TRUE(folder.ok()) << folder.status();
  EXPECT_LT(folder->size(), 80u);
  struct stat info {};
  ASSERT_EQ(stat(folder->c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0700u);
  fs::remove(*folder);
}

TEST(Interrupts, AreCountedAndEndAWaitOnce) {
  {
    InterruptScope interrupts;
    EXPECT_FALSE(interrupts.WaitFor(std::chrono::milliseconds(1)));
    raise(SIGINT);
    raise(SIGTERM);
    EXPECT_EQ(interrupts.count(), 2);
    EXPECT_TRUE(interrupts.WaitFor(std::chrono::hours(1)));
    EXPECT_FALSE(interrupts.WaitFor(std::chrono::milliseconds(1)));
  }
  struct sigaction action {};
  sigaction(SIGINT, nullptr, &action);
  EXPECT_EQ(action.sa_handler, SIG_DFL) << "handlers of before are back";
}

RunReport Report(int64_t rendered) {
  RunReport report;
  report.study.set_study_id(1);
  report.study.set_name("quickstart");
  report.study.set_state(v1::STUDY_STATE_SUCCEEDED);
  v1::VariantStatus* variant = report.study.add_variants();
  variant->set_name("indoor");
  variant->set_pairs_wanted(8);
  variant->set_pairs_done(8);
  variant->set_scenes_rejected(1);
  report.out_dir = "/out";
  report.pairs_rendered = rendered;
  report.frames_in_dataset = 8;
  report.elapsed_s = 80;
  report.core_seconds = 120;
  report.contact_sheet = "/out/contact_sheet.png";
  report.histograms = "/out/h.png";
  report.warp_median_difference = 0.5;
  return report;
}

std::string TextOf(const RunReport& report) {
  std::ostringstream stream;
  Terminal terminal;
  terminal.stream = &stream;
  PrintRunReport(terminal, report);
  return stream.str();
}

TEST(RunReport, TellsWhatWasMadeAndAtWhatCost) {
  const std::string text = TextOf(Report(6));
  for (const char* wanted :
       {"quickstart done: 8 pairs in 1:20", "6 pairs, 20.0 core-seconds a pair, 270 pairs/h",
        "2 pairs from earlier runs", "1 scene without a valid layout", "/out (8 pairs)",
        "/out/contact_sheet.png", "0.500/255"}) {
    EXPECT_THAT(text, HasSubstr(wanted));
  }
  const nlohmann::ordered_json json = RunReportJson(Report(6));
  EXPECT_EQ(json["pairs_rendered"], 6);
  EXPECT_DOUBLE_EQ(json["core_seconds_per_pair"].get<double>(), 20);
  EXPECT_EQ(json["state"], "succeeded");
}

// The time of networks is no time of pairs.
TEST(RunReport, GivesPairsNoRateWhereNetworksWereTrained) {
  RunReport report = Report(6);
  report.trainings = 9;
  const std::string text = TextOf(report);
  EXPECT_THAT(text, HasSubstr("6 pairs\n"));
  EXPECT_THAT(text, HasSubstr("9 trainings in /out/training"));
  EXPECT_THAT(text, Not(HasSubstr("core-seconds")));
  EXPECT_EQ(RunReportJson(report)["core_seconds_per_pair"], nullptr);
  EXPECT_EQ(RunReportJson(report)["core_seconds"], 120);
}

TEST(RunReport, SaysThatThereWasNothingToDo) {
  const std::string text = TextOf(Report(0));
  EXPECT_THAT(text, HasSubstr("nothing to render: all 8 pairs were there already"));
  EXPECT_THAT(text, Not(HasSubstr("core-seconds")));
}

TEST(RunReport, SaysHowMuchAFailedStudyHas) {
  RunReport report = Report(3);
  report.study.set_state(v1::STUDY_STATE_FAILED);
  report.study.mutable_variants(0)->set_pairs_done(3);
  report.contact_sheet.clear();
  const std::string text = TextOf(report);
  EXPECT_THAT(text, HasSubstr("failed: 3 of 8 pairs were made"));
  EXPECT_THAT(text, Not(HasSubstr("sheet")));
  EXPECT_EQ(RunReportJson(report)["contact_sheet"], nullptr);
}

}  // namespace
}  // namespace parallax::client
