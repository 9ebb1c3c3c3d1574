// Notices reach a web server and a program, at least once, whatever these answer.
#include "coordinator/rpc/notifier.h"

#include <arpa/inet.h>
#include <fmt/core.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <deque>
#include <nlohmann/json.hpp>

#include "common/base/system/file.h"
#include "coordinator/rpc/workers/wait_reasons.h"
#include "tests/coordinator/queue/queue_fixture.h"

namespace parallax {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

// Answers each POST on loopback with the next of `answers`, else 200, and keeps the bodies.
class Receiver {
 public:
  Receiver() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(listen(listener_, 8), 0);
    EXPECT_EQ(getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { Serve(); });
  }
  ~Receiver() {
    shutdown(listener_, SHUT_RDWR);  // Ends accept().
    thread_.join();
    close(listener_);
  }
  std::string url() const { return fmt::format("http://127.0.0.1:{}/hook/secret", port_); }
  void Answer(std::deque<int> codes) {
    const std::lock_guard lock(mu_);
    answers_ = std::move(codes);
  }
  std::vector<std::string> bodies() const {
    const std::lock_guard lock(mu_);
    return bodies_;
  }

 private:
  void Serve() {
    for (int fd = -1; (fd = accept(listener_, nullptr, nullptr)) >= 0; close(fd)) {
      std::string request;
      char buffer[4096];
      size_t head = 0, wanted = std::string::npos;
      while (request.size() < wanted) {
        pollfd ready{fd, POLLIN, 0};
        const ssize_t n = poll(&ready, 1, 5000) == 1 ? read(fd, buffer, sizeof(buffer)) : 0;
        if (n <= 0) break;
        request.append(buffer, static_cast<size_t>(n));
        head = request.find("\r\n\r\n");
        if (head == std::string::npos || wanted != std::string::npos) continue;
        const size_t length = request.find("Content-Length: ");
        wanted = head + 4 + std::stoul(request.substr(length + 16));
      }
      const std::lock_guard lock(mu_);
      bodies_.push_back(request.substr(head + 4));
      const int code = answers_.empty() ? 200 : answers_.front();
      if (!answers_.empty()) answers_.pop_front();
      const std::string answer =
          fmt::format("HTTP/1.1 {} X\r\nContent-Length: 4\r\nConnection: close\r\n\r\nbusy", code);
      EXPECT_EQ(write(fd, answer.data(), answer.size()), static_cast<ssize_t>(answer.size()));
    }
  }

  const int listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  int port_ = 0;
  mutable std::mutex mu_;
  std::deque<int> answers_;          // Guarded by mu_.
  std::vector<std::string> bodies_;  // Guarded by mu_.
  std::thread thread_;
};

class NotifierTest : public QueueTest {
 protected:
  NotifierTest() {
    notify_.every_s = 0;
    notify_.clock = &clock_;
  }
  // A start of the coordinator.
  void Start() {
    notifier_.reset();
    waits_.reset();
    options_.notice_targets = notify_.Targets();
    Reopen();
    waits_.emplace(*queue_, clock_, [this] { return workers_; });
    notifier_.emplace(*queue_, *waits_, notify_);
  }
  int Look() {
    const auto delivered = notifier_->Look();
    EXPECT_TRUE(delivered.ok()) << delivered.status();
    return delivered.value_or(-1);
  }
  std::string Program(const std::string& script) {
    const std::string path = dir_ + "/program";
    EXPECT_TRUE(WriteFile(path, "#!/bin/sh\n" + script).ok());
    EXPECT_EQ(chmod(path.c_str(), 0755), 0);
    return path;
  }
  void TearDown() override {
    notifier_.reset();
    waits_.reset();
    QueueTest::TearDown();
  }

  // A study with a receiver of its own.
  absl::StatusOr<v1::SubmitReply> SubmitFor(const std::string& url,
                                            const std::vector<std::string>& events = {},
                                            const StudyOptions& options = {}) {
    v1::SubmitRequest request = MakeStudy(options);
    v1::NotifySpec& notify = *request.mutable_study()->mutable_notify();
    notify.set_url(url);
    notify.mutable_on()->Assign(events.begin(), events.end());
    request.mutable_study()->set_source_yaml("notify: {url: " + url + "}\n");
    return queue_->Submit(request, "tester");
  }
  void AllowAnyHost() { notify_.hosts = *NotifyHosts::Of({"*"}); }

  NotifierOptions notify_;
  std::vector<WorkerGroup> workers_;
  std::optional<WaitReasons> waits_;
  std::optional<Notifier> notifier_;
};

TEST_F(NotifierTest, TheEndOfAStudyIsPostedOnce) {
  Receiver receiver;
  notify_.url = receiver.url();
  Start();
  Submit({.name = "baseline", .pairs = 2, .rigs_per_scene = 2});
  EXPECT_EQ(Look(), 0);
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(Look(), 1);
  EXPECT_EQ(Look(), 0);
  ASSERT_THAT(receiver.bodies(), SizeIs(1));
  const json notice = json::parse(receiver.bodies()[0]);
  EXPECT_EQ(notice["event"], "done");
  EXPECT_EQ(notice["text"], "study 1 (baseline) is succeeded: 2 of 2 pairs done");
  EXPECT_EQ(notice["unix_s"], clock_.UnixSeconds());
  EXPECT_EQ(notice["study"]["study_id"], 1);
  EXPECT_EQ(notice["study"]["pairs_done"], 2);
}

TEST_F(NotifierTest, WhatIsNotTakenIsRepeatedLaterAndOverARestart) {
  Receiver receiver;
  notify_.url = receiver.url();
  Start();
  Submit({.pairs = 2, .rigs_per_scene = 2});
  WorkOff(AnyWorker("w"));
  receiver.Answer({503, 404});
  EXPECT_EQ(Look(), 0);
  EXPECT_EQ(Look(), 0) << "not at once";
  EXPECT_THAT(receiver.bodies(), SizeIs(1));
  clock_.Advance(10);
  EXPECT_EQ(Look(), 0);
  clock_.Advance(10);
  EXPECT_EQ(Look(), 0) << "the second wait is longer";
  EXPECT_THAT(receiver.bodies(), SizeIs(2));
  Start();
  clock_.Advance(10);
  EXPECT_EQ(Look(), 1);
  EXPECT_THAT(receiver.bodies(), SizeIs(3));
}

TEST_F(NotifierTest, AReceiverThatIsAwayCostsLittleAndLosesItsNoticesAfterAWeek) {
  {
    Receiver receiver;
    notify_.url = receiver.url();  // Nobody listens there any more.
  }
  Start();
  for (uint64_t i = 0; i < 5; ++i) Submit({.seed = i, .pairs = 2, .rigs_per_scene = 2});
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(Look(), 0);
  const auto left = queue_->ListNotices(100);
  EXPECT_THAT(*left, SizeIs(2)) << "three were tried, then it is taken to be away";
  for (int i = 0; i < 2; ++i) {
    clock_.Advance(8 * 86400);
    Look();
  }
  clock_.Advance(8 * 86400);
  EXPECT_THAT(*queue_->ListNotices(100), IsEmpty());
}

TEST_F(NotifierTest, AProgramIsTheOtherReceiverAndEachHasItsOwnTries) {
  Receiver receiver;
  notify_.url = receiver.url();
  notify_.command = Program("echo \"$1\" >> " + dir_ +
                            "/told\necho no room >&2\n"
                            "test -e " +
                            dir_ + "/room\n");
  Start();
  Submit({.pairs = 2, .rigs_per_scene = 2});
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(Look(), 1) << "the program ended with status 1";
  ASSERT_TRUE(WriteFile(dir_ + "/room", "x").ok());
  clock_.Advance(10);
  EXPECT_EQ(Look(), 1);
  EXPECT_THAT(receiver.bodies(), SizeIs(1));
  const std::string told = *ReadFile(dir_ + "/told", 1 << 20);
  EXPECT_EQ(told, receiver.bodies()[0] + "\n" + receiver.bodies()[0] + "\n");
}

TEST_F(NotifierTest, AProgramThatHangsIsEnded) {
  notify_.command = Program("sleep 1000\n");
  notify_.most_s = 0.1;
  Start();
  Submit({.pairs = 2, .rigs_per_scene = 2});
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(Look(), 0);
  clock_.Advance(10);
  EXPECT_THAT(*queue_->ListNotices(100), SizeIs(1));
}

TEST_F(NotifierTest, FailedJobsAreToldWithTheirCause) {
  Receiver receiver;
  notify_.url = receiver.url();
  Start();
  Submit({.name = "baseline", .pairs = 40});
  for (int i = 0; i < 2; ++i) {
    Fail(Failure(LeaseOne(Solver("w")), "w", "no such file", /*retryable=*/false));
  }
  EXPECT_EQ(Look(), 0);
  clock_.Advance(60);
  EXPECT_EQ(Look(), 1);
  const json notice = json::parse(receiver.bodies().at(0));
  EXPECT_EQ(notice["event"], "failed");
  EXPECT_EQ(notice["text"],
            "study 1 (baseline): 2 jobs have failed; the last: no such file at line 7");
}

TEST_F(NotifierTest, AStudyThatStandsStillIsToldOfOnceUntilItRunsAgain) {
  Receiver receiver;
  notify_.url = receiver.url();
  notify_.stall_s = 600;
  Start();
  const StudyId study = Submit({.name = "baseline", .pairs = 40});
  EXPECT_EQ(Look(), 0);
  clock_.Advance(599);
  EXPECT_EQ(Look(), 0);
  clock_.Advance(1);
  EXPECT_EQ(Look(), 1);
  clock_.Advance(3600);
  EXPECT_EQ(Look(), 0) << "once";
  const std::string text = json::parse(receiver.bodies().at(0))["text"];
  EXPECT_THAT(text, HasSubstr("study 1 (baseline): no job of it has run for 10 minutes"));
  EXPECT_THAT(text, HasSubstr("solve jobs: no worker")) << "and why";
  const v1::Lease lease = LeaseOne(Solver("w"));  // It runs...
  EXPECT_EQ(Look(), 0);
  ASSERT_TRUE(queue_->HandBack("w", lease.attempt(), "").ok());
  EXPECT_EQ(Look(), 0);
  clock_.Advance(600);
  EXPECT_EQ(Look(), 1);  // ...and stands still again.
  ASSERT_TRUE(queue_->Pause(study, "", "t").ok());
  EXPECT_EQ(Look(), 0);
  clock_.Advance(600);
  EXPECT_EQ(Look(), 0) << "a paused study is meant to";
}

TEST_F(NotifierTest, NobodyIsToldOfAStudyThatIsForgottenOrGoesOn) {
  Receiver receiver;
  notify_.url = receiver.url();
  Start();
  const StudyId forgotten = Submit({.seed = 1, .pairs = 2, .rigs_per_scene = 2});
  WorkOff(AnyWorker("w"));
  ASSERT_TRUE(queue_->Forget(forgotten, "", "t").ok());
  const StudyId failed = Submit({.seed = 2, .pairs = 2, .rigs_per_scene = 2});
  while (Status(failed).finished_unix_s() == 0) {
    Fail(Failure(LeaseOne(Solver("w")), "w", "no such file", /*retryable=*/false));
  }
  ASSERT_TRUE(queue_->Retry(failed, "t").ok());
  Look();
  EXPECT_THAT(receiver.bodies(), IsEmpty());
}

TEST_F(NotifierTest, AStudysOwnReceiverHearsOfItAlone) {
  Receiver operators, own;
  notify_.url = operators.url();
  AllowAnyHost();
  Start();
  Submit({.name = "other", .seed = 1, .pairs = 2});
  ASSERT_TRUE(SubmitFor(own.url(), {}, {.name = "told", .seed = 2, .pairs = 2}).ok());
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(Look(), 3);
  EXPECT_THAT(operators.bodies(), SizeIs(2));
  ASSERT_THAT(own.bodies(), SizeIs(1));
  EXPECT_EQ(json::parse(own.bodies()[0])["study"]["name"], "told");
}

TEST_F(NotifierTest, AStudysReceiverHearsTheEventsThatItWants) {
  Receiver own;
  AllowAnyHost();
  Start();
  ASSERT_TRUE(SubmitFor(own.url(), {"failed", "waits"}, {.pairs = 2}).ok());
  Fail(Failure(LeaseOne(Solver("w")), "w", "no such file", /*retryable=*/false));
  WorkOff(AnyWorker("w"));
  clock_.Advance(60);
  EXPECT_EQ(Look(), 1);
  ASSERT_THAT(own.bodies(), SizeIs(1));
  EXPECT_EQ(json::parse(own.bodies()[0])["event"], "failed") << "not done";
}

TEST_F(NotifierTest, TheAddressOfAStudysReceiverIsNotInItsText) {
  AllowAnyHost();
  Start();
  const auto reply = SubmitFor("https://hooks.example.com/T0/secret");
  ASSERT_TRUE(reply.ok()) << reply.status();
  const v1::StudyStatus study = Status(StudyId{reply->study_id()});
  EXPECT_FALSE(study.spec().has_notify());
  EXPECT_EQ(study.spec().source_yaml(), "notify: {url: <hooks.example.com>}\n");
}

TEST_F(NotifierTest, AStudyThatIsSubmittedAgainTakesItsNewReceiver) {
  Receiver before, after;
  AllowAnyHost();
  Start();
  const auto first = SubmitFor(before.url(), {}, {.pairs = 2, .key = "k"});
  const auto again = SubmitFor(after.url(), {}, {.pairs = 2, .key = "k"});
  ASSERT_TRUE(first.ok() && again.ok()) << again.status();
  EXPECT_TRUE(again->existed());
  EXPECT_EQ(again->study_id(), first->study_id());
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(Look(), 1);
  EXPECT_THAT(before.bodies(), IsEmpty());
  EXPECT_THAT(after.bodies(), SizeIs(1));
  ASSERT_TRUE(queue_->Submit(MakeStudy({.pairs = 2, .key = "k"}), "tester")->existed());
  ASSERT_TRUE(queue_->RaiseNotice(StudyId{first->study_id()}, kNoticeFailed).ok());
  EXPECT_EQ(Look(), 0) << "it has none any more";
}

TEST_F(NotifierTest, AHostThatIsAwayHoldsUpNoOther) {
  Receiver away, there;
  away.Answer({503, 503, 503, 503, 503});
  AllowAnyHost();
  Start();
  for (uint64_t i = 0; i < 5; ++i)
    ASSERT_TRUE(SubmitFor(away.url(), {}, {.seed = i, .pairs = 2}).ok());
  ASSERT_TRUE(SubmitFor(there.url(), {}, {.seed = 5, .pairs = 2}).ok());
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(Look(), 1);
  EXPECT_THAT(there.bodies(), SizeIs(1));
  EXPECT_THAT(away.bodies(), SizeIs(1)) << "one is tried in a look";
  EXPECT_THAT(*queue_->ListNotices(100), IsEmpty()) << "all five come later";
  clock_.Advance(10);
  EXPECT_THAT(*queue_->ListNotices(100), SizeIs(5));
}

TEST_F(NotifierTest, NothingIsPostedToAHostThatIsNoLongerAllowed) {
  Receiver own;
  AllowAnyHost();
  Start();
  ASSERT_TRUE(SubmitFor(own.url(), {}, {.pairs = 2}).ok());
  WorkOff(AnyWorker("w"));
  notify_.hosts = *NotifyHosts::Of({"hooks.example.com"});
  Start();
  EXPECT_EQ(Look(), 1) << "dropped";
  EXPECT_THAT(own.bodies(), IsEmpty());
}

TEST_F(NotifierTest, JobsThatWaitForAPersonAreToldOfOnceUntilItChanges) {
  Receiver receiver;
  notify_.url = receiver.url();
  notify_.stall_s = 0;
  Start();
  const WorkerGroup solvers{.kinds = {"solve"}, .memory_mb = 64'000, .free = 1};
  v1::SubmitRequest request = MakeStudy({.name = "baseline", .pairs = 4});
  request.mutable_study()->add_tags("big");
  ASSERT_TRUE(queue_->Submit(request, "tester").ok());
  const auto look_after = [this](double seconds) {
    clock_.Advance(seconds);
    return Look();
  };
  EXPECT_EQ(Look(), 0);
  EXPECT_EQ(look_after(300), 0) << "without workers, nobody knows what the next ones bring";
  workers_ = {solvers};
  EXPECT_EQ(look_after(1), 0);
  EXPECT_EQ(look_after(299), 0);
  EXPECT_EQ(look_after(1), 1);
  EXPECT_EQ(look_after(3600), 0) << "once";
  const json notice = json::parse(receiver.bodies().at(0));
  EXPECT_EQ(notice["event"], "waits");
  EXPECT_THAT(std::string(notice["text"]),
              HasSubstr("study 1 (baseline): jobs wait for a person; 2 solve jobs: no connected "
                        "worker for solve jobs has the tag big"));
  workers_.clear();
  EXPECT_EQ(look_after(1), 0);
  workers_ = {solvers};
  EXPECT_EQ(look_after(1000), 0) << "they were away for a while only";
  workers_[0].tags = {"big"};
  EXPECT_EQ(look_after(1), 0);
  workers_ = {solvers};
  EXPECT_EQ(look_after(1), 0);
  EXPECT_EQ(look_after(300), 1) << "it is so again";
}

TEST_F(NotifierTest, WhatTheDatabaseDidNotKeepIsToldByALaterLook) {
  Receiver receiver;
  notify_.url = receiver.url();
  notify_.stall_s = 600;
  FailingCommand failing(options_);
  Start();
  v1::SubmitRequest request = MakeStudy({.name = "baseline", .pairs = 40});
  request.mutable_study()->add_tags("big");
  ASSERT_TRUE(queue_->Submit(request, "tester").ok());
  workers_ = {{.kinds = {"solve"}, .memory_mb = 64'000, .free = 1}};
  EXPECT_EQ(Look(), 0);
  const auto insist = [&] {
    failing.Set("notice");
    for (int i = 0; i < 2; ++i) EXPECT_FALSE(notifier_->Look().ok());
    failing.Clear();
    return Look();
  };
  clock_.Advance(300);
  EXPECT_EQ(insist(), 1) << "it waits for a person";
  clock_.Advance(300);
  EXPECT_EQ(insist(), 1) << "it stands still";
  EXPECT_EQ(Look(), 0) << "once";
}

TEST_F(NotifierTest, ReceiversAreCheckedAtTheStart) {
  const struct {
    const char *url, *command, *error;
  } kCases[] = {
      {"ftp://host/x", "", "--notify \"ftp://host/x\": is no address, allowed is http://HOST/..."},
      {"http:///x", "", "--notify \"http:///x\""},
      {"host", "", "--notify \"host\""},
      {"", "/no/such/program", "--notify-command \"/no/such/program\": is no program"},
      {"https://ada:secret@host:8080/x?y=z", "true", ""},
  };
  for (const auto& one : kCases) {
    const absl::Status status = CheckNotifierOptions({.url = one.url, .command = one.command});
    EXPECT_THAT(std::string(status.message()), HasSubstr(one.error));
    EXPECT_EQ(status.ok(), *one.error == '\0') << status;
  }
}

}  // namespace
}  // namespace parallax
