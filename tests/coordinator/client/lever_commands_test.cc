// A hand on a study or a job that is there: priority, comments, retries, the log of what runs; and
// coordinators and readers that go meanwhile.
#include <gmock/gmock.h>
#include <unistd.h>

#include "common/base/system/clock.h"
#include "tests/coordinator/client/command_test.h"

namespace parallax::client {
namespace {

using Json = nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

TEST_F(CommandTest, APriorityIsSetAndTold) {
  coordinator_.studies = {Baseline()};
  EXPECT_EQ(Run({"priority", "baseline", "10", "--reason", "deadline"}).out,
            "study 3 (baseline) has priority 10, it had 0\n");
  EXPECT_EQ(RunJson({"priority", "3", "-5"})["priority"], -5);
  EXPECT_EQ(RunJson({"status", "3"})["priority"], -5);
  EXPECT_THAT(Run({"status", "3"}).out, HasSubstr("\npriority -5\n"));
  for (const char* bad : {"1001", "-1001", "high", "1.5"}) {
    EXPECT_EQ(Run({"priority", "3", bad}).exit_code, kExitUsage) << bad;
  }
  EXPECT_EQ(Run({"priority", "3"}).exit_code, kExitUsage);
  EXPECT_EQ(RunJson({"priority", "3", "-010"})["priority"], -10) << "no octal number";
  EXPECT_THAT(coordinator_.orders,
              ElementsAre("priority 3 10 deadline", "priority 3 -5 ", "priority 3 -10 "));
  EXPECT_EQ(RunJson({"limits", "3", "--max-running", "012"})["max_running"], 12);
}

TEST_F(CommandTest, CommentsAreKeptWithTheStudy) {
  coordinator_.studies = {Baseline()};
  EXPECT_EQ(Run({"comment", "baseline", "keep until March"}).out,
            "study 3 (baseline) has 1 comment\n");
  const std::string text = Run({"status", "3"}).out;
  EXPECT_THAT(text, HasSubstr("\ncomment of submitter ada, 2027-01-15"));
  EXPECT_THAT(text, HasSubstr(": keep until March\n"));
  const Json json = RunJson({"comment", "3", "and more"})["comments"];
  ASSERT_EQ(json.size(), 2u);
  EXPECT_EQ(json[0]["text"], "keep until March");
  EXPECT_EQ(json[0]["actor"], "submitter ada ipv4:10.0.0.7:4711");
  EXPECT_EQ(json[0]["unix_s"], 1.8e9);
  EXPECT_EQ(Run({"comment", "3"}).exit_code, kExitUsage);
  EXPECT_THAT(coordinator_.orders, ElementsAre("comment 3", "comment 3"));
}

TEST_F(CommandTest, RetryCountsJobs) {
  coordinator_.studies = {Baseline()};
  EXPECT_THAT(Run({"retry", "3"}).out, HasSubstr("no failed jobs"));
  coordinator_.retried_jobs = 2;
  EXPECT_THAT(Run({"retry", "3"}).out, HasSubstr("2 jobs of study 3"));
  EXPECT_EQ(RunJson({"retry", "3", "--reason", "new driver"})["jobs"], 2);
  EXPECT_EQ(Run({"retry", "3", "--job", "17", "--reason", "x"}).out,
            "1 job of study 3 will be tried again\n");
  EXPECT_EQ(Run({"retry", "3", "--job", "0"}).exit_code, kExitUsage);
  EXPECT_THAT(coordinator_.orders,
              ElementsAre("retry 3 ", "retry 3 ", "retry 3 new driver", "retry 3 job 17 x"));
}

TEST_F(CommandTest, ALogIsFollowedUntilItsAttemptEnds) {
  v1::JobStatus& job = *coordinator_.attempts.mutable_job();
  job.set_job_id(17);
  job.set_kind("train");
  job.set_state("LEASED");
  v1::AttemptStatus& attempt = *coordinator_.attempts.add_attempts();
  attempt.mutable_attempt()->set_fence(7);
  attempt.set_worker("w1");
  const std::vector<std::string> tails = {"one\ntwo", "one\ntwo", "two\nthree", "nine\nten"};
  size_t looks = 0;
  coordinator_.on_list_attempts = [&](FakeCoordinator&) {
    // The first look finds it running; the log comes with the later ones.
    attempt.set_ending(looks <= tails.size() ? "running" : "failed");
    if (looks > 0 && looks <= tails.size()) attempt.set_log_tail(tails[looks - 1]);
    if (looks > tails.size()) {
      attempt.set_log_tail("one\ntwo\nthree\nfour\nnine\nten\nbang");
      attempt.set_error("INTERNAL: it burns");
      attempt.set_unix_s(Clock::System().UnixSeconds());
    }
    ++looks;
  };
  Outcome outcome = Run({"logs", "17", "--follow"});
  EXPECT_EQ(outcome.exit_code, kExitFailed);
  EXPECT_THAT(outcome.out,
              HasSubstr("one\ntwo\nthree\n...\nnine\nten\nbang\n\nfailed on w1, 0.0 s"));
  EXPECT_THAT(outcome.out, HasSubstr("INTERNAL: it burns\n"));
  // One that has ended is told as ever, with the same exit status.
  outcome = Run({"logs", "17", "--follow"});
  EXPECT_THAT(outcome.out, HasSubstr("job 17 (train"));
  EXPECT_EQ(outcome.exit_code, kExitFailed);
  EXPECT_EQ(Run({"logs", "17", "--follow", "--json"}).exit_code, kExitFailed);
  EXPECT_EQ(Run({"logs", "17"}).exit_code, kExitOk);

  looks = 0;
  attempt.clear_log_tail();
  coordinator_.on_list_attempts = [&](FakeCoordinator&) {
    attempt.set_ending(looks < 2 ? "running" : "succeeded");
    attempt.set_log_tail(looks < 2 ? "one" : "");
    ++looks;
  };
  outcome = Run({"logs", "17", "--follow", "--json"});
  EXPECT_EQ(outcome.exit_code, kExitOk);
  ASSERT_EQ(Lines(outcome.out), 2);
  const size_t end = outcome.out.find('\n');
  EXPECT_EQ(Json::parse(outcome.out.substr(0, end))["line"], "one");
  EXPECT_EQ(Json::parse(outcome.out.substr(end))["ending"], "succeeded");
  job.set_state("SUCCEEDED");
  EXPECT_EQ(Run({"logs", "17", "--follow"}).exit_code, kExitOk);
}

TEST_F(CommandTest, ACoordinatorThatStopsWhileItAnswersIsWaitedFor) {
  coordinator_.studies = {Baseline()};
  const grpc::Status stops(grpc::StatusCode::CANCELLED, "CANCELLED");
  int looks = 0;
  coordinator_.on_get_study = [&](FakeCoordinator& self) {
    self.study_status = ++looks == 2 ? stops : grpc::Status::OK;
    if (looks == 4) self.studies[0].set_state(v1::STUDY_STATE_SUCCEEDED);
  };
  Outcome outcome = Run({"watch", "3"});
  EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("note: the coordinator does not answer and is waited for"));
  coordinator_.on_get_study = [&](FakeCoordinator& self) { self.study_status = stops; };
  outcome = Run({"status", "3"});
  EXPECT_EQ(outcome.exit_code, kExitUnreachable);
  EXPECT_THAT(outcome.err, HasSubstr(" stopped before it had answered\n"));
}

TEST_F(CommandTest, WhatFollowsEndsWithItsReader) {
  coordinator_.studies = {Baseline()};
  coordinator_.attempts.mutable_job()->set_job_id(17);
  v1::AttemptStatus& attempt = *coordinator_.attempts.add_attempts();
  attempt.set_ending("running");
  int looks = 0;
  coordinator_.on_get_study = [&](FakeCoordinator& self) {
    if (++looks == 100) self.studies[0].set_state(v1::STUDY_STATE_SUCCEEDED);
  };
  coordinator_.on_list_attempts = [&](FakeCoordinator&) {
    attempt.set_log_tail("line " + std::to_string(++looks));
    if (looks >= 200) attempt.set_ending("succeeded");
  };
  for (std::vector<std::string> arguments :
       std::vector<std::vector<std::string>>{{"watch", "3"}, {"logs", "17", "--follow"}}) {
    arguments.insert(arguments.end(), {"--coordinator", coordinator_.address()});
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    close(ends[0]);
    std::ostringstream err;
    Environment environment;
    environment.out = Terminal::OnDescriptor(ends[1]);
    environment.err.stream = &err;
    environment.poll_s = 0.01;
    environment.plain_line_s = 0;
    EXPECT_EQ(RunClient(arguments, environment), kExitInterrupted) << arguments[0] << err.str();
    close(ends[1]);
  }
}

}  // namespace
}  // namespace parallax::client
