// Kinds of jobs over gRPC: one that the server knows nothing of, results whose files are not what
// they say, and how many slots are busy.
#include <atomic>

#include "common/store/store.h"
#include "coordinator/queue/database_tools.h"
#include "puppet.h"
#include "server_fixture.h"
#include "tests/noop/noop_handler.h"
#include "tests/noop/noop_kind.h"

namespace parallax {
namespace {

using JobKindsTest = CoordinatorServerTest;

TEST_F(JobKindsTest, AJobOfAThirdKindWaitsForItsPairsAndIsDone) {
  const NoopKind noop(NoopKind::AfterPairs);
  const KindRegistry kinds = KindRegistry::Builtin().With(noop);
  kinds_ = &kinds;
  StartCoordinator();
  JobHandlers idler;
  idler.push_back(std::make_unique<NoopHandler>());
  StartAgent("idler", std::move(idler), 1);
  StartAgent("maker", noop_, 2);
  const int64_t study = Submit(12, 2, {"a", "b"});
  ASSERT_TRUE(WaitForState(study, v1::STUDY_STATE_SUCCEEDED));
  const v1::StudyStatus status = GetStudy(study);
  for (const v1::VariantStatus& variant : status.variants()) {
    EXPECT_EQ(JobsOf(variant, "noop", "SUCCEEDED"), 2) << variant.name();
    EXPECT_EQ(variant.pairs_done(), 12) << variant.name();
  }
  EXPECT_EQ(server_->Metrics().work.at("noop").jobs, 4);
  ExpectEveryInvariant();
  for (RunningAgent& agent : agents_) agent.Stop();
  StopCoordinator();  // Before its kinds.
}

TEST_F(JobKindsTest, AWorkerWithAnUnknownKindOrProtocolIsToldSo) {
  StartCoordinator();
  const struct {
    std::function<void(v1::Hello&)> spoil;
    absl::StatusCode code;
    const char* says;
  } cases[] = {
      {[](v1::Hello& h) { h.add_kinds("bake"); }, absl::StatusCode::kInvalidArgument,
       "unknown kind of job 'bake'; there are: solve, render"},
      {[](v1::Hello& h) { h.set_protocol(1); }, absl::StatusCode::kFailedPrecondition,
       "speaks work protocol 1, this coordinator speaks 3: give both the same release"},
  };
  for (const auto& c : cases) {
    v1::WorkerMessage message;
    v1::Hello& hello = *message.mutable_hello();
    hello.set_name("w");
    hello.set_protocol(kWorkProtocol);
    hello.add_kinds("solve");
    hello.set_slots(1);
    c.spoil(hello);
    grpc::ClientContext context;
    SetRpcTimeout(context, std::chrono::seconds(20));
    const auto stream = stub_->Work(&context);
    stream->Write(message);
    v1::CoordinatorMessage answer;
    EXPECT_FALSE(stream->Read(&answer));
    const absl::Status status = FromGrpc(stream->Finish());
    EXPECT_EQ(status.code(), c.code) << status;
    EXPECT_NE(std::string(status.message()).find(c.says), std::string::npos) << status;
  }
}

// ---- Files
class OutputsTest : public CoordinatorServerTest {
 protected:
  void SetUp() override {
    fs::create_directories(dir_ + "/store");
    store_ = *OpenStore(dir_ + "/store");
    options_.store = store_.get();
    options_.spool_dir = dir_ + "/spool";
    StartCoordinator();
    puppet_ = std::make_unique<Puppet>(*stub_);
    puppet_->Hello("w");
    study_ = Submit(1, 1, {"only"});
    v1::SolveResult solved;
    const v1::Lease solve = NextLease();
    solved.mutable_scene()->set_scene_seed(SolveOf(solve).scene_seed());
    solved.mutable_scene()->add_rigs();
    v1::CompleteRequest request = RequestOf(solve);
    SetResult(solved, request);
    ASSERT_TRUE(Complete(request).ok());
    lease_ = NextLease();
    folder_ = {dir_ + "/store/" + lease_.store_prefix() + "/.attempt-" +
                   std::to_string(lease_.attempt().fence()),
               lease_.store_prefix() + "/.attempt-" + std::to_string(lease_.attempt().fence())};
    result_ = *noop_.Render(RenderOf(lease_), folder_, {},
                            [](double, std::string_view, const JobFigures&) {});
  }
  void TearDown() override {
    puppet_->Cut();
    puppet_->WaitForEnd().IgnoreError();
    StopCoordinator();  // Before the store that it reads goes.
  }

  v1::Lease NextLease() {
    puppet_->Credit(1);
    v1::CoordinatorMessage message;
    EXPECT_TRUE(puppet_->ReadUntil(v1::CoordinatorMessage::kLease, &message));
    return message.lease();
  }
  static v1::CompleteRequest RequestOf(const v1::Lease& lease) {
    v1::CompleteRequest request;
    *request.mutable_attempt() = lease.attempt();
    request.set_worker("w");
    return request;
  }
  absl::Status Complete(const v1::CompleteRequest& request) {
    grpc::ClientContext context;
    SetRpcTimeout(context, std::chrono::seconds(20));
    v1::ReportReply reply;
    return FromGrpc(stub_->Complete(&context, request, &reply));
  }
  absl::Status Complete(const v1::RenderResult& result) {
    v1::CompleteRequest request = RequestOf(lease_);
    SetResult(result, request);
    return Complete(request);
  }
  // The result is refused with these words, and nothing is published.
  void ExpectRefused(const v1::RenderResult& result, const std::string& words) {
    const absl::Status status = Complete(result);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
    EXPECT_NE(std::string(status.message()).find(words), std::string::npos) << status;
    EXPECT_TRUE(Frames(study_).empty());
    EXPECT_EQ(JobsOf(GetStudy(study_).variants(0), "render", "RETRY_WAIT"), 1);
  }

  std::unique_ptr<Store> store_;
  std::unique_ptr<Puppet> puppet_;
  int64_t study_ = 0;
  v1::Lease lease_;  // A render job's.
  AttemptFolder folder_;
  v1::RenderResult result_;  // Right, and its files are in the store.
};

TEST_F(OutputsTest, AResultWhoseFilesAreThereIsPublished) {
  EXPECT_TRUE(Complete(result_).ok());
  EXPECT_EQ(Frames(study_).size(), 1u);
}

TEST_F(OutputsTest, AFileThatIsNotInTheStoreFailsTheAttempt) {
  ASSERT_TRUE(fs::remove(folder_.dir + "/000/left.png"));
  ExpectRefused(result_, "000/left.png: is not in the store");
}

TEST_F(OutputsTest, AFileOfAnotherSizeFailsTheAttempt) {
  std::ofstream(folder_.dir + "/000/right.png") << "short";
  ExpectRefused(result_, "000/right.png: has 5 bytes, not");
}

TEST_F(OutputsTest, ANameThatWasNotAskedForFailsTheAttempt) {
  std::ofstream(folder_.dir + "/000/extra.png") << "extra";
  v1::FileEntry& file = *result_.mutable_frames(0)->add_files();
  file = result_.frames(0).files(0);
  file.set_name("extra.png");
  file.set_size(5);
  ExpectRefused(result_, "wanted exactly frame.json");
}

TEST_F(OutputsTest, ADoubledNameFailsTheAttempt) {
  *result_.mutable_frames(0)->add_files() = v1::FileEntry(result_.frames(0).files(0));
  ExpectRefused(result_, "wanted exactly frame.json");
}

TEST_F(OutputsTest, AMissingMapFailsTheAttempt) {
  result_.mutable_frames(0)->mutable_files()->RemoveLast();
  ExpectRefused(result_, "wanted exactly frame.json");
}

TEST_F(OutputsTest, AReportInAnothersNameIsRefusedAndTheHolderGoesOn) {
  v1::CompleteRequest request = RequestOf(lease_);
  SetResult(result_, request);
  request.set_worker("nobody");
  const absl::Status status = Complete(request);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
  EXPECT_NE(std::string(status.message()).find("reported by nobody, but w holds its lease"),
            std::string::npos)
      << status;
  v1::FailRequest fail;
  *fail.mutable_attempt() = lease_.attempt();
  fail.set_worker("nobody");
  grpc::ClientContext context;
  SetRpcTimeout(context, std::chrono::seconds(20));
  v1::ReportReply reply;
  EXPECT_EQ(FromGrpc(stub_->Fail(&context, fail, &reply)).code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(Complete(result_).ok()) << "its own report counts";
  EXPECT_EQ(Frames(study_).size(), 1u);
}

TEST_F(OutputsTest, PublishedFilesCanBeLookedForLater) {
  ASSERT_TRUE(Complete(result_).ok());
  puppet_->Cut();
  StopCoordinator();
  int files = 0;
  const auto count = [&](const std::vector<JobKind::OutputFile>& some) {
    files += static_cast<int>(some.size());
    return absl::OkStatus();
  };
  ASSERT_TRUE(VisitStoredOutputs(dir_ + "/queue.db", count).ok());
  EXPECT_EQ(files, result_.frames(0).files_size());
}

// ---- Busy slots
// Works off short jobs by hand and never sends a heartbeat.
class QuickWorker {
 public:
  QuickWorker(v1::Coordinator::Stub& stub, const std::string& name)
      : stub_(stub), name_(name), thread_([this] {
          while (!stopping_) Session();
        }) {}
  ~QuickWorker() {
    stopping_ = true;
    {
      const std::lock_guard lock(mu_);
      if (puppet_ != nullptr) puppet_->Cut();
    }
    thread_.join();
  }

 private:
  void Session() {
    Puppet puppet(stub_);
    {
      const std::lock_guard lock(mu_);
      puppet_ = &puppet;
    }
    puppet.Hello(name_);
    while (!stopping_) {
      puppet.Credit(1);
      v1::CoordinatorMessage message;
      if (!puppet.ReadUntil(v1::CoordinatorMessage::kLease, &message)) break;
      const v1::Lease& lease = message.lease();
      v1::CompleteRequest request;
      *request.mutable_attempt() = lease.attempt();
      request.set_worker(name_);
      if (lease.kind() == "solve") {
        v1::SolveResult result;
        result.mutable_scene()->set_scene_seed(SolveOf(lease).scene_seed());
        result.mutable_scene()->add_rigs();
        SetResult(result, request);
      } else {
        v1::RenderResult result;
        v1::FrameResult& frame = *result.add_frames();
        frame.set_path(lease.store_prefix() + "/.attempt-" +
                       std::to_string(lease.attempt().fence()) + "/000");
        for (const std::string& file : FrameFileNames(RenderOf(lease).render())) {
          frame.add_files()->set_name(file);
          frame.mutable_files(frame.files_size() - 1)->set_sha256(std::string(64, 'a'));
        }
        SetResult(result, request);
      }
      grpc::ClientContext context;
      SetRpcTimeout(context, std::chrono::seconds(20));
      v1::ReportReply reply;
      if (!stub_.Complete(&context, request, &reply).ok()) break;
    }
    {
      const std::lock_guard lock(mu_);
      puppet_ = nullptr;
    }
    puppet.Cut();
    puppet.WaitForEnd().IgnoreError();
  }

  v1::Coordinator::Stub& stub_;
  const std::string name_;
  std::atomic<bool> stopping_{false};
  std::mutex mu_;
  Puppet* puppet_ = nullptr;  // Guarded by mu_.
  std::thread thread_;
};

TEST_F(JobKindsTest, OfTenThousandShortJobsNeverMoreRunThanThereAreSlots) {
  StartCoordinator();
  const int64_t study = Submit(5000, 1, {"only"});
  constexpr int kWorkers = 8;
  std::vector<std::unique_ptr<QuickWorker>> workers;
  for (int i = 0; i < kWorkers; ++i) {
    workers.push_back(std::make_unique<QuickWorker>(*stub_, "w" + std::to_string(i)));
  }
  int64_t polls = 0;
  int64_t busiest = 0;
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(100);
  while (queue_->Stats().completions < 10'000 && std::chrono::steady_clock::now() < deadline) {
    ++polls;
    const ServerMetrics metrics = server_->Metrics();
    ASSERT_LE(metrics.running, metrics.slots);
    busiest = std::max(busiest, metrics.running);
    for (const v1::WorkerStatus& worker : server_->Workers()) {
      ASSERT_LE(worker.running(), worker.slots()) << worker.name();
    }
    std::this_thread::yield();
  }
  EXPECT_EQ(queue_->Stats().completions, 10'000u);
  EXPECT_GT(polls, 100);
  EXPECT_GT(busiest, 0);
  EXPECT_EQ(GetStudy(study).state(), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_EQ(server_->Metrics().running, 0) << "nothing is held any more";
}

TEST_F(JobKindsTest, LeasesAheadOfAFreeSlotAreNotBusy) {
  StartCoordinator();
  Submit(3, 1, {"only"});
  Puppet puppet(*stub_);
  puppet.Hello("ahead");  // One slot.
  puppet.Credit(3);
  v1::CoordinatorMessage message;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(puppet.ReadUntil(v1::CoordinatorMessage::kLease, &message));
  }
  EXPECT_EQ(server_->Workers()[0].running(), 1);
  EXPECT_EQ(server_->Metrics().running, 1);
  puppet.Cut();
  puppet.WaitForEnd().IgnoreError();
}

TEST_F(JobKindsTest, AWorkerThatHasGoneRunsNothing) {
  StartCoordinator(/*lease_s=*/1, /*reconnect_grace_s=*/0.2);
  Submit(2, 1, {"only"});
  {
    Puppet puppet(*stub_);
    const v1::Lease lease = puppet.FirstLease("gone");
    EXPECT_EQ(server_->Workers()[0].running(), 1);
    EXPECT_EQ(server_->Workers()[0].state(), "busy");
    puppet.Cut();
    puppet.WaitForEnd().IgnoreError();
  }
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (server_->Workers()[0].state() != "lost" && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::yield();
  }
  EXPECT_EQ(server_->Workers()[0].state(), "lost");
  EXPECT_EQ(server_->Workers()[0].running(), 0);
}

}  // namespace
}  // namespace parallax
