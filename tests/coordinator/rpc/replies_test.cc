// Replies that fit into a message, whatever the database holds.
#include <gmock/gmock.h>

#include <algorithm>

#include "common/base/names.h"
#include "coordinator/queue/database/compress.h"
#include "server_fixture.h"
#include "tests/sqlite_by_hand.h"

namespace parallax {
namespace {

class RepliesTest : public CoordinatorServerTest {
 protected:
  template <typename Method>
  absl::Status Call(Method method) {
    grpc::ClientContext context;
    SetRpcTimeout(context, std::chrono::seconds(60));
    return FromGrpc(method(context));
  }
  // Changes the closed database behind the queue's back. `bytes` is ?1.
  void Meddle(const std::string& sql, const std::string& bytes) {
    sqlite3* db = OpenByHand(dir_ + "/queue.db");
    ASSERT_NE(db, nullptr);
    sqlite3_stmt* statement = nullptr;
    EXPECT_EQ(sqlite3_prepare_v2(db, sql.c_str(), -1, &statement, nullptr), SQLITE_OK);
    sqlite3_bind_blob64(statement, 1, bytes.data(), bytes.size(), SQLITE_TRANSIENT);
    EXPECT_EQ(sqlite3_step(statement), SQLITE_DONE) << sqlite3_errmsg(db);
    sqlite3_finalize(statement);
    sqlite3_close(db);
  }
};

// A database may hold what an earlier version took.
TEST_F(RepliesTest, OversizeRowsOfAnOlderDatabaseAreCut) {
  StartCoordinator();
  const int64_t id = Submit(4, 2, {"only"});
  v1::StudySpec large;
  for (int i = 0; i < 40 * 1024; ++i) {
    large.add_variants()->mutable_config()->mutable_floating()->add_classes(std::string(1000, 'c'));
  }
  StopCoordinator();
  Meddle("UPDATE studies SET name = printf('%.*c', 5000, 'n'), paused = 1, spec_z = ?1",
         PackMessage(large));
  Meddle("DROP TRIGGER audit_is_final", "");
  Meddle("UPDATE audit SET actor = printf('%.*c', 9000, 'a'), detail = printf('%.*c', ?1, 'd')",
         std::to_string(30 << 20));
  Meddle("UPDATE jobs SET error = printf('%.*c', ?1, 'e')", std::to_string(30 << 20));
  StartCoordinator();

  const auto expect_cut = [](const std::string& text, size_t bytes) {
    EXPECT_EQ(text.size(), bytes);
    EXPECT_THAT(text, ::testing::EndsWith("..."));
  };
  v1::GetStudyRequest get;
  get.set_study_id(id);
  v1::StudyStatus study;
  absl::Status status = Call([&](auto& c) { return stub_->GetStudy(&c, get, &study); });
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_EQ(study.state(), v1::STUDY_STATE_PAUSED);
  EXPECT_EQ(study.variants_size(), 1);
  EXPECT_FALSE(study.has_spec()) << "it does not fit";
  expect_cut(study.name(), kMaxReasonBytes);
  v1::ListStudiesReply studies;
  status = Call([&](auto& c) { return stub_->ListStudies(&c, {}, &studies); });
  EXPECT_TRUE(status.ok()) << status;
  ASSERT_EQ(studies.studies_size(), 1);
  expect_cut(studies.studies(0).name(), kMaxReasonBytes);
  v1::ListAuditReply audit;
  status = Call([&](auto& c) { return stub_->ListAudit(&c, {}, &audit); });
  EXPECT_TRUE(status.ok()) << status;
  ASSERT_EQ(audit.entries_size(), 1);
  expect_cut(audit.entries(0).actor(), kMaxErrorBytes);
  EXPECT_LE(audit.entries(0).detail().size(), kMaxErrorBytes);
  v1::ListJobsRequest list;
  list.set_study_id(id);
  v1::ListJobsReply jobs;
  status = Call([&](auto& c) { return stub_->ListJobs(&c, list, &jobs); });
  EXPECT_TRUE(status.ok()) << status;
  ASSERT_EQ(jobs.jobs_size(), 2);
  expect_cut(jobs.jobs(0).error(), kMaxReasonBytes);
}

TEST_F(RepliesTest, ListsArePagedFromTheLastEntryOn) {
  StartCoordinator();
  for (int i = 0; i < 45; ++i) Submit(1, 1, {"v" + std::to_string(i)});
  std::vector<int64_t> ids;
  v1::ListStudiesRequest request;
  request.set_limit(30);
  for (int page = 0; page < 3; ++page) {
    v1::ListStudiesReply reply;
    ASSERT_TRUE(Call([&](auto& c) { return stub_->ListStudies(&c, request, &reply); }).ok());
    for (const v1::StudyStatus& study : reply.studies()) ids.push_back(study.study_id());
    EXPECT_EQ(reply.studies_size(), page == 0 ? 30 : page == 1 ? 15 : 0);
    request.set_before(ids.back());
  }
  ASSERT_EQ(ids.size(), 45u);
  EXPECT_TRUE(std::is_sorted(ids.rbegin(), ids.rend()));
}

}  // namespace
}  // namespace parallax
