// A farm of real daemons on this machine: the coordinator and workers as processes, reached over
// gRPC and HTTP, on loopback, with short leases.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "parallax/v1/service.grpc.pb.h"
#include "tests/e2e/process.h"
#include "tests/faults/experiment.h"

namespace parallax::faults {

struct FarmOptions {
  double lease_s = 2;
  double reconnect_s = 0.3;
  double backoff_s = 0;  // 0: the program's own.
  bool memory = true;    // On a memory disk.
  std::vector<std::string> coordinator_environment;
  std::vector<std::string> coordinator_arguments;
};

struct StudyShape {
  std::string name = "study";
  uint64_t seed = 3;
  int64_t pairs = 24;
  int rigs_per_scene = 2;
  int priority = 0;
};

class Farm {
 public:
  explicit Farm(const FarmOptions& options);

  // Starts it (again), on the same address as before. Returns that address; "" when it fails.
  // `environment` is for its first try alone.
  const std::string& StartCoordinator(const std::vector<std::string>& environment = {});
  // Tries that the last start took.
  int starts() const { return starts_; }
  void KillCoordinator();
  // From the next start on; "": this one's.
  void SetCoordinatorProgram(const std::string& program) { program_ = program; }
  Process& coordinator() { return *coordinator_; }
  const std::string& address() const { return address_; }

  // A worker whose jobs take `job_ms` and nothing else; reaches the coordinator at `address`, or
  // directly.
  std::unique_ptr<Process> StartWorker(const std::string& name, int job_ms,
                                       const std::string& address = "",
                                       std::vector<std::string> environment = {}, int slots = 2,
                                       const std::string& program = "",
                                       const std::vector<std::string>& more = {});

  // Calls the coordinator until it answers; aborts the experiment after a minute.
  int64_t Submit(const StudyShape& shape);
  // A study file, through the client, as a user does. 0 when it is not taken.
  int64_t SubmitFile(const std::string& yaml);
  v1::StudyStatus Status(int64_t study);
  std::vector<v1::JobStatus> Jobs(const v1::ListJobsRequest& request);
  // False when it took longer than the limit.
  bool WaitFor(int64_t study, const std::function<bool(const v1::StudyStatus&)>& condition,
               double limit_s = 60);
  bool WaitForEnd(int64_t study, double limit_s = 60);
  // A metric's value by its name with labels; -1 when it can't be read.
  double Metric(const std::string& name);
  v1::Coordinator::Stub& stub() { return *stub_; }

  struct Published {
    std::string path;
    std::map<std::string, std::string> sha256;  // By file.
  };
  // By variant, scene and rig.
  std::map<std::tuple<std::string, uint32_t, uint32_t>, Published> Frames(int64_t study,
                                                                          Tally& tally);
  // The study has all its pairs, each once, each with the files and bytes that were reported.
  void CheckPairs(int64_t study, size_t pairs, Tally& tally);
  // Stops the coordinator and lets the auditor look.
  void StopAndAudit(Tally& tally, const std::string& where);

  const std::string& folder() const { return folder_.path(); }
  std::string store() const { return folder() + "/store"; }

 private:
  const FarmOptions options_;
  TempFolder folder_;
  std::string address_;
  std::string http_;
  int starts_ = 0;
  std::string program_;
  std::unique_ptr<Process> coordinator_;
  std::unique_ptr<v1::Coordinator::Stub> stub_;
};

// Ends a worker in good order; its log when it fails to. `may_hand_back`: there is work without
// end, of which it may hold some that it has not begun.
void Drain(Process& worker, Tally& tally, bool may_hand_back = false);
int CountOf(const std::string& text, const std::string& what);
double SecondsSince(std::chrono::steady_clock::time_point begin);
void Sleep(double seconds);

}  // namespace parallax::faults
