#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <thread>

#include "common/base/status.h"
#include "coordinator/client/exit_code.h"
#include "coordinator/client/farm/farm_policy.h"
#include "coordinator/client/farm/keeper.h"
#include "coordinator/client/farm/slurm.h"
#include "tests/coordinator/client/canned_coordinator.h"
#include "tests/folder_test.h"
#include "tests/job_messages.h"

namespace parallax::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

v1::StudyStatus StudyWith(v1::StudyState state, const std::map<std::string, int64_t>& jobs) {
  v1::StudyStatus study;
  study.set_study_id(1);
  study.set_state(state);
  v1::VariantStatus* variant = study.add_variants();
  for (const auto& [name, count] : jobs) AddJobCount(*variant, "render", name, count);
  return study;
}

v1::WorkerStatus WorkerOf(const std::string& name, const std::string& state, int slots) {
  v1::WorkerStatus worker;
  worker.set_name(name);
  worker.set_state(state);
  worker.set_slots(slots);
  return worker;
}

// ---- Decisions

TEST(FarmPolicy, DemandIsWhatMayRunNowAndWhatRuns) {
  const std::map<std::string, int64_t> jobs = {{"READY", 3},   {"RETRY_WAIT", 2}, {"LEASED", 5},
                                               {"BLOCKED", 7}, {"SUCCEEDED", 11}, {"FAILED", 13}};
  const Demand running = DemandOf({StudyWith(v1::STUDY_STATE_RUNNING, jobs)});
  EXPECT_EQ(running.waiting, 5);
  EXPECT_EQ(running.leased, 5);
  const Demand paused = DemandOf({StudyWith(v1::STUDY_STATE_PAUSED, jobs)});
  EXPECT_EQ(paused.waiting, 0);
  EXPECT_EQ(paused.leased, 5);
  v1::StudyStatus limited = StudyWith(v1::STUDY_STATE_RUNNING, jobs);
  limited.set_held_jobs(4);
  EXPECT_EQ(DemandOf({limited}).waiting, 1) << "no pilot comes for jobs that may not start";
}

TEST(FarmPolicy, OtherWorkersSlotsAreThoseThatTakeWork) {
  EXPECT_EQ(OtherSlots({WorkerOf("desk", "idle", 2), WorkerOf("box", "busy", 4),
                        WorkerOf("gone", "left", 8), WorkerOf("going", "draining", 16),
                        WorkerOf("slurm-7-1", "busy", 32)},
                       "slurm-"),
            6);
}

TEST(FarmPolicy, PilotsFollowDemandWithinTheLimits) {
  using State = Pilot::State;
  const struct {
    const char* what;
    int64_t waiting, leased, other_slots;
    FarmLimits limits;
    std::vector<State> pilots;
    int submit;
    std::vector<std::string> cancel;
  } cases[] = {
      {"nothing to do", 0, 0, 0, {0, 4, 1}, {}, 0, {}},
      {"at least min", 0, 0, 0, {2, 4, 1}, {State::kRunning}, 1, {}},
      {"one a job", 3, 0, 0, {0, 4, 1}, {}, 3, {}},
      {"never more than max", 300, 0, 0, {0, 4, 1}, {State::kRunning}, 3, {}},
      {"pending ones count", 3, 0, 0, {0, 4, 1}, {State::kPending, State::kPending}, 1, {}},
      {"slots are shared", 5, 0, 0, {0, 4, 2}, {}, 3, {}},
      {"others work too", 5, 0, 4, {0, 4, 1}, {}, 1, {}},
      {"others do it all", 5, 0, 40, {0, 4, 1}, {}, 0, {}},
      {"killed ones are replaced", 0, 2, 0, {0, 4, 1}, {State::kEnding, State::kRunning}, 1, {}},
      {"running ones are left alone",
       0,
       0,
       0,
       {0, 4, 1},
       {State::kRunning, State::kRunning},
       0,
       {}},
      {"the newest pending goes first",
       2,
       0,
       0,
       {0, 4, 1},
       {State::kRunning, State::kPending, State::kPending, State::kEnding},
       0,
       {"2"}},
  };
  for (const auto& c : cases) {
    FarmView view{.demand = {c.waiting, c.leased}, .other_slots = c.other_slots};
    for (size_t i = 0; i < c.pilots.size(); ++i) {
      view.pilots.push_back({std::to_string(i), c.pilots[i]});
    }
    const FarmDecision decision = Decide(view, c.limits);
    EXPECT_EQ(decision.submit, c.submit) << c.what;
    EXPECT_EQ(decision.cancel, c.cancel) << c.what;
  }
}

TEST(FarmPolicy, PilotsThatComeToNothingArePausedFor) {
  EXPECT_EQ(SubmissionPause(30, 1), 30);
  EXPECT_EQ(SubmissionPause(30, 2), 60);
  EXPECT_EQ(SubmissionPause(30, 50), 600);
  EXPECT_EQ(SubmissionPause(900, 9), 900);
}

TEST(FarmSlurm, ReadsSqueueAndRefusesWhatItDoesNotKnow) {
  const auto pilots = ParsePilots(
      "5_1|RUNNING\n5_2|PENDING\n6_1|COMPLETING\n6_2|SUSPENDED\n7|NODE_FAIL\n8|REQUEUED\n");
  ASSERT_TRUE(pilots.ok()) << pilots.status();
  using State = Pilot::State;
  const State states[] = {State::kRunning, State::kPending, State::kEnding,
                          State::kPending, State::kEnding,  State::kPending};
  ASSERT_EQ(pilots->size(), 6u);
  for (size_t i = 0; i < 6; ++i) EXPECT_EQ((*pilots)[i].state, states[i]) << (*pilots)[i].id;
  EXPECT_EQ((*pilots)[0].id, "5_1");
  EXPECT_FALSE(ParsePilots("slurm_load_jobs error: Unable to contact slurm controller\n").ok());
}

// ---- The keeper

class ManualClock : public Clock {
 public:
  double UnixSeconds() override { return 0; }
  SteadyTime Steady() override {
    return SteadyTime(
        std::chrono::duration_cast<SteadyTime::duration>(std::chrono::duration<double>(now_s)));
  }
  double now_s = 1000;
};

// A batch system that starts nothing: what is submitted is in `pilots` until a test takes it out.
struct World {
  ManualClock clock;
  std::vector<v1::StudyStatus> studies;
  std::vector<v1::WorkerStatus> workers;
  std::vector<Pilot> pilots;
  std::vector<int> submitted;
  std::vector<std::string> cancelled;
  absl::Status squeue;

  FarmKeeper Keeper() {
    KeeperWorld world;
    world.clock = &clock;
    world.studies = [this] { return studies; };
    world.workers = [this] { return workers; };
    world.pilots = [this]() -> absl::StatusOr<std::vector<Pilot>> {
      if (!squeue.ok()) return squeue;
      return pilots;
    };
    world.submit = [this](int count) -> absl::StatusOr<std::string> {
      submitted.push_back(count);
      for (int i = 0; i < count; ++i) pilots.push_back({"9_" + std::to_string(i)});
      return std::string("9");
    };
    world.cancel = [this](const std::vector<std::string>& ids) {
      cancelled.insert(cancelled.end(), ids.begin(), ids.end());
      return absl::OkStatus();
    };
    return FarmKeeper({.limits = {.max = 4}, .interval_s = 30}, std::move(world));
  }
};

TEST(FarmKeeper, ReplacesKilledPilotsAndBacksOffWhereNoWorkerComes) {
  World world;
  FarmKeeper keeper = world.Keeper();
  world.studies = {StudyWith(v1::STUDY_STATE_RUNNING, {{"READY", 2}})};
  ASSERT_EQ(keeper.Look()->array, "9");
  // The pilots are killed after their worker had come, so new ones are submitted at once.
  world.pilots.clear();
  world.workers = {WorkerOf("slurm-9-1", "busy", 1)};
  world.clock.now_s += 5;
  EXPECT_EQ(keeper.Look()->array, "9");
  // No worker ever comes: 30 s, then 60 s between two tries.
  world.workers.clear();
  world.pilots.clear();
  world.clock.now_s += 20;
  EXPECT_GT(keeper.Look()->paused_s, 0);
  world.clock.now_s += 11;
  EXPECT_EQ(keeper.Look()->array, "9");
  world.pilots.clear();
  world.clock.now_s += 31;
  const auto paused = keeper.Look();
  EXPECT_NEAR(paused->paused_s, 29, 1e-6);
  EXPECT_THAT(paused->Line(), HasSubstr("no worker came of the last ones; submits 2 in 29 s"));
  EXPECT_THAT(world.submitted, ElementsAre(2, 2, 2));
}

TEST(FarmKeeper, DoesNothingWhenSlurmDoesNotAnswer) {
  World world;
  FarmKeeper keeper = world.Keeper();
  world.studies = {StudyWith(v1::STUDY_STATE_RUNNING, {{"READY", 2}})};
  world.squeue = Unavailable("squeue: exit status 1");
  EXPECT_EQ(keeper.Look().status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(world.submitted, IsEmpty());
  world.squeue = absl::OkStatus();
  EXPECT_EQ(keeper.Look()->array, "9");
}

TEST(FarmKeeper, IsFinishedWithoutWorkAndPilots) {
  World world;
  FarmKeeper keeper = world.Keeper();
  world.studies = {StudyWith(v1::STUDY_STATE_RUNNING, {{"READY", 2}})};
  EXPECT_FALSE(keeper.Look()->finished());
  world.studies = {StudyWith(v1::STUDY_STATE_SUCCEEDED, {{"SUCCEEDED", 2}})};
  const auto less = keeper.Look();
  EXPECT_FALSE(less->finished());
  EXPECT_THAT(world.cancelled, ElementsAre("9_1", "9_0"));
  world.pilots.clear();
  EXPECT_TRUE(keeper.Look()->finished());
}

// ---- The command, with programs in place of Slurm's

// Its work may end while a command looks, and each look at its workers is told.
class ChangingCoordinator : public FakeCoordinator {
 public:
  std::function<void()> on_list_workers = [] {};
  std::atomic<bool> done = false;

  grpc::Status ListStudies(grpc::ServerContext* context, const v1::ListStudiesRequest* request,
                           v1::ListStudiesReply* reply) override {
    if (done) return grpc::Status::OK;
    return FakeCoordinator::ListStudies(context, request, reply);
  }
  grpc::Status ListWorkers(grpc::ServerContext* context, const v1::ListWorkersRequest* request,
                           v1::ListWorkersReply* reply) override {
    on_list_workers();
    return FakeCoordinator::ListWorkers(context, request, reply);
  }
};

class FarmCommandTest : public FolderTest {
 protected:
  void SetUp() override {
    path_before_ = std::getenv("PATH");
    setenv("PATH", (dir_ + ":" + path_before_).c_str(), 1);
    coordinator_.studies = {StudyWith(v1::STUDY_STATE_RUNNING, {{"READY", 3}})};
    script_ = WriteText("pilot.sbatch", "#!/bin/sh\n");
    // squeue answers with a file, sbatch adds the array's tasks to it and scancel empties it.
    WriteText("queue", "");
    Program("squeue", "cat " + dir_ + "/queue");
    Program("sbatch", "echo \"$@\" >> " + dir_ + "/sbatch.log; env | grep ^PARALLAX_ >> " + dir_ +
                          "/sbatch.log; echo '17_1|PENDING' > " + dir_ +
                          "/queue; echo 'sbatch: a note of the site' >&2; echo '17;here'");
    Program("scancel", "echo \"$@\" >> " + dir_ + "/scancel.log; : > " + dir_ + "/queue");
  }
  void TearDown() override { setenv("PATH", path_before_.c_str(), 1); }
  Outcome Run(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--coordinator", coordinator_.address()});
    return RunCommand(arguments);
  }
  std::string WriteText(const std::string& name, const std::string& text) {
    std::ofstream(dir_ + "/" + name) << text;
    return dir_ + "/" + name;
  }
  void Program(const std::string& name, const std::string& body) {
    const std::string path = WriteText(name, "#!/bin/sh\n" + body + "\n");
    ASSERT_EQ(chmod(path.c_str(), 0755), 0);
  }
  std::string Read(const std::string& name) {
    std::ostringstream text;
    text << std::ifstream(dir_ + "/" + name).rdbuf();
    return text.str();
  }
  ChangingCoordinator coordinator_;
  std::string path_before_, script_;
};

TEST_F(FarmCommandTest, DryRunSaysWhatItWouldDoAndDoesNothing) {
  const Outcome outcome =
      Run({"farm", "slurm", "--max", "2", "--script", script_, "--dry-run", "--slots", "2"});
  EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.err;
  EXPECT_THAT(outcome.out,
              HasSubstr("3 jobs wait, 0 run; pilots: 0 run, 0 wait, 2 wanted: would submit 2"));
  EXPECT_THAT(outcome.out, HasSubstr("sbatch --parsable --job-name=parallax --array=1-2 " +
                                     script_ + " --slots 2"));
  EXPECT_EQ(Read("sbatch.log"), "");
}

TEST_F(FarmCommandTest, SubmitsPilotsAndEndsWhenTheWorkIsDone) {
  coordinator_.workers = {WorkerOf("desk", "busy", 1)};
  // The pilot's work is done as soon as it is in the queue.
  Program("sbatch", "echo \"$@\" >> " + dir_ + "/sbatch.log; env | grep ^PARALLAX_ >> " + dir_ +
                        "/sbatch.log; echo '17;here'");
  std::thread work([this] {
    while (Read("sbatch.log").empty()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    coordinator_.done = true;
  });
  const Outcome outcome =
      Run({"farm", "slurm", "--max", "8", "--script", script_, "--until-done", "--interval", "1",
           "--sbatch=--partition=short", "--idle", "60", "--worker-tls", "/tls"});
  work.join();
  EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("submitted 2 as array 17"));
  const std::string log = Read("sbatch.log");
  EXPECT_THAT(log, HasSubstr("--parsable --job-name=parallax --array=1-2 --partition=short " +
                             script_ + "\n"));
  EXPECT_THAT(log, HasSubstr("PARALLAX_COORDINATOR=" + coordinator_.address() + "\n"));
  EXPECT_THAT(log, HasSubstr("PARALLAX_TLS=/tls\n"));
  EXPECT_THAT(log, HasSubstr("PARALLAX_IDLE=60\n"));
}

TEST_F(FarmCommandTest, CtrlCLeavesOrCancelsPilotsAsTold) {
  for (const std::string at_end : {"leave", "cancel"}) {
    WriteText("queue", "17_1|RUNNING\n17_2|PENDING\n17_3|COMPLETING\n");
    // The first look comes before the command listens to signals.
    bool first = true;
    coordinator_.on_list_workers = [&first] {
      if (!first) kill(getpid(), SIGTERM);
      first = false;
    };
    const Outcome outcome = Run({"farm", "slurm", "--max", "2", "--script", script_, "--interval",
                                 "1", "--at-end", at_end});
    EXPECT_EQ(outcome.exit_code, kExitInterrupted) << outcome.err;
    if (at_end == "leave") {
      EXPECT_THAT(outcome.err, HasSubstr("2 pilots left, which end after 5:00 without work"));
      EXPECT_EQ(Read("scancel.log"), "");
    } else {
      EXPECT_THAT(outcome.err, HasSubstr("cancelled 2 pilots"));
      EXPECT_EQ(Read("scancel.log"), "17_1 17_2\n");
    }
  }
}

TEST_F(FarmCommandTest, ErrorsNameWhatIsMissing) {
  const struct {
    std::vector<std::string> arguments;
    int exit_code;
    const char* says;
  } cases[] = {
      {{"--max", "2", "--script", dir_ + "/none"}, kExitUsage, "--script: there is no file"},
      {{"--max", "2", "--min", "3", "--script", script_}, kExitUsage, "--min 3 is more than"},
      {{"--max", "2", "--script", script_, "--tls", "/mine"}, kExitUsage, "--worker-tls"},
      {{"--script", script_}, kExitUsage, "--max"},
  };
  for (const auto& c : cases) {
    std::vector<std::string> arguments = {"farm", "slurm"};
    arguments.insert(arguments.end(), c.arguments.begin(), c.arguments.end());
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, c.exit_code);
    EXPECT_THAT(outcome.err, HasSubstr(c.says));
  }
  Program("squeue", "echo 'squeue: error: Unable to contact slurm controller' >&2; exit 1");
  const Outcome outcome = Run({"farm", "slurm", "--max", "2", "--script", script_});
  EXPECT_NE(outcome.exit_code, kExitOk);
  EXPECT_THAT(outcome.err, HasSubstr("squeue: exit status 1: squeue: error: Unable to contact"));
  EXPECT_EQ(Read("sbatch.log"), "");
}

}  // namespace
}  // namespace parallax::client
