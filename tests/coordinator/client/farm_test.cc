#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <thread>

#include "common/base/status.h"
#include "common/config/files/engine_files.h"
#include "coordinator/client/exit_code.h"
#include "coordinator/client/farm/engine.h"
#include "coordinator/client/farm/farm_policy.h"
#include "coordinator/client/farm/keeper.h"
#include "tests/coordinator/client/canned_coordinator.h"
#include "tests/folder_test.h"
#include "tests/job_messages.h"

namespace parallax::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

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
  const v1::Engine slurm = *LoadEngine("slurm");
  const auto pilots = ParsePilots(
      slurm, "parallax",
      "5_1|RUNNING\n5_2|PENDING\n6_1|COMPLETING\n6_2|SUSPENDED\n7|NODE_FAIL\n8|REQUEUED\n");
  ASSERT_TRUE(pilots.ok()) << pilots.status();
  using State = Pilot::State;
  const State states[] = {State::kRunning, State::kPending, State::kEnding,
                          State::kPending, State::kEnding,  State::kPending};
  ASSERT_EQ(pilots->size(), 6u);
  for (size_t i = 0; i < 6; ++i) EXPECT_EQ((*pilots)[i].state, states[i]) << (*pilots)[i].id;
  EXPECT_EQ((*pilots)[0].id, "5_1");
  EXPECT_FALSE(
      ParsePilots(slurm, "parallax", "slurm_load_jobs error: Unable to contact slurm controller\n")
          .ok());
}

TEST(FarmEngines, ListsOfPbsAndLsfAreReadAndUnknownLinesRefused) {
  const v1::Engine pbs = *LoadEngine("pbs"), lsf = *LoadEngine("lsf");
  const auto queued =
      ParsePilots(pbs, "my-farm",
                  "\nhead: \n"
                  "                                                   Req'd  Req'd   Elap\n"
                  "Job ID          Username Queue Jobname  SessID NDS TSK Memory Time  S Time\n"
                  "--------------- -------- ----- -------- ------ --- --- ------ ----- - -----\n"
                  "110.head        ada      workq my-farm      --   1  16   32gb 24:00 Q   -- \n"
                  "9.head          ada      workq my-farm    4321   1  16   32gb 24:00 R 00:01\n"
                  "11.head         ada      workq myfarm     4322   1  16   32gb 24:00 R 00:01\n"
                  "12.head         ada      workq my-farm    4323   1  16   32gb 24:00 E 23:59\n");
  ASSERT_TRUE(queued.ok()) << queued.status();
  ASSERT_EQ(queued->size(), 3u) << "another name is another farm's";
  EXPECT_EQ((*queued)[0].id, "9.head") << "in the order of submission";
  EXPECT_EQ((*queued)[0].state, Pilot::State::kRunning);
  EXPECT_EQ((*queued)[1].state, Pilot::State::kEnding);
  EXPECT_EQ((*queued)[2].id, "110.head");
  EXPECT_EQ((*queued)[2].state, Pilot::State::kPending);
  const auto tasks = ParsePilots(lsf, "parallax", "7|10|PEND\n7|9|RUN\n6|1|UNKWN\n");
  ASSERT_TRUE(tasks.ok()) << tasks.status();
  ASSERT_EQ(tasks->size(), 3u);
  EXPECT_EQ((*tasks)[0].state, Pilot::State::kEnding);
  EXPECT_EQ((*tasks)[1].id, "7[9]");
  EXPECT_EQ((*tasks)[2].id, "7[10]");
  const auto refused = ParsePilots(pbs, "my-farm", "qstat: cannot connect to server\n");
  EXPECT_THAT(std::string(refused.status().message()),
              HasSubstr("qstat: expected a line that fits list.pilot of engine pbs, got"));
  const std::string shown(
      ParsePilots(pbs, "my-farm", "\x1b[2J" + std::string(1900, 'x') + "\n").status().message());
  EXPECT_THAT(shown, HasSubstr("got '\\x1b[2Jxxx"));
  EXPECT_LT(shown.size(), 300u);
  v1::Engine strict = lsf;
  strict.mutable_list()->mutable_states()->DeleteSubrange(2, 1);
  const auto state = ParsePilots(strict, "parallax", "7|1|ZOMBI\n");
  EXPECT_THAT(std::string(state.status().message()),
              HasSubstr("state ZOMBI fits no row of list.states of engine lsf"));
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
    return FarmKeeper({.limits = {.max = 4}, .worker_prefix = "slurm-", .interval_s = 30},
                      std::move(world));
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
  // Sends SIGTERM at the second look; the first comes before the command listens to signals.
  void StopAtSecondLook() {
    coordinator_.on_list_workers = [looks = 0]() mutable {
      if (++looks == 2) kill(getpid(), SIGTERM);
    };
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
  EXPECT_THAT(outcome.err, HasSubstr("note: pilots are told the coordinator's address " +
                                     coordinator_.address() + ", which only this machine"));
  const Outcome far = RunCommand({"farm", "slurm", "--max", "2", "--script", script_, "--dry-run",
                                  "--coordinator", "192.0.2.1:7070"});
  EXPECT_THAT(far.err, Not(HasSubstr("only this machine")));
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
  const Outcome outcome = Run({"farm", "slurm", "--max", "8", "--script", script_, "--until-done",
                               "--interval", "1", "--sbatch=--partition=short", "--idle", "60",
                               "--worker-tls", std::filesystem::relative(dir_).string()});
  work.join();
  EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("submitted 2 as array 17"));
  const std::string log = Read("sbatch.log");
  EXPECT_THAT(log, HasSubstr("--parsable --job-name=parallax --array=1-2 --partition=short " +
                             script_ + "\n"));
  EXPECT_THAT(log, HasSubstr("PARALLAX_COORDINATOR=" + coordinator_.address() + "\n"));
  EXPECT_THAT(log, HasSubstr("PARALLAX_TLS=" + dir_ + "\n")) << "absolute";
  EXPECT_THAT(log, HasSubstr("PARALLAX_IDLE=60\n"));
}

TEST_F(FarmCommandTest, CtrlCLeavesOrCancelsPilotsAsTold) {
  for (const std::string at_end : {"leave", "cancel"}) {
    WriteText("queue", "17_1|RUNNING\n17_2|PENDING\n17_3|COMPLETING\n");
    StopAtSecondLook();
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

TEST_F(FarmCommandTest, PbsSubmitsListsAndCancelsAsItsFileSays) {
  WriteText("queue",
            "7.head  ada  workq  parallax  4321  1  16  32gb 24:00 R 00:01\n"
            "8.head  ada  workq  another   4322  1  16  32gb 24:00 R 00:01\n");
  Program("qstat",
          "[ \"$1 $2 $3\" = \"-w -u $(id -un)\" ] || { echo \"qstat: $*\"; exit 2; }; cat " + dir_ +
              "/queue");
  Program("qsub", "echo \"$@\" >> " + dir_ + "/qsub.log; env | grep ^PARALLAX_ | sort > " + dir_ +
                      "/env.log; n=$((8 + $(wc -l < " + dir_ + "/qsub.log))); echo \"$n.head\"; " +
                      "echo \"$n.head ada workq parallax -- 1 16 32gb 24:00 Q --\" >> " + dir_ +
                      "/queue");
  Program("qdel", "echo \"$@\" >> " + dir_ + "/qdel.log");
  const std::vector<std::string> arguments = {
      "farm",     "--engine", "pbs",       "--max",       "3",     "--script",
      script_,    "--cores",  "16",        "--memory-mb", "32000", "--wall-minutes",
      "90",       "--log",    "pilot.log", "--interval",  "1",     "--submit=-qlong",
      "--at-end", "cancel"};
  StopAtSecondLook();
  setenv("PARALLAX_WORKER", "/nodes/worker", 1);
  setenv("PARALLAX_STATE", "/nodes/state", 1);
  std::vector<std::string> all = arguments;
  all.insert(all.end(), {"--", "--verbose"});
  all.insert(all.begin() + 1, {"--coordinator", coordinator_.address()});
  const Outcome outcome = RunCommand(all);
  unsetenv("PARALLAX_WORKER");
  unsetenv("PARALLAX_STATE");
  EXPECT_EQ(outcome.exit_code, kExitInterrupted) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("1 run, 0 wait, 3 wanted: submitted 2 as 9.head 10.head"));
  const std::string call =
      "-N parallax -j oe -v PARALLAX_ENGINE,PARALLAX_COORDINATOR,PARALLAX_TLS,PARALLAX_IDLE,"
      "PARALLAX_CORES,PARALLAX_MEMORY_MB,PARALLAX_WALL_S,PARALLAX_GRACE,PARALLAX_LONG_GRACE,"
      "PARALLAX_ARGUMENTS,PARALLAX_WORKER,PARALLAX_STATE -l ncpus=16 -l mem=32000mb -l "
      "walltime=5400 -o pilot.log -qlong " +
      script_ + "\n";
  EXPECT_EQ(Read("qsub.log"), call + call);
  EXPECT_EQ(Read("env.log"),
            "PARALLAX_ARGUMENTS=--verbose\nPARALLAX_COORDINATOR=" + coordinator_.address() +
                "\nPARALLAX_CORES=16\nPARALLAX_ENGINE=pbs\nPARALLAX_GRACE=7\n"
                "PARALLAX_IDLE=300\nPARALLAX_LONG_GRACE=\n"
                "PARALLAX_MEMORY_MB=32000\nPARALLAX_STATE=/nodes/state\nPARALLAX_TLS=\n"
                "PARALLAX_WALL_S=5400\nPARALLAX_WORKER=/nodes/worker\n");
  EXPECT_EQ(Read("qdel.log"), "7.head 9.head 10.head\n");
}

TEST_F(FarmCommandTest, LsfSubmitsListsAndCancelsAsItsFileSays) {
  // bjobs fails where it finds no job.
  Program("bjobs",
          "[ \"$*\" = \"-noheader -J parallax -o jobid jobindex stat delimiter='|'\" ] || "
          "{ echo \"bjobs: $*\"; exit 2; }; [ -s " +
              dir_ + "/queue ] || " +
              "{ echo 'Job <parallax> is not found' >&2; exit 255; }; cat " + dir_ + "/queue");
  Program("bsub", "echo \"$@\" >> " + dir_ + "/bsub.log; echo 'Job <17> is submitted to default " +
                      "queue <normal>.'; printf '17|2|PEND\\n17|1|RUN\\n' > " + dir_ + "/queue");
  Program("bkill", "echo \"$@\" >> " + dir_ + "/bkill.log");
  StopAtSecondLook();
  const Outcome outcome =
      Run({"farm", "lsf", "--max", "2", "--script", script_, "--memory-mb", "500", "--wall-minutes",
           "90", "--interval", "1", "--at-end", "cancel"});
  EXPECT_EQ(outcome.exit_code, kExitInterrupted) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("submitted 2 as array 17\n"));
  EXPECT_EQ(
      Read("bsub.log"),
      "-J parallax[1-2] -M 500MB -R rusage[mem=500MB] -W 90 -wa USR1 -wt 5 bash " + script_ + "\n");
  EXPECT_EQ(Read("bkill.log"), "17[1] 17[2]\n");
}

TEST_F(FarmCommandTest, AnEngineOfTheUsersOwnIsAFileThatIsChecked) {
  const std::string file =
      WriteText("tiny.yaml",
                "submit: {command: [tsub, \"{script}\", \"{arguments}\"], id: '^(.+)$'}\n"
                "cancel: [tdel, \"{ids}\"]\n"
                "list: {command: [tstat], pilot: '^(\\S+) (\\S+)$', name_length: 8,\n"
                "  states: [{pattern: r, is: running}]}\n");
  Program("tstat", "echo \"t1 r\"");
  const std::vector<std::string> farm = {"farm",     file,    "--max",    "2",
                                         "--script", script_, "--dry-run"};
  const Outcome dry = Run(farm);
  EXPECT_EQ(dry.exit_code, kExitOk) << dry.err;
  EXPECT_THAT(dry.out, HasSubstr("1 run, 0 wait, 2 wanted: would submit 1\n"));
  EXPECT_THAT(dry.out, HasSubstr("tsub " + script_ + "\n"));
  std::vector<std::string> spaced = farm;
  spaced[5] = WriteText("my pilot.sh", "");
  EXPECT_THAT(Run(spaced).out, HasSubstr("tsub '" + dir_ + "/my pilot.sh'\n"))
      << "a command to copy";
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), farm.begin(), farm.end());
    return Run(more);
  };
  EXPECT_THAT(with({"--cores", "4"}).err, HasSubstr("--cores: engine tiny has no words for it"));
  EXPECT_THAT(with({"--submit=-q"}).err,
              HasSubstr("--submit: engine tiny has no {options} in submit.command"));
  EXPECT_THAT(with({"--name", "a-long-name"}).err,
              HasSubstr("--name a-long-name is longer than the 8 characters that tstat shows"));
  WriteText("tiny.yaml", "submit: {comand: [tsub]}\n");
  const Outcome wrong = Run(farm);
  EXPECT_EQ(wrong.exit_code, kExitUsage);
  EXPECT_THAT(wrong.err,
              HasSubstr(file + ":1: submit.comand: no such field, did you mean command?"));
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
      {{"--max", "2", "--script", script_, "--worker-tls", "/nowhere/tls"},
       kExitUsage,
       "--worker-tls: there is no folder /nowhere/tls"},
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
