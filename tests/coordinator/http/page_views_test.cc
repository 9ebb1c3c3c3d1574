// The page shows more than figures: reasons of waiting jobs, files as they are, normals, tables,
// and the log of a job that runs.
#include <algorithm>

#include "tests/coordinator/http/http_fixture.h"

namespace parallax {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class PageViewsTest : public HttpTest {
 protected:
  json FirstPair(Browser& client, int64_t study) {
    return Json(client, "/api/v1/studies/" + std::to_string(study) + "/pairs")["pairs"].at(0);
  }
};

TEST_F(PageViewsTest, ReadyJobsHaveTheirReasonInEveryView) {
  const int64_t study = Submit();
  Serve();
  const auto client = Client();
  const std::string path = "/api/v1/studies/" + std::to_string(study);
  for (const json& shown : {Json(*client, path), Json(*client, "/api/v1/studies")["studies"].at(0),
                            Json(*client, "/api/v1/farm")["studies"].at(0)}) {
    ASSERT_EQ(shown["waiting"].size(), 1u);
    EXPECT_EQ(shown["waiting"][0]["kind"], "solve");
    EXPECT_EQ(shown["waiting"][0]["reason"], "no_worker");
    EXPECT_EQ(shown["waiting"][0]["text"], "no worker is connected");
  }
  const json job = Json(*client, path + "/jobs")["jobs"].at(0);
  EXPECT_EQ(job["waits_reason"], "no_worker");
  EXPECT_EQ(Json(*client, "/api/v1/jobs/" + job["id"].dump())["waits_text"],
            "no worker is connected");
  EXPECT_THAT(client->Get("/metrics")->body,
              HasSubstr("parallax_jobs_waiting{kind=\"solve\",reason=\"no_worker\"}"));
}

TEST_F(PageViewsTest, FilesOfAPairComeAsTheyAre) {
  const int64_t study = Submit();
  Work();
  Serve();
  const auto client = Client();
  const json pair = FirstPair(*client, study);
  const std::string path = "/api/v1/pairs/" + pair["id"].dump();
  const std::string folder = Json(*client, path)["path"];
  for (const char* name : {"left.png", "disparity_left.exr", "frame.json"}) {
    const auto answer = client->Get(path + "/file/" + name);
    ASSERT_EQ(answer->status, 200) << name << ": " << answer->body;
    EXPECT_EQ(answer->body, *store_->Get(folder + "/" + name)) << name;
  }
  for (const char* name : {"nothing.png", "..%2fleft.png", "..%2f..%2f..%2fqueue.db"}) {
    EXPECT_EQ(client->Get(path + "/file/" + name)->status, 404) << name;
  }
}

TEST_F(PageViewsTest, NormalsAreAPicture) {
  v1::SubmitRequest request = MakeStudy();
  for (v1::VariantSpec& variant : *request.mutable_study()->mutable_variants()) {
    for (const char* map : {"disparity", "normals"}) {
      variant.mutable_config()->mutable_render()->add_maps(map);
    }
  }
  const int64_t study = queue_->Submit(request, "tester")->study_id();
  Work();
  Serve();
  const auto client = Client();
  const std::string path = "/api/v1/pairs/" + FirstPair(*client, study)["id"].dump();
  const std::string folder = Json(*client, path)["path"];
  ASSERT_TRUE(
      store_->Put(folder + "/normals_left.exr", *EncodeExrRgb(ImageF3(kWidth, kHeight, 1))).ok());
  const auto normals = client->Get(path + "/normals/left");
  ASSERT_EQ(normals->status, 200) << normals->body;
  EXPECT_EQ(normals->get_header_value("Content-Type"), "image/jpeg");
  EXPECT_EQ(normals->body.substr(0, 2), "\xff\xd8");
  EXPECT_EQ(client->Get(path + "/normals/middle")->status, 404);
}

TEST_F(PageViewsTest, AStudysTableIsWhatTheServerMakesOfIt) {
  const std::string path = "/api/v1/studies/" + std::to_string(Submit()) + "/table";
  Serve();
  EXPECT_EQ(Client()->Get(path)->status, 404) << "none is made";
  http_.reset();
  options_.table = [](int64_t study) { return "{\"text\": \"" + std::to_string(study) + "\"}\n"; };
  Serve();
  EXPECT_EQ(Json(*Client(), path)["text"], "1");
  EXPECT_EQ(Client()->Get("/api/v1/studies/99/table")->status, 404);
}

TEST_F(PageViewsTest, TheLogOfARunningJobGrowsWithItsHeartbeats) {
  Submit();
  const auto leases = queue_->Lease(AnyWorker("w1"), 1);
  ASSERT_EQ(leases->size(), 1u);
  v1::Progress progress;
  *progress.mutable_attempt() = leases->at(0).attempt();
  progress.set_fraction(0.5);
  progress.set_stage("layout");
  Serve();
  const auto client = Client();
  const std::string path =
      "/api/v1/jobs/" + std::to_string(leases->at(0).attempt().job_id()) + "/log";
  for (const std::string log : {"first", "first\nsecond"}) {
    progress.set_log_tail(log);
    EXPECT_TRUE(queue_->Heartbeat("w1", {progress}).empty());
    const json attempts = Json(*client, path)["attempts"];
    ASSERT_EQ(attempts.size(), 1u);
    EXPECT_EQ(attempts[0]["log"], log);
    EXPECT_EQ(attempts[0]["worker"], "w1");
    EXPECT_EQ(attempts[0]["unix_s"], nullptr);
  }
  EXPECT_EQ(Json(*client, path.substr(0, path.rfind('/')))["fraction"], 0.5);
}

}  // namespace
}  // namespace parallax
