// Inner part of the kinds that train and evaluate: the parts of their data, their inputs, and what
// a worker must have for them.
//
// Errors: those of the desk, the reader or the database that a function is given; more where it
// says so.
#pragma once

#include <string>

#include "coordinator/queue/job_kind.h"
#include "parallax/v1/train_input.pb.h"

namespace parallax {

// Gives the set the variant's filters and, if it has one, its sensor: what is done to frames as
// they are brought out of the store.
void TakeFinish(const v1::SceneConfig& config, v1::FrameSet* set);

// Which pairs `variant` gives, for keys.
DataPart DataPartOf(const VariantFacts& variant, const v1::FrameSet& set);

// Adds the folders of all pairs of a variant. Errors: as the reader's; kDataLoss if there are not
// `pairs` of them.
absl::Status AddFolders(int64_t variant, int64_t pairs, ResultReader& results, v1::FrameSet* set);

// kDataLoss if the bytes of a job are no such message.
template <typename Input>
absl::StatusOr<Input> InputOf(std::string_view bytes) {
  Input input;
  if (input.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return input;
  return MakeError(absl::StatusCode::kDataLoss,
                   "database: a job's input is no " + Input::descriptor()->name());
}

// GPUs are asked for by the tag "gpu".
WorkNeeds NeedsOf(const v1::JobNeeds& needs);

// Why `files` below `path` can be no result's; empty if they can be.
std::string WhyBadFiles(const std::string& path,
                        const google::protobuf::RepeatedPtrField<v1::FileEntry>& files);
std::vector<JobKind::OutputFile> OutputFilesOf(
    const std::string& path, const google::protobuf::RepeatedPtrField<v1::FileEntry>& files);

// What one study's evaluations have in common. Lives in evaluate.cc.
struct EvaluationPlan {
  v1::EvaluateSpec spec;
  int64_t heldout_variant = 0;  // 0: none.
  int64_t heldout_pairs = 0;
  v1::FrameSet heldout;
  int threads = 2;
};
// Whether each variant of the resolved study is one of those that were submitted.
// Errors: kInvalidArgument if the study was submitted without its held-out variant.
absl::Status CheckResolved(const v1::StudySpec& resolved, std::span<const int64_t> variants);
// Requires that CheckResolved passes.
EvaluationPlan EvaluationPlanOf(const v1::StudySpec& study, std::span<const int64_t> variants);
// Jobs for each checkpoint and benchmark of a training. `next_ordinal` numbers them.
absl::Status AddEvaluationsOf(WorkDesk& desk, const EvaluationPlan& plan, int64_t variant,
                              const v1::TrainJob& training, int64_t train_job,
                              uint32_t* next_ordinal);
// Ordinals of baselines' jobs begin here, in the study's first variant.
inline constexpr uint32_t kFirstBaselineOrdinal = 1u << 30;

// Litter, kept folders and wrong places of this stage's results, for the auditor.
absl::Status AuditFolders(SqliteConnection& db, const JobKind& kind,
                          std::vector<std::string>& violations);

}  // namespace parallax
