// Inner part of the kinds that train and evaluate: the parts of their data, their inputs, and their
// needs of a worker.
//
// Errors: those of the desk, reader or database that a function is given, beside those named.
#pragma once

#include <string>

#include "common/base/status.h"
#include "coordinator/queue/job_kind.h"
#include "parallax/v1/train_input.pb.h"

namespace parallax {

// Copies the variant's filters and its sensor, if it has one, to the set. Both are applied to
// frames when they are brought out of the store.
void TakeFinish(const v1::SceneConfig& config, v1::FrameSet* set);
// Sets which surface is the frames' truth: "first", which needs no word, or "behind".
void TakeTruth(const std::string& truth, v1::FrameSet* set);

// Returns the values that decide which pairs `variant` gives, for keys.
DataPart DataPartOf(const VariantFacts& variant, const v1::FrameSet& set);

// Adds the folders of a variant's `pairs` pairs to the set. Errors: the reader's; kDataLoss if
// there are fewer.
absl::Status AddFolders(int64_t variant, int64_t pairs, ResultReader& results, v1::FrameSet* set);

// Parses a job's input. Errors: kDataLoss if the bytes are not such a message.
template <typename Input>
absl::StatusOr<Input> InputOf(std::string_view bytes) {
  Input input;
  if (input.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return input;
  return DataLoss("database: a job's input is no {}", Input::descriptor()->name());
}

// Returns the result of the training that job `job` has waited for. Errors: the reader's; kDataLoss
// for one without checkpoints.
absl::StatusOr<v1::TrainResult> TrainingWaitedFor(int64_t job, ResultReader& results);

// A checkpoint of a training as a file of the store.
struct StoredCheckpoint {
  std::string path;
  v1::FileEntry file;
};
StoredCheckpoint StoredCheckpointOf(const v1::TrainResult& training,
                                    const v1::TrainedCheckpoint& checkpoint);

// Returns the needs of a job; a job that needs GPUs asks for the tag "gpu".
WorkNeeds NeedsOf(const v1::JobNeeds& needs);

// Returns why `files` below `path` can't be a result's; empty if they can.
std::string WhyBadFiles(const std::string& path,
                        const google::protobuf::RepeatedPtrField<v1::FileEntry>& files);
std::vector<JobKind::OutputFile> OutputFilesOf(
    const std::string& path, const google::protobuf::RepeatedPtrField<v1::FileEntry>& files);

// The common part of a study's evaluations. Implemented in evaluate.cc.
struct EvaluationPlan {
  v1::EvaluateSpec spec;
  int64_t heldout_variant = 0;  // 0: none.
  int64_t heldout_pairs = 0;
  v1::FrameSet heldout;
  int threads = 2;
};
// Checks that each variant of the resolved study was submitted. Errors: kInvalidArgument if the
// study was submitted without its held-out variant.
absl::Status CheckResolved(const v1::StudySpec& resolved, std::span<const int64_t> variants);
// Makes the plan of a study's evaluations. Requires that CheckResolved passes.
EvaluationPlan EvaluationPlanOf(const v1::StudySpec& study, std::span<const int64_t> variants);
// Adds an evaluation for each checkpoint and benchmark of a training. Numbers them from
// `next_ordinal`, which it advances.
absl::Status AddEvaluationsOf(WorkDesk& desk, const EvaluationPlan& plan, int64_t variant,
                              const v1::TrainJob& training, int64_t train_job,
                              uint32_t* next_ordinal);
// First ordinal of the baselines' jobs, which belong to the study's first variant.
inline constexpr uint32_t kFirstBaselineOrdinal = 1u << 30;

// Checks this kind's results for the auditor: results in litter or kept folders, and wrong paths.
absl::Status AuditFolders(SqliteConnection& db, const JobKind& kind,
                          std::vector<std::string>& violations);

}  // namespace parallax
