// Reads the program's own source: what would make results differ from run to run stays out of it.
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>

#include "common/base/system/file.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

struct Rule {
  const char* pattern;
  const char* instead;
};

constexpr Rule kRules[] = {
    {R"(\b(s?rand|rand_r|drand48|random)\s*\()", "Rng"},
    {R"(\brandom_device\b|\bmt19937|\bdefault_random_engine\b)", "Rng"},
    {R"(\b(uniform_(int|real)|normal|bernoulli|discrete|poisson)_distribution\b)",
     "Rng: the library's distributions differ between compilers"},
    {R"(\bstd::(ranges::)?(shuffle|sample)\b)", "Rng::Shuffle"},
    {R"(\bsystem_clock\b|\bhigh_resolution_clock\b)", "Clock&"},
    // CPU time is a cost, not a time of day: its clocks are free.
    {R"(\bgettimeofday\s*\(|\bclock_gettime\s*\(\s*(?!CLOCK_(PROCESS|THREAD)_CPUTIME_ID)|\bstd::time\s*\(|[^\w.>:]time\s*\(\s*(NULL|nullptr|0)\s*\))",
     "Clock&"},
};

// "line 12: `rand(`: use Rng" for the first offence, "" when the text is clean. Comments don't
// count.
std::string FirstOffence(const std::string& text) {
  static const std::vector<std::regex> patterns = [] {
    std::vector<std::regex> all;
    for (const Rule& rule : kRules) all.emplace_back(rule.pattern, std::regex::optimize);
    return all;
  }();
  std::istringstream in(text);
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    line = line.substr(0, line.find("//"));
    // Regular expressions are slow: look closer only where a word of theirs stands.
    const auto holds = [&](const char* word) { return line.find(word) != std::string::npos; };
    if (!holds("rand") && !holds("mt19937") && !holds("default_") && !holds("_distribution") &&
        !holds("shuffle") && !holds("sample") && !holds("_clock") && !holds("time")) {
      continue;
    }
    for (size_t i = 0; i < patterns.size(); ++i) {
      std::smatch match;
      if (std::regex_search(line, match, patterns[i])) {
        return "line " + std::to_string(number) + ": `" + match.str() + "`: use " +
               kRules[i].instead;
      }
    }
  }
  return "";
}

TEST(SourceScan, KnowsWhatItLooksFor) {
  for (const char* bad :
       {"int x = rand();", "std::random_device d;", "std::mt19937_64 g;", "std::shuffle(a, b, g);",
        "std::uniform_int_distribution<int> d;", "std::chrono::system_clock::now();",
        "long t = time(nullptr);", "x = std::time(0);", "gettimeofday(&t, 0);",
        "clock_gettime(CLOCK_REALTIME, &t);"}) {
    EXPECT_NE(FirstOffence(bad), "") << bad;
  }
  for (const char* good : {"int operand(3);", "// rand() is bad", "steady_clock::now()",
                           "Draw(random)", "rng.Shuffle(items)", "TimeIt(0)", "step.time(0)",
                           "clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);"}) {
    EXPECT_EQ(FirstOffence(good), "") << good;
  }
}

TEST(SourceScan, RandomnessAndClocksComeOnlyFromCommonBase) {
  int files = 0;
  for (const char* part : {"common", "coordinator", "worker"}) {
    for (const auto& entry :
         fs::recursive_directory_iterator(fs::path(PARALLAX_SOURCE_DIR) / part)) {
      const std::string path = fs::relative(entry.path(), PARALLAX_SOURCE_DIR);
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cc") continue;
      if (path.rfind("common/base/", 0) == 0) continue;
      ++files;
      EXPECT_EQ(FirstOffence(*ReadFile(entry.path())), "") << path;
    }
  }
  EXPECT_GT(files, 10);
}

}  // namespace
}  // namespace parallax
