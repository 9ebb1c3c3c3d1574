// A simulated machine with one worker. The session with the coordinator (CoordinatorLink), credit,
// back-offs, departure and retirement are the agent's own; its loop, slots, sender of reports and
// outbox are modelled here, because the agent's have threads.
#pragma once

#include <list>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tests/faults/simulate/coordinator.h"
#include "tests/faults/simulate/world.h"
#include "worker/agent/attempts/job_slots.h"
#include "worker/agent/attempts/outbox.h"
#include "worker/agent/session/coordinator_link.h"
#include "worker/agent/session/departure.h"
#include "worker/agent/session/retirement.h"

namespace parallax::faults {

class SimWorker {
 public:
  SimWorker(World& world, SimCoordinator& coordinator, int number);
  ~SimWorker();

  void Start();
  // The faults are over: the line is open, and a worker that dies comes back at once.
  void Mend();
  const std::string& name() const { return name_; }
  // Returns how many of the attempts that ended here have no definitive answer.
  size_t pending() const { return unanswered_.size(); }

 private:
  using Key = std::pair<int64_t, uint64_t>;  // Job and fence.
  // One attempt in a slot, or waiting for one.
  struct Run {
    v1::Lease lease;
    StopCause stop = StopCause::kNone;
    bool working = false;
    SteadyTime started{};
    double duration_s = 0;  // Of virtual time.
  };
  struct Pending {
    Report report;
    Backoff backoff;
    SteadyTime due{};
    bool leftover = false;
    bool tried = false;
    bool sent = false;
  };
  class Port;
  // A process of the agent.
  struct Process {
    AgentOptions options;
    std::unique_ptr<Port> port;
    std::unique_ptr<CoordinatorLink> link;
    std::unique_ptr<Departure> departure;
    std::unique_ptr<Retirement> retirement;
    std::list<Run> runs;
    std::list<Pending> reports;
    std::optional<std::string> reporting_to;
    std::optional<Key> in_flight;
    int credit = 0;
    bool finished = false;
    LeaveOrder order = LeaveOrder::kStay;
    int64_t call = 0;  // The newest call of a report.
  };

  bool Lives(int life) const { return process_ != nullptr && life == lives_; }
  void Die(const char* how, double away_s);
  void PlanFaults(int life);
  void CloseLine();
  void BreakStream();

  // ---- The agent's loop
  void WakeSoon();
  void Round();
  void Connect();
  void HandleMessages();
  void HandleWelcome(const v1::Welcome& welcome);
  void HandleLease(v1::Lease lease);
  void CheckLease();
  void HandleDrain();
  void GiveCredit();
  void SleepUntilNext();
  std::vector<RunningAttempt> Running() const;
  std::vector<v1::Progress> Held() const;

  // ---- Slots
  void FillSlots();
  void Begin(Run& run);
  void Stop(Run& run, StopCause cause);
  void EndRun(const Key& key);
  Report ReportOf(const Run& run);

  // ---- Reports
  void Submit(Report report, bool leftover);
  std::vector<v1::AttemptId> Unanswered() const;
  void SendNext();
  void Send(Pending& pending);
  void Answered(const Key& key, const absl::StatusOr<v1::ReportOutcome>& outcome);
  void Later(double seconds, std::function<void()> event);  // In this process's life.

  World& world_;
  SimCoordinator& coordinator_;
  const std::string name_;
  MachineClock clock_;
  Rng dice_;
  Line line_;
  std::map<Key, Report> outbox_;  // On the machine's disk.
  std::set<Key> unanswered_;      // The same, whatever becomes of the disk.
  std::unique_ptr<Process> process_;
  int lives_ = 0;
  bool wakes_ = false;
  double sleeps_until_s_ = 0;
  std::weak_ptr<SimStream> stream_;
};

}  // namespace parallax::faults
