// Kind `train`: a network, from a training set: a variant's pairs or a mixture of several
// variants'.
//
// Results: "train" by work key, a TrainResult. Training i of all sets of a study has the same
// initial weights and order of batches, so that their differences are the data's; see TrainingSeed.
#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "common/base/ability_tags.h"
#include "common/base/hash.h"
#include "common/base/names.h"
#include "common/base/status.h"
#include "common/base/system/installation.h"
#include "common/config/frame_notes.h"
#include "common/config/training_plan.h"
#include "coordinator/queue/commands/report_check.h"
#include "coordinator/queue/kinds/folder_kind.h"
#include "coordinator/queue/kinds/result_figures.h"
#include "coordinator/study/training_seed.h"

namespace parallax {
namespace {

constexpr double kMostSteps = 1e9;
constexpr double kLargestLoss = 1e9;

std::string WhyBadCheckpoints(const v1::TrainResult& result) {
  if (result.checkpoints().empty()) return "no checkpoints";
  int64_t last = 0;
  for (const v1::TrainedCheckpoint& checkpoint : result.checkpoints()) {
    const auto is_it = [&](const v1::FileEntry& file) { return file.name() == checkpoint.name(); };
    const auto file = std::find_if(result.files().begin(), result.files().end(), is_it);
    if (file == result.files().end()) {
      return "checkpoint '" + OneLine(checkpoint.name()) + "' is not among its files";
    }
    if (file->size() == 0) return "checkpoint '" + OneLine(checkpoint.name()) + "' is empty";
    if (checkpoint.step() <= last) {
      return fmt::format("a checkpoint of step {} after one of step {}", checkpoint.step(), last);
    }
    last = checkpoint.step();
  }
  return WhyNotIn("a checkpoint's step", static_cast<double>(last), 1, kMostSteps);
}

std::string WhyNoResult(const v1::TrainResult& result) {
  if (std::string why = WhyBadCheckpoints(result); !why.empty()) return why;
  if (std::string why = WhyNotIn("a loss", result.loss(), -kLargestLoss, kLargestLoss);
      !why.empty()) {
    return why;
  }
  if (std::string why = WhyNotIn("a time in seconds", result.train_s(), 0, kLongestS);
      !why.empty()) {
    return why;
  }
  if (result.pairs() < 1) return fmt::format("{} pairs trained on", result.pairs());
  return "";
}

// Returns TrainJob.start: the tag of the network's file here, "" for weights drawn by the seed.
// Errors: those of FindNetwork and reading.
absl::StatusOr<std::string> StartOf(const v1::TrainSpec& train) {
  if (train.start() != "network") return std::string();
  const absl::StatusOr<std::string> path = FindNetwork();
  if (!path.ok()) return FailedPrecondition("train.start: {}", ToStd(path.status().message()));
  ASSIGN_OR_RETURN(const std::string hash, Sha256HexOfFile(*path));
  return NetworkTag(hash);
}

std::vector<JobWait> WaitsOfTraining(const v1::TrainInput& input) {
  std::vector<JobWait> waits;
  for (int i = 0; i < input.variant_ids_size(); ++i) {
    waits.push_back(JobWait::OnPairs(input.variant_ids(i), input.pairs(i)));
  }
  if (input.curator_job() != 0) waits.push_back(JobWait::OnJob(input.curator_job()));
  return waits;
}

class TrainKind final : public FolderKind<v1::TrainInput, v1::TrainResult> {
 public:
  TrainKind()
      : FolderKind(
            "train",
            {.stages = {"train"}, .doing = "training", .has_output = true, .resumes = true}) {}

  // ---- Messages
  absl::StatusOr<std::string> Spec(const LeasedJob& lease, ResultReader& results) const override {
    ASSIGN_OR_RETURN(v1::TrainInput input, InputOf<v1::TrainInput>(lease.job.input));
    v1::TrainJob& spec = *input.mutable_job();
    for (int i = 0; i < spec.parts_size(); ++i) {
      RETURN_IF_ERROR(
          AddFolders(input.variant_ids(i), input.pairs(i), results, spec.mutable_parts(i)));
    }
    spec.set_resume_folder(StorePrefixOf(lease.job.work_key));
    if (input.curator_job() != 0) RETURN_IF_ERROR(AddCurator(lease.job.id, results, &spec));
    return spec.SerializeAsString();
  }

  std::string LabelOf(std::string_view bytes) const override {
    const auto input = InputOf<v1::TrainInput>(bytes);
    if (!input.ok()) return "";
    return fmt::format("{}, seed {}", input->job().name(), input->job().seed());
  }

  std::vector<StageSeconds> StagesOf(std::string_view bytes) const override {
    v1::TrainResult result;
    if (!result.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return {};
    return {{"train", result.train_s()}};
  }

  double CoreSecondsOf(std::string_view input_bytes, std::string_view packed) const override {
    const auto input = InputOf<v1::TrainInput>(input_bytes);
    v1::TrainResult result;
    if (!input.ok() || !UnpackMessage(packed, result).ok()) return 0;
    return result.train_s() * std::max(1, input->job().threads());
  }

  std::vector<JobWait> WaitsOf(std::string_view bytes) const override {
    const auto input = InputOf<v1::TrainInput>(bytes);
    return input.ok() ? WaitsOfTraining(*input) : std::vector<JobWait>();
  }

  // ---- Hooks
  absl::StatusOr<JobKeys> Keys(WorkDesk& desk, const JobFacts& job) const override {
    ASSIGN_OR_RETURN(v1::TrainInput input, InputOf<v1::TrainInput>(job.input));
    std::vector<DataPart> parts;
    for (int i = 0; i < input.job().parts_size(); ++i) {
      ASSIGN_OR_RETURN(const VariantFacts variant, desk.VariantOf(input.variant_ids(i)));
      parts.push_back(DataPartOf(variant, input.job().parts(i)));
    }
    // Equal data under other names are equal data.
    v1::TrainJob settings = input.job();
    settings.clear_name();
    settings.clear_parts();
    if (input.curator_job() != 0) {
      ASSIGN_OR_RETURN(const JobFacts curator, desk.NewestOf(input.curator_job()));
      settings.set_curator_path(HexOf(curator.work_key));
    }
    const Sha256Digest key = TrainKey(desk.versions(), DeterministicBytes(settings), parts);
    return JobKeys{key, key};
  }

  absl::StatusOr<std::string> WhyNot(WorkDesk&, const JobFacts& job,
                                     const CheckedResult& result) const override {
    ASSIGN_OR_RETURN(const v1::TrainInput input, InputOf<v1::TrainInput>(job.input));
    const int64_t pairs = std::accumulate(input.pairs().begin(), input.pairs().end(), int64_t{0});
    if (ResultIn(result).pairs() > pairs) {
      return fmt::format("{} pairs trained on, of {}", ResultIn(result).pairs(), pairs);
    }
    const int seen = ResultIn(result).checkpoints_size();
    if (seen <= input.job().checkpoints()) return std::string();
    return fmt::format("{} checkpoints, wanted at most {}", seen, input.job().checkpoints());
  }

  absl::StatusOr<Ending> Store(WorkDesk& desk, const JobFacts& job,
                               const CheckedResult& result) const override {
    // A worker keeps its checkpoints until here; nobody needs them any more.
    RETURN_IF_ERROR(desk.Discard(ResultIn(result).path() + "/" + kResumeFolder));
    return FolderKind::Store(desk, job, result);
  }

  // One training for each set and seed; the first seed of all sets comes first, and curated sets
  // after those whose networks score their frames.
  absl::Status OnSubmit(WorkDesk& desk, const v1::StudySpec& given,
                        std::span<const int64_t> variants) const override {
    if (!given.has_train()) return absl::OkStatus();
    v1::StudySpec study = given;
    ResolveTraining(&study);
    RETURN_IF_ERROR(CheckResolved(study, variants));
    const std::vector<v1::Mixture> sets = TrainingSetsOf(study);
    const EvaluationPlan plan = EvaluationPlanOf(study, variants);
    const std::vector<size_t> order = OrderOf(sets);
    ASSIGN_OR_RETURN(const std::string start, StartOf(study.train()));
    uint32_t ordinal = 0;
    uint32_t evaluation = 0;
    for (int seed = 0; seed < study.train().seeds(); ++seed) {
      std::map<int, int64_t> jobs;  // Trainings of this seed, by the place of their sets.
      for (const size_t place : order) {
        const v1::Mixture& set = sets[place];
        ASSIGN_OR_RETURN(v1::TrainInput input, InputFor(desk, study, variants, set, seed));
        input.mutable_job()->set_start(start);
        if (set.curated()) {
          ASSIGN_OR_RETURN(const int64_t curator, CuratorOf(set, sets, jobs));
          input.set_curator_job(curator);
        }
        ASSIGN_OR_RETURN(const int64_t id, desk.AddJob({.kind = name(),
                                                        .variant = input.variant_ids(0),
                                                        .ordinal = ordinal++,
                                                        .input = DeterministicBytes(input),
                                                        .waits = WaitsOfTraining(input)}));
        jobs[static_cast<int>(place)] = id;
        if (!study.has_evaluate()) continue;
        RETURN_IF_ERROR(
            AddEvaluationsOf(desk, plan, input.variant_ids(0), input.job(), id, &evaluation));
      }
    }
    return absl::OkStatus();
  }

  std::vector<WorkNeeds> NeedsOfStudy(const v1::StudySpec& given) const override {
    if (!given.has_train()) return {};
    v1::StudySpec study = given;
    ResolveTraining(&study);
    v1::TrainInput input;
    *input.mutable_needs() = study.train().needs();
    input.mutable_job()->set_trainer(study.train().trainer());
    input.mutable_job()->set_start(StartOf(study.train()).value_or(""));
    return {NeedsOf(input.SerializeAsString())};
  }

  // ---- Audit
  std::span<const Invariant> Invariants() const override { return kInvariants; }

 private:
  std::string WhyBad(const v1::TrainResult& result) const override { return WhyNoResult(result); }

  void AddAbilities(const v1::TrainInput& input, std::vector<std::string>* tags) const override {
    tags->push_back(TrainerTag(input.job().trainer()));
    if (!input.job().start().empty()) tags->push_back(input.job().start());
  }

  static constexpr Invariant kInvariants[] = {
      {"a trained network has its result",
       "SELECT j.id FROM all_jobs AS j LEFT JOIN results AS r ON r.work_key = j.work_key"
       " WHERE j.kind = 'train' AND j.state = 'SUCCEEDED' AND r.stage IS NOT 'train'"
       " AND j.study_id IN (SELECT id FROM studies WHERE forgotten = 0 AND cancelled = 0)"
       // A damaged one is made again, after an upgrade under another key.
       " AND NOT EXISTS (SELECT 1 FROM all_jobs AS n WHERE n.variant_id = j.variant_id"
       " AND n.ordinal = j.ordinal AND n.kind = j.kind AND n.generation > j.generation)"},
      {"a training began when its pairs were there",
       "SELECT j.id FROM jobs AS j WHERE j.kind = 'train' AND j.attempts > 0"
       " AND EXISTS (SELECT 1 FROM waits AS w WHERE w.job_id = j.id AND w.state <> 'MET')"},
  };

  // The places of the sets, those that are not curated first.
  static std::vector<size_t> OrderOf(const std::vector<v1::Mixture>& sets) {
    std::vector<size_t> order(sets.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::stable_partition(order.begin(), order.end(),
                          [&](size_t place) { return !sets[place].curated(); });
    return order;
  }

  // The training among `jobs` whose network scores the frames of `set`.
  static absl::StatusOr<int64_t> CuratorOf(const v1::Mixture& set,
                                           const std::vector<v1::Mixture>& sets,
                                           const std::map<int, int64_t>& jobs) {
    const auto job = jobs.find(PlainTwinOf(set, sets));
    if (job != jobs.end()) return job->second;
    return InvalidArgument(
        "train: training set {} is curated, and no set has the same parts without curation",
        Quoted(set.name()));
  }

  // Tells the worker the network of the training that the job has waited for.
  static absl::Status AddCurator(int64_t job, ResultReader& results, v1::TrainJob* spec) {
    ASSIGN_OR_RETURN(const v1::TrainResult training, TrainingWaitedFor(job, results));
    const StoredCheckpoint last = StoredCheckpointOf(training, *training.checkpoints().rbegin());
    spec->set_curator_path(last.path);
    *spec->mutable_curator() = last.file;
    return absl::OkStatus();
  }

  static absl::StatusOr<v1::TrainInput> InputFor(WorkDesk& desk, const v1::StudySpec& study,
                                                 std::span<const int64_t> variants,
                                                 const v1::Mixture& set, int seed) {
    std::map<std::string, int> by_name;
    for (int i = 0; i < study.variants_size(); ++i) by_name[study.variants(i).name()] = i;
    const v1::TrainSpec& train = study.train();
    v1::TrainInput input;
    *input.mutable_needs() = train.needs();
    v1::TrainJob& job = *input.mutable_job();
    job.set_name(set.name());
    job.set_trainer(train.trainer());
    job.set_seed(TrainingSeed(study, seed));
    job.set_steps(train.steps());
    job.set_minutes(train.minutes());
    job.set_width_px(train.width_px());
    job.set_height_px(train.height_px());
    job.set_batch(train.batch());
    job.set_threads(train.threads());
    job.set_share(set.share());
    job.set_mismatched(set.mismatched());
    // All pairs are the 0 of the message, as before there were shares.
    if (MismatchedShareOf(set) < 1) job.set_mismatched_share(MismatchedShareOf(set));
    job.set_curated(set.curated());
    job.set_checkpoints(study.has_evaluate() ? study.evaluate().checkpoints() : 1);
    for (const v1::Mixture::Part& part : set.parts()) {
      if (part.weight() <= 0) continue;  // Nothing is drawn from it.
      const auto found = by_name.find(part.variant());
      if (found == by_name.end()) {
        return InvalidArgument("train: {} is no variant of the study", Quoted(part.variant()));
      }
      const int64_t id = variants[static_cast<size_t>(found->second)];
      ASSIGN_OR_RETURN(const VariantFacts variant, desk.VariantOf(id));
      v1::FrameSet& frames = *job.add_parts();
      frames.set_variant(part.variant());
      frames.set_weight(part.weight());
      TakeFinish(*variant.config, &frames);
      TakeTruth(set.truth(), &frames);
      input.add_variant_ids(id);
      input.add_pairs(variant.pairs_wanted);
    }
    if (job.parts_size() == 1) job.mutable_parts(0)->set_weight(1);
    if (job.parts().empty()) {
      return InvalidArgument("train: training set {} has no parts", Quoted(set.name()));
    }
    return input;
  }
};

}  // namespace

std::unique_ptr<JobKind> MakeTrainKind() { return std::make_unique<TrainKind>(); }

}  // namespace parallax
