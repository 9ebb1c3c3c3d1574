// Studies that are forgotten: gone at once, their rows and files bit by bit, and nothing that
// another study uses with them.
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <set>

#include "train_fixture.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class Forget : public TrainQueueTest {
 protected:
  StudyId Finished(const StudyOptions& options) {
    const StudyId study = Submit(options);
    WorkOff(AnyWorker("w"));
    EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
    return study;
  }
  v1::ForgetReply Forgotten(StudyId study) {
    const auto had = queue_->Forget(study, "too old", "ada");
    EXPECT_TRUE(had.ok()) << had.status();
    return had.ok() ? *had : v1::ForgetReply();
  }
  // Removes rows until none is left, and audits the database after each step.
  void RemoveAll() {
    for (int i = 0; i < 12; ++i) {
      Tick();
      ExpectSound();
    }
    clock_.Advance(100);
  }
  // But for the notes and checkpoints of jobs that are done, which go before a study can be
  // forgotten.
  std::vector<std::string> Litter() {
    const auto paths = queue_->ListLitter(0, 10'000);
    EXPECT_TRUE(paths.ok()) << paths.status();
    std::vector<std::string> litter = paths.ok() ? *paths : std::vector<std::string>();
    std::erase_if(litter, [](const std::string& path) {
      return path.ends_with("/finished") || path.ends_with("/resume");
    });
    return litter;
  }
  std::set<std::string> Folders(StudyId study) {
    std::set<std::string> folders;
    for (const v1::PublishedFrame& frame : Frames(study)) folders.insert(frame.frame().path());
    return folders;
  }
  std::vector<int64_t> Listed() {
    std::vector<int64_t> ids;
    const auto studies = queue_->ListStudies(100);  // Outlives the loop over it.
    for (const v1::StudyStatus& study : *studies) ids.push_back(study.study_id());
    return ids;
  }
  // Rows of the tables that grow with a study.
  int64_t Rows() {
    queue_.reset();
    sqlite3* db = nullptr;
    EXPECT_EQ(sqlite3_open(options_.db_path.c_str(), &db), SQLITE_OK);
    int64_t rows = 0;
    for (const char* table : {"frames", "results", "scenes", "jobs", "archived_jobs", "variants",
                              "study_results", "job_counts", "taken_back", "waits", "kept_folders",
                              "attempt_losses", "archived_losses"}) {
      const std::string sql = std::string("SELECT count(*) FROM ") + table;
      sqlite3_stmt* statement = nullptr;
      EXPECT_EQ(sqlite3_prepare_v2(db, sql.c_str(), -1, &statement, nullptr), SQLITE_OK) << sql;
      EXPECT_EQ(sqlite3_step(statement), SQLITE_ROW);
      rows += sqlite3_column_int64(statement, 0);
      sqlite3_finalize(statement);
    }
    sqlite3_close(db);
    Reopen();
    return rows;
  }
};

TEST_F(Forget, OnlyAStudyAtItsEndCanBe) {
  const StudyId study = Submit({.pairs = 4, .rigs_per_scene = 2});
  const auto refused = queue_->Forget(study, "", "ada");
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("cancel it first"));
  EXPECT_EQ(queue_->Forget(StudyId{99}, "", "ada").status().code(), absl::StatusCode::kNotFound);
  ASSERT_TRUE(queue_->Cancel(study, "", "ada").ok());
  Forgotten(study);
  EXPECT_EQ(queue_->Forget(study, "", "ada").status().code(), absl::StatusCode::kNotFound);
}

TEST_F(Forget, ItIsGoneAtOnceAndItsRowsAndFilesFollow) {
  const StudyId stays = Finished({.name = "stays", .seed = 2, .pairs = 4, .rigs_per_scene = 2});
  const int64_t before = Rows();
  const StudyId study = Submit({.name = "goes", .pairs = 6, .rigs_per_scene = 2});
  EXPECT_EQ(Fail(Failure(LeaseOne(AnyWorker("w")), "w", "boom", false)), v1::REPORT_OUTCOME_OK);
  WorkOff(AnyWorker("w"));
  const std::set<std::string> folders = Folders(study);
  EXPECT_THAT(folders, SizeIs(6));
  const int64_t jobs = static_cast<int64_t>(ListJobs(study).size());

  const v1::ForgetReply had = Forgotten(study);
  EXPECT_EQ(had.pairs(), 6);
  EXPECT_EQ(had.jobs(), jobs);
  EXPECT_EQ(queue_->GetStudy(study).status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(Listed(), ElementsAre(stays.value));
  for (const absl::Status& status :
       {queue_->Pause(study, "", "ada"), queue_->Cancel(study, "", "ada"),
        queue_->Retry(study, "ada").status()}) {
    EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  }
  ExpectSound();
  // The newest job of all is needed for the next one's number.
  const StudyId next = Submit({.name = "next", .seed = 2, .pairs = 4, .rigs_per_scene = 2});
  RemoveAll();
  const std::vector<std::string> litter = Litter();
  EXPECT_EQ(std::set<std::string>(litter.begin(), litter.end()), folders);
  EXPECT_THAT(Frames(stays), SizeIs(4));
  EXPECT_EQ(State(next), v1::STUDY_STATE_SUCCEEDED) << "of what is there";
  Forgotten(next);
  const StudyId last = Submit({.name = "last", .seed = 9, .pairs = 1, .rigs_per_scene = 1});
  ASSERT_TRUE(queue_->Cancel(last, "", "ada").ok());
  RemoveAll();
  Forgotten(last);
  RemoveAll();
  EXPECT_LE(Rows(), before + 8) << "the last one's newest job, with its scene and variant";
  const auto audit = queue_->ListAudit({});
  ASSERT_TRUE(audit.ok());
  EXPECT_EQ(audit->front().action(), "forget");
  EXPECT_EQ(audit->front().detail(), "last: too old");
}

TEST_F(Forget, WhatAnotherStudyUsesStaysWhoeverMadeIt) {
  const StudyId maker = Finished({.name = "maker", .pairs = 4, .rigs_per_scene = 2});
  const StudyId user = Submit({.name = "user", .pairs = 6, .rigs_per_scene = 2});
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(Status(user).variants(0).frames_reused(), 4);
  const auto frames = Frames(user);
  Forgotten(maker);
  RemoveAll();
  EXPECT_THAT(Litter(), IsEmpty());
  ASSERT_THAT(Frames(user), SizeIs(6));
  for (size_t i = 0; i < 6; ++i)
    EXPECT_EQ(Frames(user)[i].frame().path(), frames[i].frame().path());
  // And is still found by what it is.
  const StudyId again = Submit({.name = "again", .pairs = 6, .rigs_per_scene = 2});
  EXPECT_THAT(Lease(AnyWorker("w"), 8), IsEmpty());
  EXPECT_EQ(State(again), v1::STUDY_STATE_SUCCEEDED);
  Forgotten(user);
  RemoveAll();
  EXPECT_THAT(Litter(), IsEmpty());
  Forgotten(again);
  Submit({.name = "other", .seed = 5, .pairs = 2, .rigs_per_scene = 2});
  RemoveAll();
  EXPECT_THAT(Litter(), SizeIs(6));
  const StudyId anew = Submit({.name = "anew", .pairs = 6, .rigs_per_scene = 2});
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(Status(anew).variants(0).frames_reused(), 0) << "none of it was there any more";
  EXPECT_EQ(Status(anew).variants(0).pairs_done(), 6);
}

TEST_F(Forget, ARunningStudyOfTheSameScenesGoesOn) {
  const StudyId ended = Finished({.name = "ended", .pairs = 2, .rigs_per_scene = 2});
  // Its two variants share the first one's rooms; neither is done.
  const StudyId runs =
      Submit({.name = "runs", .pairs = 6, .rigs_per_scene = 2, .variants = {"only", "wider"}});
  const auto held = Lease(AnyWorker("h"), 3);
  Forgotten(ended);
  RemoveAll();
  for (const v1::Lease& lease : held) {
    EXPECT_EQ(Complete(Answer(lease, "h")), v1::REPORT_OUTCOME_OK);
  }
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(State(runs), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(Forget, NetworksAndScoresGoWithIt) {
  const StudyId study = SubmitRequest(WithTrainings(MakeStudy({.pairs = 2})));
  WorkOff(AnyWorker("w"));
  TrainAll();
  EvaluateAll();
  ASSERT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
  const auto results = queue_->ListResults([&] {
    v1::ListResultsRequest request;
    request.set_study_id(study.value);
    return request;
  }());
  ASSERT_TRUE(results.ok()) << results.status();
  ASSERT_THAT(*results, SizeIs(5));
  EXPECT_EQ(Forgotten(study).results(), 5);
  Submit({.name = "other", .seed = 5, .pairs = 2, .rigs_per_scene = 2});
  RemoveAll();
  const std::vector<std::string> litter = Litter();
  for (const v1::JobResult& result : *results)
    EXPECT_THAT(litter, testing::Contains(result.path()));
  EXPECT_THAT(litter, SizeIs(5 + 2));
}

TEST_F(Forget, TheSameStudyIsANewOneAfterwards) {
  const StudyOptions options{.name = "study", .pairs = 4, .rigs_per_scene = 2, .key = "key"};
  const StudyId study = Finished(options);
  std::set<int64_t> jobs;
  for (const v1::JobStatus& job : ListJobs(study)) jobs.insert(job.job_id());
  Forgotten(study);
  RemoveAll();
  const StudyId again = Submit(options);
  EXPECT_GT(again.value, study.value);
  RemoveAll();
  WorkOff(AnyWorker("w"));
  EXPECT_EQ(State(again), v1::STUDY_STATE_SUCCEEDED);
  for (const v1::JobStatus& job : ListJobs(again)) EXPECT_EQ(jobs.count(job.job_id()), 0u);
}

// Kills a process at each step, and goes on with what it left.
TEST_F(Forget, AProcessKilledInTheMidstLosesNothingOfOthers) {
  const auto forget_in_child = [&](int step, StudyId study) {
    int taken = 0;
    options_.fail_point = [&](const std::string& command, int) {
      if ((command == "forget" || command == "tick") && ++taken == step) raise(SIGKILL);
      return absl::OkStatus();
    };
    const auto queue = JobQueue::Open(options_);
    if (!queue.ok()) _exit(3);
    if (!(*queue)->Forget(study, "", "ada").ok()) _exit(4);
    for (int i = 0; i < 10; ++i) {
      if (!(*queue)->Tick().ok()) _exit(5);
    }
    _exit(0);
  };
  int killed = 0;
  for (int step = 1;; step += 3) {
    ASSERT_LT(step, 1000);
    queue_.reset();
    for (const char* suffix : {"", "-wal", "-shm"}) {
      std::filesystem::remove(options_.db_path + suffix);
    }
    Reopen();
    const StudyId study = Finished({.name = "goes", .pairs = 4, .rigs_per_scene = 2});
    const StudyId stays = Finished({.name = "stays", .pairs = 2, .rigs_per_scene = 2});
    queue_.reset();
    const pid_t pid = fork();
    if (pid == 0) forget_in_child(step, study);
    int status = 0;
    ASSERT_EQ(waitpid(pid, &status, 0), pid);
    if (WIFEXITED(status)) {
      ASSERT_EQ(WEXITSTATUS(status), 0) << step;
      break;  // There is no such step.
    }
    ++killed;
    Reopen();
    ExpectSound();
    EXPECT_THAT(Frames(stays), SizeIs(2)) << step;
    if (queue_->GetStudy(study).ok()) Forgotten(study);
    RemoveAll();
    EXPECT_EQ(queue_->GetStudy(study).status().code(), absl::StatusCode::kNotFound) << step;
    EXPECT_THAT(Litter(), SizeIs(2)) << step << ": the pairs of the scene that only it has";
    EXPECT_THAT(Frames(stays), SizeIs(2)) << step;
  }
  EXPECT_GE(killed, 10);
}

}  // namespace
}  // namespace parallax
