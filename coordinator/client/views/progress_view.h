// Shows a running study as bars with rate and ETA, for `watch` and `run`.
//
// Not thread-safe.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/base/rate_estimator.h"
#include "coordinator/client/views/terminal.h"
#include "parallax/v1/service.pb.h"

namespace parallax::client {

// Describes the progress of a running job: "render 40%"; for a job that reports figures, "step 420
// of 1,500, loss 1.83, 9:00 left".
std::string DescribeProgress(const v1::JobStatus& job);

class ProgressView {
 public:
  // Notes no job without a worker in the first `workers_come_s` seconds of observation, in which
  // the workers that start beside the client connect.
  explicit ProgressView(double workers_come_s = 0) : workers_come_s_(workers_come_s) {}

  // Adds an observation. `time_s` is the time of any steady clock and must not decrease. `leased`
  // has the study's jobs in state LEASED, whose fractions move the bars between completions.
  void Observe(double time_s, const v1::StudyStatus& study, const v1::ListJobsReply& leased);

  // Returns a heading, a bar for each variant and a line on jobs, fitted to `terminal.size()`.
  std::vector<std::string> Lines(const Terminal& terminal) const;
  // Returns the same as one line for logs: "0:42  5/12 pairs (41%)  412 pairs/h  ETA 1:10  2
  // solving 1 rendering".
  std::string PlainLine() const;
  // Returns an object with study_id, name, state, pairs_done, pairs_wanted, elapsed_s,
  // pairs_per_hour, eta_s, running, waiting and variants.
  nlohmann::ordered_json Json() const;

  const v1::StudyStatus& study() const { return study_; }

 private:
  struct Variant {
    RateEstimator rate;
    double begun_pairs = 0;  // Pairs in leased render jobs, by the jobs' fractions.
  };
  std::string JobsLine() const;
  std::vector<std::string> LinesBelow(const Terminal& terminal) const;  // The bars.
  // Returns the READY jobs with their reasons, but for those that the constructor leaves out.
  std::vector<v1::WaitingJobs> Waiting() const;
  // Returns the time left to the study's end or, if that is unknown, to its last pair.
  std::string EtaText() const;
  // Returns the seconds until all pairs are there; absent if they are, or if the rate is unknown.
  std::optional<double> SecondsToPairs() const;
  // Returns the seconds until the study ends; absent if unknown, as the time of trainings is.
  std::optional<double> SecondsLeft() const;

  const double workers_come_s_;
  double start_s_ = -1;
  double now_s_ = 0;
  v1::StudyStatus study_;
  std::map<std::string, int64_t> at_work_;  // Leased jobs by kind.
  RateEstimator rate_;
  std::map<std::string, Variant> variants_;
  std::vector<v1::JobStatus> labelled_;  // Leased jobs without a scene.
};

}  // namespace parallax::client
