// Kind `evaluate`: a trained network (or a classical baseline) x a benchmark -> scores of each
// pair.
#include <algorithm>
#include <filesystem>
#include <optional>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/base/system/log.h"
#include "common/config/content_folders.h"
#include "common/store/content.h"
#include "common/store/store.h"
#include "parallax/v1/train.pb.h"
#include "worker/agent/attempts/failure.h"
#include "worker/evaluate/benchmark.h"
#include "worker/evaluate/evaluation.h"
#include "worker/evaluate/own_benchmark.h"
#include "worker/evaluate/prediction_sheet.h"
#include "worker/jobs/files/content_cache.h"
#include "worker/jobs/files/frame_folder.h"
#include "worker/jobs/files/kept_files.h"
#include "worker/jobs/files/store_files.h"
#include "worker/jobs/jobs.h"
#include "worker/jobs/training/log_reader.h"
#include "worker/jobs/training/network_predictor.h"
#include "worker/materials/pictures/user_picture.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr char kHeldout[] = "heldout";
constexpr char kSgbm[] = "sgbm";

// Keeps the groups that the study asks for.
void DropGroups(const google::protobuf::RepeatedPtrField<std::string>& wanted,
                std::vector<Scores>& images) {
  for (Scores& image : images) {
    std::erase_if(image.groups, [&](const auto& group) {
      return std::find(wanted.begin(), wanted.end(), group.first) == wanted.end();
    });
  }
}

// One attempt.
class EvaluateAttempt {
 public:
  EvaluateAttempt(const v1::EvaluateJob& job, const JobOptions& options,
                  const AttemptFolder& folder, const CancelToken& cancel,
                  const JobProgressFn& progress)
      : job_(job),
        options_(options),
        folder_(folder),
        cancel_(cancel),
        progress_(progress),
        threads_(std::max(1, job.threads())),
        work_dir_(folder.scratch + "/work"),
        kept_(folder) {}

  absl::StatusOr<JobOutcome> Run() {
    RETURN_IF_ERROR(MakeFolders(work_dir_));
    progress_(0, "data");
    ASSIGN_OR_RETURN(const Benchmark benchmark, Open());
    ASSIGN_OR_RETURN(const auto predictor, MakePredictor());
    CoreShare::Hold cores;
    if (options_.cores != nullptr) {
      ASSIGN_OR_RETURN(cores, options_.cores->TakeAlone(
                                  threads_, cancel_, [this] { progress_(0, "wait for cores"); }));
    }
    progress_(0, "predict");
    progress_.FollowLog(work_dir_ + "/predictor.log");
    absl::StatusOr<Evaluation> evaluation = Evaluate(*predictor, benchmark, Options());
    if (!evaluation.ok()) return Failed(evaluation.status());
    DropGroups(job_.group_by(), evaluation->images);
    return Keep(benchmark, *evaluation);
  }

 private:
  // The error in one line, with the predictor's last message and the end of its log.
  absl::Status Failed(const absl::Status& status) const {
    const LogReader log(work_dir_ + "/predictor.log");
    std::string message(ToStd(status.message()));
    message = message.substr(0, message.find('\n'));
    if (const size_t at = message.find("; the end of "); at != std::string::npos) {
      message = message.substr(0, at) + ": " + log.LastLine();
    }
    return WithLogTail(MakeError(status.code(), message), log.Tail());
  }

  // The user's own pairs, checked by their hash: below the folder of benchmarks, by their path or
  // its last part; below the picture root; or from the store.
  absl::StatusOr<Benchmark> OpenOwn() const {
    v1::OwnBenchmark own = job_.own();
    const std::optional<ContentReference> reference = FindContentReference(PathOfBenchmark(own));
    const fs::path named = reference ? reference->path : PathOfBenchmark(own);
    for (const fs::path& part : {named, named.filename()}) {
      const fs::path place = fs::path(options_.benchmarks_dir) / part;
      std::error_code error;
      if (options_.benchmarks_dir.empty() || !fs::exists(place, error)) continue;
      absl::StatusOr<Benchmark> opened = OpenOwnBenchmark(own, place);
      if (opened.ok()) return opened;
    }
    ASSIGN_OR_RETURN(const std::string path,
                     ContentCache(options_.content_cache)
                         .Bring(*folder_.store, PathOfBenchmark(own),
                                {cancel_, [this] { progress_(0, "content"); }}));
    if (path.starts_with('/')) own.clear_sha256();  // Each file of the cache has been checked.
    ASSIGN_OR_RETURN(const std::string place, BelowPictureRoot(path));
    return OpenOwnBenchmark(own, place);
  }

  absl::StatusOr<Benchmark> Open() const {
    if (job_.has_own()) return OpenOwn();
    if (job_.benchmark() != kHeldout) {
      // Kinds that take a path would let a submitter read this machine's files.
      if (job_.benchmark().find_first_of(":=/") != std::string::npos) {
        return InvalidArgument("benchmark '{}': a name, and no path", job_.benchmark());
      }
      return OpenBenchmark(job_.benchmark(), options_.benchmarks_dir);
    }
    const std::string dir = folder_.scratch + "/data/" + job_.heldout().variant();
    FrameFolderOptions bring;
    bring.files = FilesForEvaluation();
    bring.cancel = cancel_;
    bring.progress = [this](double fraction) { progress_(fraction, "data"); };
    const FrameCache cache(options_.frame_cache);
    RETURN_IF_ERROR(BringFrames(job_.heldout(), *folder_.store, cache, dir, bring).status());
    cache.Trim();
    return OpenBenchmark(std::string(kHeldout) + "=archive:" + dir, "");
  }

  absl::StatusOr<std::unique_ptr<Predictor>> MakePredictor() {
    if (job_.checkpoint_path().empty()) {
      if (job_.trainer() == kSgbm) return MakeSgbmPredictor();
      return Unimplemented("there is no baseline '{}' (there is sgbm)", job_.trainer());
    }
    return OpenStoredNetwork(
        {job_.trainer(), job_.checkpoint_path(), job_.checkpoint(), job_.looks()},
        options_.trainers, *folder_.store, work_dir_, threads_);
  }

  EvaluateOptions Options() const {
    EvaluateOptions options;
    options.run.variant = job_.name().empty() ? job_.trainer() : job_.name();
    options.run.trainer = job_.checkpoint_path().empty() ? "opencv" : job_.trainer();
    if (!job_.checkpoint_path().empty()) options.run.seed = static_cast<int64_t>(job_.seed());
    options.run.checkpoint = job_.checkpoint().sha256();
    options.run.looks = job_.looks();
    options.work_dir = work_dir_;
    options.keep_predictions = true;
    options.max_pairs = job_.max_pairs();
    options.cancel = cancel_;
    options.note = [this](const std::string& note) {
      LogWarning("benchmark", {{"name", job_.benchmark()}, {"note", note}});
    };
    options.progress = [this](std::string_view stage, int done, int total) {
      progress_(static_cast<double>(done) / std::max(1, total), stage,
                {{"pairs", static_cast<double>(done)}});
    };
    return options;
  }

  absl::StatusOr<JobOutcome> Keep(const Benchmark& benchmark, const Evaluation& evaluation) {
    progress_(1, "keep");
    const std::string sheet = work_dir_ + "/sheet.png";
    RETURN_IF_ERROR(DrawPredictionSheet(benchmark, evaluation, work_dir_, sheet));
    RETURN_IF_ERROR(kept_.KeepText(EncodeEvaluation(evaluation), "scores.jsonl"));
    RETURN_IF_ERROR(kept_.Keep(sheet, "sheet.png").status());
    v1::EvaluateResult result;
    result.set_path(folder_.path);
    *result.mutable_files() = kept_.entries();
    result.set_pairs(static_cast<int64_t>(evaluation.images.size()));
    result.set_metric(MetricName(evaluation.headline));
    result.set_value(FigureOf(evaluation.headline, evaluation));
    result.set_predict_s(evaluation.seconds);
    const auto found = static_cast<int64_t>(benchmark.pairs.size());
    result.set_pairs_missing(std::max<int64_t>(0, benchmark.pairs_published - found));
    return JobOutcome{result.SerializeAsString(), kept_.outputs()};
  }

  const v1::EvaluateJob& job_;
  const JobOptions& options_;
  const AttemptFolder& folder_;
  const CancelToken& cancel_;
  const JobProgressFn& progress_;
  const int threads_;
  const std::string work_dir_;
  KeptFiles kept_;
};

class EvaluateHandler final : public JobHandler {
 public:
  explicit EvaluateHandler(std::shared_ptr<const JobOptions> options)
      : JobHandler("evaluate", /*writes_output=*/true), options_(std::move(options)) {}

  absl::StatusOr<JobOutcome> Run(std::string_view spec, const AttemptFolder& folder,
                                 const CancelToken& cancel,
                                 const JobProgressFn& progress) override {
    v1::EvaluateJob job;
    if (!job.ParseFromArray(spec.data(), static_cast<int>(spec.size()))) {
      return InvalidArgument("a spec that is no EvaluateJob");
    }
    return EvaluateAttempt(job, *options_, folder, cancel, progress).Run();
  }

 private:
  const std::shared_ptr<const JobOptions> options_;
};

}  // namespace

std::unique_ptr<JobHandler> MakeEvaluateHandler(std::shared_ptr<const JobOptions> options) {
  return std::make_unique<EvaluateHandler>(std::move(options));
}

}  // namespace parallax
