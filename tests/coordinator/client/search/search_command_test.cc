// parallax search: what it says of searches, the recipe and the picture that it writes.
#include <fmt/core.h>
#include <gmock/gmock.h>

#include <atomic>
#include <future>
#include <thread>

#include "common/base/system/file.h"
#include "common/config/config.h"
#include "coordinator/client/runs/plan_power.h"
#include "coordinator/client/search/best_recipe.h"
#include "coordinator/client/search/search_names.h"
#include "coordinator/client/search/search_picture.h"
#include "coordinator/client/search/search_view.h"
#include "coordinator/search/rung_study.h"
#include "coordinator/view/search_json.h"
#include "parallax/v1/search.grpc.pb.h"
#include "tests/coordinator/client/command_test.h"

namespace parallax::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

const char kCamera[] =
    "study: camera\n"
    "pairs: 200\n"
    "rigs_per_scene: 10\n"
    "set: {render: {profile: preview}, rigs: {width_px: 640, height_px: 360}}\n"
    "search:\n"
    "  space:\n"
    "    floating.count: {range: [0, 40]}\n"
    "    floating.size_m: {range: [0.1, 1], log: true}\n"
    "    materials.mode: {choice: [all, none]}\n"
    "    materials.replace_probability: {range: [0, 1], when: {materials.mode: all}}\n"
    "  trials: 3\n"
    "  confirm: {benchmarks: [middlebury2014-Q]}\n"
    "train: {steps: 400, seeds: 2}\n"
    "evaluate: {benchmarks: [shipped, middlebury2014-Q]}\n";

v1::StudySpec Camera(const std::string& file = "camera.yaml") {
  const auto study = ParseStudy(kCamera, file);
  EXPECT_TRUE(study.ok()) << study.status();
  return study.ok() ? *study : v1::StudySpec();
}

void SetFigure(double value, double half, v1::SearchFigure* figure) {
  figure->set_value(value);
  figure->set_low(value - half);
  figure->set_high(value + half);
}

void AddScore(int rung, double error, double difference, const std::string& verdict,
              v1::SearchTrial& trial) {
  v1::SearchScore& score = *trial.add_scores();
  score.set_rung(rung);
  SetFigure(error, 1.5, score.mutable_objective());
  SetFigure(difference, difference == 0 ? 0 : 0.5, score.mutable_difference());
  score.set_verdict(verdict);
  score.set_core_s_per_pair(4.25);
}

v1::SearchTrial& AddTrial(const std::vector<std::pair<std::string, std::string>>& values,
                          v1::SearchStatus& search) {
  v1::SearchTrial& trial = *search.add_trials();
  trial.set_number(search.trials_size() - 1);
  for (const auto& [path, yaml] : values) {
    v1::SearchValue& value = *trial.add_values();
    value.set_path(path);
    value.set_yaml(yaml);
  }
  return trial;
}

// A search of three trials on its second rung.
v1::SearchStatus Status() {
  v1::SearchStatus search;
  search.set_name("camera");
  search.set_state("running");
  search.set_rung(1);
  search.set_rungs(3);
  search.set_core_hours(1.25);
  search.set_waits_for("rung 2: 9 of 12 trainings have ended");
  search.add_studies(4);
  search.add_studies(7);
  *search.mutable_study() = Camera();
  v1::SearchTrial& none = AddTrial({}, search);
  AddScore(0, 30, 0, "", none);
  AddScore(1, 22, 0, "", none);
  v1::SearchTrial& first = AddTrial(
      {{"floating.count", "7"}, {"floating.size_m", "0.13726481"}, {"materials.mode", "none"}},
      search);
  AddScore(0, 40, 10, "worse", first);
  first.set_ended("rung 1: significantly worse than the default");
  v1::SearchTrial& second = AddTrial({{"floating.count", "33"},
                                      {"floating.size_m", "0.5"},
                                      {"materials.mode", "all"},
                                      {"materials.replace_probability", "0.25"}},
                                     search);
  AddScore(0, 28, -2, "not significant", second);
  AddScore(1, 19.5, -2.5, "better", second);
  v1::SearchTrial& third = AddTrial({{"floating.count", "20"},
                                     {"floating.size_m", "0.2"},
                                     {"materials.mode", "all"},
                                     {"materials.replace_probability", "1"}},
                                    search);
  AddScore(0, 31, 1, "not significant", third);
  search.set_best(2);
  v1::SearchImportance& importance = *search.add_importances();
  importance.set_path("materials.mode");
  importance.mutable_share()->set_value(0.62);
  importance.mutable_share()->set_low(0.3);
  importance.mutable_share()->set_high(0.8);
  // Chance explains these: trials hardly differ in them, or are too few.
  for (const double high : {0.4, 1.0}) {
    v1::SearchImportance& none = *search.add_importances();
    none.set_path(high < 1 ? "floating.count" : "floating.size_m");
    none.mutable_share()->set_value(0.1);
    none.mutable_share()->set_high(high);
  }
  return search;
}

class FakeSearches : public v1::Searches::Service {
 public:
  FakeSearches() { Start("127.0.0.1:0"); }
  const std::string& address() const { return address_; }
  void Start(const std::string& address) {
    auto server = RpcServer::Start({*ParseRpcAddress(address)}, RpcSecurity{}, *this);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    address_ = server_->addresses()[0].ToString();
  }
  void Stop() { server_.reset(); }

  // What List gives, one after the other; the last one stays.
  std::vector<v1::SearchStatus> statuses;
  std::vector<std::string> orders;
  v1::StudySpec opened;
  std::atomic<int> lists = 0;

  grpc::Status Open(grpc::ServerContext*, const v1::OpenSearchRequest* request,
                    v1::SearchStatus* reply) override {
    opened = request->study();
    orders.push_back("open " + opened.name());
    *reply = statuses.front();
    return grpc::Status::OK;
  }
  grpc::Status List(grpc::ServerContext*, const v1::ListSearchesRequest* request,
                    v1::ListSearchesReply* reply) override {
    ++lists;
    if (statuses.empty() && request->name().empty()) return grpc::Status::OK;
    if (statuses.empty() ||
        (!request->name().empty() && request->name() != statuses.front().name())) {
      return {grpc::StatusCode::NOT_FOUND, "no search '" + request->name() + "'"};
    }
    *reply->add_searches() = statuses.front();
    if (statuses.size() > 1) statuses.erase(statuses.begin());
    return grpc::Status::OK;
  }
  grpc::Status Stop(grpc::ServerContext*, const v1::StopSearchRequest* request,
                    v1::SearchStatus* reply) override {
    orders.push_back((request->forget() ? "forget " : "stop ") + request->name());
    *reply = statuses.front();
    return grpc::Status::OK;
  }

 private:
  std::string address_;
  std::unique_ptr<RpcServer> server_;  // Last: it calls the rest until it is gone.
};

class SearchCommandTest : public FolderTest {
 protected:
  Outcome Run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "search");
    arguments.insert(arguments.end(), {"--coordinator", searches_.address()});
    return RunCommand(arguments);
  }
  FakeSearches searches_;
};

TEST_F(SearchCommandTest, ASearchIsATableOfItsTrials) {
  searches_.statuses = {Status()};
  const Outcome shown = Run({"camera"});
  EXPECT_EQ(shown.exit_code, kExitOk) << shown.err;
  EXPECT_EQ(
      shown.out,
      "camera: running, rung 2 of 3 with 2 of 3 trials, 1.25 core-hours\n"
      "  rung 2: 9 of 12 trainings have ended\n"
      "  TRIAL     count  size_m  mode  replace_probability  RUNG            ERROR %         FROM "
      "DEFAULT  VERDICT          CORE-S/PAIR  ENDED\n"
      "  default  10..30  0.5..1  all                   0.5     2  22.0 [20.5, 23.5]            "
      "        -                          4.25\n"
      "  2            33   0.500  all                 0.250     2  19.5 [18.0, 21.0]    -2.5 "
      "[-3.0, -2.0]  better                  4.25\n"
      "  3            20   0.200  all                  1.00     1  31.0 [29.5, 32.5]    +1.0 "
      "[+0.5, +1.5]  not significant         4.25\n"
      "  1             7   0.137  none                    -     1  40.0 [38.5, 41.5]  +10.0 "
      "[+9.5, +10.5]  worse                   4.25  rung 1: significantly worse than the "
      "default\n"
      "Settings, by the share of the error's variance that they explain:\n"
      "  SETTING          SHARE  95 %\n"
      "  materials.mode    62 %  30 % to 80 %\n"
      "  floating.count       -  not significant, at most 40 %\n"
      "  floating.size_m      -  not significant\n"
      "Best: trial 2: floating.count 33, floating.size_m 0.500, materials.mode all, "
      "materials.replace_probability 0.250\n"
      "  its error is 2.5 points below the default's [-3.0, -2.0]\n");
}

TEST_F(SearchCommandTest, ASearchWithoutScoresSaysWhatItWaitsFor) {
  v1::SearchStatus search = Status();
  search.clear_trials();
  search.clear_best();
  search.clear_importances();
  search.set_rung(0);
  search.mutable_studies()->Truncate(1);
  searches_.statuses = {search};
  EXPECT_THAT(Run({"camera"}).out,
              HasSubstr("  rung 2: 9 of 12 trainings have ended\n"
                        "  no trial has a score yet; `parallax watch 4` shows the work "
                        "of rung 1\n"));
  search.set_needs("no worker may train: start one with --role all, or " + std::string(99, 'x'));
  searches_.statuses = {search};
  const Outcome shown = Run({"camera"});
  EXPECT_THAT(shown.out, HasSubstr("  no trial has a score yet\n"));
  EXPECT_THAT(Run({}).out, HasSubstr("  no worker may train: start one with --role all, or "));
  EXPECT_THAT(Run({}).out, HasSubstr("xxx...\n"));
  EXPECT_THAT(shown.err, HasSubstr("note: no worker may train: start one with --role all"));
  const Outcome best = Run({"camera", "--best", dir_ + "/best.yaml"});
  EXPECT_EQ(best.exit_code, kExitUsage);
  EXPECT_THAT(best.err, HasSubstr("search 'camera' has no best trial yet: rung 2"));
}

TEST_F(SearchCommandTest, TheConfirmationIsSaidEitherWay) {
  v1::SearchStatus search = Status();
  search.set_state("ended");
  search.set_outcome("confirmed");
  SetFigure(-3, 1, search.mutable_confirmation()->mutable_difference());
  searches_.statuses = {search};
  EXPECT_THAT(Run({"camera"}).out,
              HasSubstr("Best: trial 2: floating.count 33, floating.size_m 0.500, materials.mode "
                        "all, materials.replace_probability 0.250\n"
                        "  its error is 2.5 points below the default's [-3.0, -2.0]\n"
                        "Confirmed with fresh scenes and trainings on middlebury2014-Q: its error "
                        "is 3.0 points below the default's [-4.0, -2.0]\n"));
  searches_.statuses[0].set_outcome("not confirmed");
  SetFigure(0.5, 1, searches_.statuses[0].mutable_confirmation()->mutable_difference());
  EXPECT_THAT(Run({"camera"}).out,
              HasSubstr("\nNot confirmed with fresh scenes and trainings on middlebury2014-Q: its "
                        "error is 0.5 points above the default's [-0.5, +1.5]\n"));
  searches_.statuses[0].set_best(0);
  EXPECT_THAT(Run({"camera"}).out, HasSubstr("\nBest: the default; no trial is better\n"));
}

TEST_F(SearchCommandTest, AVerdictByTheLogErrorHasItsOwnInterval) {
  v1::SearchStatus search = Status();
  v1::SearchScore& last = *search.mutable_trials(2)->mutable_scores(1);
  SetFigure(-0.12, 0.05, last.mutable_log_difference());
  searches_.statuses = {search};
  const std::string text = Run({"camera"}).out;
  EXPECT_THAT(text, HasSubstr("better by log -0.12 [-0.17, -0.07]"));
  EXPECT_THAT(text, HasSubstr("the default's [-3.0, -2.0], by log -0.12 [-0.17, -0.07]\n"));
  const auto trials = nlohmann::json::parse(Run({"camera", "--json"}).out)["trials"];
  EXPECT_EQ(trials[2]["scores"][1]["log_difference"]["value"], -0.12);
  EXPECT_EQ(trials[2]["scores"][0]["log_difference"], nullptr);
}

TEST_F(SearchCommandTest, JsonHasAllOfIt) {
  searches_.statuses = {Status()};
  const auto json = nlohmann::json::parse(Run({"camera", "--json"}).out);
  EXPECT_EQ(json["name"], "camera");
  EXPECT_EQ(json["best"], 2);
  EXPECT_EQ(json["confirmation"], nullptr);
  EXPECT_EQ(json["studies"], nlohmann::json({4, 7}));
  EXPECT_EQ(json["trials"][2]["values"]["floating.count"], "33");
  EXPECT_EQ(json["trials"][2]["scores"][1]["difference"]["low"], -3);
  EXPECT_EQ(json["trials"][1]["ended"], "rung 1: significantly worse than the default");
  EXPECT_EQ(json["importances"][0]["share"]["value"], 0.62);
  EXPECT_EQ(json["importances"][0]["significant"], true);
  EXPECT_EQ(json["importances"][1]["significant"], false);
  EXPECT_EQ(json["trial_states"], nlohmann::json({{"open", 2}, {"dropped", 1}, {"failed", 0}}));
  EXPECT_EQ(json["space"][2]["default"], "all");
}

TEST_F(SearchCommandTest, AFileBeginsASearchAndANameFindsIt) {
  EXPECT_EQ(Run({}).out, "no search was begun; `parallax search FILE` begins one\n");
  searches_.statuses = {Status()};
  const std::string file = dir_ + "/camera.yaml";
  ASSERT_TRUE(WriteFile(file, kCamera).ok());
  EXPECT_EQ(Run({file}).exit_code, kExitOk);
  EXPECT_EQ(searches_.opened.search().trials(), 3);
  EXPECT_EQ(Run({"camera"}).exit_code, kExitOk);
  EXPECT_THAT(Run({}).out, HasSubstr("camera  running   2/3        1.25  trial 2"));
  EXPECT_EQ(Run({file, "--stop"}).exit_code, kExitOk);
  EXPECT_EQ(Run({"camera", "--forget", "--yes"}).exit_code, kExitOk);
  EXPECT_EQ(Run({"camera", "--forget"}).exit_code, kExitUsage);  // Nobody agrees.
  EXPECT_THAT(searches_.orders, ElementsAre("open camera", "stop camera", "forget camera"));
  EXPECT_EQ(nlohmann::json::parse(Run({"camera", "--stop", "--json"}).out)["name"], "camera");
  const Outcome unknown = Run({"kamera"});
  EXPECT_EQ(unknown.exit_code, kExitUsage);
  EXPECT_THAT(unknown.err, HasSubstr("no search 'kamera'"));
  EXPECT_THAT(Run({"quickstart"}).err, HasSubstr("study 'quickstart' has no `search`"));
  EXPECT_EQ(Run({"--stop"}).exit_code, kExitUsage);
  EXPECT_EQ(Run({"camera", "--stop", "--watch"}).exit_code, kExitUsage);
  EXPECT_THAT(Run({"camera", "--picture", "x.png"}).err, HasSubstr("ends with .svg is needed"));
}

TEST_F(SearchCommandTest, WatchingTellsOfChangesAndEndsWithTheSearch) {
  v1::SearchStatus first = Status(), second = Status(), end = Status();
  second.set_waits_for("rung 2: 12 of 12 trainings have ended");
  end.set_state("ended");
  end.clear_waits_for();
  searches_.statuses = {first, first, first, second, end};
  const Outcome watched = Run({"camera", "--watch"});
  EXPECT_EQ(watched.exit_code, kExitOk) << watched.err;
  EXPECT_THAT(watched.out,
              testing::StartsWith("running, rung 2 of 3 with 2 of 3 trials, 1.25 core-hours; rung "
                                  "2: 9 of 12 trainings have ended\n"
                                  "running, rung 2 of 3 with 2 of 3 trials, 1.25 core-hours; rung "
                                  "2: 12 of 12 trainings have ended\n"
                                  "camera: ended, 1.25 core-hours\n"));
  end.set_state("stopped");
  searches_.statuses = {end};
  EXPECT_EQ(Run({"camera", "--watch"}).exit_code, kExitFailed);
}

TEST_F(SearchCommandTest, WatchingOutlastsARestartOfTheCoordinator) {
  searches_.statuses = {Status()};
  std::ostringstream out, err;
  Environment environment;
  environment.out.stream = &out;
  environment.err.stream = &err;
  environment.poll_s = 0.5;  // Longer pauses than a connection's handshake stands without a wait.
  auto watched = std::async(std::launch::async, [&] {
    return RunClient({"search", "camera", "--watch", "--coordinator", searches_.address()},
                     environment);
  });
  while (searches_.lists < 3) {
    ASSERT_NE(watched.wait_for(std::chrono::milliseconds(10)), std::future_status::ready);
  }
  searches_.Stop();
  // Tries to connect fail meanwhile.
  std::this_thread::sleep_for(std::chrono::seconds(3));
  searches_.statuses[0].set_state("ended");
  searches_.Start(searches_.address());
  EXPECT_EQ(watched.wait_for(std::chrono::seconds(6)), std::future_status::ready);
  EXPECT_EQ(watched.get(), kExitOk) << err.str();
  EXPECT_THAT(err.str(), testing::MatchesRegex("note: the coordinator does not answer and is "
                                               "waited for; giving up in [0-9: s]+\n"));
  EXPECT_THAT(out.str(), HasSubstr("\ncamera: ended, "));
}

TEST_F(SearchCommandTest, TheBestRecipeIsAStudyThatStandsAlone) {
  searches_.statuses = {Status()};
  const std::string file = dir_ + "/best.yaml";
  ASSERT_EQ(Run({"camera", "--best", file}).exit_code, kExitOk);
  const auto text = ReadFile(file);
  ASSERT_TRUE(text.ok());
  EXPECT_THAT(*text, testing::StartsWith("# The best of the search camera: trial 2, -2.5 points of "
                                         "error from the default.\nstudy: camera-best\n"));
  EXPECT_THAT(*text, HasSubstr("seed: 1\npairs: 200\nrigs_per_scene: 10\n"
                               "set:\n  rigs:\n    width_px: 640\n    height_px: 360\n"
                               "  render:\n    profile: preview\n"
                               "train:\n  steps: 400\n  seeds: 2\n"
                               "evaluate:\n  benchmarks: [shipped, middlebury2014-Q]\n"
                               "variants:\n  - name: best\n"
                               "    set: {floating: {count: 33, size_m: 0.5}, materials: {mode: "
                               "all, replace_probability: 0.25}}\n"));
  const auto study = LoadStudy(file);
  ASSERT_TRUE(study.ok()) << study.status();
  EXPECT_EQ(study->pairs(), 200);
  EXPECT_EQ(study->train().steps(), 400);
  EXPECT_EQ(study->variants(0).config().floating().count().constant(), 33);
  EXPECT_EQ(study->variants(0).config().rigs().width_px(), 640);
}

// Settings that a short file would not read back to stand there in full.
TEST(BestRecipeTest, TheConfigIsThatOfTheTrialWhateverTheBaseIs) {
  for (const char* set : {
           "{rigs: {camera: {preset: zed_2i}}}",
           "{sensor: {preset: webcam, white_e: 0, read_noise_e: 0}, render: {keep_hdr: true}}",
           "{type: nature, nature: {biomes: {forest: 1, river: 0.5}}}",
           "{assets: {exclude: []}, room: {kinds: [kitchen]}}",
       }) {
    SCOPED_TRACE(set);
    v1::SearchStatus search;
    search.set_name("s");
    const auto study = ParseStudy(
        "study: s\npairs: 40\nset: " + std::string(set) +
            "\nsearch: {space: {lighting.sky_strength: {range: [0.1, 2]}}}\ntrain: {steps: 9}\n"
            "evaluate: {}\n",
        "s.yaml");
    ASSERT_TRUE(study.ok()) << study.status();
    *search.mutable_study() = *study;
    AddTrial({}, search);
    AddTrial({{"lighting.sky_strength", "1.5"}}, search);
    search.set_best(1);
    const auto text = BestRecipe(search);
    ASSERT_TRUE(text.ok()) << text.status();
    const auto read = ParseStudy(*text, "best.yaml");
    ASSERT_TRUE(read.ok()) << read.status() << *text;
    v1::SceneConfig wanted = study->variants(0).config();
    wanted.mutable_lighting()->mutable_sky_strength()->set_constant(1.5);
    EXPECT_EQ(read->variants(0).config().SerializeAsString(), wanted.SerializeAsString()) << *text;
  }
}

TEST(SearchPictureTest, EachScoreIsAPointAndEachTrialALine) {
  const std::string svg = SearchSvg(Status());
  const auto count = [&](const std::string& what) {
    int found = 0;
    for (size_t at = svg.find(what); at != std::string::npos; at = svg.find(what, at + 1)) ++found;
    return found;
  };
  // Six scores in two panels, two of them the default's; three rungs and the best in the legend.
  EXPECT_EQ(count("<circle"), 2 * 4 + 3 + 1);
  EXPECT_EQ(count("<path") - 2, 3);  // Beside the least error and its legend.
  EXPECT_EQ(count("<svg"), 1);
  EXPECT_THAT(svg, HasSubstr("</svg>\n"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(SearchSvg([] {
                v1::SearchStatus search = Status();
                search.clear_trials();
                return search;
              }()),
              HasSubstr("No trial has a score yet."));
}

TEST(SearchViewTest, NamesAreAsShortAsTellsThemApart) {
  v1::SearchSpec search;
  for (const char* path : {"floating.count", "rigs.count", "materials.mode", "type"}) {
    search.add_space()->set_path(path);
  }
  EXPECT_THAT(ShortNames(search), ElementsAre("floating.count", "rigs.count", "mode", "type"));
}

TEST(SearchViewTest, TheDefaultHasTheValuesOfItsConfig) {
  const v1::SearchStatus search = Status();
  EXPECT_EQ(DefaultText(search, "floating.count"), "10..30");
  EXPECT_EQ(DefaultText(search, "materials.mode"), "all");
  EXPECT_EQ(DefaultText(search, "rigs.width_px"), "640");
  EXPECT_EQ(DefaultText(search, "nature.walk.fps"), "6");
  EXPECT_EQ(DefaultText(search, "floating"), "-");
  EXPECT_EQ(DefaultText(search, "floating.nothing"), "-");
}

class SearchPlanTest : public FolderTest {
 protected:
  std::string Camera() {
    EXPECT_TRUE(WriteFile(dir_ + "/camera.yaml", kCamera).ok());
    return dir_ + "/camera.yaml";
  }
};

TEST_F(SearchPlanTest, APlanPricesTheRungsAndTheConfirmation) {
  const Outcome plan = RunCommand({"plan", Camera(), "--cores", "4"});
  ASSERT_EQ(plan.exit_code, kExitOk) << plan.err;
  EXPECT_THAT(plan.out, testing::StartsWith("camera: a search over 4 settings\n  rung"));
  EXPECT_THAT(plan.out, HasSubstr("\nSearch: "));
  EXPECT_THAT(plan.out, HasSubstr(" core-hours in all (950 pairs "));
  const auto json = nlohmann::json::parse(RunCommand({"plan", Camera(), "--json"}).out)["search"];
  // Four of 50 pairs, three of 100 and two of 200, of which each has some from the rung before.
  ASSERT_EQ(json["rungs"].size(), 3u);
  EXPECT_EQ(json["rungs"][0]["pairs_made"], 200);
  EXPECT_EQ(json["rungs"][1]["pairs_made"], 150);
  EXPECT_EQ(json["rungs"][2]["pairs_made"], 200);
  EXPECT_EQ(json["rungs"][2]["trainings"], 4);
  EXPECT_EQ(json["confirmation"]["pairs_made"], 400);
  EXPECT_EQ(json["total"]["trainings"], 8 + 6 + 4 + 4);
  const double pairs_hours = json["rungs"][0]["pairs_core_hours"];
  EXPECT_GT(pairs_hours, 0);
  // 400 steps for each of two seeds, of which the first rung has a quarter.
  EXPECT_LT(json["rungs"][0]["trained_core_hours"], json["confirmation"]["trained_core_hours"]);
}

TEST_F(SearchPlanTest, APlanSaysWhichDifferencesTheLastRungAndTheConfirmationShow) {
  const auto plan = [&](const std::string& more) {
    std::string text = kCamera;
    text.replace(text.find("[shipped,"), 9, "[eth3d,");
    text.replace(text.find("  trials: 3\n"), 12, "  trials: 3\n" + more);
    EXPECT_TRUE(WriteFile(dir_ + "/power.yaml", text).ok());
    const Outcome outcome = RunCommand({"plan", dir_ + "/power.yaml"});
    EXPECT_EQ(outcome.exit_code, kExitOk) << outcome.err;
    return outcome.out;
  };
  // Two variants of a study with as many seeds are compared alike.
  const auto pair = ParseStudy(
      "study: s\npairs: 1\nvariants: [{name: a}, {name: b}]\ntrain: {seeds: 2}\n"
      "evaluate: {benchmarks: [eth3d, middlebury2014-Q]}\n",
      "s.yaml");
  ASSERT_TRUE(pair.ok()) << pair.status();
  const std::vector<BenchmarkPower> powers = PowerOf(*pair, {}, {});
  ASSERT_EQ(powers.size(), 2u);
  const auto line = [&](const BenchmarkPower& power, const std::string& part) {
    return fmt::format(
        "\nSignificant on {} ({} pairs, 80 of 100 times) in {}: differences of bad-2 from {:.1f} "
        "points with 2 seeds\n",
        power.benchmark, power.pairs, part, power.least_difference);
  };
  const std::string whole = plan("");
  EXPECT_THAT(whole, HasSubstr(line(powers[0], "rung 3")));
  EXPECT_THAT(whole, HasSubstr(line(powers[1], "the confirmation")));
  EXPECT_THAT(whole, Not(HasSubstr("middlebury2014-Q (15 pairs, 80 of 100 times) in rung")))
      << "the rungs do not see it";
  EXPECT_THAT(plan("  core_hours: 0.001\n"), HasSubstr(line(powers[0], "rung 1")));
  const std::string one_seed = plan("  rungs: [{seeds: 1}]\n");
  EXPECT_THAT(one_seed, HasSubstr("\nSignificant in rung 1: no difference with one seed\n"));
  EXPECT_THAT(one_seed, HasSubstr(line(powers[1], "the confirmation")));
  const auto json =
      nlohmann::json::parse(RunCommand({"plan", dir_ + "/power.yaml", "--json"}).out)["power"];
  ASSERT_EQ(json.size(), 1u);
  EXPECT_EQ(json[0]["part"], "the confirmation");
  EXPECT_EQ(json[0]["least_difference"], powers[1].least_difference);
}

TEST_F(SearchPlanTest, ACheckNamesTheSearchAndWhatBeginsIt) {
  const std::string file = Camera();
  const Outcome check = RunCommand({"config", "check", file});
  EXPECT_EQ(check.exit_code, kExitOk) << check.err;
  EXPECT_THAT(check.out, HasSubstr("\n  Search: 4 settings, 3 trials, 3 rungs; `parallax search " +
                                   file + "` begins it\n"));
  for (const std::string& err : {check.err, RunCommand({"plan", file}).err}) {
    EXPECT_THAT(err, HasSubstr("note: workers need what this machine lacks: " + file + ":"));
    EXPECT_THAT(err, Not(HasSubstr("parallax run")));
  }
}

TEST_F(SearchPlanTest, ASpaceWithFewerPointsThanTrialsIsNamed) {
  std::string text = kCamera;
  const size_t begin = text.find("    floating.size_m"), end = text.find("  trials: 3");
  text.replace(begin, end - begin, "");
  text.replace(text.find("[0, 40]"), 7, "[0, 1]");
  ASSERT_TRUE(WriteFile(dir_ + "/small.yaml", text).ok());
  EXPECT_THAT(RunCommand({"config", "check", dir_ + "/small.yaml"}).out,
              HasSubstr("1 setting, 3 trials (its space has 2 at most), 3 rungs"));
  EXPECT_THAT(RunCommand({"plan", dir_ + "/small.yaml"}).out,
              HasSubstr("; its space has only 2 of the 3 trials\n"));
  EXPECT_THAT(RunCommand({"plan", Camera()}).out, Not(HasSubstr("its space")));
}

TEST_F(SearchPlanTest, SearchesAreNotSubmitted) {
  const std::string file = Camera();
  EXPECT_THAT(RunCommand({"submit", file}).err,
              HasSubstr("study 'camera' is a search: `parallax search " + file + "` begins it"));
  EXPECT_THAT(RunCommand({"run", file, "--out", dir_ + "/out"}).err,
              HasSubstr("`parallax search " + file + "` begins it"));
  EXPECT_THAT(RunCommand({"plan", file, "--yes"}).err,
              HasSubstr("study 'camera' is a search and is not submitted; `parallax search "));
}

}  // namespace
}  // namespace parallax::client
