// Kind `evaluate`: the scores of a trained network, or of a baseline, on a benchmark.
//
// Results: "evaluate" by work key, an EvaluateResult. The key covers the training's key, so that a
// benchmark is scored once for each network, whichever study asks. Scores of a benchmark that was
// incomplete where they were made are not used for later studies: see KeyFor.
#include <fmt/core.h>

#include <regex>

#include "common/base/ability_tags.h"
#include "common/base/names.h"
#include "common/base/status.h"
#include "common/config/content_folders.h"
#include "common/config/training_plan.h"
#include "coordinator/queue/commands/report_check.h"
#include "coordinator/queue/kinds/folder_kind.h"
#include "coordinator/queue/kinds/result_figures.h"

namespace parallax {
namespace {

constexpr char kScoresFile[] = "scores.jsonl";
constexpr int kBaselineThreads = 2;

constexpr int64_t kMostPairs = 100'000'000;

// The largest value of a metric such as "bad-2 nocc" or "epe all pooled": percent, or pixels of the
// largest image. 0 for a text that is no metric.
double HighestOf(const std::string& metric) {
  static const std::regex kMetric(
      R"((bad-\d+(?:\.\d+)?|d1|epe|rmse) [a-z][a-z0-9_-]{0,30}(?: pooled)?)");
  std::smatch match;
  if (!std::regex_match(metric, match, kMetric)) return 0;
  const std::string measure = match[1];
  return measure == "epe" || measure == "rmse" ? 1e6 : 100;
}

std::string WhyNoResult(const v1::EvaluateResult& result) {
  const auto is_scores = [](const v1::FileEntry& file) { return file.name() == kScoresFile; };
  if (std::none_of(result.files().begin(), result.files().end(), is_scores)) {
    return std::string("no file ") + kScoresFile;
  }
  if (result.pairs() < 1) return fmt::format("{} pairs scored", result.pairs());
  if (result.pairs_missing() < 0) return "a negative number of missing pairs";
  if (result.pairs() > kMostPairs || result.pairs_missing() > kMostPairs) {
    return fmt::format("{} pairs scored and {} missing, allowed are at most {}", result.pairs(),
                       result.pairs_missing(), kMostPairs);
  }
  const double highest = HighestOf(result.metric());
  if (highest == 0) {
    return "metric '" + OneLine(result.metric()).substr(0, 60) +
           "', wanted is bad-N, d1, epe or rmse with a region";
  }
  if (std::string why = WhyNotIn("a value", result.value(), 0, highest); !why.empty()) return why;
  if (std::string why = WhyNotIn("a time in seconds", result.predict_s(), 0, kLongestS);
      !why.empty()) {
    return why;
  }
  return "";
}

// Checkpoint `index` of `wanted`, spread evenly over those that a training has left; the last is
// the last.
const v1::TrainedCheckpoint& PickCheckpoint(const v1::TrainResult& result, int index, int wanted) {
  const int64_t there = result.checkpoints_size();
  const int64_t at = there * (index + 1) / std::max(1, wanted) - 1;
  return result.checkpoints(static_cast<int>(std::clamp<int64_t>(at, 0, there - 1)));
}

std::vector<JobWait> WaitsOfEvaluation(const v1::EvaluateInput& input) {
  std::vector<JobWait> waits;
  if (input.train_job() != 0) waits.push_back(JobWait::OnJob(input.train_job()));
  if (input.heldout_variant_id() != 0) {
    waits.push_back(JobWait::OnPairs(input.heldout_variant_id(), input.heldout_pairs()));
  }
  return waits;
}

class EvaluateKind final : public FolderKind<v1::EvaluateInput, v1::EvaluateResult> {
 public:
  EvaluateKind()
      : FolderKind("evaluate",
                   {.stages = {"evaluate"}, .doing = "evaluating", .has_output = true}) {}

  // ---- Messages
  absl::StatusOr<std::string> Spec(const LeasedJob& lease, ResultReader& results) const override {
    ASSIGN_OR_RETURN(v1::EvaluateInput input, InputOf<v1::EvaluateInput>(lease.job.input));
    v1::EvaluateJob& spec = *input.mutable_job();
    if (input.heldout_variant_id() != 0) {
      RETURN_IF_ERROR(AddFolders(input.heldout_variant_id(), input.heldout_pairs(), results,
                                 spec.mutable_heldout()));
    }
    if (input.train_job() != 0) RETURN_IF_ERROR(AddCheckpoint(lease.job.id, input, results));
    return spec.SerializeAsString();
  }

  std::string LabelOf(std::string_view bytes) const override {
    const auto input = InputOf<v1::EvaluateInput>(bytes);
    if (!input.ok()) return "";
    const v1::EvaluateJob& job = input->job();
    std::string label = job.name().empty() ? job.trainer() : job.name();
    if (job.has_seed()) label += fmt::format(", seed {}", job.seed());
    label += " on " + job.benchmark();
    if (input->checkpoints() < 2) return label;
    return fmt::format("{}, checkpoint {} of {}", label, input->checkpoint() + 1,
                       input->checkpoints());
  }

  std::optional<Score> ScoreOf(std::string_view input_bytes,
                               std::string_view packed) const override {
    const auto input = InputOf<v1::EvaluateInput>(input_bytes);
    v1::EvaluateResult result;
    if (!input.ok() || !UnpackMessage(packed, result).ok()) return std::nullopt;
    const v1::EvaluateJob& job = input->job();
    Score score;
    score.set = job.name();
    score.predictor = job.trainer();
    if (job.has_seed()) score.seed = job.seed();
    score.benchmark = job.benchmark();
    score.checkpoint = input->checkpoint() + 1;
    score.checkpoints = std::max(1, input->checkpoints());
    score.metric = result.metric();
    score.value = result.value();
    score.pairs = result.pairs();
    return score;
  }

  double CoreSecondsOf(std::string_view input_bytes, std::string_view packed) const override {
    const auto input = InputOf<v1::EvaluateInput>(input_bytes);
    v1::EvaluateResult result;
    if (!input.ok() || !UnpackMessage(packed, result).ok()) return 0;
    return result.predict_s() * std::max(1, input->job().threads());
  }

  std::vector<StageSeconds> StagesOf(std::string_view bytes) const override {
    v1::EvaluateResult result;
    if (!result.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return {};
    return {{"predict", result.predict_s()}};
  }

  std::vector<JobWait> WaitsOf(std::string_view bytes) const override {
    const auto input = InputOf<v1::EvaluateInput>(bytes);
    return input.ok() ? WaitsOfEvaluation(*input) : std::vector<JobWait>();
  }

  // ---- Hooks
  absl::StatusOr<JobKeys> Keys(WorkDesk& desk, const JobFacts& job) const override {
    ASSIGN_OR_RETURN(v1::EvaluateInput input, InputOf<v1::EvaluateInput>(job.input));
    v1::EvaluateJob settings = input.job();
    std::string predictor = settings.trainer();
    if (input.train_job() != 0) {
      ASSIGN_OR_RETURN(const JobFacts training, desk.NewestOf(input.train_job()));
      predictor.assign(training.work_key.begin(), training.work_key.end());
      predictor += fmt::format("/{}/{}", input.checkpoint(), input.checkpoints());
    }
    std::vector<DataPart> heldout;
    if (input.heldout_variant_id() != 0) {
      ASSIGN_OR_RETURN(const VariantFacts variant, desk.VariantOf(input.heldout_variant_id()));
      heldout.push_back(DataPartOf(variant, settings.heldout()));
    } else {
      settings.clear_group_by();  // Only the pairs that are held out have groups.
    }
    // Names say nothing of the network; how many threads predict changes no score.
    settings.clear_name();
    settings.clear_trainer();
    settings.clear_seed();
    settings.clear_heldout();
    settings.clear_threads();
    // The content of own pairs counts, not where they are.
    if (settings.has_own()) SetPath("", *settings.mutable_own());
    ASSIGN_OR_RETURN(const Sha256Digest key,
                     KeyFor(desk, EvaluateKey(desk.versions(), predictor,
                                              DeterministicBytes(settings), heldout)));
    return JobKeys{key, key};
  }

  // Baselines; networks are evaluated after their trainings, which add those jobs.
  absl::Status OnSubmit(WorkDesk& desk, const v1::StudySpec& given,
                        std::span<const int64_t> variants) const override {
    if (!given.has_evaluate() || variants.empty()) return absl::OkStatus();
    v1::StudySpec study = given;
    ResolveTraining(&study);
    RETURN_IF_ERROR(CheckResolved(study, variants));
    const EvaluationPlan plan = EvaluationPlanOf(study, variants);
    uint32_t ordinal = kFirstBaselineOrdinal;
    for (const std::string& baseline : study.evaluate().baselines()) {
      v1::TrainJob none;
      none.set_trainer(baseline);
      RETURN_IF_ERROR(AddEvaluationsOf(desk, plan, variants[0], none, 0, &ordinal));
    }
    return absl::OkStatus();
  }

  std::vector<WorkNeeds> NeedsOfStudy(const v1::StudySpec& given) const override {
    if (!given.has_evaluate()) return {};
    v1::StudySpec study = given;
    ResolveTraining(&study);
    std::vector<std::string> benchmarks(study.evaluate().benchmarks().begin(),
                                        study.evaluate().benchmarks().end());
    if (study.evaluate().heldout_pairs() > 0) benchmarks.push_back(kHeldoutName);
    std::vector<WorkNeeds> needs;
    for (const std::string& benchmark : benchmarks) {
      v1::EvaluateInput input;
      *input.mutable_needs() = study.evaluate().needs();
      input.mutable_job()->set_benchmark(benchmark);
      if (!study.evaluate().baselines().empty()) {
        needs.push_back(NeedsOf(input.SerializeAsString()));
      }
      if (!study.has_train()) continue;
      input.mutable_job()->set_trainer(study.train().trainer());
      input.set_train_job(1);  // Any training.
      needs.push_back(NeedsOf(input.SerializeAsString()));
    }
    return needs;
  }

  // ---- Audit
  std::span<const Invariant> Invariants() const override { return kInvariants; }

 private:
  std::string WhyBad(const v1::EvaluateResult& result) const override {
    return WhyNoResult(result);
  }

  // A network predicts by its trainer.
  void AddAbilities(const v1::EvaluateInput& input, std::vector<std::string>* tags) const override {
    const v1::EvaluateJob& job = input.job();
    if (input.train_job() != 0) tags->push_back(TrainerTag(job.trainer()));
    if (job.benchmark() != kHeldoutName && job.benchmark() != kShippedBenchmark && !job.has_own()) {
      tags->push_back(BenchmarkTag(job.benchmark()));
    }
  }

  static constexpr Invariant kInvariants[] = {
      {"an evaluation has its result",
       "SELECT j.id FROM all_jobs AS j LEFT JOIN results AS r ON r.work_key = j.work_key"
       " WHERE j.kind = 'evaluate' AND j.state = 'SUCCEEDED' AND r.stage IS NOT 'evaluate'"
       " AND j.study_id IN (SELECT id FROM studies WHERE forgotten = 0 AND cancelled = 0)"
       // A damaged one is made again, after an upgrade under another key.
       " AND NOT EXISTS (SELECT 1 FROM all_jobs AS n WHERE n.variant_id = j.variant_id"
       " AND n.ordinal = j.ordinal AND n.kind = j.kind AND n.generation > j.generation)"},
      {"an evaluation began when its network was trained",
       "SELECT j.id FROM jobs AS j JOIN waits AS w ON w.job_id = j.id"
       " JOIN all_jobs AS t ON t.id = w.on_job WHERE j.kind = 'evaluate' AND j.attempts > 0"
       " AND (t.kind <> 'train' OR t.state <> 'SUCCEEDED')"},
  };

  // Returns the first of a row of keys, which begins with `key`, that has no stored result of an
  // incomplete benchmark. A benchmark's folder may be completed, and no key tells that: so each new
  // job makes such a result again, until there is a complete one.
  static absl::StatusOr<Sha256Digest> KeyFor(WorkDesk& desk, Sha256Digest key) {
    while (true) {
      ASSIGN_OR_RETURN(const std::optional<StoredResult> stored, desk.FindResult(key));
      v1::EvaluateResult result;
      if (!stored || stored->rejected || !UnpackMessage(stored->bytes, result).ok() ||
          result.pairs_missing() == 0) {
        return key;
      }
      key = Sha256Of("evaluate again " + HexOf(key));
    }
  }

  static absl::Status AddCheckpoint(int64_t job, v1::EvaluateInput& input, ResultReader& results) {
    ASSIGN_OR_RETURN(const v1::TrainResult training, TrainingWaitedFor(job, results));
    const v1::TrainedCheckpoint& picked =
        PickCheckpoint(training, input.checkpoint(), input.checkpoints());
    const StoredCheckpoint stored = StoredCheckpointOf(training, picked);
    v1::EvaluateJob& spec = *input.mutable_job();
    spec.set_step(picked.step());
    spec.set_checkpoint_path(stored.path);
    *spec.mutable_checkpoint() = stored.file;
    return absl::OkStatus();
  }
};

}  // namespace

absl::Status CheckResolved(const v1::StudySpec& resolved, std::span<const int64_t> variants) {
  if (static_cast<size_t>(resolved.variants_size()) == variants.size()) return absl::OkStatus();
  return InvalidArgument(
      "study.evaluate.heldout_pairs: the study has no variant '{}'; submit it as it is resolved",
      kHeldoutName);
}

EvaluationPlan EvaluationPlanOf(const v1::StudySpec& study, std::span<const int64_t> variants) {
  EvaluationPlan plan{.spec = study.evaluate()};
  plan.threads = study.has_train() ? study.train().threads() : kBaselineThreads;
  for (int i = 0; i < study.variants_size(); ++i) {
    const v1::VariantSpec& variant = study.variants(i);
    if (!variant.heldout()) continue;
    plan.heldout_variant = variants[static_cast<size_t>(i)];
    plan.heldout_pairs = variant.pairs();
    plan.heldout.set_variant(variant.name());
    plan.heldout.set_weight(1);
    TakeFinish(variant.config(), &plan.heldout);
    TakeTruth(TruthOfHeldout(study), &plan.heldout);
  }
  return plan;
}

absl::Status AddEvaluationsOf(WorkDesk& desk, const EvaluationPlan& plan, int64_t variant,
                              const v1::TrainJob& training, int64_t train_job,
                              uint32_t* next_ordinal) {
  std::vector<std::string> benchmarks(plan.spec.benchmarks().begin(), plan.spec.benchmarks().end());
  for (const v1::OwnBenchmark& own : plan.spec.own_benchmarks()) benchmarks.push_back(own.name());
  if (plan.heldout_variant != 0) benchmarks.push_back(kHeldoutName);
  const int checkpoints = train_job == 0 ? 1 : plan.spec.checkpoints();
  for (int checkpoint = 0; checkpoint < checkpoints; ++checkpoint) {
    for (const std::string& benchmark : benchmarks) {
      v1::EvaluateInput input;
      input.set_train_job(train_job);
      input.set_checkpoint(checkpoint);
      input.set_checkpoints(checkpoints);
      *input.mutable_needs() = plan.spec.needs();
      v1::EvaluateJob& job = *input.mutable_job();
      job.set_name(training.name());
      job.set_trainer(training.trainer());
      if (train_job != 0) {
        job.set_seed(training.seed());
        // Networks take two by themselves.
        if (plan.spec.looks() == 1) job.set_looks(1);
      }
      job.set_benchmark(benchmark);
      for (const v1::OwnBenchmark& own : plan.spec.own_benchmarks()) {
        if (own.name() == benchmark) *job.mutable_own() = own;
      }
      job.set_max_pairs(plan.spec.max_pairs());
      *job.mutable_group_by() = plan.spec.group_by();
      job.set_threads(plan.threads);
      if (benchmark == kHeldoutName) {
        input.set_heldout_variant_id(plan.heldout_variant);
        input.set_heldout_pairs(plan.heldout_pairs);
        *job.mutable_heldout() = plan.heldout;
      }
      RETURN_IF_ERROR(desk.AddJob({.kind = "evaluate",
                                   .variant = variant,
                                   .ordinal = (*next_ordinal)++,
                                   .input = DeterministicBytes(input),
                                   .waits = WaitsOfEvaluation(input)})
                          .status());
    }
  }
  return absl::OkStatus();
}

std::unique_ptr<JobKind> MakeEvaluateKind() { return std::make_unique<EvaluateKind>(); }

}  // namespace parallax
