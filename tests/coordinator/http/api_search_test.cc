// The routes of searches, and what the farm shows of them.
#include "tests/coordinator/http/http_fixture.h"
#include "tests/coordinator/search/search_study.h"

namespace parallax {
namespace {

using testing::HasSubstr;
using Parsed = nlohmann::json;

class ApiSearchTest : public HttpTest {
 protected:
  // A search that has ended its first rung: trial 1 is better, trial 2 was dropped, trial 3 failed.
  static v1::SearchRecord Record() {
    v1::SearchRecord record;
    *record.mutable_study() = SmallSearch(3);
    record.mutable_study()->mutable_search()->set_core_hours(8);
    record.set_actor("submitter ada ipv4:1");
    record.set_opened_unix_s(1e9);
    record.set_core_hours(2.5);
    record.add_rung_studies(1);
    for (int number = 0; number <= 3; ++number) {
      v1::SearchTrial& trial = *record.add_trials();
      trial.set_number(number);
      if (number > 0) {
        v1::SearchValue& count = *trial.add_values();
        count.set_path("floating.count");
        count.set_yaml(std::to_string(10 * number));
      }
      if (number == 3) continue;
      v1::SearchScore& score = *trial.add_scores();
      score.mutable_objective()->set_value(20 - number);
      score.mutable_difference()->set_value(-number);
      score.set_verdict(number == 0 ? "" : "better");
    }
    record.mutable_trials(2)->set_ended("rung 1: not among the best 1 of 2");
    record.mutable_trials(3)->set_ended("rung 1: train trial-003, seed 0: out of memory");
    return record;
  }
  // Starts a coordinator whose database has the search. It has no scorer, so that it stands still.
  void ServeSearch() {
    server_.reset();
    ASSERT_TRUE(queue_->KeepSearch(Record()).ok());
    server_ = *CoordinatorServer::Start(
        {.listen = {"unix:" + dir_ + "/s"}, .store_uri = store_->Uri()}, *queue_);
    Serve();
  }
};

TEST_F(ApiSearchTest, AFarmWithoutSearchesHasAnEmptyList) {
  Serve();
  EXPECT_EQ(Json(*Client(), "/api/v1/searches")["searches"], Parsed::array());
  EXPECT_EQ(Json(*Client(), "/api/v1/farm")["searches"], Parsed::array());
  EXPECT_EQ(Json(*Client(), "/api/v1/searches/recipe", 404)["error"]["message"],
            "search \"recipe\" is not known");
}

TEST_F(ApiSearchTest, TheListSaysHowFarEachIsAndWhichTrialIsTheBest) {
  ServeSearch();
  const Parsed list = Json(*Client(), "/api/v1/searches");
  ASSERT_EQ(list["searches"].size(), 1u);
  const Parsed& line = list["searches"][0];
  EXPECT_EQ(line["name"], "recipe");
  EXPECT_EQ(line["user"], "submitter ada");
  EXPECT_EQ(line["state"], "running");
  EXPECT_EQ(line["rung"], 1);
  EXPECT_EQ(line["rungs"], 3);
  EXPECT_EQ(line["best"], 2);
  EXPECT_EQ(line["best_score"]["difference"]["value"], -2);
  EXPECT_EQ(line["core_hours"], 2.5);
  EXPECT_EQ(line["core_hours_most"], 8);
  EXPECT_EQ(line["trial_states"], Parsed({{"open", 1}, {"dropped", 1}, {"failed", 1}}));
  EXPECT_FALSE(line.contains("trials"));
  EXPECT_EQ(Json(*Client(), "/api/v1/farm")["searches"], list["searches"]);
}

TEST_F(ApiSearchTest, OneSearchHasItsTrialsSpaceAndImportances) {
  ServeSearch();
  const Parsed search = Json(*Client(), "/api/v1/searches/recipe");
  ASSERT_EQ(search["trials"].size(), 4u);
  EXPECT_EQ(search["trials"][3]["ended"], "rung 1: train trial-003, seed 0: out of memory");
  EXPECT_EQ(search["trials"][1]["values"]["floating.count"], "10");
  ASSERT_EQ(search["space"].size(), 3u);
  EXPECT_EQ(search["space"][0]["path"], "floating.count");
  EXPECT_EQ(search["space"][0]["high"], 40);
  EXPECT_EQ(search["space"][2]["choices"], Parsed({"none", "all"}));
  ASSERT_EQ(search["importances"].size(), 3u);
  EXPECT_EQ(search["importances"][0]["significant"], false);
}

TEST_F(ApiSearchTest, ThePictureIsThatOfTheProgram) {
  ServeSearch();
  EXPECT_EQ(Client()->Get("/api/v1/searches/recipe/picture.svg")->status, 404);
  http_.reset();
  options_.picture = [](const v1::SearchStatus& search) {
    return "<svg>" + std::to_string(search.trials_size()) + search.study().name() + "</svg>";
  };
  Serve();
  const auto picture = Client()->Get("/api/v1/searches/recipe/picture.svg?seen=1");
  EXPECT_EQ(picture->status, 200);
  EXPECT_EQ(picture->body, "<svg>4recipe</svg>");
  EXPECT_EQ(picture->get_header_value("content-type"), "image/svg+xml");
}

TEST_F(ApiSearchTest, MetricsCountTrialsAndCoreHours) {
  ServeSearch();
  const std::string text = Client()->Get("/metrics")->body;
  for (const char* line : {"parallax_search_trials{search=\"recipe\",state=\"failed\"} 1\n",
                           "parallax_search_trials{search=\"recipe\",state=\"open\"} 1\n",
                           "parallax_search_rung{search=\"recipe\"} 2\n",
                           "parallax_search_core_hours{search=\"recipe\"} 2.5\n",
                           "parallax_search_core_hours_most{search=\"recipe\"} 8\n",
                           "parallax_search_open{search=\"recipe\"} 1\n",
                           "parallax_search_needs_person{search=\"recipe\"} 0\n"}) {
    EXPECT_THAT(text, HasSubstr(line));
  }
}

}  // namespace
}  // namespace parallax
