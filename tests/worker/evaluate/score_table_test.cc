#include "worker/evaluate/score_table.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/worker/evaluate/test_scores.h"

namespace parallax {
namespace {

using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

// Three seeds of `default` and of a variant that is worse by far, and SGBM.
std::vector<Evaluation> Study() {
  std::vector<Evaluation> all;
  for (int64_t seed = 1; seed <= 3; ++seed) {
    const auto s = static_cast<double>(seed);
    all.push_back(SyntheticEvaluation("eth3d", "default", seed, {4 + s, 10 + s, 20 + s}));
    all.push_back(SyntheticEvaluation("eth3d", "narrow", seed, {14 + s, 21 + s, 30 + s}));
    all.push_back(SyntheticEvaluation("shipped", "default", seed, {7 + s / 10}));
    all.push_back(SyntheticEvaluation("shipped", "narrow", seed, {7.1 + s / 5}));
  }
  all.push_back(SyntheticEvaluation("eth3d", "sgbm", std::nullopt, {6, 12, 22}, "opencv"));
  return all;
}

TEST(Table, JsonHasRowsAndComparisonsWithTheAgreedNames) {
  const auto table = MakeTable(Study(), {});
  ASSERT_TRUE(table.ok()) << table.status();
  const Json json = Json::parse(*FormatTable(*table, "json"));
  ASSERT_EQ(json["rows"].size(), 3);
  const Json& row = json["rows"][0];
  EXPECT_EQ(row["variant"], "default");
  EXPECT_EQ(row["trainer"], "builtin");
  EXPECT_EQ(row["seeds"], 3);
  const Json& figure = row["benchmarks"]["eth3d"];
  EXPECT_EQ(figure["metric"], "bad-2 all");
  EXPECT_NEAR(figure["value"], 40.0 / 3, 1e-9);
  ASSERT_TRUE(figure.contains("low") && figure.contains("high"));
  EXPECT_LT(figure["low"], figure["value"]);
  EXPECT_GT(figure["high"], figure["value"]);
  EXPECT_EQ(figure["pairs"], 3);
  EXPECT_EQ(json["rows"][2]["variant"], "sgbm");  // Without seeds: last.
  EXPECT_EQ(json["rows"][2]["seeds"], 0);
  EXPECT_FALSE(json["rows"][2]["benchmarks"].contains("shipped"));

  ASSERT_EQ(json["comparisons"].size(), 3);
  const Json& narrow = json["comparisons"][0];
  EXPECT_EQ(narrow["variant"], "narrow");
  EXPECT_EQ(narrow["baseline"], "default");
  EXPECT_EQ(narrow["benchmark"], "eth3d");
  EXPECT_EQ(narrow["verdict"], "worse");
  EXPECT_NEAR(narrow["difference"], 31.0 / 3, 1e-9);
  EXPECT_EQ(narrow["seeds"], 3);
  EXPECT_EQ(narrow["pairs"], 3);
  EXPECT_EQ(narrow["more_seeds"], nullptr);
}

// `other` has as many pixels beyond 2 px as `default`, and fewer beyond 0.5 px.
std::vector<Evaluation> StudyOfLogs() {
  std::vector<Evaluation> all;
  for (int64_t seed = 1; seed <= 3; ++seed) {
    for (const std::string variant : {"default", "other"}) {
      // Bad-2 jumps from seed to seed, whichever the variant.
      const double jump = (variant == "other" ? 1.0 : -1.0) * (seed == 2 ? 2.0 : -1.0);
      all.push_back(SyntheticEvaluation("real", variant, seed, {10 + jump, 14 + jump, 18 + jump}));
      for (Scores& image : all.back().images) {
        ErrorTally& tally = image.regions["all"];
        tally.bad[0] = variant == "other" ? 300 : 600;
        tally.bad[1] = variant == "other" ? 250 : 400;
      }
    }
  }
  return all;
}

TEST(Table, TheMeanLogErrorMayDecideWhileTheHeadlineIsShown) {
  const auto shown = MakeTable(StudyOfLogs(), {});
  const auto by_log = MakeTable(StudyOfLogs(), {.decide_by_log = true});
  ASSERT_TRUE(shown.ok() && by_log.ok()) << shown.status() << by_log.status();
  EXPECT_EQ(shown->comparisons[0].comparison.verdict, Verdict::kNotSignificant);
  EXPECT_EQ(by_log->comparisons[0].comparison.verdict, Verdict::kBetter);
  EXPECT_DOUBLE_EQ(by_log->rows[0].cells.at("real").headline.interval.value,
                   shown->rows[0].cells.at("real").headline.interval.value);

  const Json before = Json::parse(*FormatTable(*shown, "json"))["comparisons"][0];
  const Json after = Json::parse(*FormatTable(*by_log, "json"))["comparisons"][0];
  EXPECT_EQ(before["decided_by"]["metric"], "bad-2 all");
  EXPECT_EQ(before["decided_by"]["difference"], before["difference"]);
  for (const char* of_shown : {"metric", "difference", "low", "high"}) {
    EXPECT_EQ(after[of_shown], before[of_shown]) << of_shown;
  }
  EXPECT_EQ(after["decided_by"]["metric"], "log all");
  // By the trapezoids: 30 % of the pixels over half an octave, 15 % over one.
  EXPECT_NEAR(after["decided_by"]["difference"], -0.5 * 0.3 - 0.15, 1e-9);
  EXPECT_LT(after["decided_by"]["high"], 0);
  EXPECT_EQ(after["verdict"], "better");
  const std::string text = *FormatTable(*by_log, "text");
  EXPECT_THAT(text, HasSubstr("better by 0.30 [0.09, 0.51] log all; shown +0.00"));
  EXPECT_THAT(text, HasSubstr("note: Verdicts are by log, "));
  EXPECT_THAT(text, HasSubstr("differences of log all from "));
  EXPECT_THAT(*FormatTable(*shown, "text"), Not(HasSubstr("log all")));
  // The verdict is on the line of the figure that decides.
  const std::string csv = *FormatTable(*by_log, "csv");
  EXPECT_THAT(csv, ContainsRegex("other,builtin,3,real,log all,[^\n]*,better,3\n"));
  EXPECT_THAT(csv, ContainsRegex("other,builtin,3,real,bad-2 all,[^\n]*,,3\n"));
}

TEST(Table, OneLookAndTwoAreNotCompared) {
  std::vector<Evaluation> study = Study();
  for (Evaluation& one : study) {
    if (one.run.variant == "narrow") one.run.looks = 1;
  }
  const auto table = MakeTable(study, {});
  EXPECT_EQ(table.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(Message(table.status()),
              HasSubstr("variant narrow, trainer builtin, seed 1 and variant default, trainer "
                        "builtin, seed 1 can't be compared: one has looked once"));
  for (Evaluation& one : study) one.run.looks = one.run.trainer == "builtin" ? 1 : 0;
  EXPECT_TRUE(MakeTable(study, {}).ok()) << "a classical method looks as it does";
}

// Twelve pairs of six sets, whose pairs have nearly the same errors.
std::vector<Evaluation> StudyOfSets(int sets) {
  std::vector<Evaluation> all;
  for (int64_t seed = 1; seed <= 3; ++seed) {
    std::vector<double> good, bad;
    for (int i = 0; i < 12; ++i) {
      const double hard = 3.0 * (i % sets) + 0.1 * static_cast<double>(seed);
      good.push_back(10 + hard);
      bad.push_back(10.5 + hard + 0.4 * (i % sets % 3));
    }
    for (const auto& [variant, figures] : {std::pair("default", good), std::pair("other", bad)}) {
      all.push_back(SyntheticEvaluation("real", variant, seed, figures));
      for (size_t i = 0; i < figures.size(); ++i) {
        all.back().images[i].pair_group = "set" + std::to_string(static_cast<int>(i) % sets);
      }
    }
  }
  return all;
}

TEST(Table, PairsOfOneSetAreDrawnTogether) {
  const auto grouped = MakeTable(StudyOfSets(6), {});
  std::vector<Evaluation> alone = StudyOfSets(6);
  for (Evaluation& evaluation : alone) {
    for (Scores& scores : evaluation.images) scores.pair_group.clear();
  }
  const auto pairs = MakeTable(alone, {});
  ASSERT_TRUE(grouped.ok() && pairs.ok()) << grouped.status() << pairs.status();
  const auto cell = [](const ResultTable& table) { return table.rows[0].cells.at("real"); };
  const Interval of_sets = cell(*grouped).headline.interval;
  const Interval of_pairs = cell(*pairs).headline.interval;
  EXPECT_DOUBLE_EQ(of_sets.value, of_pairs.value);
  // Two alike count as one: wider by the root of 2, and by fewer degrees of freedom.
  EXPECT_GT(of_sets.high - of_sets.low, 1.3 * (of_pairs.high - of_pairs.low));
  EXPECT_LT(of_sets.high - of_sets.low, 2.2 * (of_pairs.high - of_pairs.low));
  EXPECT_EQ(grouped->comparisons[0].comparison.images, 6);
  EXPECT_EQ(grouped->comparisons[0].pairs, 12);

  const Json json = Json::parse(*FormatTable(*grouped, "json"));
  EXPECT_EQ(json["comparisons"][0]["pairs"], 12);
  EXPECT_EQ(json["comparisons"][0]["groups"], 6);
  const Json& groups = json["rows"][0]["benchmarks"]["real"]["groups"];
  ASSERT_EQ(groups.size(), 6);
  EXPECT_EQ(groups[2]["group"], "set2");
  EXPECT_EQ(groups[2]["pairs"], 2);
  EXPECT_NEAR(groups[2]["value"], 16.2, 1e-9);
  EXPECT_THAT(
      grouped->notes,
      ::testing::Contains("real: intervals draw its 6 sets (2 pairs each), because pairs of "
                          "one set are not independent."));
  for (const char* format : {"text", "markdown"}) {
    const std::string text = *FormatTable(*grouped, format);
    EXPECT_THAT(text, HasSubstr("bad-2 all by set (pairs)")) << format;
    EXPECT_THAT(text, HasSubstr("set5 (2)")) << format;
    EXPECT_THAT(text, HasSubstr("16.20")) << format;
    EXPECT_THAT(*FormatTable(*pairs, format), Not(HasSubstr("by set"))) << format;
  }
  const Json without = Json::parse(*FormatTable(*pairs, "json"));
  EXPECT_EQ(without["comparisons"][0]["groups"], nullptr);
  EXPECT_FALSE(without["rows"][0]["benchmarks"]["real"].contains("groups"));
}

TEST(Table, FewSetsAreShownAndPairsDrawn) {
  const auto table = MakeTable(StudyOfSets(3), {});
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->comparisons[0].comparison.images, 12);
  EXPECT_EQ(table->rows[0].cells.at("real").groups.size(), 3u);
  EXPECT_THAT(table->notes, ::testing::Contains(
                                "real: intervals draw pairs, which are not independent: its 3 sets "
                                "(4 pairs each) are too few."));
}

TEST(Table, ManySetsAreNoColumnsAndSetsOfOnePairNoNote) {
  std::vector<Evaluation> all = StudyOfSets(6);
  for (Evaluation& evaluation : all) {
    for (Scores& scores : evaluation.images) scores.pair_group = "of_" + scores.pair;
    Scores more = evaluation.images.back();
    more.pair = more.pair_group = "more";
    evaluation.images.push_back(more);
  }
  const auto table = MakeTable(all, {});
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->rows[0].cells.at("real").groups.size(), 13u);
  EXPECT_THAT(*FormatTable(*table, "text"), Not(HasSubstr("by set")));
  EXPECT_THAT(table->notes, Not(::testing::Contains(HasSubstr("independent"))));
}

// Studies grow over versions: scores that were made before sets were known stay comparable.
TEST(Table, ScoresWithoutSetsTakeThemFromOthersOfTheSamePairs) {
  std::vector<Evaluation> all = StudyOfSets(6);
  const auto with = MakeTable(all, {});
  for (Scores& scores : all[1].images) scores.pair_group.clear();
  for (Scores& scores : all[2].images) scores.pair_group.clear();
  const auto table = MakeTable(all, {});
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(*FormatTable(*table, "json"), *FormatTable(*with, "json"));
}

TEST(Table, SetsCountAlikeWhereThatIsWanted) {
  std::vector<Evaluation> all = StudyOfSets(6);
  for (Evaluation& evaluation : all) {  // Seven pairs in one set, the other five alone.
    for (size_t i = 0; i < 7; ++i) evaluation.images[i].pair_group = "many";
    for (size_t i = 7; i < 12; ++i) evaluation.images[i].pair_group = "s" + std::to_string(i);
  }
  const auto by_pairs = MakeTable(all, {}), by_sets = MakeTable(all, {.weigh_groups = true});
  ASSERT_TRUE(by_pairs.ok() && by_sets.ok());
  const auto value = [](const ResultTable& table) {
    return table.rows[0].cells.at("real").headline.interval.value;
  };
  EXPECT_NEAR(value(*by_pairs), 17.7, 1e-9);
  EXPECT_NEAR(value(*by_sets), 10.2 + (45.0 / 7 + 3 + 6 + 9 + 12 + 15) / 6, 1e-9);
  EXPECT_THAT(by_sets->notes, ::testing::Contains(HasSubstr("its 6 sets (1 to 7 pairs each)")));
  EXPECT_THAT(by_sets->notes, ::testing::Contains(HasSubstr("Each set counts alike in the mean.")));
  EXPECT_THAT(by_pairs->notes, Not(::testing::Contains(HasSubstr("counts alike"))));
  for (Evaluation& evaluation : all) {  // Too few sets to be drawn: they count alike all the same.
    for (size_t i = 7; i < 12; ++i) evaluation.images[i].pair_group = "few";
  }
  const auto two = MakeTable(all, {.weigh_groups = true});
  ASSERT_TRUE(two.ok()) << two.status();
  EXPECT_NEAR(value(*two), 10.2 + (45.0 / 7 + 45.0 / 5) / 2, 1e-9);
}

TEST(Table, ClassicalRowStandsBesideEachSeedOfTheBaseline) {
  const auto table = MakeTable(Study(), {});
  ASSERT_TRUE(table.ok());
  const TableComparison& sgbm = table->comparisons.back();
  EXPECT_EQ(sgbm.variant, "sgbm");
  EXPECT_EQ(sgbm.baseline_trainer, "builtin");
  EXPECT_EQ(sgbm.comparison.seeds, 3);
  EXPECT_NEAR(sgbm.comparison.difference.value, 40.0 / 3 - 40.0 / 3, 1e-9);
  EXPECT_EQ(sgbm.comparison.verdict, Verdict::kNotSignificant);
}

TEST(Table, BaselineCanBeChosenAndMustExist) {
  const auto table = MakeTable(Study(), {.baseline = "narrow", .variant_order = {"narrow"}});
  ASSERT_TRUE(table.ok());
  EXPECT_EQ(table->rows[0].variant, "narrow");
  EXPECT_EQ(table->comparisons[0].variant, "default");
  EXPECT_EQ(table->comparisons[0].comparison.verdict, Verdict::kBetter);
  EXPECT_THAT(Message(MakeTable(Study(), {.baseline = "wide"}).status()),
              HasSubstr("'wide' is not among the variants: default, narrow, sgbm"));
}

TEST(Table, ScoresThatCannotBeComparedAreRefused) {
  const Evaluation good = SyntheticEvaluation("eth3d", "a", 1, {5, 6});
  Evaluation other_pairs = SyntheticEvaluation("eth3d", "b", 1, {5, 6});
  other_pairs.images[1].pair = "p9";
  Evaluation other_truth = SyntheticEvaluation("eth3d", "b", 1, {5, 6});
  other_truth.images[1].regions["all"].pixels = 999;
  Evaluation other_metric = SyntheticEvaluation("eth3d", "b", 1, {5, 6});
  other_metric.headline.measure = BadAt(3);
  const struct {
    Evaluation evaluation;
    const char* wanted;
  } cases[] = {
      {SyntheticEvaluation("eth3d", "b", 1, {5}), "2 pairs and 1"},
      {other_pairs, "pair p1 and pair p9"},
      {other_truth, "pair p1 has other truth"},
      {other_metric, "their metrics differ"},
      {SyntheticEvaluation("eth3d", "a", std::nullopt, {5, 6}), "with and without a seed"}};
  for (const auto& c : cases) {
    const auto table = MakeTable({good, c.evaluation}, {});
    EXPECT_EQ(table.status().code(), absl::StatusCode::kFailedPrecondition) << c.wanted;
    EXPECT_THAT(Message(table.status()), HasSubstr(c.wanted));
  }
}

TEST(Table, OnlyCommonSeedsAreCompared) {
  std::vector<Evaluation> all;
  for (int64_t seed = 1; seed <= 3; ++seed) {
    all.push_back(SyntheticEvaluation("eth3d", "default", seed, {5, 6}));
  }
  for (int64_t seed = 2; seed <= 4; ++seed) {
    all.push_back(SyntheticEvaluation("eth3d", "narrow", seed, {7, 8}));
  }
  all.push_back(SyntheticEvaluation("eth3d", "other", 9, {7, 8}));
  const auto table = MakeTable(all, {});
  ASSERT_TRUE(table.ok());
  ASSERT_EQ(table->comparisons.size(), 1);
  EXPECT_EQ(table->comparisons[0].comparison.seeds, 2);
  EXPECT_THAT(table->notes,
              ::testing::Contains(HasSubstr("other and default have no seed in common")));
}

TEST(Table, ACellTellsItsOwnSeeds) {
  std::vector<Evaluation> all = Study();
  all.push_back(SyntheticEvaluation("kitti2015", "narrow", 2, {9, 11, 13}));
  all.push_back(SyntheticEvaluation("kitti2015", "default", 1, {8, 10, 12}));
  all.push_back(SyntheticEvaluation("kitti2015", "default", 2, {7, 10, 12}));
  const auto table = MakeTable(all, {});
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(table->notes,
              ::testing::Contains("kitti2015: fewer seeds than on other benchmarks for rows "
                                  "default (2 of 3), narrow (1 of 3)."));
  EXPECT_THAT(table->notes, ::testing::Contains(HasSubstr("one seed")));
  EXPECT_THAT(table->notes,
              ::testing::Contains(HasSubstr("eth3d: with 3 seeds and 3 pairs, differences of ")));
  const Json json = Json::parse(*FormatTable(*table, "json"));
  EXPECT_EQ(json["rows"][1]["seeds"], 3);
  EXPECT_EQ(json["rows"][1]["benchmarks"]["eth3d"]["seeds"], 3);
  EXPECT_EQ(json["rows"][1]["benchmarks"]["kitti2015"]["seeds"], 1);
  EXPECT_EQ(json["rows"][2]["benchmarks"]["eth3d"]["seeds"], 0);
  for (const Json& one : json["comparisons"]) {
    EXPECT_EQ(one["least_difference"].is_number(), one["seeds"] > 1 && one["pairs"] > 1) << one;
  }
  EXPECT_THAT(*FormatTable(*table, "csv"), HasSubstr(",not significant,1\n"));
  EXPECT_THAT(*FormatTable(*table, "markdown"), HasSubstr("| narrow | builtin | 1 | 11.00 ["));
}

std::string PowerNoteOf(const std::vector<Evaluation>& evaluations) {
  const auto table = MakeTable(evaluations, {});
  EXPECT_TRUE(table.ok()) << table.status();
  for (const std::string& note : table->notes) {
    if (note.starts_with("eth3d: with ")) return note;
  }
  return "";
}

TEST(Table, TheNoteOnWhatSeedsCanShowIsOfTrainingsAlone) {
  std::vector<Evaluation> trained = Study();
  trained.pop_back();  // SGBM.
  EXPECT_THAT(PowerNoteOf(trained), HasSubstr("differences of bad-2 all from "));
  EXPECT_EQ(PowerNoteOf(Study()), PowerNoteOf(trained));
}

TEST(Table, TheNoteOnWhatSeedsCanShowIsOfOneComparison) {
  std::vector<Evaluation> three = Study();
  three.pop_back();  // SGBM.
  std::vector<Evaluation> more = three;
  for (int64_t seed = 1; seed <= 2; ++seed) {  // It varies much more.
    const auto s = static_cast<double>(seed);
    more.push_back(SyntheticEvaluation("eth3d", "wide", seed, {20 * s, 60 - 9 * s, 30 + 4 * s}));
  }
  EXPECT_THAT(PowerNoteOf(more), HasSubstr("with 3 seeds"));
  EXPECT_EQ(PowerNoteOf(more), PowerNoteOf(three));
}

TEST(Table, PairsOutsideOfSetsAreNamedBesideThem) {
  std::vector<Evaluation> all = StudyOfSets(3);
  const auto notes = [&](size_t grouped) {
    for (Evaluation& evaluation : all) {
      for (size_t i = grouped; i < 12; ++i) evaluation.images[i].pair_group.clear();
    }
    return MakeTable(all, {})->notes;
  };
  EXPECT_THAT(notes(6), ::testing::Contains(
                            "real: intervals draw its 3 sets (2 pairs each) and 6 single pairs, "
                            "because pairs of one set are not independent."));
  EXPECT_EQ(MakeTable(all, {})->comparisons[0].comparison.images, 9);
  EXPECT_THAT(notes(3), Not(::testing::Contains(HasSubstr("independent"))));
}

TEST(Table, SubsetsAndSingleSeedsAreNoted) {
  Evaluation part = SyntheticEvaluation("eth3d", "default", 1, {5, 6});
  part.pairs_published = 27;
  const auto table = MakeTable({part, SyntheticEvaluation("shipped", "default", 1, {5})}, {});
  ASSERT_TRUE(table.ok());
  EXPECT_THAT(table->notes, ElementsAre(HasSubstr("2 pairs, the whole set has 27"),
                                        HasSubstr("one pair"), HasSubstr("one seed")));
}

TEST(Table, AllFormatsShowFiguresAndVerdicts) {
  const auto table = MakeTable(Study(), {});
  ASSERT_TRUE(table.ok());
  const std::string text = *FormatTable(*table, "text");
  EXPECT_THAT(text, HasSubstr("eth3d (3 pairs; as nobody)"));
  EXPECT_THAT(text, HasSubstr("worse by 10.33 ["));
  EXPECT_THAT(text, HasSubstr("not significant"));
  EXPECT_THAT(text, HasSubstr("epe all"));
  const std::string markdown = *FormatTable(*table, "markdown");
  EXPECT_THAT(markdown, HasSubstr("| default | builtin | 3 | 13.33 ["));
  EXPECT_THAT(markdown, HasSubstr("✗"));
  const std::string latex = *FormatTable(*table, "latex");
  EXPECT_THAT(latex, HasSubstr("\\begin{tabular}{ll*{3}{r}}"));
  EXPECT_THAT(latex, HasSubstr("$^{-}$"));
  EXPECT_THAT(latex, HasSubstr("\\bottomrule"));
  const std::string csv = *FormatTable(*table, "csv");
  EXPECT_THAT(csv, HasSubstr("variant,trainer,seeds,benchmark,metric,value,low,high,pairs,verdict,"
                             "benchmark_seeds\n"));
  EXPECT_THAT(csv, HasSubstr("narrow,builtin,3,eth3d,bad-2 all,23.6667,"));
  EXPECT_THAT(csv, HasSubstr(",worse,3\n"));
  const auto unknown = FormatTable(*table, "html");
  EXPECT_THAT(Message(unknown.status()), HasSubstr("text, markdown, latex, csv, json"));
}

TEST(Table, FigureOfARegionThatNoPairHasIsNoZero) {
  Evaluation evaluation = SyntheticEvaluation("mine", "default", 1, {5, 6});
  evaluation.headline.region = "nocc";
  const auto table = MakeTable({evaluation}, {});
  ASSERT_TRUE(table.ok()) << table.status();
  const Json json = Json::parse(*FormatTable(*table, "json"));
  EXPECT_TRUE(json["rows"][0]["benchmarks"]["mine"]["value"].is_null());
  EXPECT_THAT(*FormatTable(*table, "markdown"), HasSubstr("| default | builtin | 1 | - |"));
}

TEST(Table, IntervalsOfPercentagesStayWithin0And100) {
  const auto table = MakeTable({SyntheticEvaluation("eth3d", "bad", std::nullopt, {95, 100, 99}),
                                SyntheticEvaluation("eth3d", "good", std::nullopt, {0, 5, 1})},
                               {});
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->rows[0].cells.at("eth3d").headline.interval.high, 100);
  EXPECT_EQ(table->rows[1].cells.at("eth3d").headline.interval.low, 0);
  // The mean error in pixels has no upper end.
  EXPECT_GT(table->rows[0].cells.at("eth3d").others[0].interval.high, 9.8);
}

TEST(Table, LatexEscapesNames) {
  const auto table = MakeTable({SyntheticEvaluation("my_set", "50%_glass", 1, {5, 6})}, {});
  ASSERT_TRUE(table.ok());
  const std::string latex = *FormatTable(*table, "latex");
  EXPECT_THAT(latex, HasSubstr("50\\%\\_glass"));
  EXPECT_THAT(latex, HasSubstr("my\\_set"));
}

}  // namespace
}  // namespace parallax
