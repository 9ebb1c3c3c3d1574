// The registry of kinds, and that nothing but a kind's own files knows its name.
#include <filesystem>
#include <regex>

#include "common/base/system/file.h"
#include "coordinator/queue/job_kind.h"
#include "queue_fixture.h"
#include "tests/noop/noop_kind.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

// Names of kinds that are words of study files, commands and stages too: they name a kind where the
// line speaks of kinds.
bool IsWord(const std::string& name) { return name == "train" || name == "evaluate"; }

// "line 12: \"render\"" for the first, "" without. Comments don't count.
std::string FirstKindIn(const std::string& text) {
  static const std::regex* pattern = [] {
    std::string names;
    for (const std::string& name : KindRegistry::Builtin().Names()) {
      names += (names.empty() ? "" : "|") + name;
    }
    return new std::regex("[\"'](" + names + ")[\"']");
  }();
  std::istringstream in(text);
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    line = line.substr(0, line.find("//"));
    std::smatch match;
    static const std::regex kOfKinds("kind", std::regex::icase);
    if (std::regex_search(line, match, *pattern) &&
        (!IsWord(match[1]) || std::regex_search(line, kOfKinds))) {
      return "line " + std::to_string(number) + ": " + match.str();
    }
  }
  return "";
}

TEST(JobKinds, OnlyAKindsOwnFilesKnowItsName) {
  ASSERT_EQ(FirstKindIn("x\nif (kind == \"render\") {"), "line 2: \"render\"");
  ASSERT_EQ(FirstKindIn("WHERE kind = 'solve'"), "line 1: 'solve'");
  ASSERT_EQ(FirstKindIn("// \"render\""), "");
  ASSERT_EQ(FirstKindIn("if (job.kind() == \"train\") {"), "line 1: \"train\"");
  ASSERT_EQ(FirstKindIn("ReadPart(node, \"train\");"), "");
  int files = 0;
  for (const char* part : {"common", "coordinator", "worker"}) {
    for (const auto& entry :
         fs::recursive_directory_iterator(fs::path(PARALLAX_SOURCE_DIR) / part)) {
      const std::string path = fs::relative(entry.path(), PARALLAX_SOURCE_DIR);
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cc") continue;
      if (path.rfind("coordinator/queue/kinds/", 0) == 0 || path.rfind("worker/jobs/", 0) == 0) {
        continue;
      }
      // Names of stages in keys, which are older than the kinds: other words would be other keys.
      if (path == "coordinator/study/keys.cc") continue;
      ++files;
      EXPECT_EQ(FirstKindIn(*ReadFile(entry.path())), "") << path;
    }
  }
  EXPECT_GT(files, 300);
}

TEST(JobKinds, ARegistryFindsItsKindsByName) {
  const NoopKind noop;
  const KindRegistry kinds = KindRegistry::Builtin().With(noop);
  EXPECT_THAT(kinds.Names(), testing::ElementsAre("solve", "render", "train", "evaluate", "noop"));
  EXPECT_EQ(&kinds[*kinds.Find("noop")], &noop);
  EXPECT_EQ(kinds[kinds.begins_scenes()].name(), "solve");
  EXPECT_FALSE(kinds.Find("Noop"));
  EXPECT_THAT(std::string(kinds.IdOf("nope").status().message()),
              testing::HasSubstr(
                  "unknown kind of job 'nope'; there are: solve, render, train, evaluate, noop"));
}

TEST(JobKinds, ARegistryThatCantWorkEndsTheProgram) {
  const NoopKind noop;
  EXPECT_DEATH(KindRegistry::Builtin().With(noop).With(noop), "two are named 'noop'");
  EXPECT_DEATH(KindRegistry({&noop}), "0 begin scenes");
}

TEST(JobStates, AWordThatNamesNoStateIsNone) {
  for (const char* name : kJobStateNames) {
    ASSERT_TRUE(JobStateOf(name)) << name;
    EXPECT_STREQ(NameOf(*JobStateOf(name)), name);
  }
  EXPECT_FALSE(JobStateOf("DONE"));
  EXPECT_FALSE(JobStateOf(""));
}

}  // namespace
}  // namespace parallax
