// A study's own receiver of notices: how a file names it, and where its address is not shown.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/system/file.h"
#include "common/config/check/notify_check.h"
#include "common/config/config.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

const char kNotifyStudy[] = "study: s\npairs: 4\nrigs_per_scene: 4\nvariants: [{name: a}]\n";
const char kUrl[] = "https://hooks.example.com/T0/secret";

std::string NotifyError(const std::string& more) {
  const auto study = ParseStudy(kNotifyStudy + more, "s.yaml");
  return study.ok() ? "" : std::string(study.status().message());
}

TEST(NotifyStudyTest, AnAddressAndItsEventsAreReadAndWritten) {
  const auto study = ParseStudy(
      kNotifyStudy + std::string("notify:\n  url: ") + kUrl + "\n  on: [failed, waits]\n",
      "s.yaml");
  ASSERT_TRUE(study.ok()) << study.status();
  EXPECT_EQ(study->notify().url(), kUrl);
  EXPECT_THAT(study->notify().on(), ElementsAre("failed", "waits"));
  auto again = ParseStudy(StudyToYaml(*study), "study.lock.yaml");
  ASSERT_TRUE(again.ok()) << again.status();
  again->set_source_yaml(study->source_yaml());
  EXPECT_EQ(again->SerializeAsString(), study->SerializeAsString());
}

TEST(NotifyStudyTest, WhatIsWrongIsNamedWithoutTheAddress) {
  EXPECT_THAT(NotifyError("notify: {on: [done]}\n"),
              HasSubstr("s.yaml:5: notify.url: missing, allowed is http://HOST/..."));
  const std::string bad = NotifyError("notify:\n  url: ftp://host/secret\n");
  EXPECT_THAT(bad, HasSubstr("s.yaml:6: notify.url: is no address, allowed is http://HOST/..."));
  EXPECT_THAT(bad, Not(HasSubstr("secret")));
  EXPECT_THAT(NotifyError("notify: {url: http:///x}\n"), HasSubstr("s.yaml:5: notify.url: is no"));
  EXPECT_THAT(NotifyError("notify: {url: \"http://host/\\x78\"}\n"),
              HasSubstr("s.yaml:5: notify.url: written with escapes"));
  EXPECT_THAT(NotifyError("notify:\n  url: http://host/\n  on: [doen]\n"),
              HasSubstr("s.yaml:7: notify.on[0]: \"doen\" is not known, did you mean done"));
  EXPECT_THAT(NotifyError("notify: {uri: http://host/}\n"), HasSubstr("did you mean url"));
  const auto endless = ParseStudy(
      "study: s\npairs: endless\nvariants: [{name: a}]\nnotify: {url: http://h/, on: [done]}\n",
      "s.yaml");
  EXPECT_THAT(std::string(endless.status().message()),
              HasSubstr("s.yaml:4: notify.on: only done, and an endless study never is"));
}

using NotifyFilesTest = FolderTest;

TEST_F(NotifyFilesTest, AStudyThatExtendsAnotherChangesItsEventsAlone) {
  const std::string base = kNotifyStudy + std::string("notify: {url: ") + kUrl + "}\n";
  ASSERT_TRUE(WriteFile(dir_ + "/base.yaml", base).ok());
  const auto study =
      ParseStudy("study: t\nextends: base.yaml\nnotify: {on: [failed]}\n", dir_ + "/t.yaml");
  ASSERT_TRUE(study.ok()) << study.status();
  EXPECT_EQ(study->notify().url(), kUrl);
  EXPECT_THAT(study->notify().on(), ElementsAre("failed"));
}

TEST(NotifyStudyTest, WhatOthersSeeHasItsHostOnly) {
  auto study = ParseStudy(
      kNotifyStudy + std::string("# To ") + kUrl + "\nnotify: {url: " + kUrl + "}\n", "s.yaml");
  ASSERT_TRUE(study.ok()) << study.status();
  EXPECT_EQ(TakeNotify(&*study).url(), kUrl);
  EXPECT_FALSE(study->has_notify());
  EXPECT_EQ(study->source_yaml(),
            kNotifyStudy + std::string("# To <hooks.example.com>\n"
                                       "notify: {url: <hooks.example.com>}\n"));
  EXPECT_THAT(NotifyError("notify: {url: <hooks.example.com>}\n"), HasSubstr("notify.url: is no"));
  auto silent = ParseStudy(kNotifyStudy, "s.yaml");
  EXPECT_FALSE(TakeNotify(&*silent).has_url());
  EXPECT_EQ(silent->source_yaml(), kNotifyStudy);
}

}  // namespace
}  // namespace parallax
