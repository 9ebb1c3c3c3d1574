// Keys of trainings and evaluations: whose work is equal, and is done once.
#include "common/base/system/file.h"
#include "train_fixture.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using TrainKeysTest = TrainQueueTest;

TEST_F(TrainKeysTest, TheSameDataTrainerAndSeedAreTrainedOnceAcrossStudies) {
  v1::SubmitRequest request = Request({.name = "first", .pairs = 2, .variants = {"wide"}});
  request.mutable_study()->mutable_evaluate()->add_benchmarks("shipped");
  SubmitRequest(request);
  MakePairs();
  TrainAll();
  EvaluateAll();
  // Other names, and one benchmark more.
  request.mutable_study()->set_name("second");
  request.mutable_study()->mutable_variants(0)->set_name("other");
  request.mutable_study()->mutable_evaluate()->add_benchmarks("eth3d");
  const StudyId second = SubmitRequest(request);
  EXPECT_THAT(States(second, "train"), ElementsAre("other, seed 0: SUCCEEDED"));
  EXPECT_THAT(States(second, "evaluate"),
              ElementsAre("other, seed 0 on shipped: SUCCEEDED", "other, seed 0 on eth3d: READY"));
  EXPECT_EQ(EvaluateJobOf(LeaseOne(Evaluator("e"))).step(), 100);
}

// Their scores are those of other pairs once the worker's folder is complete.
TEST_F(TrainKeysTest, ScoresOfAnIncompleteBenchmarkAreMadeAgainForEachNewStudy) {
  v1::SubmitRequest request = MakeStudy({.pairs = 2});
  request.mutable_study()->mutable_evaluate()->add_benchmarks("eth3d");
  request.mutable_study()->mutable_evaluate()->add_baselines("sgbm");
  for (const int64_t missing : {20, 3, 0}) {
    request.mutable_study()->set_name("missing-" + std::to_string(missing));
    const StudyId study = SubmitRequest(request);
    EXPECT_THAT(States(study, "evaluate"), ElementsAre("sgbm on eth3d: READY")) << missing;
    Complete(EvaluateAnswer(LeaseOne(Evaluator("e")), "e", missing));
    EXPECT_THAT(States(study, "evaluate"), ElementsAre("sgbm on eth3d: SUCCEEDED"));
  }
  request.mutable_study()->set_name("whole");
  EXPECT_THAT(States(SubmitRequest(request), "evaluate"), ElementsAre("sgbm on eth3d: SUCCEEDED"));
  ExpectSound();
}

TEST_F(TrainKeysTest, WhatDecidesANetworkIsInItsKeyAndNamesAreNot) {
  const auto prefix_of = [&](const std::function<void(v1::StudySpec&)>& change) {
    static int number = 0;
    v1::SubmitRequest request =
        Request({.name = "s" + std::to_string(number++), .pairs = 2, .variants = {"wide"}});
    change(*request.mutable_study());
    SubmitRequest(request);
    MakePairs();
    const v1::Lease lease = LeaseOne(Trainer("t" + std::to_string(number)));
    EXPECT_TRUE(queue_->Cancel(StudyId{number}, "", "tester").ok());
    return lease.store_prefix();
  };
  const auto mixture = [](v1::StudySpec& study) -> v1::Mixture& {
    study.mutable_train()->set_only_mixtures(true);
    v1::Mixture* mixture = study.mutable_train()->add_mixtures();
    mixture->set_name("m");
    mixture->add_parts()->set_variant(study.variants(0).name());
    return *mixture;
  };
  const std::string plain = prefix_of([](auto&) {});
  const struct {
    const char* name;
    bool same;
    std::function<void(v1::StudySpec&)> change;
  } cases[] = {
      {"variant's name", true, [](auto& s) { s.mutable_variants(0)->set_name("x"); }},
      {"a mixture of it alone", true, [&](auto& s) { mixture(s); }},
      {"weight of the only part", true,
       [&](auto& s) { mixture(s).mutable_parts(0)->set_weight(7); }},
      {"needs", true, [](auto& s) { s.mutable_train()->mutable_needs()->set_memory_mb(1); }},
      {"study's seed, as the variant's own", true,
       [](auto& s) { s.mutable_variants(0)->set_seed(s.seed()); }},
      {"study's seed", false, [](auto& s) { s.set_seed(2); }},
      {"study's seed, of the training alone", false,
       [](auto& s) {
         s.mutable_variants(0)->set_seed(s.seed());
         s.set_seed(uint64_t{1} << 32);
       }},
      {"variant's seed", false, [](auto& s) { s.mutable_variants(0)->set_seed(2); }},
      {"pairs", false, [](auto& s) { s.set_pairs(3); }},
      {"rigs per scene", false, [](auto& s) { s.set_rigs_per_scene(1); }},
      {"config", false,
       [](auto& s) {
         s.mutable_variants(0)->mutable_config()->mutable_render()->set_samples_per_pixel(8);
       }},
      {"filters", false,
       [](auto& s) {
         s.mutable_variants(0)->mutable_config()->mutable_filters()->set_min_depth_m(1);
       }},
      {"a sensor that is off", true,
       [](auto& s) {
         s.mutable_variants(0)->mutable_config()->mutable_sensor()->set_preset("off");
       }},
      {"sensor", false,
       [](auto& s) {
         s.mutable_variants(0)->mutable_config()->mutable_sensor()->set_preset("webcam");
       }},
      {"steps", false, [](auto& s) { s.mutable_train()->set_steps(101); }},
      {"threads", false, [](auto& s) { s.mutable_train()->set_threads(1); }},
      {"batch", false, [](auto& s) { s.mutable_train()->set_batch(1); }},
      {"trainer", false, [](auto& s) { s.mutable_train()->set_trainer("other"); }},
      {"share", false, [&](auto& s) { mixture(s).set_share(0.5); }},
      {"mismatched", false, [&](auto& s) { mixture(s).set_mismatched(true); }},
      {"share of mismatched pairs where none is", true,
       [&](auto& s) { mixture(s).set_mismatched_share(1); }},
      {"checkpoints", false,
       [](auto& s) {
         s.mutable_evaluate()->add_benchmarks("shipped");
         s.mutable_evaluate()->set_checkpoints(2);
       }},
  };
  for (const auto& c : cases) EXPECT_EQ(prefix_of(c.change) == plain, c.same) << c.name;
  std::set<std::string> by_share;
  for (const double share : {0.1, 0.2, 1.0}) {
    by_share.insert(prefix_of([&](auto& s) {
      mixture(s).set_mismatched(true);
      s.mutable_train()->mutable_mixtures(0)->set_mismatched_share(share);
    }));
  }
  EXPECT_EQ(by_share.size(), 3u);
  EXPECT_TRUE(by_share.contains(prefix_of([&](auto& s) { mixture(s).set_mismatched(true); })))
      << "all of them without a share";
}

// The network's file is what counts, not its place.
TEST_F(TrainKeysTest, AnotherNetworkToStartFromIsAnotherTraining) {
  const auto write = [&](const std::string& name, const std::string& content) {
    const std::string path = testing::TempDir() + "queue_" + std::to_string(getpid()) + name;
    EXPECT_TRUE(WriteFile(path, content).ok());
    return path;
  };
  const auto lease_with = [&](const std::string& network) {
    static int number = 0;
    setenv("PARALLAX_NETWORK", network.c_str(), 1);
    v1::SubmitRequest request =
        Request({.name = "n" + std::to_string(number++), .pairs = 2, .variants = {"wide"}});
    request.mutable_study()->mutable_train()->set_start(network.empty() ? "scratch" : "network");
    SubmitRequest(request);
    MakePairs();
    WorkerFacts worker = Trainer("n" + std::to_string(number));
    if (!network.empty()) {
      EXPECT_THAT(Lease(worker, 1), IsEmpty()) << "without the network";
      worker.tags.push_back(NetworkTag(*Sha256HexOfFile(network)));
    }
    const v1::Lease lease = LeaseOne(worker);
    EXPECT_TRUE(queue_->Cancel(StudyId{number}, "", "tester").ok());
    return lease;
  };
  const v1::Lease scratch = lease_with(""), one = lease_with(write("a.pt", "1")),
                  other = lease_with(write("b.pt", "2")), again = lease_with(write("c.pt", "1"));
  EXPECT_EQ(TrainJobOf(scratch).start(), "");
  EXPECT_EQ(TrainJobOf(one).start(), NetworkTag(Sha256Hex("1")));
  EXPECT_NE(one.store_prefix(), scratch.store_prefix());
  EXPECT_NE(one.store_prefix(), other.store_prefix());
  EXPECT_EQ(one.store_prefix(), again.store_prefix());

  setenv("PARALLAX_NETWORK", "/nowhere/network.pt", 1);
  v1::SubmitRequest request = Request({.name = "lost", .pairs = 2, .variants = {"wide"}});
  request.mutable_study()->mutable_train()->set_start("network");
  ResolveTraining(request.mutable_study());
  const absl::Status lost = queue_->Submit(request, "tester").status();
  EXPECT_EQ(lost.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(lost.message()), HasSubstr("train.start: $PARALLAX_NETWORK: /nowhere"));
  unsetenv("PARALLAX_NETWORK");
}

TEST_F(TrainKeysTest, TheNumberOfLooksIsInTheKeyOfNetworksScoresAlone) {
  const auto states = [&](const std::string& name, int looks) {
    v1::SubmitRequest request = Request({.name = name, .pairs = 2, .variants = {"wide"}});
    v1::EvaluateSpec& evaluate = *request.mutable_study()->mutable_evaluate();
    evaluate.add_benchmarks("shipped");
    evaluate.add_baselines("sgbm");
    if (looks > 0) evaluate.set_looks(looks);
    return States(SubmitRequest(request), "evaluate");
  };
  states("first", 0);
  MakePairs();
  TrainAll();
  for (const v1::Lease& lease : Lease(Evaluator("e"), 9)) {
    EXPECT_EQ(EvaluateJobOf(lease).looks(), 0);
    Complete(EvaluateAnswer(lease, "e"));
  }
  EXPECT_THAT(states("same", 2),
              ElementsAre("wide, seed 0 on shipped: SUCCEEDED", "sgbm on shipped: SUCCEEDED"));
  EXPECT_THAT(states("once", 1),
              ElementsAre("wide, seed 0 on shipped: READY", "sgbm on shipped: SUCCEEDED"));
  EXPECT_EQ(EvaluateJobOf(LeaseOne(Evaluator("e"))).looks(), 1);
}

TEST_F(TrainKeysTest, EqualTrainingsOfTwoStudiesAreDoneByOneWorkerAtATime) {
  SubmitRequest(Request({.name = "first", .pairs = 2, .variants = {"wide"}}));
  const StudyId second = SubmitRequest(Request({.name = "second", .pairs = 2, .variants = {"x"}}));
  MakePairs();
  const v1::Lease lease = LeaseOne(Trainer("t"));
  EXPECT_THAT(Lease(Trainer("u"), 4), IsEmpty());
  EXPECT_THAT(States(second, "train"), ElementsAre("x, seed 0: BLOCKED"));
  Complete(TrainAnswer(lease, "t"));
  EXPECT_THAT(States(second, "train"), ElementsAre("x, seed 0: SUCCEEDED"));
}

}  // namespace
}  // namespace parallax
