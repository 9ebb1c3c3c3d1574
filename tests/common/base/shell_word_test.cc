#include "common/base/shell_word.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace parallax {
namespace {

TEST(ShellWord, QuotesOnlyWhatAShellWouldNotTakeAsOneWord) {
  const struct {
    const char* text;
    const char* word;
  } cases[] = {
      {"rooms.yaml", "rooms.yaml"},
      {"/data/out-1/a_b.yaml", "/data/out-1/a_b.yaml"},
      {"unix:/run/c.sock", "unix:/run/c.sock"},
      {"stra\u00dfe.yaml", "stra\u00dfe.yaml"},
      {"my rooms.yaml", "'my rooms.yaml'"},
      {"it's.yaml", "'it'\\''s.yaml'"},
      {"$HOME/*;rm", "'$HOME/*;rm'"},
      {"~/rooms.yaml", "'~/rooms.yaml'"},
      {"a\x1b[1m", "'a\\x1b[1m'"},
      {"", "''"},
  };
  for (const auto& c : cases) EXPECT_EQ(ShellWord(c.text), c.word);
}

TEST(ShellWord, AShellReadsItAsTheTextThatItWas) {
  for (const std::string text :
       {"my rooms.yaml", "it's", "a\\b\"c`d`", "$(id)", "*", "#x", "a&b"}) {
    FILE* const shell = popen(("printf %s " + ShellWord(text)).c_str(), "r");
    ASSERT_NE(shell, nullptr);
    char read[64] = {};
    const size_t size = fread(read, 1, sizeof(read), shell);
    EXPECT_EQ(pclose(shell), 0);
    EXPECT_EQ(std::string(read, size), text);
  }
}

}  // namespace
}  // namespace parallax
