// A running study as bars with rate and ETA: what `watch` and `run` show.
//
// Not thread-safe.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/base/rate_estimator.h"
#include "coordinator/client/terminal.h"
#include "parallax/v1/service.pb.h"

namespace parallax::client {

// Where a running job is: "render 40%", or of one that tells figures of itself "step 420 of 1,500,
// loss 1.83, 9:00 left".
std::string DescribeProgress(const v1::JobStatus& job);

class ProgressView {
 public:
  // `time_s` of any steady clock; must not decrease. `leased`: the study's jobs in state LEASED,
  // whose fractions make bars move between completions.
  // `workers`: those that are connected, for a word on jobs that none of them takes.
  void Observe(double time_s, const v1::StudyStatus& study, const v1::ListJobsReply& leased,
               const v1::ListWorkersReply& workers = {});

  // Heading, a bar a variant, a line on jobs. Asks for `terminal.size()`.
  std::vector<std::string> Lines(const Terminal& terminal) const;
  // The same in one line for logs: "0:42  5/12 pairs (41%)  412 pairs/h  ETA 1:10  2 solving  1
  // rendering".
  std::string PlainLine() const;
  // With fields study_id, name, state, pairs_done, pairs_wanted, elapsed_s, pairs_per_hour, eta_s
  // and variants.
  nlohmann::ordered_json Json() const;

  const v1::StudyStatus& study() const { return study_; }

 private:
  struct Variant {
    RateEstimator rate;
    double begun_pairs = 0;  // Of leased render jobs, by their fractions.
  };
  std::string JobsLine() const;
  std::vector<std::string> LinesBelow(const Terminal& terminal) const;  // The bars.
  void NoteWaiting(const v1::ListWorkersReply& workers);
  // Seconds until the study ends, as far as anything tells.
  std::optional<double> SecondsLeft() const;

  double start_s_ = -1;
  double now_s_ = 0;
  v1::StudyStatus study_;
  std::map<std::string, int64_t> at_work_;  // By kind of job: how many are leased.
  RateEstimator rate_;
  std::map<std::string, Variant> variants_;
  std::vector<v1::JobStatus> labelled_;  // Leased jobs without a scene.
  std::vector<std::string> waiting_;     // Kinds of jobs that no worker takes, in a line each.
};

}  // namespace parallax::client
