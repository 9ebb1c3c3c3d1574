// Fixture of the page's tests: a queue with a store, a study that a worker has worked on, and the
// page in front of them.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "common/base/system/file.h"
#include "common/image/io.h"
#include "common/store/store.h"
#include "coordinator/http/http_server.h"
#include "coordinator/init.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/coordinator_server.h"
#include "tests/coordinator/http/browser.h"
#include "tests/coordinator/queue/queue_fixture.h"
#include "tests/folder_test.h"

namespace parallax {

class HttpTest : public FolderTest {
 public:
  static constexpr int kWidth = 64, kHeight = 36;

  HttpTest() {
    JobQueueOptions queue;
    queue.db_path = dir_ + "/queue.db";
    queue.retry.backoff_min_s = 100;
    queue_ = *JobQueue::Open(queue);
    store_ = *OpenStore(dir_ + "/store");
    server_ = *CoordinatorServer::Start(
        {.listen = {"unix:" + dir_ + "/s"}, .store_uri = store_->Uri()}, *queue_);
    options_.listen = "127.0.0.1:0";
    options_.store_uri = store_->Uri();
    options_.store = store_.get();
    options_.db_path = queue.db_path;
  }
  ~HttpTest() override {
    http_.reset();
    server_.reset();
    queue_.reset();
  }

  void Serve() {
    auto http = HttpServer::Start(options_, *queue_, *server_);
    ASSERT_TRUE(http.ok()) << http.status();
    http_ = *std::move(http);
  }
  // With certificates for worker pool, submitters ada and bert, operator olga, read-only board.
  void ServeTls() {
    std::ostringstream said;
    ASSERT_TRUE(InitFarm({.dir = dir_ + "/tls",
                          .issue = {{"worker", "pool"},
                                    {"submitter", "ada"},
                                    {"submitter", "bert"},
                                    {"operator", "olga"},
                                    {"read-only", "board"}}},
                         Clock::System(), said)
                    .ok());
    options_.listen = "0.0.0.0:0";
    options_.security = *MakeRpcSecurity(false, Tls("server"), Clock::System());
    Serve();
  }
  std::string Tls(const std::string& party) const { return dir_ + "/tls/" + party; }
  int Port() const {
    const std::string address = http_->address();
    return std::stoi(address.substr(address.rfind(':') + 1));
  }

  std::unique_ptr<Browser> Client() const {
    return std::make_unique<Browser>("http://127.0.0.1:" + std::to_string(Port()));
  }
  // Empty: a stranger.
  std::unique_ptr<Browser> TlsClient(const std::string& party) const {
    HttpFarm farm{.ca_file = Tls("server") + "/ca.crt"};
    if (!party.empty()) {
      farm.certificate_file = Tls(party) + "/tls.crt";
      farm.key_file = Tls(party) + "/tls.key";
    }
    return std::make_unique<Browser>("https://127.0.0.1:" + std::to_string(Port()), farm);
  }

  static nlohmann::json Json(const Browser& client, const std::string& path, int status = 200,
                             const Browser::Headers& headers = {}) {
    const auto answer = client.Get(path, headers);
    EXPECT_TRUE(answer) << path;
    if (!answer) return {};
    EXPECT_EQ(answer->status, status) << path << ": " << answer->body;
    return nlohmann::json::parse(answer->body, nullptr, false);
  }
  // Posts as the page does, with the CSRF header from /api/v1/me.
  static Browser::Result Post(const Browser& client, const std::string& path,
                              const std::string& body = "{}", Browser::Headers headers = {}) {
    const auto me = client.Get("/api/v1/me", headers);
    const nlohmann::json json = nlohmann::json::parse(me ? me->body : "", nullptr, false);
    if (json.is_object()) headers.emplace("X-Parallax-Csrf", json.value("csrf", std::string()));
    return client.Post(path, body, headers);
  }

  int64_t Submit(const StudyOptions& options = {}, const std::string& actor = "tester") {
    v1::SubmitRequest request = MakeStudy(options);
    for (v1::VariantSpec& variant : *request.mutable_study()->mutable_variants()) {
      variant.mutable_config()->mutable_render()->add_maps("disparity");
    }
    return queue_->Submit(request, actor)->study_id();
  }
  // Ends `jobs` jobs as a worker would, with pictures in the store.
  void Work(int jobs = 1000) {
    for (; jobs > 0; --jobs) {
      const auto leases = queue_->Lease(AnyWorker("w1"), 1);
      ASSERT_TRUE(leases.ok()) << leases.status();
      if (leases->empty()) return;
      const v1::CompleteRequest answer = Answer(leases->front(), "w1");
      const v1::RenderResult made =
          leases->front().kind() == "render" ? RenderOf(answer) : v1::RenderResult();
      for (const v1::FrameResult& frame : made.frames()) PutPictures(frame.path());
      ASSERT_TRUE(queue_->Complete(answer).ok());
    }
  }
  // A worker fails the next job, and its log says so.
  int64_t FailOne(const std::string& fingerprint, bool retryable) {
    const auto leases = queue_->Lease(AnyWorker("w2"), 1);
    v1::FailRequest failure = Failure(leases->at(0), "w2", fingerprint, retryable);
    failure.set_log_tail("first line\n" + fingerprint + " happened\n");
    EXPECT_TRUE(queue_->Fail(failure).ok());
    return leases->at(0).attempt().job_id();
  }

  void PutPictures(const std::string& folder) {
    ImageRgb8 left(kWidth, kHeight, 40);
    for (int y = 0; y < kHeight; ++y) {
      for (int c = 0; c < 3; ++c) left(kWidth / 2, y, c) = 250;
    }
    ImageF disparity(kWidth, kHeight, 7.25f);
    disparity(3, 2) = 0;
    ASSERT_TRUE(store_->Put(folder + "/left.png", *EncodePng(left)).ok());
    ASSERT_TRUE(store_->Put(folder + "/right.png", *EncodePng(left)).ok());
    ASSERT_TRUE(store_->Put(folder + "/disparity_left.exr", *EncodeExrY(disparity)).ok());
    ASSERT_TRUE(
        store_->Put(folder + "/masks_left.png", *EncodePng(ImageU8(kWidth, kHeight, 5))).ok());
    ASSERT_TRUE(store_->Put(folder + "/frame.json", "{\"rig\": 0}\n").ok());
  }

  std::unique_ptr<JobQueue> queue_;
  std::unique_ptr<Store> store_;
  std::unique_ptr<CoordinatorServer> server_;
  HttpServerOptions options_;
  std::unique_ptr<HttpServer> http_;
};

}  // namespace parallax
