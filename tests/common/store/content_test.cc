#include "common/store/content.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace parallax {
namespace {

using ::testing::HasSubstr;

const std::string kHash(64, 'a');

TEST(Content, AListReadsBackInOrderOfNames) {
  const std::string text =
      ContentListText({{"b/two words.png", 7, kHash}, {"a.png", 0, std::string(64, '1')}});
  const auto files = ParseContentList(text);
  ASSERT_TRUE(files.ok()) << files.status();
  ASSERT_EQ(files->size(), 2u);
  EXPECT_EQ((*files)[0].name, "a.png");
  EXPECT_EQ((*files)[1].name, "b/two words.png");
  EXPECT_EQ((*files)[1].size, 7);
  EXPECT_EQ((*files)[1].sha256, kHash);
  EXPECT_EQ(ContentListText(*files), text);
}

TEST(Content, ListsThatAreNoneSayWhere) {
  const std::string head = "parallax-content 1\n";
  const struct {
    std::string text, says;
  } cases[] = {
      {"", "names no file"},
      {"something else\n", "line 1: wanted is"},
      {head, "names no file"},
      {head + kHash + " 7 a", "line 2: it has no end"},
      {head + kHash + " 7\n", "line 2: wanted is a hash"},
      {head + std::string(64, 'G') + " 7 a\n", "line 2: wanted is a hash"},
      {head + kHash + " x a\n", "line 2: its size"},
      {head + kHash + " -1 a\n", "line 2: its size"},
      {head + kHash + " 7 ../a\n", "line 2: store path"},
      {head + kHash + " 7 /etc/passwd\n", "absolute"},
      {head + kHash + " 7 a\n" + kHash + " 7 a\n", "line 3: a is listed twice"},
      {head + kHash + " 99999999999 a\n", "allowed are 1073741824 a file"},
  };
  for (const auto& [text, says] : cases) {
    const auto files = ParseContentList(text);
    EXPECT_EQ(files.status().code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_THAT(std::string(ToStd(files.status().message())), HasSubstr(says));
  }
}

TEST(Content, FoldersHaveBounds) {
  std::vector<ContentFile> files(kMostContentFiles + 1, {"a", 1, kHash});
  EXPECT_FALSE(CheckContentSizes(files, "f").ok());
  files.resize(17);
  for (ContentFile& file : files) file.size = kMostContentFileBytes;
  const absl::Status status = CheckContentSizes(files, "my folder");
  EXPECT_THAT(std::string(ToStd(status.message())), HasSubstr("my folder: its files have more"));
  files.resize(16);
  EXPECT_TRUE(CheckContentSizes(files, "f").ok());
}

TEST(Content, ReferencesReadBackAndPathsAreNone) {
  const std::string text = ContentReferenceText({kHash, "srv/chairs"});
  EXPECT_EQ(text, "store:" + kHash + "/srv/chairs");
  const auto reference = FindContentReference(text);
  ASSERT_TRUE(reference.has_value());
  EXPECT_EQ(reference->sha256, kHash);
  EXPECT_EQ(reference->path, "srv/chairs");
  for (const std::string& other :
       {std::string("srv/chairs"), "store:" + kHash, "store:" + kHash + "/",
        "store:" + std::string(64, 'Z') + "/x", std::string("store:abc/x"), std::string()}) {
    EXPECT_FALSE(FindContentReference(other).has_value()) << other;
  }
  EXPECT_EQ(ContentPath(kHash), "content/aa/" + kHash);
  EXPECT_TRUE(IsBelowContent(ContentPath(kHash)));
  EXPECT_FALSE(IsBelowContent("contents/x"));
}

}  // namespace
}  // namespace parallax
