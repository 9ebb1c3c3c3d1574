// Common part of all fault experiments: options, counts, and the line that they end with.
//
// An experiment repeats rounds, each from its own seed: it injects faults, lets the work come to
// its end, and then asks whether anything that was acknowledged is lost, anything is there twice,
// and whether the auditor finds a broken invariant.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/base/rng.h"

namespace parallax::faults {

struct ExperimentOptions {
  int rounds = 1;
  uint64_t seed = 1;
  bool full = false;      // Every point instead of a sample.
  int64_t jobs = 0;       // 0: the experiment's own.
  double seconds = 0;     // How long the chaos lasts; 0: the experiment's own.
  int64_t rows = 0;       // kill-coordinator: jobs that the database holds before.
  std::string guard;      // simulate-controls: the one guard to switch off; empty: all, one by one.
  std::string old_bin;    // versions: folder with programs of an older release.
  std::string seeds;      // simulate: "5..9".
  int64_t new_seeds = 0;  // simulate: run the kept seeds, then so many that are new each time.
  bool trace = false;     // simulate: tell the stories of the seeds.
  int64_t events = 100'000;  // simulate-growth: through which the coordinator lives.
};

struct Tally {
  int64_t rounds = 0;
  int64_t faults = 0;  // Injected.
  int64_t jobs = 0;    // That succeeded.
  int64_t lost = 0;    // Acknowledged and not there, or wanted and never made.
  int64_t doubled = 0;
  int64_t findings = 0;                   // The auditor's.
  std::map<std::string, double> figures;  // The experiment's own.
  std::vector<std::string> complaints;    // A line for each of lost, doubled and findings.

  void Lost(const std::string& what);
  void Doubled(const std::string& what);
  void Found(const std::vector<std::string>& violations, const std::string& where);
  bool clean() const { return complaints.empty(); }
};

using Experiment = std::function<void(const ExperimentOptions&, Tally&)>;

void DaemonFilePoints(const ExperimentOptions& options, Tally& tally);
void Versions(const ExperimentOptions& options, Tally& tally);
void KillCoordinator(const ExperimentOptions& options, Tally& tally);
void Outboxes(const ExperimentOptions& options, Tally& tally);
void LostReplies(const ExperimentOptions& options, Tally& tally);
void Partitions(const ExperimentOptions& options, Tally& tally);
void Poison(const ExperimentOptions& options, Tally& tally);
void Invariance(const ExperimentOptions& options, Tally& tally);
void Simulate(const ExperimentOptions& options, Tally& tally);
void SimulateControls(const ExperimentOptions& options, Tally& tally);
void SimulateGrowth(const ExperimentOptions& options, Tally& tally);
void Strangers(const ExperimentOptions& options, Tally& tally);

// A folder of this process's own, gone with it; if the process is killed, with the next one.
class TempFolder {
 public:
  // `memory`: on a memory disk where there is one; what is on it outlives the death of processes,
  // which is all that most experiments need, and costs no fsync.
  explicit TempFolder(bool memory);
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

Rng RoundRng(const ExperimentOptions& options, const std::string& experiment, int round);

}  // namespace parallax::faults
