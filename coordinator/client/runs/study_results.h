// Copies the results of a study's jobs other than pairs into its dataset folder: trained networks,
// scores and sheets of predictions.
//
//   <out>/training/<set>/<trainer>/seed-<i>/   final.*, checkpoint-<step>.*, log.txt, curve.csv,
//                                              training.json
//   <out>/scores/<benchmark>.<set>.<trainer>.seed-<i>.jsonl     (of baselines without the seed)
//   <out>/sheets/<the same>.png
//   <out>/curves/<the same>.<k>-of-<n>.jsonl   scores of checkpoints before the last
//
// Not thread-safe. Borrows the connection of each call.
#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>

#include "common/base/status.h"
#include "coordinator/client/connection.h"
#include "coordinator/client/runs/store_reader.h"
#include "coordinator/client/scores/result_label.h"
#include "parallax/v1/study.pb.h"
#include "worker/evaluate/scores.h"

namespace parallax::client {

class StudyResults {
 public:
  // Opens the folder. Errors: kFailedPrecondition if a variant or mixture has the name of one of
  // the folders above.
  static absl::StatusOr<std::unique_ptr<StudyResults>> Open(const std::string& out_dir,
                                                            const v1::StudySpec& study);

  // Copies all results of now, or only scores; leaves existing files alone. Errors: the
  // connection's, the store's and the disk's.
  absl::Status CatchUp(Connection& connection, int64_t study_id, bool only_scores = false);

  // Paths of this study's score files, also those of checkpoints before the last. The folder may
  // hold others: of a study that had more seeds.
  const std::set<std::string>& score_files() const { return score_files_; }
  int trainings() const { return trainings_; }  // This study's, in the folder.
  int evaluations() const { return evaluations_; }

 private:
  StudyResults(std::string out_dir, std::string trainer)
      : out_dir_(std::move(out_dir)), trainer_(std::move(trainer)) {}
  absl::Status Add(const v1::JobResult& result, bool only_scores);
  absl::Status AddTraining(const ResultName& name, const std::string& from,
                           const v1::JobResult& result);
  absl::Status AddScores(const ResultName& name, const std::string& from,
                         const v1::JobResult& result);
  absl::Status WriteScores(const std::string& name, const Evaluation& evaluation);

  const std::string out_dir_;
  const std::string trainer_;
  std::unique_ptr<StoreReader> store_;  // From the first result on.
  int64_t cursor_ = 0;
  std::set<std::string> score_files_;
  int trainings_ = 0, evaluations_ = 0;
};

}  // namespace parallax::client
