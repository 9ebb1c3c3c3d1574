#include "coordinator/client/preview/preview_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/coordinator/http/browser.h"

namespace parallax::client {
namespace {

using ::testing::HasSubstr;

class PreviewPageTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto page = PreviewPage::Start("127.0.0.1:0", "my <study>.yaml");
    ASSERT_TRUE(page.ok()) << page.status();
    page_ = *std::move(page);
    const std::string link = page_->link();
    site_ = link.substr(0, link.find('/', std::string("http://").size()));
    root_ = link.substr(site_.size());
  }
  Browser browser() const { return Browser(site_); }
  int StatusOf(const std::string& path, const Browser::Headers& headers = {}) const {
    const auto answer = browser().Get(path, headers);
    return answer ? answer->status : 0;
  }
  // Reads the stream of events until `enough` of what came.
  void ReadEvents(const std::function<bool(const std::string& all)>& enough) const {
    std::string all;
    browser().Get(root_ + "events", {}, [&](std::string_view bytes) {
      all += bytes;
      return !enough(all);
    });
    EXPECT_TRUE(enough(all)) << all;
  }

  std::unique_ptr<PreviewPage> page_;
  std::string site_, root_;
};

TEST_F(PreviewPageTest, OnlyTheLinkOpensIt) {
  EXPECT_GT(root_.size(), 30u);
  const auto page = browser().Get(root_);
  ASSERT_TRUE(page);
  EXPECT_EQ(page->status, 200);
  EXPECT_THAT(page->body, HasSubstr("/js/preview.js"));
  EXPECT_THAT(page->get_header_value("Content-Security-Policy"), HasSubstr("script-src 'self'"));
  EXPECT_EQ(StatusOf("/js/preview.js"), 200);
  EXPECT_EQ(StatusOf("/app.css"), 200);
  page_->Show("png");
  for (const char* path : {"/sheet.png", "/events", "/0123456789abcdef0123456789abcdef/sheet.png",
                           "/healthz", "/api/v1/farm"}) {
    EXPECT_EQ(StatusOf(path), 404) << path;
  }
  EXPECT_EQ(StatusOf(root_ + "other"), 404);
  EXPECT_EQ(StatusOf(root_, {{"Host", "evil.example:80"}}), 403);
}

TEST_F(PreviewPageTest, TheSheetComesOnceItIsMade) {
  EXPECT_EQ(StatusOf(root_ + "sheet.png"), 404);
  page_->Show("first");
  page_->Show("second");
  const auto sheet = browser().Get(root_ + "sheet.png?2");
  ASSERT_TRUE(sheet);
  EXPECT_EQ(sheet->body, "second");
  EXPECT_EQ(sheet->get_header_value("Content-Type"), "image/png");
  EXPECT_EQ(sheet->get_header_value("Cache-Control"), "no-store");
}

TEST_F(PreviewPageTest, EventsTellOfEachSheetAndError) {
  page_->Tell({.making = true, .text = "is made"});
  bool shown = false;
  ReadEvents([&](const std::string& all) {
    if (all.find("\"making\":true") == std::string::npos) return false;
    if (!shown) {
      shown = true;
      page_->Tell({.text = "mend it", .error = "s.yaml:3: pairs\nand more"});
      page_->Show("png");
    }
    return all.find("\"sheet\":1}") != std::string::npos;
  });
  ReadEvents([](const std::string& all) {
    const size_t begin = all.find("data: ");
    if (begin == std::string::npos || all.find("\n\n") == std::string::npos) return false;
    const auto json = nlohmann::json::parse(all.substr(begin + 6, all.find("\n\n") - begin - 6));
    EXPECT_EQ(json["file"], "my <study>.yaml");
    EXPECT_EQ(json["error"], "s.yaml:3: pairs\nand more");
    EXPECT_EQ(json["making"], false);
    EXPECT_EQ(json["sheet"], 1);
    return true;
  });
}

TEST_F(PreviewPageTest, AddressesThatOtherMachinesReachAreRefused) {
  for (const char* address : {"0.0.0.0:0", "192.168.1.1:8080", "unix:/tmp/x"}) {
    const auto page = PreviewPage::Start(address, "s.yaml");
    EXPECT_EQ(page.status().code(), absl::StatusCode::kInvalidArgument) << address;
    EXPECT_THAT(std::string(page.status().message()), HasSubstr("--page-listen: ")) << address;
  }
  EXPECT_FALSE(PreviewPage::Start("nonsense", "s.yaml").ok());
}

}  // namespace
}  // namespace parallax::client
