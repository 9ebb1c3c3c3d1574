// Trainings and evaluations: which jobs a study has, what they wait for, what workers are told, and
// which results are right.
#include <chrono>
#include <cmath>

#include "common/config/check/limits.h"
#include "common/rpc/endpoint.h"
#include "train_fixture.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

using TrainKindsTest = TrainQueueTest;

TEST_F(TrainKindsTest, ATrainingOfEachSetAndSeedWaitsForThePairsOfItsParts) {
  v1::SubmitRequest request = Request();
  request.mutable_study()->mutable_train()->set_seeds(2);
  v1::Mixture* both = request.mutable_study()->mutable_train()->add_mixtures();
  both->set_name("both");
  both->add_parts()->set_variant("wide");
  both->add_parts()->set_variant("narrow");
  const StudyId study = SubmitRequest(request);
  EXPECT_THAT(
      States(study, "train"),
      ElementsAre("wide, seed 0: BLOCKED", "narrow, seed 0: BLOCKED", "both, seed 0: BLOCKED",
                  "wide, seed 1: BLOCKED", "narrow, seed 1: BLOCKED", "both, seed 1: BLOCKED"));
  EXPECT_THAT(Lease(Trainer("t"), 9), IsEmpty());
  // The first variant's pairs alone.
  for (;;) {
    const auto leases = Lease(AnyWorker("w"), 8);
    if (leases.empty()) break;
    for (const v1::Lease& lease : leases) {
      if (lease.variant() == "narrow" && lease.kind() == "render") {
        Fail(Failure(lease, "w", "later"));
      } else {
        Complete(Answer(lease, "w"));
      }
    }
  }
  EXPECT_THAT(
      States(study, "train"),
      ElementsAre("wide, seed 0: READY", "narrow, seed 0: BLOCKED", "both, seed 0: BLOCKED",
                  "wide, seed 1: READY", "narrow, seed 1: BLOCKED", "both, seed 1: BLOCKED"));
  ExpectSound();
  clock_.Advance(1000);
  Tick();
  MakePairs();
  const auto leases = Lease(Trainer("t"), 9);
  ASSERT_THAT(leases, SizeIs(6));
  EXPECT_EQ(leases[0].label(), "wide, seed 0") << "the first seed of all sets comes first";
  EXPECT_EQ(leases[2].label(), "both, seed 0");
  EXPECT_EQ(State(study), v1::STUDY_STATE_RUNNING) << "its trainings are still to be done";
  for (const v1::Lease& lease : leases) {
    EXPECT_EQ(Complete(TrainAnswer(lease, "t")), v1::REPORT_OUTCOME_OK);
  }
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(TrainKindsTest, AWorkerIsToldTheFoldersOfAllPairs) {
  v1::SubmitRequest request = Request({.pairs = 5, .rigs_per_scene = 2, .variants = {"wide"}});
  v1::TrainSpec& train = *request.mutable_study()->mutable_train();
  train.set_width_px(64);
  train.set_height_px(32);
  train.set_batch(3);
  train.set_threads(4);
  SubmitRequest(request);
  MakePairs();
  const v1::Lease lease = LeaseOne(Trainer("t"));
  const v1::TrainJob job = TrainJobOf(lease);
  EXPECT_EQ(job.name(), "wide");
  EXPECT_EQ(job.trainer(), "builtin");
  EXPECT_EQ(job.steps(), 100);
  EXPECT_EQ(job.width_px(), 64);
  EXPECT_EQ(job.height_px(), 32);
  EXPECT_EQ(job.batch(), 3);
  EXPECT_EQ(job.threads(), 4);
  EXPECT_EQ(job.share(), 1);
  EXPECT_EQ(job.checkpoints(), 1);
  EXPECT_EQ(job.resume_folder(), lease.store_prefix());
  ASSERT_EQ(job.parts_size(), 1);
  EXPECT_EQ(job.parts(0).variant(), "wide");
  std::vector<std::pair<uint32_t, std::vector<uint32_t>>> seen;
  for (const v1::FrameFolder& folder : job.parts(0).folders()) {
    EXPECT_THAT(folder.folder(), HasSubstr("/.attempt-"));
    seen.push_back({folder.scene(), {folder.rigs().begin(), folder.rigs().end()}});
  }
  using Rigs = std::vector<uint32_t>;
  EXPECT_THAT(seen, ElementsAre(std::pair(0u, Rigs{0, 1}), std::pair(1u, Rigs{0, 1}),
                                std::pair(2u, Rigs{0})));
  // The folders are those of the pairs.
  const auto frames = Frames(StudyId{1});
  EXPECT_EQ(frames[0].frame().path(), job.parts(0).folders(0).folder() + "/000");
  Complete(TrainAnswer(lease, "t"));
}

TEST_F(TrainKindsTest, CheckpointsAreLitterOnceTheResultIsStored) {
  SubmitRequest(Request({.pairs = 2, .variants = {"wide"}}));
  MakePairs();
  const v1::Lease lease = LeaseOne(Trainer("t"));
  const std::string checkpoints = AttemptFolderOf(lease) + "/resume";
  clock_.Advance(1);
  EXPECT_THAT(*queue_->ListLitter(0, 100), testing::Not(testing::Contains(checkpoints)));
  EXPECT_EQ(Complete(TrainAnswer(lease, "t")), v1::REPORT_OUTCOME_OK);
  clock_.Advance(1);
  EXPECT_THAT(*queue_->ListLitter(0, 100), testing::Contains(checkpoints));
  ExpectSound();
}

// A study of "wide", trained on as it is and curated.
v1::SubmitRequest CuratedRequest(v1::SubmitRequest request, bool curated_first = false) {
  v1::StudySpec& study = *request.mutable_study();
  study.mutable_variants(0)->mutable_config()->mutable_filters()->set_max_ambiguous_share(0.5);
  study.mutable_train()->set_seeds(2);
  study.mutable_train()->set_only_mixtures(true);
  for (const bool curated : {curated_first, !curated_first}) {
    v1::Mixture* mixture = study.mutable_train()->add_mixtures();
    mixture->set_name(curated ? "good" : "all");
    mixture->set_curated(curated);
    mixture->add_parts()->set_variant("wide");
  }
  return request;
}

TEST_F(TrainKindsTest, ACuratedSetWaitsForTheNetworkOfItsPlainTwin) {
  const StudyId study =
      SubmitRequest(CuratedRequest(Request({.pairs = 2, .variants = {"wide"}}), true));
  MakePairs();
  EXPECT_THAT(States(study, "train"), ElementsAre("all, seed 0: READY", "good, seed 0: BLOCKED",
                                                  "all, seed 1: READY", "good, seed 1: BLOCKED"));
  const auto plain = Lease(Trainer("t"), 2);
  ASSERT_THAT(plain, SizeIs(2));
  EXPECT_EQ(plain[1].label(), "all, seed 1");
  Complete(TrainAnswer(plain[1], "t"));
  EXPECT_THAT(States(study, "train"), ElementsAre("all, seed 0: LEASED", "good, seed 0: BLOCKED",
                                                  "all, seed 1: SUCCEEDED", "good, seed 1: READY"));
  const v1::Lease lease = LeaseOne(Trainer("u"));
  const v1::TrainJob job = TrainJobOf(lease);
  EXPECT_TRUE(job.curated());
  EXPECT_EQ(job.curator_path(), AttemptFolderOf(plain[1]) + "/step-100.pt") << "the trained one";
  EXPECT_EQ(job.curator().sha256(), std::string(64, 'b'));
  EXPECT_EQ(job.parts(0).filters().max_ambiguous_share(), 0.5);
  EXPECT_FALSE(TrainJobOf(plain[1]).has_curator());
  Complete(TrainAnswer(lease, "u"));
  ExpectSound();
  // Where no network comes to score its frames, none can be trained on them.
  Fail(Failure(plain[0], "t", "no such luck"));
  for (int i = 0; i < 20 && State(study) == v1::STUDY_STATE_RUNNING; ++i) {
    clock_.Advance(1000);
    Tick();
    for (const v1::Lease& again : Lease(Trainer("t"), 9)) Fail(Failure(again, "t", "nor now"));
  }
  EXPECT_NE(State(study), v1::STUDY_STATE_RUNNING);
  EXPECT_THAT(States(study, "train")[1], HasSubstr("good, seed 0: "));
  EXPECT_THAT(States(study, "train")[1], testing::Not(HasSubstr("SUCCEEDED")));
}

TEST_F(TrainKindsTest, EqualCuratedTrainingsHaveOneKeyAndTheirTwinsAreReused) {
  std::vector<std::string> prefixes;
  for (const int steps : {100, 100, 101}) {
    const std::string number = std::to_string(prefixes.size());
    v1::SubmitRequest request =
        CuratedRequest(Request({.name = "s" + number, .pairs = 2, .variants = {"wide"}}));
    request.mutable_study()->mutable_train()->set_seeds(1);
    request.mutable_study()->mutable_train()->set_steps(steps);
    const StudyId study = SubmitRequest(request);
    MakePairs();
    std::map<std::string, std::string> prefix_of;
    for (int i = 0; i < 2; ++i) {
      for (const v1::Lease& lease : Lease(Trainer("t"), 1)) {
        prefix_of[lease.label()] = lease.store_prefix();
        if (i == 0) Complete(TrainAnswer(lease, "t"));
        if (i == 1) {
          EXPECT_TRUE(queue_->Cancel(study, "", "tester").ok());
        }
      }
    }
    if (steps == 100 && number == "1") {
      EXPECT_EQ(prefix_of.count("all, seed 0"), 0u) << "its network is there";
    }
    prefixes.push_back(prefix_of["good, seed 0"]);
  }
  EXPECT_NE(prefixes[0], "");
  EXPECT_EQ(prefixes[0], prefixes[1]);
  EXPECT_NE(prefixes[0], prefixes[2]);
}

TEST_F(TrainKindsTest, ACuratedSetWithoutATwinIsRefused) {
  v1::SubmitRequest request = CuratedRequest(Request({.pairs = 2, .variants = {"wide"}}));
  request.mutable_study()->mutable_train()->mutable_mixtures(0)->set_share(0.5);
  ResolveTraining(request.mutable_study());
  const auto reply = queue_->Submit(request, "tester");
  EXPECT_EQ(reply.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(reply.status().message()), HasSubstr("\"good\" is curated"));
}

TEST_F(TrainKindsTest, SeventyFiveThousandPairsAreToldAtOnce) {
  constexpr int64_t kPairs = 75'000;
  SubmitRequest(Request({.pairs = kPairs, .rigs_per_scene = 1000, .variants = {"wide"}}));
  for (;;) {
    const auto leases = Lease(AnyWorker("w"), 8);
    if (leases.empty()) break;
    for (const v1::Lease& lease : leases) Complete(Answer(lease, "w"));
  }
  const auto start = std::chrono::steady_clock::now();
  const v1::Lease lease = LeaseOne(Trainer("t"));
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  int64_t rigs = 0;
  const v1::TrainJob job = TrainJobOf(lease);
  for (const v1::FrameFolder& folder : job.parts(0).folders()) rigs += folder.rigs_size();
  EXPECT_EQ(rigs, kPairs);
  EXPECT_LT(lease.spec().size(), 1u << 20);
  EXPECT_LT(took.count(), 5);
  RecordProperty("spec_ms", static_cast<int>(1000 * took.count()));
}

TEST(TrainJobMessage, TheLargestTrainingSetFitsIntoALease) {
  v1::TrainJob job;
  v1::FrameSet* set = job.add_parts();
  const std::string folder =
      StorePrefixOf(Sha256Of("x")) + "/.attempt-" + std::to_string(uint64_t{1} << 63);
  for (int64_t i = 0; i < kMaxTrainingPairs; ++i) {  // A pair a scene.
    v1::FrameFolder* one = set->add_folders();
    one->set_folder(folder);
    one->add_rigs(0);
    one->set_scene(static_cast<uint32_t>(i));
  }
  EXPECT_LT(job.ByteSizeLong(), static_cast<size_t>(kMaxRpcMessageBytes));
}

TEST_F(TrainKindsTest, EvaluationsWaitForTheirNetworkAndBaselinesForNothing) {
  v1::SubmitRequest request = Request({.pairs = 2, .variants = {"wide"}});
  v1::EvaluateSpec& evaluate = *request.mutable_study()->mutable_evaluate();
  evaluate.add_benchmarks("shipped");
  evaluate.add_benchmarks("eth3d");
  evaluate.add_baselines("sgbm");
  const StudyId study = SubmitRequest(request);
  EXPECT_THAT(States(study, "evaluate"),
              ElementsAre("wide, seed 0 on shipped: BLOCKED", "wide, seed 0 on eth3d: BLOCKED",
                          "sgbm on shipped: READY", "sgbm on eth3d: READY"));
  const v1::EvaluateJob baseline = EvaluateJobOf(LeaseOne(Evaluator("e")));
  EXPECT_EQ(baseline.trainer(), "sgbm");
  EXPECT_EQ(baseline.name(), "");
  EXPECT_FALSE(baseline.has_seed());
  EXPECT_FALSE(baseline.has_checkpoint());
  ASSERT_TRUE(queue_->WorkerLost("e").ok());
  MakePairs();
  const v1::Lease training = LeaseOne(Trainer("t"));
  Complete(TrainAnswer(training, "t"));
  const auto leases = Lease(Evaluator("f"), 9);
  ASSERT_THAT(leases, SizeIs(4));
  const v1::EvaluateJob job = EvaluateJobOf(leases[0]);
  EXPECT_EQ(leases[0].label(), "wide, seed 0 on shipped");
  EXPECT_EQ(job.name(), "wide");
  EXPECT_EQ(job.trainer(), "builtin");
  EXPECT_EQ(job.seed(), 0u);
  EXPECT_TRUE(job.has_seed());
  EXPECT_EQ(job.benchmark(), "shipped");
  EXPECT_EQ(job.step(), 100);
  EXPECT_EQ(job.checkpoint_path(), AttemptFolderOf(training) + "/step-100.pt");
  EXPECT_EQ(job.checkpoint().size(), 10);
  EXPECT_EQ(State(study), v1::STUDY_STATE_RUNNING);
  for (const v1::Lease& lease : leases) Complete(EvaluateAnswer(lease, "f"));
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(TrainKindsTest, ABaselineIsScoredAlthoughTheFirstVariantGivesUp) {
  v1::SubmitRequest request = Request({.pairs = 2, .rigs_per_scene = 1, .variants = {"wide"}});
  request.mutable_study()->mutable_evaluate()->add_benchmarks("shipped");
  request.mutable_study()->mutable_evaluate()->add_baselines("sgbm");
  const StudyId study = SubmitRequest(request);
  for (int i = 0; i < 200; ++i) {
    const auto leases = Lease(Solver("w"), 1);
    if (leases.empty()) break;
    Complete(RejectAnswer(leases[0], "w", /*with_layout=*/false));
  }
  EXPECT_THAT(States(study, "train"), ElementsAre("wide, seed 0: CANCELLED"));
  EXPECT_THAT(States(study, "evaluate"),
              ElementsAre("wide, seed 0 on shipped: CANCELLED", "sgbm on shipped: READY"));
  EXPECT_EQ(State(study), v1::STUDY_STATE_RUNNING);
  Complete(EvaluateAnswer(LeaseOne(Evaluator("e")), "e"));
  EXPECT_EQ(State(study), v1::STUDY_STATE_FAILED);
}

TEST_F(TrainKindsTest, HeldOutPairsAreABenchmarkThatNothingIsTrainedOn) {
  v1::SubmitRequest request = Request({.pairs = 2, .variants = {"wide"}});
  v1::EvaluateSpec& evaluate = *request.mutable_study()->mutable_evaluate();
  evaluate.set_heldout_pairs(3);
  evaluate.add_group_by("class");
  const StudyId study = SubmitRequest(request);
  EXPECT_THAT(States(study, "train"), ElementsAre("wide, seed 0: BLOCKED"));
  EXPECT_THAT(States(study, "evaluate"), ElementsAre("wide, seed 0 on heldout: BLOCKED"));
  MakePairs();
  // The seeds differ: no scene of one is one of the other.
  std::map<std::string, std::set<std::string>> paths;
  for (const v1::PublishedFrame& frame : Frames(study)) {
    paths[frame.variant()].insert(frame.frame().path());
  }
  EXPECT_THAT(paths["wide"], SizeIs(2));
  EXPECT_THAT(paths["heldout"], SizeIs(3));
  for (const std::string& path : paths["heldout"]) EXPECT_EQ(paths["wide"].count(path), 0u);
  TrainAll();
  const v1::EvaluateJob job = EvaluateJobOf(LeaseOne(Evaluator("e")));
  EXPECT_EQ(job.heldout().variant(), "heldout");
  int rigs = 0;
  for (const v1::FrameFolder& folder : job.heldout().folders()) rigs += folder.rigs_size();
  EXPECT_EQ(rigs, 3);
  EXPECT_THAT(job.group_by(), ElementsAre("class"));
}

TEST_F(TrainKindsTest, EachCheckpointIsEvaluatedSpreadEvenlyUpToTheLast) {
  v1::SubmitRequest request = Request({.pairs = 2, .variants = {"wide"}});
  v1::EvaluateSpec& evaluate = *request.mutable_study()->mutable_evaluate();
  evaluate.add_benchmarks("shipped");
  evaluate.set_checkpoints(3);
  const StudyId study = SubmitRequest(request);
  MakePairs();
  const v1::Lease training = LeaseOne(Trainer("t"));
  EXPECT_EQ(TrainJobOf(training).checkpoints(), 3);
  v1::CompleteRequest answer = TrainAnswer(training, "t", {30, 70, 100});
  // One more than asked for.
  EXPECT_THAT(
      std::string(queue_->Complete(TrainAnswer(training, "t", {1, 2, 3, 4})).status().message()),
      HasSubstr("4 checkpoints, wanted at most 3"));
  clock_.Advance(1000);
  Tick();
  Complete(TrainAnswer(LeaseOne(Trainer("t")), "t", {30, 70, 100}));
  std::vector<int64_t> steps;
  for (const v1::Lease& lease : Lease(Evaluator("e"), 9)) {
    steps.push_back(EvaluateJobOf(lease).step());
    Complete(EvaluateAnswer(lease, "e"));
  }
  EXPECT_THAT(steps, ElementsAre(30, 70, 100));
  EXPECT_THAT(States(study, "evaluate"),
              ElementsAre("wide, seed 0 on shipped, checkpoint 1 of 3: SUCCEEDED",
                          "wide, seed 0 on shipped, checkpoint 2 of 3: SUCCEEDED",
                          "wide, seed 0 on shipped, checkpoint 3 of 3: SUCCEEDED"));
}

// ---- Which results are right
TEST_F(TrainKindsTest, WrongResultsAreRefused) {
  options_.retry.max_app_failures = 100;
  options_.retry.quarantine_workers = 100;
  options_.retry.backoff_max_s = options_.retry.backoff_min_s = 1;
  Reopen();
  SubmitRequest(Request({.pairs = 2, .variants = {"wide"}}));
  MakePairs();
  const struct {
    std::function<void(v1::TrainResult&)> breaks;
    const char* want;
  } cases[] = {
      {[](auto& r) { r.set_path("../x"); }, "path '../x' leaves the store"},
      {[](auto& r) { r.set_path("ab/cd/.attempt-1"); }, "wanted a folder under '"},
      {[](auto& r) { r.clear_files(); }, "no files"},
      {[](auto& r) { r.mutable_files(0)->set_name("../a"); }, "'../a' leaves its folder"},
      {[](auto& r) { *r.add_files() = r.files(0); }, "is named twice"},
      {[](auto& r) { r.mutable_files(0)->set_size(-1); }, "has a negative size"},
      {[](auto& r) { r.mutable_files(0)->set_sha256("AA"); }, "has no SHA-256"},
      {[](auto& r) { r.clear_checkpoints(); }, "no checkpoints"},
      {[](auto& r) { r.mutable_checkpoints(0)->set_name("x.pt"); },
       "checkpoint 'x.pt' is not among its files"},
      {[](auto& r) { r.mutable_checkpoints(0)->set_step(0); },
       "a checkpoint of step 0 after one of step 0"},
      {[](auto& r) { r.set_loss(std::nan("")); }, "a loss of nan, allowed is"},
      {[](auto& r) { r.set_loss(1e308); }, "a loss of 1e+308, allowed is"},
      {[](auto& r) { r.set_train_s(-1); }, "a time in seconds of -1, allowed is"},
      {[](auto& r) { r.set_pairs(int64_t{1} << 62); },
       "4611686018427387904 pairs trained on, of 2"},
      {[](auto& r) { r.mutable_checkpoints(0)->set_step(INT64_MAX); },
       "a checkpoint's step of 9.223372036854776e+18, allowed is"},
      {[](auto& r) { r.mutable_files(0)->set_size(0); }, "checkpoint 'step-100.pt' is empty"},
      {[](auto& r) { r.set_pairs(0); }, "0 pairs trained on"},
  };
  for (const auto& c : cases) {
    const std::string worker = std::string("t") + std::to_string(&c - cases);
    v1::CompleteRequest request = TrainAnswer(LeaseOne(Trainer(worker)), worker);
    v1::TrainResult result;
    ASSERT_TRUE(result.ParseFromString(request.result()));
    c.breaks(result);
    request.set_result(result.SerializeAsString());
    const auto outcome = queue_->Complete(request);
    EXPECT_EQ(outcome.status().code(), absl::StatusCode::kInvalidArgument) << c.want;
    EXPECT_THAT(std::string(outcome.status().message()), HasSubstr(c.want));
    clock_.Advance(100);
    Tick();
  }
}

TEST_F(TrainKindsTest, WrongScoresAreRefused) {
  options_.retry.max_app_failures = 100;
  options_.retry.quarantine_workers = 100;
  options_.retry.backoff_max_s = options_.retry.backoff_min_s = 1;
  Reopen();
  v1::SubmitRequest request = MakeStudy({.pairs = 2});
  request.mutable_study()->mutable_evaluate()->add_benchmarks("shipped");
  request.mutable_study()->mutable_evaluate()->add_baselines("sgbm");
  SubmitRequest(request);
  const struct {
    std::function<void(v1::EvaluateResult&)> breaks;
    const char* want;
  } cases[] = {
      {[](auto& r) { r.mutable_files(0)->set_name("x"); }, "no file scores.jsonl"},
      {[](auto& r) { r.set_pairs(0); }, "0 pairs scored"},
      {[](auto& r) { r.set_pairs_missing(-1); }, "a negative number of missing pairs"},
      {[](auto& r) { r.set_metric(""); }, "metric '', wanted is bad-N"},
      {[](auto& r) { r.set_metric("a\nb"); }, "metric 'a b', wanted is bad-N"},
      {[](auto& r) { r.set_metric("<script>"); }, "metric '<script>', wanted is bad-N"},
      {[](auto& r) { r.set_value(std::nan("")); }, "a value of nan, allowed is [0, 100]"},
      {[](auto& r) { r.set_value(-5); }, "a value of -5, allowed is [0, 100]"},
      {[](auto& r) { r.set_pairs(int64_t{1} << 62); }, "allowed are at most 100000000"},
      {[](auto& r) { r.set_predict_s(-1); }, "a time in seconds of -1, allowed is"},
      {[](auto& r) { r.set_path("a"); }, "wanted a folder under '"},
  };
  for (const auto& c : cases) {
    v1::CompleteRequest answer = EvaluateAnswer(LeaseOne(Evaluator("e")), "e");
    v1::EvaluateResult result;
    ASSERT_TRUE(result.ParseFromString(answer.result()));
    c.breaks(result);
    answer.set_result(result.SerializeAsString());
    EXPECT_THAT(std::string(queue_->Complete(answer).status().message()), HasSubstr(c.want));
    clock_.Advance(100);
    Tick();
  }
}

// ---- Failures
TEST_F(TrainKindsTest, AFailedTrainingFailsTheStudyAndARetryGoesOn) {
  options_.retry.max_app_failures = 1;
  Reopen();
  v1::SubmitRequest request = Request({.pairs = 2, .variants = {"wide"}});
  request.mutable_study()->mutable_evaluate()->add_benchmarks("shipped");
  const StudyId study = SubmitRequest(request);
  MakePairs();
  Fail(Failure(LeaseOne(Trainer("t")), "t", "loss is NaN", false));
  EXPECT_THAT(States(study, "train"), ElementsAre("wide, seed 0: FAILED"));
  EXPECT_THAT(States(study, "evaluate"), ElementsAre("wide, seed 0 on shipped: CANCELLED"));
  const v1::StudyStatus status = Status(study);
  EXPECT_EQ(status.state(), v1::STUDY_STATE_FAILED);
  ASSERT_GE(status.variants(0).problems_size(), 1);
  EXPECT_THAT(status.variants(0).problems(0).error(), HasSubstr("loss is NaN"));
  ASSERT_TRUE(queue_->Retry(study, "tester").ok());
  EXPECT_EQ(State(study), v1::STUDY_STATE_RUNNING);
  TrainAll();
  EvaluateAll();
  EXPECT_EQ(State(study), v1::STUDY_STATE_SUCCEEDED);
}

TEST_F(TrainKindsTest, CancellingEndsTrainingsAndTellsTheWorker) {
  const StudyId study = SubmitRequest(Request({.pairs = 2, .variants = {"wide"}}));
  MakePairs();
  const v1::Lease lease = LeaseOne(Trainer("t"));
  ASSERT_TRUE(queue_->Pause(study, "", "tester").ok());
  ASSERT_TRUE(queue_->Cancel(study, "enough", "tester").ok());
  EXPECT_THAT(States(study, "train"), ElementsAre("wide, seed 0: CANCELLED"));
  EXPECT_EQ(Complete(TrainAnswer(lease, "t")), v1::REPORT_OUTCOME_CANCELLED);
  EXPECT_EQ(State(study), v1::STUDY_STATE_CANCELLED);
}

TEST_F(TrainKindsTest, APausedStudysTrainingsAreNotLeased) {
  const StudyId study = SubmitRequest(Request({.pairs = 2, .variants = {"wide"}}));
  MakePairs();
  ASSERT_TRUE(queue_->Pause(study, "", "tester").ok());
  EXPECT_THAT(Lease(Trainer("t"), 1), IsEmpty());
  ASSERT_TRUE(queue_->Resume(study, "", "tester").ok());
  EXPECT_THAT(Lease(Trainer("t"), 1), SizeIs(1));
}

}  // namespace
}  // namespace parallax
