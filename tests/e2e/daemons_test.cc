// The two daemons as processes, with work that only takes time: what is killed, whenever, loses and
// doubles nothing.
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"
#include "parallax/v1/service.grpc.pb.h"
#include "tests/e2e/process.h"
#include "tests/folder_test.h"
#include "tests/sqlite_by_hand.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;

constexpr char kCoordinator[] = PARALLAX_COORDINATOR_PROGRAM;
constexpr char kWorker[] = PARALLAX_NOOP_WORKER_PROGRAM;

class DaemonsTest : public FolderTest {
 protected:
  std::vector<std::string> ServeCommand(const std::string& listen = "127.0.0.1:0") const {
    return {kCoordinator,    "serve", "--db",   dir_ + "/queue.db", "--store",   dir_ + "/store",
            "--listen",      listen,  "--http", "127.0.0.1:0",      "--lease-s", "5",
            "--reconnect-s", "0.2"};
  }

  // Returns the address that it says it listens on.
  std::string StartCoordinator(const std::string& listen = "127.0.0.1:0") {
    coordinator_ = std::make_unique<Process>(ServeCommand(listen));
    std::string line;
    EXPECT_TRUE(coordinator_->ReadLine(&line)) << coordinator_->Err();
    const std::string prefix = "listening on ";
    EXPECT_EQ(line.substr(0, prefix.size()), prefix);
    const std::string address = line.substr(std::min(prefix.size(), line.size()));
    EXPECT_TRUE(coordinator_->ReadLine(&line));
    EXPECT_EQ(line.substr(0, 23), "http on http://127.0.0.") << line;
    stub_ = v1::Coordinator::NewStub(*ConnectRpc(*ParseRpcAddress(address), {}));
    return address;
  }

  std::unique_ptr<Process> StartWorker(const std::string& name, const std::string& address,
                                       int job_ms) {
    return std::make_unique<Process>(
        std::vector<std::string>{kWorker, "--role", "all", "--coordinator", address, "--slots", "2",
                                 "--name", name, "--outbox", dir_ + "/outbox"},
        std::vector<std::string>{"PARALLAX_NOOP_MS=" + std::to_string(job_ms)});
  }

  int64_t Submit(int64_t pairs, int rigs_per_scene) {
    v1::SubmitRequest request;
    v1::StudySpec& study = *request.mutable_study();
    study.set_name("noop");
    study.set_seed(3);
    study.set_pairs(pairs);
    study.set_rigs_per_scene(rigs_per_scene);
    study.add_variants()->set_name("v");
    study.mutable_variants(0)->mutable_config()->set_type(v1::SCENE_TYPE_INDOOR);
    study.mutable_variants(0)->mutable_config()->mutable_rigs()->set_count(rigs_per_scene);
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(20));
    context.set_wait_for_ready(true);
    v1::SubmitReply reply;
    const absl::Status status = FromGrpc(stub_->Submit(&context, request, &reply));
    EXPECT_TRUE(status.ok()) << status;
    return reply.study_id();
  }

  // Asks until `condition` holds; a coordinator that is away is waited for.
  bool WaitFor(int64_t study_id, const std::function<bool(const v1::StudyStatus&)>& condition) {
    const auto deadline = std::chrono::steady_clock::now() + kPatience * seconds(50);
    while (std::chrono::steady_clock::now() < deadline) {
      grpc::ClientContext context;
      SetRpcTimeout(context, seconds(5));
      context.set_wait_for_ready(true);
      v1::GetStudyRequest request;
      request.set_study_id(study_id);
      v1::StudyStatus study;
      if (stub_->GetStudy(&context, request, &study).ok() && condition(study)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }
  bool WaitForPairs(int64_t study_id, int64_t pairs) {
    return WaitFor(study_id, [pairs](const v1::StudyStatus& study) {
      return study.variants(0).pairs_done() >= pairs;
    });
  }
  bool WaitForSuccess(int64_t study_id) {
    return WaitFor(study_id, [](const v1::StudyStatus& study) {
      return study.state() == v1::STUDY_STATE_SUCCEEDED;
    });
  }

  // Every pair once, each with its file.
  void ExpectPairs(int64_t study_id, size_t pairs) {
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(20));
    v1::ListFramesRequest request;
    request.set_study_id(study_id);
    v1::ListFramesReply reply;
    const absl::Status status = FromGrpc(stub_->ListFrames(&context, request, &reply));
    ASSERT_TRUE(status.ok()) << status;
    std::set<std::pair<uint32_t, uint32_t>> seen;
    for (const v1::PublishedFrame& frame : reply.frames()) {
      EXPECT_TRUE(seen.insert({frame.scene(), frame.frame().rig()}).second) << "twice";
      EXPECT_TRUE(fs::exists(dir_ + "/store/" + frame.frame().path() + "/left.png"));
    }
    EXPECT_EQ(seen.size(), pairs);
  }

  // Stops the coordinator and lets the auditor look.
  void StopAndCheck() {
    coordinator_->Signal(SIGTERM);
    EXPECT_EQ(coordinator_->Wait(), 0) << coordinator_->Err();
    Process check({kCoordinator, "check", "--db", dir_ + "/queue.db"});
    std::string line;
    EXPECT_TRUE(check.ReadLine(&line));
    EXPECT_EQ(check.Wait(), 0) << line;
  }

  // Runs to the end; expects this exit status and one line on stderr with this text.
  static void ExpectRefusal(const std::vector<std::string>& command, int exit_status,
                            const std::string& text) {
    Process process(command);
    EXPECT_EQ(process.Wait(), exit_status) << text;
    const std::string errors = process.Err();
    EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 1) << errors;
    EXPECT_NE(errors.find(text), std::string::npos) << errors;
  }

  std::unique_ptr<Process> coordinator_;
  std::unique_ptr<v1::Coordinator::Stub> stub_;
};

TEST_F(DaemonsTest, AStudyOutlivesAKilledWorker) {
  const std::string address = StartCoordinator();
  const int64_t study = Submit(24, 2);
  auto doomed = StartWorker("doomed", address, 20);
  ASSERT_TRUE(WaitForPairs(study, 4)) << doomed->Err();
  Process backup({kCoordinator, "backup", "--db", dir_ + "/queue.db", dir_ + "/backup.db"});
  EXPECT_EQ(backup.Wait(), 0) << backup.Err();
  Process check({kCoordinator, "check", "--db", dir_ + "/backup.db"});
  EXPECT_EQ(check.Wait(), 0) << check.Err();
  ExpectRefusal({kCoordinator, "check", "--db", dir_ + "/queue.db"}, 5, "queue.db");
  doomed->Signal(SIGKILL);
  EXPECT_EQ(doomed->Wait(), 128 + SIGKILL);
  auto heir = StartWorker("heir", address, 1);
  ASSERT_TRUE(WaitForSuccess(study)) << heir->Err();
  // The doomed one may have been that fast; a signal before there is a handler is the heir's end.
  ASSERT_TRUE(WaitUntil(*heir, [&] { return heir->Err().find("connected") != std::string::npos; }));
  ExpectPairs(study, 24);
  heir->Signal(SIGTERM);
  EXPECT_EQ(heir->Wait(), 0) << heir->Err();
  StopAndCheck();
}

TEST_F(DaemonsTest, AStudyOutlivesAKilledCoordinator) {
  const std::string address = StartCoordinator();
  const int64_t study = Submit(24, 2);
  auto worker = StartWorker("steady", address, 20);
  for (int64_t pairs : {4, 10}) {
    ASSERT_TRUE(WaitForPairs(study, pairs)) << worker->Err();
    coordinator_->Signal(SIGKILL);
    EXPECT_EQ(coordinator_->Wait(), 128 + SIGKILL);
    StartCoordinator(address);
  }
  ASSERT_TRUE(WaitForSuccess(study)) << worker->Err();
  ExpectPairs(study, 24);
  worker->Signal(SIGTERM);
  EXPECT_EQ(worker->Wait(), 0) << worker->Err();
  StopAndCheck();
}

TEST_F(DaemonsTest, ADrainedWorkerHandsOverAndLeaves) {
  const std::string address = StartCoordinator();
  const int64_t study = Submit(8, 2);
  auto slow = StartWorker("slow", address, 100'000);
  const auto running = [this](const v1::StudyStatus&) {
    grpc::ClientContext context;
    SetRpcTimeout(context, seconds(5));
    v1::ListWorkersReply reply;
    return stub_->ListWorkers(&context, {}, &reply).ok() && reply.workers_size() == 1 &&
           reply.workers(0).running() == 2;
  };
  ASSERT_TRUE(WaitFor(study, running)) << slow->Err();
  // The coordinator counts leases whose reply is still on its way to the worker.
  std::this_thread::sleep_for(seconds(1));
  slow->Signal(SIGTERM);
  slow->Signal(SIGINT);
  EXPECT_EQ(slow->Wait(), 4) << "work was handed back\n" << slow->Err();
  auto quick = StartWorker("quick", address, 0);
  ASSERT_TRUE(WaitForSuccess(study)) << quick->Err();
  StopAndCheck();
}

TEST_F(DaemonsTest, EachStartUpErrorHasItsLineAndExitStatus) {
  const std::string address = StartCoordinator();
  ExpectRefusal(ServeCommand(), 5, "queue.db");
  std::vector<std::string> other = ServeCommand(address);
  other[3] = dir_ + "/other.db";
  ExpectRefusal(other, 6, "it belongs to the database ");
  other[5] = dir_ + "/other-store";
  ExpectRefusal(other, 3, address);
  coordinator_->Signal(SIGTERM);
  EXPECT_EQ(coordinator_->Wait(), 0);

  std::vector<std::string> no_store = ServeCommand();
  std::ofstream(dir_ + "/file") << "not a folder";
  no_store[5] = dir_ + "/file/store";
  ExpectRefusal(no_store, 6, "file");
  std::vector<std::string> no_folder = ServeCommand();
  no_folder[3] = dir_ + "/none/queue.db";
  ExpectRefusal(no_folder, 7, dir_ + "/none");
  std::vector<std::string> read_only = ServeCommand();
  read_only[3] = "/proc/queue.db";
  ExpectRefusal(read_only, 7, "/proc/queue.db");
  std::vector<std::string> public_address = ServeCommand("0.0.0.0:0");
  ExpectRefusal(public_address, 2, "--insecure");
  ExpectRefusal({kCoordinator, "serve", "--db", "x"}, 2, "--store");
  ExpectRefusal({kCoordinator, "serve", "--bogus"}, 2, "--help");
  ExpectRefusal({kCoordinator, "serv"}, 2, "'serv'; did you mean `coordinator serve`?");

  std::ofstream(dir_ + "/text.db") << std::string(8192, 'x');
  std::vector<std::string> text = ServeCommand();
  text[3] = dir_ + "/text.db";
  ExpectRefusal(text, 8, "text.db");
  EXPECT_FALSE(fs::exists(dir_ + "/text.db.lock")) << "left beside somebody's file";
}

TEST_F(DaemonsTest, TooFewDescriptorsOrThreadsHaveTheirLine) {
  const auto limited = [this](const std::string& limits) {
    std::vector<std::string> command = {"/bin/sh", "-c", limits + "; exec \"$@\"", "sh"};
    for (const std::string& word : ServeCommand()) command.push_back(word);
    return command;
  };
  ExpectRefusal(limited("ulimit -n 40"), 1, "ulimit -n");
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // No address space for the stacks of so many: threads can't be made, as where a container bounds
  // their number.
  for (const char* space : {"3000000", "9000000"}) {
    ExpectRefusal(limited(std::string("ulimit -s 262144; ulimit -v ") + space), 1, "ulimit -u");
  }
#endif
}

TEST_F(DaemonsTest, ADatabaseFromTheFutureIsRefused) {
  StartCoordinator();
  coordinator_->Signal(SIGTERM);
  ASSERT_EQ(coordinator_->Wait(), 0);
  sqlite3* const db = OpenByHand(dir_ + "/queue.db");
  ASSERT_NE(db, nullptr);
  EXPECT_EQ(sqlite3_exec(db, "PRAGMA user_version = 9999", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(db);
  ExpectRefusal(ServeCommand(), 4, "9999");
}

TEST_F(DaemonsTest, AWorkerSaysWhyItDoesNotStart) {
  ExpectRefusal({kWorker, "--role", "cook", "--coordinator", "127.0.0.1:1"}, 2, "--role");
  ExpectRefusal({kWorker, "--role", "all", "--coordinator", "nowhere"}, 2, "HOST:PORT");
  ExpectRefusal({kWorker, "--role", "all", "--coordinator", "farm:7070"}, 2, "--insecure");
  ExpectRefusal({kWorker, "--role", "all", "--coordinator", "127.0.0.1:1", "--name", "a/b"}, 2,
                "a/b");
  ExpectRefusal(
      {kWorker, "--role", "all", "--coordinator", "127.0.0.1:1", "--outbox", "/proc/none"}, 1,
      "/proc/none");
}

}  // namespace
}  // namespace parallax
