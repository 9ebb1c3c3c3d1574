// The page's API as a browser sees it: what it tells, what it does, and for whom.
#include <fmt/core.h>
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "common/rpc/certificate.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/revocation.h"
#include "coordinator/http/api_json.h"
#include "parallax/v1/stream.grpc.pb.h"
#include "tests/coordinator/http/http_fixture.h"

namespace parallax {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

class ApiTest : public HttpTest {};

std::vector<std::string> Actions(const json& study) {
  return study["actions"].get<std::vector<std::string>>();
}

TEST_F(ApiTest, SubmittersSteerTheirOwnStudiesOnly) {
  const int64_t study = Submit({}, "submitter ada ipv4:10.0.0.7:4711");
  ServeTls();
  const std::string path = "/api/v1/studies/" + std::to_string(study);
  const auto ada = TlsClient("submitter-ada"), bert = TlsClient("submitter-bert"),
             olga = TlsClient("operator-olga");
  EXPECT_THAT(Actions(Json(*ada, path)),
              testing::ElementsAre("pause", "limit", "priority", "cancel", "comment"));
  EXPECT_THAT(Actions(Json(*bert, path)), testing::IsEmpty());
  EXPECT_THAT(Actions(Json(*TlsClient("read-only-board"), path)), testing::IsEmpty());
  EXPECT_EQ(Post(*bert, path + "/pause")->status, 403);
  EXPECT_EQ(queue_->GetStudy(StudyId{study})->state(), v1::STUDY_STATE_RUNNING);
  EXPECT_EQ(Post(*ada, path + "/pause", R"({"reason": "too warm"})")->status, 200);
  EXPECT_EQ(queue_->GetStudy(StudyId{study})->state(), v1::STUDY_STATE_PAUSED);
  EXPECT_EQ(Post(*olga, path + "/resume")->status, 200);
  const json entries = Json(*olga, "/api/v1/audit")["entries"];
  EXPECT_EQ(entries[1]["actor"], "submitter ada https:127.0.0.1");
  EXPECT_EQ(entries[1]["detail"], "too warm");
}

TEST_F(ApiTest, RevokedCertificatesAreStrangersAndSoAreTheirSessions) {
  ServeTls();
  const auto olga = TlsClient("operator-olga"), browser = TlsClient("");
  const json link = json::parse(Post(*olga, "/api/v1/links")->body);
  const auto entered =
      browser->Post("/api/v1/session", "{\"code\": \"" + link["code"].get<std::string>() + "\"}");
  ASSERT_EQ(entered->status, 200) << entered->body;
  const std::string cookie = entered->get_header_value("Set-Cookie");
  const Browser::Headers session = {{"Cookie", cookie.substr(0, cookie.find(';'))}};
  EXPECT_EQ(Json(*browser, "/api/v1/me", 200, session)["name"], "olga");

  const std::string pem = *ReadFile(Tls("operator-olga") + "/tls.crt");
  ASSERT_TRUE(
      WriteFile(Tls("server") + "/" + kRevokedFile, ReadCertificate(pem)->sha256 + "\n").ok());
  const auto until_refused = [&](const Browser& client, const Browser::Headers& headers) {
    for (int i = 0; i < 100; ++i) {
      if (client.Get("/api/v1/me", headers)->status == 401) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return false;
  };
  EXPECT_TRUE(until_refused(*TlsClient("operator-olga"), {}));
  EXPECT_EQ(browser->Get("/api/v1/me", session)->status, 401);
}

TEST_F(ApiTest, AStreamOfEventsEndsWhenItsCertificateIsRevoked) {
  ServeTls();
  const std::string pem = *ReadFile(Tls("read-only-board") + "/tls.crt");
  bool revoked = false;
  // The client gives up a stream that goes on, and then has no answer.
  const auto answer =
      TlsClient("read-only-board")->Get("/api/v1/events", {}, [&](std::string_view) {
        if (!revoked) {
          revoked =
              WriteFile(Tls("server") + "/" + kRevokedFile, ReadCertificate(pem)->sha256 + "\n")
                  .ok();
        }
        return true;
      });
  EXPECT_TRUE(revoked);
  ASSERT_TRUE(answer) << "the stream goes on";
  EXPECT_EQ(answer->status, 200);
}

TEST_F(ApiTest, TheListOfRevokedCertificatesMayBeElsewhere) {
  ServeTls();
  const auto olga = TlsClient("operator-olga");
  EXPECT_EQ(olga->Get("/api/v1/me")->status, 200);
  http_.reset();
  options_.revoked = dir_ + "/list";
  const std::string pem = *ReadFile(Tls("operator-olga") + "/tls.crt");
  ASSERT_TRUE(WriteFile(options_.revoked, ReadCertificate(pem)->sha256 + "\n").ok());
  Serve();
  EXPECT_EQ(TlsClient("operator-olga")->Get("/api/v1/me")->status, 401);
}

TEST_F(ApiTest, OnLoopbackAFarmWithCertificatesLetsThisMachineLookOnly) {
  const int64_t study = Submit();
  ServeTls();
  http_.reset();
  options_.listen = "127.0.0.1:0";
  Serve();
  const auto client = Client();
  const std::string path = "/api/v1/studies/" + std::to_string(study);
  EXPECT_EQ(Json(*client, "/api/v1/me")["role"], "read-only");
  EXPECT_THAT(Actions(Json(*client, path)), testing::IsEmpty());
  EXPECT_EQ(Post(*client, path + "/pause")->status, 403);
  EXPECT_EQ(client->Get("/api/v1/audit")->status, 403);
}

TEST_F(ApiTest, ChangesNeedTheCsrfHeaderAndOurOwnPage) {
  const int64_t study = Submit();
  Serve();
  const auto client = Client();
  const std::string path = "/api/v1/studies/" + std::to_string(study) + "/pause";
  EXPECT_EQ(client->Post(path, "{}")->status, 403);
  EXPECT_EQ(client->Post(path, "{}", {{"X-Parallax-Csrf", "guess"}})->status, 403);
  EXPECT_EQ(Post(*client, path, "{}", {{"Sec-Fetch-Site", "cross-site"}})->status, 403);
  EXPECT_EQ(client->Get(path)->status, 404) << "nothing changes by a GET";
  EXPECT_EQ(queue_->GetStudy(StudyId{study})->state(), v1::STUDY_STATE_RUNNING);
  EXPECT_EQ(Post(*client, path, "{}", {{"Sec-Fetch-Site", "same-origin"}})->status, 200);
  EXPECT_EQ(queue_->GetStudy(StudyId{study})->state(), v1::STUDY_STATE_PAUSED);
  EXPECT_EQ(Post(*client, path, "[1]")->status, 400);
  EXPECT_EQ(Post(*client, path, "{\"reason\": \"a\\u0007b\"}")->status, 400);
}

TEST_F(ApiTest, EveryAnswerCarriesThePolicy) {
  Serve();
  const auto client = Client();
  for (const char* path : {"/", "/js/app.js", "/api/v1/me", "/api/v1/studies/77"}) {
    const auto answer = client->Get(path);
    const std::string policy = answer->get_header_value("Content-Security-Policy");
    EXPECT_THAT(policy, HasSubstr("default-src 'none'; script-src 'self'; style-src 'self'"));
    EXPECT_EQ(policy.find("unsafe"), std::string::npos) << path;
  }
  const std::string etag = client->Get("/js/app.js")->get_header_value("ETag");
  EXPECT_EQ(client->Get("/js/app.js", {{"If-None-Match", etag}})->status, 304);
}

TEST_F(ApiTest, ByLinkOnlyOneBrowserComesInOnce) {
  options_.by_link_only = true;
  Serve();
  const auto client = Client();
  EXPECT_EQ(client->Get("/")->status, 200) << "the page's files are no secret";
  EXPECT_EQ(client->Get("/api/v1/farm")->status, 401);
  const std::string link = *http_->link_url();
  const std::string code = link.substr(link.find("#code=") + 6);
  const auto enter = [&](const std::string& body) { return client->Post("/api/v1/session", body); };
  EXPECT_EQ(enter(R"({"token": ""})")->status, 401);
  const auto entered = enter("{\"code\": \"" + code + "\"}");
  ASSERT_EQ(entered->status, 200) << entered->body;
  const std::string cookie = entered->get_header_value("Set-Cookie");
  EXPECT_THAT(cookie, HasSubstr("HttpOnly; SameSite=Strict"));
  EXPECT_THAT(cookie, testing::StartsWith("parallax_" + std::to_string(Port()) + "="));
  EXPECT_EQ(enter("{\"code\": \"" + code + "\"}")->status, 401) << "a link opens once";

  const Browser::Headers session = {{"Cookie", cookie.substr(0, cookie.find(';'))}};
  EXPECT_EQ(Json(*client, "/api/v1/me", 200, session)["role"], "operator");
  EXPECT_EQ(Post(*client, "/api/v1/links", "{}", session)->status, 403);
  EXPECT_EQ(Post(*client, "/api/v1/session/end", "{}", session)->status, 200);
  EXPECT_EQ(client->Get("/api/v1/me", session)->status, 401);
}

TEST_F(ApiTest, TheTokenOpensASessionThatLooks) {
  const int64_t study = Submit();
  ServeTls();
  std::string token = *ReadFile(Tls("server") + "/http.token");
  token.pop_back();  // The line's end.
  const auto client = TlsClient("");
  const auto entered = client->Post("/api/v1/session", "{\"token\": \"" + token + "\"}");
  ASSERT_EQ(entered->status, 200) << entered->body;
  const std::string cookie = entered->get_header_value("Set-Cookie");
  EXPECT_THAT(cookie, HasSubstr("; Secure"));
  const Browser::Headers session = {{"Cookie", cookie.substr(0, cookie.find(';'))}};
  const std::string path = "/api/v1/studies/" + std::to_string(study);
  EXPECT_EQ(Json(*client, "/api/v1/me", 200, session)["role"], "read-only");
  EXPECT_EQ(Json(*client, path, 200, session)["state"], "running");
  EXPECT_EQ(Post(*client, path + "/pause", "{}", session)->status, 403);
}

TEST_F(ApiTest, OperatorsDrainWorkersAndForgetStudies) {
  const int64_t study = Submit();
  Work();
  ServeTls();
  const auto olga = TlsClient("operator-olga"), ada = TlsClient("submitter-ada");
  const std::string order = R"({"pattern": "node-*", "reason": "new disks"})";
  EXPECT_EQ(Post(*ada, "/api/v1/workers/drain", order)->status, 403);
  EXPECT_EQ(Post(*olga, "/api/v1/workers/drain", R"({"pattern": "a b"})")->status, 400);
  EXPECT_EQ(Post(*olga, "/api/v1/workers/drain", order)->status, 200);
  const auto drains = queue_->Drains();
  ASSERT_EQ(drains->size(), 1u);
  EXPECT_EQ(drains->at(0).pattern(), "node-*");
  EXPECT_EQ(drains->at(0).actor(), "operator olga https:127.0.0.1");
  EXPECT_EQ(Post(*olga, "/api/v1/workers/undrain", order)->status, 200);
  EXPECT_TRUE(queue_->Drains()->empty());

  const std::string path = "/api/v1/studies/" + std::to_string(study);
  EXPECT_THAT(Actions(Json(*olga, path)), testing::ElementsAre("comment", "forget"));
  EXPECT_EQ(Post(*ada, path + "/forget")->status, 403);
  EXPECT_EQ(Post(*olga, path + "/forget")->status, 200);
  EXPECT_EQ(olga->Get(path)->status, 404);
}

// ---- What it tells
TEST_F(ApiTest, JobsComeInPagesThatMissNoneAndRepeatNone) {
  const int64_t study = Submit({.pairs = 24, .rigs_per_scene = 2, .variants = {"a", "b"}});
  Work(20);
  FailOne("bang", /*retryable=*/false);
  FailOne("boom", /*retryable=*/true);
  ASSERT_TRUE(queue_->Lease(AnyWorker("w1"), 3).ok());
  Serve();
  const auto client = Client();
  const std::string path = "/api/v1/studies/" + std::to_string(study) + "/jobs?limit=";
  for (const std::string state : {"", "&state=SUCCEEDED", "&state=READY"}) {
    const json whole = Json(*client, path + "1000" + state);
    EXPECT_TRUE(whole["next"].is_null());
    ASSERT_GT(whole["jobs"].size(), 5u) << state;
    json pages = json::array();
    std::string after;
    for (int page = 0; page < 200; ++page) {
      const json some = Json(*client, path + "4" + state + after);
      for (const json& job : some["jobs"]) pages.push_back(job);
      if (some["next"].is_null()) break;
      after = "&after=" + some["next"].get<std::string>();
    }
    EXPECT_EQ(pages, whole["jobs"]) << state;
  }
  for (const char* bad : {"&after=7", "&after=:7", "&after=READY:", "&after=READY:x",
                          "&after=READY:7x", "&after=NONE:7", "&state=READY&after=LEASED:1"}) {
    EXPECT_EQ(client->Get(path + "4" + bad)->status, 400) << bad;
  }
  EXPECT_EQ(client->Get(path + "4&after=READY:99999")->status, 404);
}

TEST_F(ApiTest, ASubmitterLimitsItsStudyAndAllSeeIt) {
  const int64_t study = Submit({.pairs = 40}, "submitter ada ipv4:10.0.0.7:4711");
  ServeTls();
  const std::string path = "/api/v1/studies/" + std::to_string(study);
  const auto ada = TlsClient("submitter-ada"), bert = TlsClient("submitter-bert");
  EXPECT_EQ(Post(*bert, path + "/limit", R"({"max_running": 2})")->status, 403);
  for (const char* bad : {"{}", R"({"max_running": -1})", R"({"max_running": 1.5})",
                          R"({"max_running": "2"})", R"({"max_running": 99999999999})", "[]"}) {
    EXPECT_EQ(Post(*ada, path + "/limit", bad)->status, 400) << bad;
  }
  EXPECT_EQ(Post(*ada, path + "/limit", R"({"max_running": 2, "reason": "room"})")->status, 200);
  EXPECT_EQ(queue_->Lease(AnyWorker("w"), 9)->size(), 2u);
  const json seen = Json(*bert, path);
  EXPECT_EQ(seen["max_running"], 2);
  EXPECT_EQ(seen["user"], "submitter ada");
  EXPECT_EQ(seen["at_limit"], "max_running 2");
  EXPECT_GT(seen["held_jobs"], 0);
  const json users = Json(*bert, "/api/v1/users")["users"];
  ASSERT_EQ(users.size(), 1u);
  EXPECT_EQ(users[0]["user"], "submitter ada");
  EXPECT_EQ(users[0]["running"], 2);
}

TEST_F(ApiTest, ASubmitterRanksItsStudyAndRetriesAJobOfIt) {
  const int64_t study = Submit({.pairs = 40}, "submitter ada ipv4:10.0.0.7:4711");
  ServeTls();
  const std::string path = "/api/v1/studies/" + std::to_string(study);
  const auto ada = TlsClient("submitter-ada"), bert = TlsClient("submitter-bert");
  EXPECT_EQ(Post(*bert, path + "/priority", R"({"priority": 2})")->status, 403);
  EXPECT_EQ(Post(*ada, path + "/priority", R"({"priority": 101})")->status, 403);
  for (const char* bad : {"{}", R"({"priority": -1001})", R"({"priority": 1.5})"}) {
    EXPECT_EQ(Post(*ada, path + "/priority", bad)->status, 400) << bad;
  }
  EXPECT_EQ(Post(*ada, path + "/priority", R"({"priority": -2, "reason": "later"})")->status, 200);
  EXPECT_EQ(Json(*bert, path)["priority"], -2);
  EXPECT_EQ(Post(*bert, path + "/comment", R"({"reason": "mine"})")->status, 403);
  EXPECT_EQ(Post(*ada, path + "/comment", "{}")->status, 400);
  EXPECT_EQ(Post(*ada, path + "/comment", R"({"reason": "for March"})")->status, 200);
  EXPECT_EQ(Json(*bert, path)["comments"][0]["text"], "for March");

  const v1::Lease lease = queue_->Lease(AnyWorker("w"), 1)->at(0);
  const std::string job = path + "/jobs/" + std::to_string(lease.attempt().job_id()) + "/retry";
  EXPECT_EQ(Post(*bert, job, "{}")->status, 403);
  EXPECT_EQ(Post(*ada, job, "{}")->status, 409) << "it runs";
  EXPECT_EQ(Post(*ada, path + "/jobs/4711/retry", "{}")->status, 404);
  v1::FailRequest failure;
  *failure.mutable_attempt() = lease.attempt();
  failure.set_worker("w");
  failure.set_error("boom");
  failure.set_retryable(true);
  ASSERT_TRUE(queue_->Fail(failure).ok());
  EXPECT_EQ(Post(*ada, job, "{}")->status, 200);
}

TEST_F(ApiTest, TheReasonOfARetryIsInTheAudit) {
  const std::string path = "/api/v1/studies/" + std::to_string(Submit());
  FailOne("bang", /*retryable=*/false);
  Serve();
  const auto client = Client();
  EXPECT_EQ(Post(*client, path + "/retry", R"({"reason": "the disk is new"})")->status, 200);
  const json entry = Json(*client, "/api/v1/audit")["entries"][0];
  EXPECT_EQ(entry["action"], "retry");
  EXPECT_THAT(entry["detail"].get<std::string>(), HasSubstr("the disk is new"));
}

TEST_F(ApiTest, TheHistoryGoesOnOverARestart) {
  const double now = Clock::System().UnixSeconds();
  queue_->KeepSample({.unix_s = now - 30 * 3600, .ready = 7});  // Not of this day.
  for (int minute = 200; minute > 2; --minute) {
    queue_->KeepSample({.unix_s = now - 60 * minute, .pairs_per_hour = 90, .ready = minute});
  }
  ASSERT_TRUE(queue_->Tick().ok());  // Behind them.
  Serve();
  const json history = Json(*Client(), "/api/v1/history");
  ASSERT_GE(history["ready"].size(), 198u);
  EXPECT_EQ(history["ready"][0], 200);
  EXPECT_EQ(history["pairs_per_hour"][197], 90);
  // Nothing is known yet of the pairs of an hour: a gap, and no fall to 0.
  EXPECT_EQ(history["ready"].size(), 198u);
}

TEST_F(ApiTest, TellsOfAFarmAtWork) {
  const int64_t study = Submit({.name = "odd", .pairs = 4, .variants = {"narrow", "wide"}});
  Work();
  Serve();
  const auto client = Client();
  const json farm = Json(*client, "/api/v1/farm");
  EXPECT_EQ(farm["pairs"]["done"], 8);
  EXPECT_EQ(farm["studies"][0]["name"], "odd");
  EXPECT_EQ(farm["studies"][0]["state"], "succeeded");
  EXPECT_EQ(Json(*client, "/api/v1/studies")["studies"][0]["study_id"], study);
  EXPECT_EQ(Json(*client, "/api/v1/history")["unix_s"].size(), 1u);
  EXPECT_EQ(Json(*client, "/api/v1/workers")["workers"].size(), 0u);
  const json one = Json(*client, "/api/v1/studies/" + std::to_string(study));
  EXPECT_EQ(one["variants"][1]["name"], "wide");
  EXPECT_EQ(one["variants"][1]["pairs_done"], 4);
  EXPECT_EQ(one["variants"][0]["render_jobs"]["succeeded"], 2);
  EXPECT_THAT(Actions(one), testing::ElementsAre("comment", "forget"))
      << "nothing else is left to do";
  EXPECT_EQ(client->Get("/api/v1/studies/77")->status, 404);
  EXPECT_EQ(client->Get("/api/v1/studies?limit=0")->status, 400);
  EXPECT_EQ(client->Get("/api/v1/studies/99999999999999999999")->status, 400);
}

TEST_F(ApiTest, TheWallHasTheNewestPairsFirstAndGoesOn) {
  const int64_t study = Submit({.pairs = 6, .variants = {"narrow", "wide"}});
  Work();
  Serve();
  const auto client = Client();
  const std::string path = "/api/v1/studies/" + std::to_string(study) + "/pairs";
  std::vector<int64_t> numbers;
  std::string before;
  for (int page = 0; page < 4; ++page) {
    const json listed = Json(*client, path + "?limit=5" + before)["pairs"];
    for (const json& pair : listed) {
      numbers.push_back(pair["id"]);
    }
    before = "&before=" + std::to_string(numbers.back());
  }
  EXPECT_EQ(numbers.size(), 12u);
  EXPECT_TRUE(std::is_sorted(numbers.rbegin(), numbers.rend()));

  const json wide = Json(*client, path + "?variant=wide&limit=4")["pairs"];
  ASSERT_EQ(wide.size(), 4u);
  EXPECT_EQ(wide[0]["scene"], 2);
  EXPECT_EQ(wide[0]["rig"], 1);
  const json rest = Json(
      *client, path + "?variant=wide&before=" + std::to_string(wide[3]["id"].get<int>()))["pairs"];
  ASSERT_EQ(rest.size(), 2u);
  EXPECT_EQ(rest[0]["scene"], 0);
  EXPECT_EQ(client->Get(path + "?variant=none")->status, 404);
}

TEST_F(ApiTest, DemandLeavesOutPausedStudiesHoweverManyAreNewer) {
  ASSERT_TRUE(queue_->Pause(StudyId{Submit()}, "", "tester").ok());
  for (int i = 0; i < 50; ++i) {
    const StudyId newer{Submit({.name = "newer"})};
    ASSERT_TRUE(queue_->Cancel(newer, "", "tester").ok());
  }
  Serve();
  EXPECT_THAT(Client()->Get("/metrics")->body,
              testing::HasSubstr("parallax_demand_slots{kind=\"solve\"} 0\n"));
}

TEST_F(ApiTest, APairHasPicturesMapsAndItsRecipe) {
  const int64_t study = Submit();
  Work();
  Serve();
  const auto client = Client();
  const json newest = Json(*client, "/api/v1/studies/" + std::to_string(study) + "/pairs")["pairs"];
  const std::string path = "/api/v1/pairs/" + std::to_string(newest[1]["id"].get<int>());
  const json pair = Json(*client, path);
  EXPECT_EQ(pair["newer"], newest[0]["id"]);
  EXPECT_EQ(pair["older"], newest[2]["id"]);
  EXPECT_EQ(pair["study_id"], study);
  const auto picture = client->Get(path + "/picture/left?width=64");
  EXPECT_EQ(picture->get_header_value("Content-Type"), "image/jpeg");
  EXPECT_EQ(picture->body.substr(0, 2), "\xff\xd8");
  // Another pair may get this number, after its study was forgotten.
  EXPECT_EQ(picture->get_header_value("Cache-Control"), "private, no-cache");
  const std::string etag = picture->get_header_value("ETag");
  const auto same = client->Get(path + "/picture/left?width=64", {{"If-None-Match", etag}});
  EXPECT_EQ(same->status, 304);
  EXPECT_EQ(same->body, "");
  const auto other = client->Get("/api/v1/pairs/" + newest[0]["id"].dump() + "/picture/left",
                                 {{"If-None-Match", etag}});
  EXPECT_EQ(other->status, 200) << "another pair has another tag";
  EXPECT_EQ(client->Get(path + "/map/disparity_left")->body.size(), 8u + 4u * kWidth * kHeight);
  EXPECT_EQ(Json(*client, path + "/frame")["rig"], 0);
  EXPECT_TRUE(Json(*client, path + "/recipe").contains("rigs"));
  for (const char* absent : {"/map/nonsense_left", "/map/frame_left", "/picture/middle",
                             "/picture/left?width=1", "/map/..%2f..%2fqueue_left"}) {
    EXPECT_GE(client->Get(path + absent)->status, 400) << absent;
  }
  EXPECT_EQ(client->Get("/api/v1/pairs/999")->status, 404);
  for (const char* list : {"", "/pairs", "/jobs", "/scores"}) {
    EXPECT_EQ(client->Get(std::string("/api/v1/studies/9999") + list)->status, 404) << list;
  }
}

TEST_F(ApiTest, AFailedJobShowsItsAttemptsAndTheirLogs) {
  const int64_t study = Submit();
  const int64_t job = FailOne("mesh-has-no-faces", true);
  Serve();
  const auto client = Client();
  const std::string path = "/api/v1/jobs/" + std::to_string(job);
  const json shown = Json(*client, path);
  EXPECT_EQ(shown["state"], "RETRY_WAIT");
  EXPECT_EQ(shown["study_id"], study);
  EXPECT_EQ(shown["app_failures"], 1);
  ASSERT_EQ(shown["lost_attempts"].size(), 1u);
  EXPECT_EQ(shown["lost_attempts"][0]["end"], "app");
  EXPECT_EQ(shown["lost_attempts"][0]["worker"], "w2");
  EXPECT_EQ(shown["lost_attempts"][0]["has_log"], true);
  EXPECT_THAT(Json(*client, path + "/log")["attempts"][0]["log"].get<std::string>(),
              HasSubstr("mesh-has-no-faces happened"));
  const json jobs =
      Json(*client, "/api/v1/studies/" + std::to_string(study) + "/jobs?state=RETRY_WAIT")["jobs"];
  ASSERT_EQ(jobs.size(), 1u);
  EXPECT_EQ(jobs[0]["id"], job);
  EXPECT_EQ(client->Get("/api/v1/studies/1/jobs?state=NONSENSE")->status, 400);
  EXPECT_EQ(client->Get("/api/v1/jobs/999")->status, 404);
}

TEST_F(ApiTest, AFinishedRenderShowsItsPairs) {
  Submit();
  Work();
  Serve();
  const auto client = Client();
  for (int64_t id = 1; id <= 4; ++id) {
    const json job = Json(*client, "/api/v1/jobs/" + std::to_string(id));
    EXPECT_EQ(job["pairs"].size(), job["kind"] == "render" ? 2u : 0u) << job;
  }
}

TEST_F(ApiTest, ProblemsAreGroupedByTheirCause) {
  const int64_t study = Submit({.pairs = 8});
  FailOne("no-faces", false);
  FailOne("no-faces", false);
  FailOne("out-of-memory", true);
  Serve();
  const json causes = Json(*Client(), "/api/v1/studies/" + std::to_string(study))["causes"];
  ASSERT_EQ(causes.size(), 2u) << causes;
  EXPECT_EQ(causes[0]["fingerprint"], "no-faces");
  EXPECT_EQ(causes[0]["jobs"], 2);
  EXPECT_EQ(causes[0]["examples"].size(), 2u);
  EXPECT_EQ(causes[1]["states"]["RETRY_WAIT"], 1);
}

StudyScore ScoreOf(const std::string& set, uint64_t seed, double value, int checkpoint = 2) {
  StudyScore score{.job_id = 7};
  score.score = {.set = set,
                 .predictor = set.empty() ? "sgbm" : "builtin",
                 .seed = seed,
                 .benchmark = "shipped",
                 .checkpoint = checkpoint,
                 .checkpoints = 2,
                 .metric = "bad-2 nocc",
                 .value = value,
                 .pairs = 48};
  return score;
}

TEST(ScoresJson, RowsAreMeansOfLastCheckpointsAndCurvesHaveAll) {
  const auto scores =
      ScoresJson({ScoreOf("narrow", 0, 14), ScoreOf("narrow", 1, 16), ScoreOf("narrow", 0, 30, 1),
                  ScoreOf("narrow", 1, 34, 1), ScoreOf("wide", 0, 8)});
  ASSERT_EQ(scores["rows"].size(), 2u);
  EXPECT_EQ(scores["rows"][0]["set"], "wide") << "the best comes first";
  EXPECT_DOUBLE_EQ(scores["rows"][1]["mean"], 15);
  EXPECT_NEAR(scores["rows"][1]["deviation"], 1.41421, 1e-4);
  EXPECT_EQ(scores["rows"][1]["seeds"].size(), 2u);
  ASSERT_EQ(scores["curves"][0]["points"].size(), 2u);
  EXPECT_DOUBLE_EQ(scores["curves"][0]["points"][0]["share"], 0.5);
  EXPECT_DOUBLE_EQ(scores["curves"][0]["points"][0]["value"], 32);
}

TEST_F(ApiTest, EventsTellOfChangesAndEndWithTheServer) {
  Submit({.name = "streamed"});
  Serve();
  std::string heard;
  std::mutex mu;
  std::condition_variable changed;
  std::thread listening([&] {
    Client()->Get("/api/v1/events", {}, [&](std::string_view piece) {
      std::lock_guard lock(mu);
      heard.append(piece);
      changed.notify_all();
      return true;
    });
  });
  const auto wait_for = [&](const std::string& text) {
    std::unique_lock lock(mu);
    return changed.wait_for(lock, std::chrono::seconds(20),
                            [&] { return heard.find(text) != std::string::npos; });
  };
  EXPECT_TRUE(wait_for("event: farm\ndata: {"));
  EXPECT_TRUE(wait_for("streamed"));
  ASSERT_TRUE(queue_->Pause(StudyId{1}, "", "tester").ok());
  EXPECT_TRUE(wait_for("\"paused\""));
  http_->Stop();
  listening.join();
}

TEST_F(ApiTest, TheFarmShowsItsStreamsAndWhatTheyWaitFor) {
  Serve();
  const auto client = Client();
  EXPECT_EQ(Json(*client, "/api/v1/farm")["streams"], json::array());
  EXPECT_THAT(client->Get("/metrics")->body,
              HasSubstr("parallax_demand_slots{kind=\"solve\"} 0\n"));
  v1::OpenStreamRequest request;
  v1::StudySpec& study = *request.mutable_study();
  study.set_name("drive");
  study.set_seed(7);
  study.set_pairs(6);
  study.set_rigs_per_scene(3);
  study.mutable_stream()->set_chunk_pairs(6);
  study.add_variants()->set_name("rooms");
  study.mutable_variants(0)->mutable_config()->mutable_rigs()->set_count(3);
  const auto stub = v1::Streams::NewStub(*ConnectRpc(*ParseRpcAddress("unix:" + dir_ + "/s"), {}));
  grpc::ClientContext context;
  SetRpcTimeout(context, std::chrono::seconds(20));
  v1::StreamStatus status;
  const grpc::Status opened = stub->Open(&context, request, &status);
  ASSERT_TRUE(opened.ok()) << opened.error_message();
  // What the farm says of the stream once it waits for `wanted`.
  const auto waiting_for = [&](const std::string& wanted) {
    for (int look = 0; look < 100; ++look) {
      const json streams = Json(*client, "/api/v1/farm")["streams"];
      if (streams.size() == 1 && streams[0]["waits_for"] == wanted) return streams[0];
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    ADD_FAILURE() << "no stream waits for " << wanted;
    return json();
  };
  const json begun = waiting_for("pairs of chunk 0");
  EXPECT_EQ(begun["name"], "drive");
  EXPECT_EQ(begun["chunks_begun"], status.chunks_begun());
  EXPECT_EQ(begun["needs"], "");
  const int64_t chunk = queue_->ListStudies(10)->back().study_id();
  ASSERT_TRUE(queue_->Pause(StudyId{chunk}, "", "tester").ok());
  waiting_for(fmt::format("chunk 0 is paused: `parallax resume {}`", chunk));
  const std::string metrics = client->Get("/metrics")->body;
  EXPECT_THAT(metrics, HasSubstr("parallax_stream_needs_person{stream=\"drive\"} 1\n"));
  // The next chunks wait for workers: demand, from which a farm grows.
  EXPECT_THAT(metrics, testing::Not(HasSubstr("parallax_demand_slots{kind=\"solve\"} 0\n")));
}

}  // namespace
}  // namespace parallax
