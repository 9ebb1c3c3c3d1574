#include "common/base/names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace parallax {
namespace {

using ::testing::HasSubstr;

TEST(Names, AreLettersDigitsDotsDashesAndNothingThatATerminalOrAPathActsOn) {
  for (const std::string& good :
       {std::string("w"), std::string("host-1.example-42"), std::string("GPU_box"),
        std::string("7"), std::string(100, 'x')}) {
    EXPECT_TRUE(IsName(good)) << good;
  }
  for (const std::string& bad :
       {std::string(), std::string(101, 'x'), std::string(".hidden"), std::string("-rf"),
        std::string("_x"), std::string("a b"), std::string("a/b"), std::string("../../etc/passwd"),
        std::string("a\x1b[31m"), std::string("a\0b", 3), std::string("a\nb"),
        std::string("a\u202eb"), std::string("\u00e9"), std::string("a\xff")}) {
    EXPECT_FALSE(IsName(bad)) << Printable(bad);
    EXPECT_FALSE(IsFolderName(bad)) << Printable(bad);
    const absl::Status status = CheckName("worker name", bad);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_TRUE(IsPlainText(ToStd(status.message()))) << status;
  }
  EXPECT_TRUE(IsFolderName("a-1_b"));
  EXPECT_TRUE(IsFolderName(std::string(64, 'x')));
  for (const char* bad : {"A", "a.b", "aB"}) EXPECT_FALSE(IsFolderName(bad)) << bad;
  EXPECT_FALSE(IsFolderName(std::string(65, 'x')));
}

TEST(Names, ReasonsAreOneLineOfPlainText) {
  for (const char* good :
       {"", "disk is full (node-7)", "zu gro\u00df", "\u8cc7\u6599", "a\u0301"}) {
    EXPECT_TRUE(CheckPlainText("reason", good, 100).ok()) << good;
  }
  for (const std::string& bad :
       {std::string("a\nb"), std::string("\x1b]0;title\a"), std::string("a\0", 2),
        std::string("\x7f"), std::string("\u0085"), std::string("\u2028"), std::string("\u200f"),
        std::string("\u2066"), std::string("\ufeff"), std::string("\xed\xa0\x80"),
        std::string("\xc0\xaf"), std::string("\xf4\x90\x80\x80"), std::string("\xe2\x82")}) {
    EXPECT_FALSE(CheckPlainText("reason", bad, 100).ok()) << Printable(bad);
  }
  const absl::Status status = CheckPlainText("reason", std::string(101, 'x'), 100);
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("reason has 101 bytes, allowed are at most"));
}

TEST(Printable, SpellsOutWhatATerminalActsOnAndKeepsTheRest) {
  const struct {
    std::string text;
    const char* want;
  } rows[] = {
      {"plain \u00e9 \u8cc7", "plain \u00e9 \u8cc7"},
      {"\x1b[2J", "\\x1b[2J"},
      {std::string("a\0b", 3), "a\\x00b"},
      {"a\nb\tc", "a\\nb\\tc"},
      {"\u202eabc", "\\u{202e}abc"},
      {"\u009b31m", "\\u{009b}31m"},
      {"\x9b", "\\x9b"},
      {"\xe2\x82", "\\xe2\\x82"},
  };
  for (const auto& row : rows) {
    EXPECT_EQ(Printable(row.text), row.want);
    EXPECT_TRUE(IsPlainText(Printable(row.text)));
  }
}

TEST(CutText, EndsBetweenCharactersAndMarksTheCut) {
  EXPECT_EQ(CutText("abc", 3), "abc");
  EXPECT_EQ(CutText("abcdefgh", 6), "abc...");
  EXPECT_EQ(CutText("\u00e9\u00e9\u00e9\u00e9", 6), "\u00e9...");
  EXPECT_EQ(CutText("abcdefgh", 2), "..");
  EXPECT_EQ(Quoted(std::string(70, 'x')), "\"" + std::string(60, 'x') + "...\"");
}

}  // namespace
}  // namespace parallax
