// How much users and studies may have: jobs at a time, unfinished studies, pairs that wait.
#include <sqlite3.h>

#include <atomic>
#include <thread>

#include "common/base/status.h"
#include "queue_fixture.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr char kAda[] = "submitter ada ipv4:10.0.0.7:4711";
constexpr char kBob[] = "submitter bob ipv4:10.0.0.8:4711";

class Limits : public QueueTest {
 protected:
  void SetLimits(const std::string& yaml) {
    const auto limits = LimitRules::Parse(yaml, "limits.yaml");
    ASSERT_TRUE(limits.ok()) << limits.status();
    options_.limits = *limits;
    Reopen();
  }
  absl::StatusOr<v1::SubmitReply> SubmitAs(const std::string& actor, const StudyOptions& options,
                                           int max_running = 0) {
    v1::SubmitRequest request = MakeStudy(options);
    request.set_max_running(max_running);
    return queue_->Submit(request, actor);
  }
  StudyId IdOf(const absl::StatusOr<v1::SubmitReply>& reply) {
    EXPECT_TRUE(reply.ok()) << reply.status();
    return StudyId{reply.ok() ? reply->study_id() : 0};
  }
  v1::UserStatus User(const std::string& name) {
    const auto users = queue_->ListUsers();
    EXPECT_TRUE(users.ok()) << users.status();
    for (const v1::UserStatus& user : *users) {
      if (user.user() == name) return user;
    }
    ADD_FAILURE() << "no user " << name;
    return {};
  }
  std::vector<std::string> AuditOf(const std::string& action) {
    v1::ListAuditRequest request;
    const auto entries = queue_->ListAudit(request);
    std::vector<std::string> details;
    for (const v1::AuditEntry& entry : *entries) {
      if (entry.action() == action) details.push_back(entry.actor() + ": " + entry.detail());
    }
    return details;
  }
};

// Counts what is told to workers.
class ReadyCounter final : public JobQueueObserver {
 public:
  void OnWorkReady() override { ++ready; }
  void OnStop(const std::string&, const v1::AttemptId&, const std::string&) override {}
  std::atomic<int> ready{0};
};

TEST_F(Limits, AStudyNeverHasMoreRunningJobsThanItAskedForAndOthersGoOn) {
  const StudyId limited = IdOf(SubmitAs(kAda, {.name = "limited", .seed = 1, .pairs = 20}, 2));
  const StudyId other = IdOf(SubmitAs(kBob, {.name = "other", .seed = 2, .pairs = 20}));
  const auto leases = Lease(AnyWorker("w"), 7);
  EXPECT_THAT(leases, SizeIs(7));
  EXPECT_EQ(Jobs(limited, "solve", "LEASED"), 2);
  EXPECT_EQ(Jobs(other, "solve", "LEASED"), 5);
  const v1::StudyStatus status = Status(limited);
  EXPECT_EQ(status.user(), "submitter ada");
  EXPECT_EQ(status.max_running(), 2);
  EXPECT_EQ(status.at_limit(), "max_running 2");
  EXPECT_EQ(status.held_jobs(), Jobs(limited, "solve", "READY"));
  EXPECT_EQ(Status(other).at_limit(), "");
  // The end of one makes room for one.
  for (const v1::Lease& lease : leases) {
    if (lease.study() != "limited") continue;
    EXPECT_EQ(*queue_->HandBack("w", lease.attempt(), ""), v1::REPORT_OUTCOME_OK);
    break;
  }
  EXPECT_EQ(Jobs(limited, "solve", "LEASED"), 1);
  Lease(AnyWorker("w"), 4);
  EXPECT_EQ(Jobs(limited, "solve", "LEASED"), 2);
}

TEST_F(Limits, AnEndAtALimitTellsIdleWorkersAndAnotherEndDoesNot) {
  const StudyId study = IdOf(SubmitAs(kAda, {.pairs = 12, .rigs_per_scene = 2}, 1));
  for (int i = 0; i < 6; ++i) Complete(SolveAnswer(LeaseOne(Solver("s")), "s"));
  for (const int most : {1, 0}) {
    ASSERT_TRUE(queue_->SetMaxRunning(study, most, "", kAda).ok());
    const v1::Lease lease = LeaseOne(Renderer("r"));
    ReadyCounter told;
    queue_->SetObserver(&told);
    Complete(RenderAnswer(lease, "r"));
    queue_->SetObserver(nullptr);
    EXPECT_EQ(told.ready, most) << "a render's end makes no other work";
  }
}

TEST_F(Limits, ALimitIsChangedWhileTheStudyRunsAndStaysOverARestart) {
  const StudyId study = IdOf(SubmitAs(kAda, {.pairs = 40}, 1));
  EXPECT_THAT(Lease(AnyWorker("w"), 9), SizeIs(1));
  ASSERT_TRUE(queue_->SetMaxRunning(study, 4, "more", kAda).ok());
  EXPECT_THAT(Lease(AnyWorker("w"), 9), SizeIs(3));
  // Less than what runs: it goes on.
  ASSERT_TRUE(queue_->SetMaxRunning(study, 2, "", kAda).ok());
  EXPECT_EQ(Jobs(study, "solve", "LEASED"), 4);
  Reopen();
  EXPECT_THAT(Lease(AnyWorker("w"), 9), IsEmpty());
  EXPECT_EQ(Status(study).max_running(), 2);
  ASSERT_TRUE(queue_->SetMaxRunning(study, 0, "", kAda).ok());
  EXPECT_THAT(Lease(AnyWorker("w"), 9), SizeIs(9));
  EXPECT_THAT(AuditOf("limit"), ElementsAre(std::string(kAda) + ": max_running 0, was 2",
                                            std::string(kAda) + ": max_running 2, was 4",
                                            std::string(kAda) + ": max_running 4, was 1: more"));
  EXPECT_TRUE(absl::IsNotFound(queue_->SetMaxRunning(StudyId{99}, 1, "", kAda)));
}

TEST_F(Limits, APriorityThatIsChangedCountsFromTheNextLeaseOn) {
  IdOf(SubmitAs(kAda, {.name = "first", .seed = 1, .pairs = 40, .priority = 5}));
  const StudyId second = IdOf(SubmitAs(kBob, {.name = "second", .seed = 2, .pairs = 40}));
  EXPECT_EQ(LeaseOne(Solver("a")).study(), "first");
  ASSERT_TRUE(queue_->SetPriority(second, 6, "deadline", kBob).ok());
  EXPECT_EQ(LeaseOne(Solver("b")).study(), "second");
  Reopen();
  EXPECT_EQ(Status(second).priority(), 6);
  EXPECT_EQ(LeaseOne(Solver("c")).study(), "second");
  ASSERT_TRUE(queue_->SetPriority(second, -6, "", kBob).ok());
  ASSERT_TRUE(queue_->SetPriority(second, -6, "again", kBob).ok());  // Changes nothing.
  EXPECT_EQ(LeaseOne(Solver("d")).study(), "first");
  EXPECT_THAT(AuditOf("priority"),
              ElementsAre(std::string(kBob) + ": priority -6, was 6",
                          std::string(kBob) + ": priority 6, was 0: deadline"));
  EXPECT_TRUE(absl::IsNotFound(queue_->SetPriority(StudyId{99}, 1, "", kAda)));
}

TEST_F(Limits, AUsersPriorityIsAddedToThatOfItsStudies) {
  SetLimits("default: {priority: -1}\nusers: {submitter bob: {priority: 10}}");
  IdOf(SubmitAs(kAda, {.name = "adas", .seed = 1, .pairs = 40, .priority = 5}));
  const StudyId bobs = IdOf(SubmitAs(kBob, {.name = "bobs", .seed = 2, .pairs = 40}));
  EXPECT_EQ(LeaseOne(Solver("a")).study(), "bobs");
  EXPECT_EQ(User("submitter bob").priority(), 10);
  EXPECT_EQ(User("submitter ada").priority(), -1);
  EXPECT_EQ(Status(bobs).priority(), 0) << "its own";
  ASSERT_TRUE(queue_->SetPriority(bobs, -7, "", kBob).ok());  // 3 against 4.
  EXPECT_EQ(LeaseOne(Solver("b")).study(), "adas");
}

TEST_F(Limits, AUsersStudiesShareItsLimitAndEachHasItsOwnTurn) {
  SetLimits("users: {submitter ada: {max_running: 3}}");
  IdOf(SubmitAs(kAda, {.name = "one", .seed = 1, .pairs = 20, .priority = 1}));
  const StudyId two = IdOf(SubmitAs(kAda, {.name = "two", .seed = 2, .pairs = 20}));
  const StudyId bobs = IdOf(SubmitAs(kBob, {.name = "bobs", .seed = 3, .pairs = 20}));
  EXPECT_THAT(Lease(AnyWorker("w"), 10), SizeIs(10));
  EXPECT_EQ(User("submitter ada").running(), 3);
  EXPECT_EQ(User("submitter ada").max_running(), 3);
  EXPECT_EQ(User("submitter ada").rule(), "submitter ada");
  EXPECT_EQ(User("submitter bob").max_running(), 0);
  EXPECT_EQ(Jobs(bobs, "solve", "LEASED"), 7);
  EXPECT_EQ(Status(two).at_limit(), "max_running 3 of submitter ada");
  // The one that waits behind the other's priority ages, and has its turn.
  EXPECT_EQ(Jobs(two, "solve", "LEASED"), 0);
  ASSERT_TRUE(queue_->WorkerLost("w").ok());
  clock_.Advance(2 * kAgeingStepS);
  Lease(AnyWorker("w"), 10);
  EXPECT_GE(Jobs(two, "solve", "LEASED"), 1);
  EXPECT_EQ(User("submitter ada").running(), 3);
}

TEST_F(Limits, SubmitRefusesWhatIsOverALimitAndNamesIt) {
  SetLimits(
      "default: {max_studies: 2}\n"
      "users:\n"
      "  submitter *: {max_waiting_pairs: 30}\n"
      "  local: {max_studies: 0}\n");
  const StudyId first = IdOf(SubmitAs(kAda, {.name = "one", .pairs = 20, .key = "one"}));
  const auto pairs = SubmitAs(kAda, {.name = "two", .seed = 2, .pairs = 11}).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(pairs));
  EXPECT_THAT(std::string(pairs.message()),
              HasSubstr("submitter ada has 20 pairs waiting, 11 more would be over the limit "
                        "max_waiting_pairs 30 that this farm's operator set for submitter *"));
  IdOf(SubmitAs(kAda, {.name = "two", .seed = 2, .pairs = 10}));
  const auto studies = SubmitAs(kAda, {.name = "three", .seed = 3, .pairs = 1}).status();
  EXPECT_THAT(std::string(studies.message()), HasSubstr("2 unfinished studies"));
  EXPECT_THAT(std::string(studies.message()), HasSubstr("max_studies 2"));
  // The first again is no new one, others have their own, and without a limit none exists.
  EXPECT_TRUE(SubmitAs(kAda, {.name = "one", .pairs = 20, .key = "one"})->existed());
  IdOf(SubmitAs(kBob, {.name = "bobs", .seed = 4, .pairs = 30}));
  for (int i = 0; i < 3; ++i) Submit({.name = "local", .seed = 5, .pairs = 100});
  EXPECT_EQ(User("submitter ada").studies(), 2);
  EXPECT_EQ(User("submitter ada").waiting_pairs(), 30);
  EXPECT_EQ(User("local").studies(), 3);
  // An end makes room.
  ASSERT_TRUE(queue_->Cancel(first, "", kAda).ok());
  const StudyId third = IdOf(SubmitAs(kAda, {.name = "three", .seed = 3, .pairs = 20}));
  // A finished study that is tried again is unfinished again.
  ASSERT_TRUE(queue_->Cancel(third, "", kAda).ok());
  EXPECT_THAT(AuditOf("limits"),
              ElementsAre("coordinator: default: max_studies 2; local: no limit; submitter *: "
                          "max_studies 2, max_waiting_pairs 30"));
  Reopen();
  EXPECT_THAT(AuditOf("limits"), SizeIs(1)) << "they are the same";
  SetLimits("");
  EXPECT_THAT(AuditOf("limits").front(), "coordinator: none");
}

TEST_F(Limits, AFailedStudyIsTriedAgainOnlyIfItsUserMayHaveAnother) {
  SetLimits("default: {max_studies: 1}");
  const StudyId failed = IdOf(SubmitAs(kAda, {.name = "fails", .pairs = 2}));
  Complete(SolveAnswer(LeaseOne(Solver("s")), "s"));
  Fail(Failure(LeaseOne(Renderer("r")), "r", "bang", /*retryable=*/false));
  // Its lost scene is replaced by others, until it gives up or is cancelled: it still counts.
  EXPECT_FALSE(SubmitAs(kAda, {.name = "other", .seed = 2}).ok());
  for (int i = 0; i < 200 && Status(failed).finished_unix_s() == 0; ++i) {
    for (const v1::Lease& lease : Lease(AnyWorker("w"), 8)) {
      Fail(Failure(lease, "w", "bang", /*retryable=*/false));
    }
  }
  ASSERT_GT(Status(failed).finished_unix_s(), 0);
  IdOf(SubmitAs(kAda, {.name = "other", .seed = 2}));
  const auto again = queue_->Retry(failed, kAda).status();
  EXPECT_THAT(std::string(again.message()), HasSubstr("max_studies 1"));
}

TEST_F(Limits, ACommandThatIsUndoneLeavesTheCountsAsTheyWere) {
  FailingCommand failing(options_);
  SetLimits("default: {max_running: 2}");
  const StudyId study = IdOf(SubmitAs(kAda, {.pairs = 40}, 2));
  failing.Set("lease", 2);  // The second lease of the call.
  EXPECT_FALSE(queue_->Lease(AnyWorker("w"), 2).ok());
  failing.Clear();
  EXPECT_EQ(Jobs(study, "solve", "LEASED"), 0);
  EXPECT_THAT(Lease(AnyWorker("w"), 9), SizeIs(2));
}

// Several workers at once, failures and losses among them: at no commit are there more than may be.
TEST_F(Limits, AThousandShortJobsNeverExceedThem) {
  constexpr int kStudyLimit = 3, kUserLimit = 5;
  SetLimits("users: {submitter ada: {max_running: 5}}");
  const StudyId one = IdOf(
      SubmitAs(kAda, {.name = "one", .seed = 1, .pairs = 360, .rigs_per_scene = 1}, kStudyLimit));
  const StudyId two =
      IdOf(SubmitAs(kAda, {.name = "two", .seed = 2, .pairs = 100, .rigs_per_scene = 1}));
  IdOf(SubmitAs(kBob, {.name = "bobs", .seed = 3, .pairs = 60, .rigs_per_scene = 1}));
  std::atomic<bool> over{false};
  std::atomic<int> done{0}, most_of_study{0}, most_of_user{0};
  std::thread watch([&] {
    while (!over) {
      const auto studies = queue_->ListStudies(10);
      ASSERT_TRUE(studies.ok()) << studies.status();
      int of_user = 0;
      for (const v1::StudyStatus& study : *studies) {
        int running = 0;
        for (const v1::VariantStatus& variant : study.variants()) {
          for (const char* kind : {"solve", "render"}) {
            running += static_cast<int>(JobsOf(variant, kind, "LEASED"));
          }
        }
        if (study.study_id() == one.value) most_of_study = std::max<int>(most_of_study, running);
        if (study.user() == "submitter ada") of_user += running;
      }
      most_of_user = std::max<int>(most_of_user, of_user);
    }
  });
  std::vector<std::thread> workers;
  for (int i = 0; i < 4; ++i) {
    workers.emplace_back([&, name = "w" + std::to_string(i)] {
      int idle = 0;
      for (int round = 0; idle < 2000; ++round) {
        const auto leases = queue_->Lease(AnyWorker(name), 4);
        ASSERT_TRUE(leases.ok()) << leases.status();
        idle = leases->empty() ? idle + 1 : 0;
        if (round % 17 == 16) {
          ASSERT_TRUE(queue_->WorkerLost(name).ok());
          continue;
        }
        for (const v1::Lease& lease : *leases) {
          const auto end = queue_->Complete(Answer(lease, name));
          ASSERT_TRUE(end.ok()) << end.status();
          done += *end == v1::REPORT_OUTCOME_OK ? 1 : 0;
        }
        if (Status(one).finished_unix_s() > 0 && Status(two).finished_unix_s() > 0) break;
      }
    });
  }
  for (std::thread& worker : workers) worker.join();
  over = true;
  watch.join();
  EXPECT_GE(done, 920) << "two jobs a pair";
  EXPECT_EQ(most_of_study, kStudyLimit);
  EXPECT_EQ(most_of_user, kUserLimit);
  EXPECT_EQ(Status(one).state(), v1::STUDY_STATE_SUCCEEDED);
  EXPECT_EQ(Status(two).state(), v1::STUDY_STATE_SUCCEEDED);
}

}  // namespace
}  // namespace parallax
