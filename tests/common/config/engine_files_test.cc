// Batch systems as files: the built-in ones are read, and wrong ones are refused by line and field.
#include "common/config/files/engine_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/system/file.h"
#include "common/config/config.h"

namespace parallax {
namespace {

using ::testing::StartsWith;

TEST(EngineFiles, BuiltInOnesAreReadByName) {
  for (const std::string name : {"slurm", "pbs", "lsf"}) {
    const auto engine = LoadEngine(name);
    ASSERT_TRUE(engine.ok()) << engine.status();
    EXPECT_EQ(engine->name(), name);
  }
  const auto missing = LoadEngine("sge");
  EXPECT_EQ(missing.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(missing.status().message()), testing::HasSubstr("lsf, pbs, slurm"));
}

// The example of the documentation, a batch system that nobody has, is a good file.
TEST(EngineFiles, TheExampleOfTheDocumentationIsRead) {
  const auto page = ReadFile(PARALLAX_CONFIGS "/../deploy/site/docs/recipes/slurm.md", 1 << 20);
  ASSERT_TRUE(page.ok()) << page.status();
  const std::string fence = "```yaml\n";
  const size_t begin = page->find(fence) + fence.size();
  const auto engine = ParseEngine(page->substr(begin, page->find("```", begin) - begin), "e.yaml");
  ASSERT_TRUE(engine.ok()) << engine.status();
  EXPECT_EQ(engine->submit().command(0), "tsub");
}

TEST(EngineFiles, EachWrongFileNamesLineFieldAndWhatIsExpected) {
  const std::string good = *BuiltinConfigText("engines/slurm.yaml");
  const struct {
    const char* part;
    const char* by;
    const char* want;  // The beginning of the message.
  } rows[] = {
      {"{pilots}", "{pilot}",
       "mine.yaml:3: submit.command[3]: there is no {pilot}, expected {name}, {pilots}, {script}"},
      {"\"{ids}\"", "\"{id}\"", "mine.yaml:10: cancel[1]: there is no {id}, expected {ids}"},
      {"  id: ", "  job: ", "mine.yaml:3: submit.id: is missing, expected a regular expression"},
      {"^(\\d+)(;.*)?$", "^(\\d+", "mine.yaml:9: submit.id: \"^(\\d+\" is no regular expression"},
      {"\\|(.*)$", "\\|.*$",
       "mine.yaml:13: list.pilot: \"^(\\d[^|]*)\\|.*$\" has 1 groups, expected 2 at least"},
      {"is: running", "is: runs",
       "mine.yaml:15: list.states[0].is: runs is not known (allowed: waiting, running, ending)"},
      {"is: running", "es: running", "mine.yaml:15: list.states[0].es: no such field"},
      {"term_s: 30", "term_s: soon",
       "mine.yaml:19: signals.term_s: soon is not a whole number, allowed 1 to 86400 s"},
      {"array: true", "array: many", "mine.yaml:4: submit.array: many, allowed is true or false"},
      {"cancel:", "cancels:", "mine.yaml:10: cancels: no such field, did you mean cancel?"},
      {"={tls}", "={secret}", "mine.yaml:20: environment[1]: there is no {secret}, expected {"},
      {"\"{options}\"", "\"--opts={options}\"",
       "mine.yaml:3: submit.command[4]: \"--opts={options}\", expected {options} as a word of its"},
      {"\"{arguments}\"", "\"x {arguments}\"",
       "mine.yaml:3: submit.command[6]: \"x {arguments}\", expected {arguments} as a word of its"},
      {"\"{ids}\"", "\"-j{ids}\"",
       "mine.yaml:10: cancel[1]: \"-j{ids}\", expected {ids} as a word"},
      {", \"{ids}\"", "", "mine.yaml:10: cancel: has no {ids}"},
      {"\"{script}\"", "x", "mine.yaml:3: submit.command: has no {script}"},
      {"\"{options}\"", "x", "mine.yaml:3: submit.command: has no {options}"},
      {", \"{arguments}\"", "",
       "mine.yaml:3: submit.command: has no {arguments}, expected it here or in environment"},
      {"{pilots}", "5", "mine.yaml:4: submit.array: true, expected {pilots} in submit.command"},
      {"  array: true\n", "",
       "mine.yaml:3: submit.array: not true, expected so where submit.command has {pilots}"},
      {"[sbatch,", "[\"\",", "mine.yaml:3: submit.command[0]: \"\", expected a program"},
      {"scancel", "\"\"", "mine.yaml:10: cancel[0]: \"\", expected a program"},
      {"  states:", "  id: $9\n  states:",
       "mine.yaml:14: list.id: there is no group $9 in list.pilot, which has 2"},
      {"  states:", "  id: job\n  states:",
       "mine.yaml:14: list.id: \"job\", expected a group of list.pilot, such as $1"},
      {"  states:", "  state: $3\n  states:", "mine.yaml:14: list.state: there is no group $3 in"},
      {"PARALLAX_TLS=", "=", "mine.yaml:20: environment[1]: \"={tls}\", expected NAME=value"},
      {"IDLE={idle_s}", "IDLE", "mine.yaml:20: environment[2]: \"PARALLAX_IDLE\", expected NAME="},
      {"submit:", "name: a b\nsubmit:", "mine.yaml:2: name: \"a b\" is not a name"},
  };
  ASSERT_TRUE(ParseEngine(good, "mine.yaml").ok());
  for (const auto& row : rows) {
    std::string text = good;
    const size_t at = text.find(row.part);
    ASSERT_NE(at, std::string::npos) << row.part;
    const auto engine =
        ParseEngine(text.replace(at, std::string(row.part).size(), row.by), "mine.yaml");
    EXPECT_EQ(engine.status().code(), absl::StatusCode::kInvalidArgument) << row.by;
    EXPECT_THAT(std::string(engine.status().message()), StartsWith(row.want));
  }
}

}  // namespace
}  // namespace parallax
