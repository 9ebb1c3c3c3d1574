// The service Searches: its calls, what it refuses, and that it goes on by itself.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "coordinator/search/rung_study.h"
#include "parallax/v1/search.grpc.pb.h"
#include "server_fixture.h"
#include "tests/coordinator/queue/train_fixture.h"
#include "tests/coordinator/search/search_study.h"

namespace parallax {
namespace {

using testing::HasSubstr;

class SearchesTest : public CoordinatorServerTest {
 protected:
  SearchesTest() {
    searches_ = v1::Searches::NewStub(*ConnectRpc(*ParseRpcAddress(address_), {}));
    // Trials are the better the later they come; with more seeds than one.
    options_.scorer = [this](const ScoreQuery& query) { return ScoresOf(query); };
    options_.check_outputs = false;
  }

  absl::StatusOr<std::vector<TrialScore>> ScoresOf(const ScoreQuery& query) {
    ASSIGN_OR_RETURN(const v1::StudyStatus study, queue_->GetStudy(StudyId{query.study}));
    std::vector<TrialScore> scores;
    for (const v1::VariantSpec& variant : study.spec().variants()) {
      TrialScore& score = scores.emplace_back();
      score.variant = variant.name();
      score.objective.set_value(20.0 - static_cast<double>(scores.size()));
      score.verdict = scores.size() == 1 ? "not significant" : "better";
    }
    return scores;
  }

  absl::StatusOr<v1::SearchStatus> Open(const v1::StudySpec& study) {
    grpc::ClientContext context;
    SetRpcTimeout(context, std::chrono::seconds(20));
    v1::OpenSearchRequest request;
    *request.mutable_study() = study;
    v1::SearchStatus status;
    RETURN_IF_ERROR(FromGrpc(searches_->Open(&context, request, &status)));
    return status;
  }
  absl::StatusOr<v1::ListSearchesReply> List(const std::string& name) {
    grpc::ClientContext context;
    SetRpcTimeout(context, std::chrono::seconds(20));
    v1::ListSearchesRequest request;
    request.set_name(name);
    v1::ListSearchesReply reply;
    RETURN_IF_ERROR(FromGrpc(searches_->List(&context, request, &reply)));
    return reply;
  }
  absl::StatusOr<v1::SearchStatus> Stop(const std::string& name, bool forget) {
    grpc::ClientContext context;
    SetRpcTimeout(context, std::chrono::seconds(20));
    v1::StopSearchRequest request;
    request.set_name(name);
    request.set_reason("a test");
    request.set_forget(forget);
    v1::SearchStatus status;
    RETURN_IF_ERROR(FromGrpc(searches_->Stop(&context, request, &status)));
    return status;
  }
  void WorkOff() {
    for (;;) {
      const auto leases = queue_->Lease(Everyman("w"), 8);
      ASSERT_TRUE(leases.ok());
      if (leases->empty()) return;
      for (const v1::Lease& lease : *leases) {
        ASSERT_TRUE(queue_->Complete(AnyAnswer(lease, "w")).ok());
      }
    }
  }

  std::unique_ptr<v1::Searches::Stub> searches_;
};

TEST_F(SearchesTest, ASearchGoesOnByItselfAndAfterARestart) {
  StartCoordinator();
  const auto opened = Open(SmallSearch());
  ASSERT_TRUE(opened.ok()) << opened.status();
  EXPECT_EQ(opened->state(), "running");
  EXPECT_EQ(opened->trials_size(), 9);
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  absl::StatusOr<v1::ListSearchesReply> now = List("recipe");
  bool restarted = false;
  while (now.ok() && now->searches(0).outcome().empty() &&
         std::chrono::steady_clock::now() < deadline) {
    WorkOff();
    if (now->searches(0).rung() == 1 && !restarted) {
      restarted = true;
      StopCoordinator();
      StartCoordinator();
    }
    now = List("recipe");
  }
  ASSERT_TRUE(now.ok()) << now.status();
  EXPECT_TRUE(restarted);
  EXPECT_EQ(now->searches(0).outcome(), "confirmed");
  EXPECT_EQ(now->searches(0).studies_size(), 4);
  EXPECT_EQ(List("")->searches(0).trials_size(), 0);
  ASSERT_TRUE(Stop("recipe", /*forget=*/true).ok());
  while (!absl::IsNotFound(List("recipe").status()) &&
         std::chrono::steady_clock::now() < deadline) {
    std::this_thread::yield();
  }
  EXPECT_EQ(queue_->ListStudies(10)->size(), 0u);
  ExpectEveryInvariant();
}

TEST_F(SearchesTest, WrongCallsAreRefusedByName) {
  StartCoordinator();
  EXPECT_THAT(std::string(List("recipe").status().message()),
              HasSubstr("search \"recipe\" is not known; `parallax search FILE` begins one"));
  EXPECT_TRUE(absl::IsNotFound(Stop("recipe", false).status()));
  v1::StudySpec study = SmallSearch();
  study.mutable_search()->set_trials(-3);
  EXPECT_THAT(std::string(Open(study).status().message()),
              HasSubstr("search.trials: -3 is out of range"));
  study = SmallSearch();
  study.mutable_search()->set_sampler("optuna");
  EXPECT_THAT(std::string(Open(study).status().message()),
              HasSubstr("search.sampler \"optuna\" is not known here; known are: sobol"));
  study.clear_search();
  EXPECT_THAT(std::string(Open(study).status().message()), HasSubstr("has no `search`"));
}

TEST_F(SearchesTest, ACoordinatorWithoutScoresSaysSo) {
  options_.scorer = nullptr;
  StartCoordinator();
  const absl::Status refused = Open(SmallSearch()).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), HasSubstr("reads no scores"));
}

}  // namespace
}  // namespace parallax
