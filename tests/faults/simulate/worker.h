// A simulated machine with one worker. The session with the coordinator (CoordinatorLink), credit,
// back-offs, departure, retirement, outbox and queue of reports are the agent's own; its loop and
// slots are modelled here, because the agent's have threads.
#pragma once

#include <list>
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
#include "worker/agent/session/report_queue.h"
#include "worker/agent/session/retirement.h"

namespace parallax::faults {

class SimWorker {
 public:
  // `folder`: where its disk is.
  SimWorker(World& world, SimCoordinator& coordinator, const std::string& folder, int number);
  ~SimWorker();

  void Start();
  // The faults are over: the line is open, its release is the newest, and a worker that dies comes
  // back at once.
  void Mend();
  const std::string& name() const { return name_; }
  bool is_up() const { return process_ != nullptr; }
  // Returns how many of the attempts that ended here have no definitive answer.
  size_t pending() const { return unanswered_.size(); }
  // Returns the attempts that it runs.
  std::vector<v1::AttemptId> running() const;
  // Kills it. It comes back after `away_s`.
  void Die(const char* how, double away_s);

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
  class Port;
  // A process of the agent.
  struct Process {
    AgentOptions options;
    int release = 0;
    std::unique_ptr<Port> port;
    std::unique_ptr<CoordinatorLink> link;
    std::unique_ptr<Departure> departure;
    std::unique_ptr<Retirement> retirement;
    std::list<Run> runs;
    std::unique_ptr<Outbox> outbox;
    std::unique_ptr<ReportQueue> reports;
    ReportQueue::Entry* in_flight = nullptr;
    std::set<Key> sent;
    int credit = 0;
    bool finished = false;
    LeaveOrder order = LeaveOrder::kStay;
    int64_t call = 0;  // The newest call of a report.
  };

  bool Lives(int life) const { return process_ != nullptr && life == lives_; }
  int DrawRelease();
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
  void Submit(Report report);
  std::vector<v1::AttemptId> Unanswered() const;
  void SendNext();
  void Send(ReportQueue::Entry* entry);
  void Answered(const absl::Status& status);
  void Later(double seconds, std::function<void()> event);  // In this process's life.

  World& world_;
  SimCoordinator& coordinator_;
  const std::string name_;
  MachineClock clock_;
  Rng dice_;
  Line line_;
  const std::string outbox_root_;
  std::set<Key> unanswered_;  // What must be in its outbox.
  std::unique_ptr<Process> process_;
  int lives_ = 0;
  bool wakes_ = false;
  double sleeps_until_s_ = 0;
  std::weak_ptr<SimStream> stream_;
};

}  // namespace parallax::faults
