// Lists and folders of a user's own pairs, as other people's tools and systems write them.
#include <gmock/gmock.h>

#include "tests/worker/evaluate/test_tree.h"
#include "worker/evaluate/benchmark.h"
#include "worker/evaluate/benchmarks/benchmark_layout.h"

namespace parallax {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(OwnPairs, ListsMayQuoteNamesSayTheirScaleAndBeginWithAMark) {
  const TestTree tree;
  tree.Pictures("my left.png", "it's,right#1.png", 400, 1);
  tree.Png16("64.png", ImageF(400, 1, 20.0f), 64);
  tree.Png16("100.png", ImageF(400, 1, 20.0f), 100);
  tree.Mask("8.png", ImageU8(400, 1, 80));
  tree.Pfm("d.pfm", ImageF(400, 1, 20.0f));
  tree.Text("pairs.txt",
            "\xef\xbb\xbf\"my left.png\" it's,right#1.png d.pfm\r\n"
            "scale: 64\r\n"
            "'my left.png' \"it's,right#1.png\" 64.png # a comment\n"
            "scale:100\n"
            "'my left.png','it''s,right#1.png',100.png\n"
            "scale: 4  # grey levels\n"
            "\"my left.png\", \"it's,right#1.png\", 8.png\n");
  const auto benchmark = OpenBenchmark("list:" + tree.dir() + "/pairs.txt", "");
  ASSERT_TRUE(benchmark.ok()) << benchmark.status();
  EXPECT_TRUE(benchmark->own);
  ASSERT_EQ(benchmark->pairs.size(), 4u);
  for (const BenchmarkPair& pair : benchmark->pairs) {
    EXPECT_EQ(pair.left, tree.dir() + "/my left.png");
    EXPECT_EQ(pair.right, tree.dir() + "/it's,right#1.png");
    const auto truth = pair.read_truth();
    ASSERT_TRUE(truth.ok()) << truth.status();
    EXPECT_EQ(truth->disparity_px, ImageF(400, 1, 20.0f)) << pair.name;
  }
}

TEST(OwnPairs, SetsOfPairsAreNamedByListsAndByNamesInFolders) {
  const TestTree tree;
  const auto groups = [](const absl::StatusOr<Benchmark>& benchmark) {
    EXPECT_TRUE(benchmark.ok()) << benchmark.status();
    std::vector<std::string> all;
    for (const BenchmarkPair& pair : benchmark->pairs) all.push_back(pair.group);
    return all;
  };
  for (const char* name : {"mb2006_rocks1", "mb2006_baby1", "mb2001_bull", "alone"}) {
    const std::string dir = std::string("real/") + name;
    tree.Pictures(dir + "/im0.png", dir + "/im1.png", 40, 1);
    tree.Pfm(dir + "/disp0GT.pfm", ImageF(40, 1, 20.0f));
  }
  EXPECT_THAT(groups(OpenBenchmark("folder:" + tree.dir() + "/real", "")),
              ElementsAre("alone", "mb2001", "mb2006", "mb2006"));

  const std::string pair = "real/alone/im0.png real/alone/im1.png real/alone/disp0GT.pfm\n";
  tree.Text("pairs.txt", pair + "group: hall\n" + pair + "group: \"the kitchen\"\n" + pair +
                             "group: 'bath room'\n" + pair + "group:\n" + pair);
  const auto listed = OpenBenchmark("list:" + tree.dir() + "/pairs.txt", "");
  EXPECT_THAT(groups(listed), ElementsAre("", "hall", "the_kitchen", "bath_room", ""));
  EXPECT_THAT(listed->list, HasSubstr("group: the_kitchen\n"));  // A copy's sets are the same.

  using Names = std::vector<std::string>;
  EXPECT_EQ(GroupsByName({"scene_1", "scene_2", "scene_3"}), Names(3));  // One group of all.
  EXPECT_EQ(GroupsByName({"a", "b_1", "c_2"}), Names(3));                // No group of two.
}

TEST(OwnPairs, ListsSayWhatIsWrongAndWhere) {
  const struct {
    std::string text, wanted;
  } cases[] = {
      {"a b",
       "pairs.txt:1: 2 fields, wanted `left right disparity [mask]`; a name with blanks goes "
       "into quotes"},
      {"\na b c d e", "pairs.txt:2: 5 fields"},
      {"'a b c", "pairs.txt:1: a ' without its end"},
      {"scale: x", "pairs.txt:1: scale: wanted a number above 0"},
      {"scale: 0", "pairs.txt:1: scale: wanted a number above 0"},
      {"scale: 1 2", "pairs.txt:1: scale: wanted a number above 0"},
      {"group: my kitchen", "pairs.txt:1: group: wanted one name"},
      {"group:a b", "pairs.txt:1: group: wanted one name"},
      {std::string("\xff\xfe"
                   "a\0",
                   4),
       "holds a NUL byte: no text file, or UTF-16"},
      {"a b c", "a: missing, and 2 more files"}};
  for (const auto& c : cases) {
    const TestTree tree;
    tree.Text("pairs.txt", c.text);
    const auto status = OpenBenchmark("list:" + tree.dir() + "/pairs.txt", "").status();
    EXPECT_THAT(std::string(status.message()), HasSubstr(c.wanted)) << c.text;
  }
}

TEST(OwnPairs, WhatArchivesOfMacOsBringIsNoPair) {
  const TestTree tree;
  tree.Pictures("pairs/one/im0.png", "pairs/one/im1.png", 8, 1);
  tree.Pfm("pairs/one/disp0GT.pfm", ImageF(8, 1, 10.0f));
  tree.Text("pairs/__MACOSX/one/._im0.png", "resource fork");
  tree.Text("pairs/._one", "resource fork");
  tree.Text("pairs/one/._im0.png", "resource fork");
  const auto benchmark = OpenBenchmark("folder:" + tree.dir() + "/pairs", "");
  ASSERT_TRUE(benchmark.ok()) << benchmark.status();
  ASSERT_EQ(benchmark->pairs.size(), 1u);
  EXPECT_EQ(benchmark->pairs[0].name, "one");
}

}  // namespace
}  // namespace parallax
