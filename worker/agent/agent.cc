#include "worker/agent/agent.h"

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <optional>
#include <set>

#include "common/base/hash.h"
#include "common/base/seconds.h"
#include "common/base/system/log.h"
#include "worker/agent/agent_control.h"
#include "worker/agent/attempts/attempt_folders.h"
#include "worker/agent/attempts/attempt_report.h"
#include "worker/agent/attempts/job_slots.h"
#include "worker/agent/attempts/running.h"
#include "worker/agent/session/coordinator_link.h"
#include "worker/agent/session/credit.h"
#include "worker/agent/session/departure.h"
#include "worker/agent/session/retirement.h"

namespace parallax {
namespace {

// Time limit of the goodbye.
constexpr double kGoodbye_s = 2;
// Longest wait between two rounds of the loop.
constexpr double kLookAgain_s = 60;

RetirementOptions RetirementOf(const AgentOptions& options, Clock& clock) {
  RetirementOptions out{.idle_s = options.idle_exit_s, .deadline = {}, .margin_s = options.grace_s};
  if (options.deadline_unix_s > 0) {
    const double left = options.deadline_unix_s - clock.UnixSeconds();
    out.deadline = SecondsAfter(clock.Steady(), left);
  }
  return out;
}

// A number from the worker's name: workers draw different back-offs.
SceneSeed SeedOf(const std::string& name) {
  const Sha256Digest digest = Sha256Of(name);
  SceneSeed seed;
  for (int i = 0; i < 8; ++i) seed.value = seed.value << 8 | digest[static_cast<size_t>(i)];
  return seed;
}

std::pair<int64_t, uint64_t> KeyOf(const v1::AttemptId& attempt) {
  return {attempt.job_id(), attempt.fence()};
}

// The caller of Run() is the only thread that uses the state below "Run()'s own"; the others only
// wake it.
class AgentImpl final : public Agent {
 public:
  AgentImpl(const AgentOptions& options, const JobHandlers& handlers, Clock& clock,
            std::unique_ptr<Outbox> outbox, const std::shared_ptr<grpc::Channel>& channel)
      : options_(options),
        handlers_(handlers),
        clock_(clock),
        outbox_(std::move(outbox)),
        coordinator_(v1::Coordinator::NewStub(channel)),
        folders_({.store_uri = options.store_uri,
                  .staging = outbox_->staging(),
                  .worker = options.name,
                  .store_look_s = options.store_look_s,
                  .store_changed = [this] { control_.Wake(); }},
                 channel),
        port_(*coordinator_),
        link_(options_, port_, clock, Rng(SeedOf(options.name), "agent/reconnect"),
              {[this] { control_.Wake(); }, [this] { reports_.SetCoordinator(std::nullopt); }}),
        departure_({options.grace_s, options.long_grace_s, options.hand_back_s}),
        reports_(options.reports, *outbox_, *coordinator_, clock,
                 Rng(SeedOf(options.name), "agent/reports"), [this] { control_.Wake(); }),
        slots_(
            options.slots, options.name, handlers, clock,
            [this](Report report) { reports_.Submit(std::move(report)); },
            [this] { control_.Wake(); }),
        retirement_(RetirementOf(options, clock), clock.Steady()) {}

  ~AgentImpl() override { link_.Close(); }

  absl::StatusOr<AgentSummary> Run() override {
    LogContext names;
    names.worker = options_.name;
    ScopedLogContext scope(names);
    while (true) {
      control_.NoteRound(link_.IsWelcomed() && !departure_.leaving());
      if (link_.ConnectIsDue()) Connect();
      HandleMessages();
      link_.HandleEnd();
      HandleEnded();
      CheckLease();
      CheckHung();
      CheckRetirement();
      HandleDrain();
      if (const absl::Status& fatal = fatal_.ok() ? link_.fatal() : fatal_; !fatal.ok()) {
        slots_.StopAll(StopCause::kLeaseLost);
        return fatal;
      }
      if (finished_) break;
      GiveCredit();
      SendHeartbeatIfDue();
      control_.WaitUntil(NextDeadline());
    }
    SayGoodbye();
    summary_.reports_left = reports_.pending_in_all();
    summary_.stuck = slots_.busy();
    summary_.hung = summary_.stuck - std::max(0, Unfinished());
    return summary_;
  }

  void DrainLong() override { control_.Order(LeaveOrder::kDrainLong); }
  void Drain() override { control_.Order(LeaveOrder::kDrain); }
  void HandBack() override { control_.Order(LeaveOrder::kHandBack); }

  WorkerHealth Health() const override { return control_.Health(); }

 private:
  // ---- The coordinator
  void Connect() {
    const std::string before = link_.coordinator_id();
    if (!link_.Meet()) return;
    if (!before.empty() && link_.coordinator_id() != before) {
      LogWarning("another coordinator answers: its predecessor's work is stopped");
      slots_.StopAll(StopCause::kCoordinator);
    }
    credit_ = 0;
    link_.Open(Held());
  }

  std::vector<v1::Progress> Held() {
    return ProgressOf(slots_.Running(), reports_.Pending(link_.coordinator_id()));
  }

  void HandleMessages() {
    for (v1::CoordinatorMessage& message : link_.TakeMessages()) {
      switch (message.message_case()) {
        case v1::CoordinatorMessage::kWelcome:
          HandleWelcome(message.welcome());
          break;
        case v1::CoordinatorMessage::kLease:
          HandleLease(std::move(*message.mutable_lease()));
          break;
        case v1::CoordinatorMessage::kStop:
          HandleStop(message.stop());
          break;
        case v1::CoordinatorMessage::kHeartbeatAck:
          link_.Answered(message.heartbeat_ack().sequence());
          break;
        case v1::CoordinatorMessage::MESSAGE_NOT_SET:
          break;  // A message that only newer coordinators send.
      }
    }
  }

  bool NeedsStore() const {
    return std::any_of(options_.kinds.begin(), options_.kinds.end(), [this](const auto& kind) {
      return FindHandler(handlers_, kind)->writes_output();
    });
  }

  void HandleWelcome(const v1::Welcome& welcome) {
    if (!(welcome.lease_s() > 0)) {
      fatal_ = InvalidArgument("the coordinator's lease is not positive");
      return;
    }
    if (NeedsStore()) {
      fatal_ = folders_.Use(welcome);
      if (!fatal_.ok()) return;
    }
    link_.Welcomed(welcome);
    std::set<std::pair<int64_t, uint64_t>> adopted;
    for (const v1::AttemptId& attempt : welcome.adopted()) adopted.insert(KeyOf(attempt));
    for (const RunningAttempt& run : slots_.Running()) {
      if (adopted.count(KeyOf(run.attempt)) == 0) {
        slots_.Stop(run.attempt, StopCause::kCoordinator);
      }
    }
    for (const std::string& note : welcome.notes()) LogWarning(note);
    LogInfo("connected", {{"coordinator", options_.coordinator.ToString()},
                          {"epoch", welcome.epoch()},
                          {"lease_s", welcome.lease_s()},
                          {"adopted", adopted.size()}});
    reports_.SetCoordinator(link_.coordinator_id());
  }

  void HandleLease(v1::Lease lease) {
    credit_ = std::max(0, credit_ - 1);
    const v1::AttemptId attempt = lease.attempt();
    if (departure_.leaving()) return link_.HandBack(attempt, "draining");
    AttemptFolder folder;
    const JobHandler* handler = FindHandler(handlers_, lease.kind());
    if (handler == nullptr) {
      return ReportUnusable(lease,
                            Unimplemented("this worker does no jobs of kind '{}'", lease.kind()));
    }
    if (!folders_.StoreIsThere()) {
      return link_.HandBack(attempt, "the store is gone from this machine");
    }
    if (handler->writes_output()) {
      absl::StatusOr<AttemptFolder> found = folders_.Of(lease);
      if (!found.ok()) return ReportUnusable(lease, found.status());
      folder = *std::move(found);
    } else {
      folder = folders_.ReadOnly(lease);
    }
    if (!slots_.Start(std::move(lease), std::move(folder), link_.coordinator_id())) {
      return link_.HandBack(attempt, "no free slot");
    }
    retirement_.Began(KeyOf(attempt), clock_.Steady());
  }

  void ReportUnusable(const v1::Lease& lease, const absl::Status& status) {
    reports_.Submit(UnusableReport(lease, {options_.name, link_.coordinator_id()}, status));
  }

  void HandleStop(const v1::Stop& stop) {
    if (!slots_.Stop(stop.attempt(), StopCause::kCoordinator)) return;
    LogInfo("told to stop an attempt", {{"job", stop.attempt().job_id()},
                                        {"attempt", stop.attempt().fence()},
                                        {"reason", stop.reason()}});
  }

  // ---- Upkeep
  void HandleEnded() {
    for (const EndedAttempt& ended : slots_.TakeEnded()) {
      retirement_.Ended(KeyOf(ended.attempt), clock_.Steady());
      if (ended.reported) {
        ++(ended.succeeded ? summary_.succeeded : summary_.failed);
      } else if (ended.stop == StopCause::kHandBack) {
        ++summary_.handed_back;
        link_.HandBack(ended.attempt, "drained");
        folders_.LookSoon();  // Or because the store is gone.
      }
    }
  }

  void CheckLease() {
    link_.BreakIfSilent();
    if (!link_.LeaseIsOver()) return;
    for (const RunningAttempt& run : slots_.Running()) {
      if (run.stop != StopCause::kNone) continue;
      LogWarning("coordinator out of reach for longer than the lease; work stopped",
                 {{"job", run.attempt.job_id()}, {"attempt", run.attempt.fence()}});
      slots_.Stop(run.attempt, StopCause::kLeaseLost);
    }
  }

  void CheckHung() {
    if (options_.hang_s <= 0) return;
    for (const RunningAttempt& run : slots_.Running()) {
      if (run.stop != StopCause::kNone || run.idle_s < options_.hang_s) continue;
      if (!slots_.Abandon(run.attempt)) continue;
      LogError("a job hangs; it is reported as failed, and this worker drains",
               {{"job", run.attempt.job_id()},
                {"attempt", run.attempt.fence()},
                {"stage", run.stage},
                {"idle_s", run.idle_s}});
      Drain();
    }
  }

  void CheckRetirement() {
    const SteadyTime now = clock_.Steady();
    retirement_.Observe(slots_.busy() > 0, now);
    const char* why = retirement_.WhyLeave(now);
    if (why == nullptr || departure_.leaving()) return;
    LogInfo("leaving", {{"why", why}});
    Drain();
  }

  // Attempts that may still end by themselves.
  int Unfinished() const { return slots_.busy() - CountHung(slots_.Running()); }

  void GiveCredit() {
    if (!link_.IsWelcomed() || departure_.leaving()) return;
    if (!retirement_.TakesWork(clock_.Steady())) return;
    if (reports_.HasUntriedLeftovers(link_.coordinator_id())) return;
    if (!folders_.StoreIsThere()) return;
    const int soon = options_.ahead_s > 0 ? CountEndingSoon(slots_.Running(), options_.ahead_s) : 0;
    const std::optional<v1::Credit> credit =
        CreditFor({.slots = options_.slots,
                   .taken = slots_.busy() + credit_,
                   .ending_soon = soon,
                   .pending_reports = static_cast<int>(reports_.pending_in_all()),
                   .max_pending_reports = options_.max_pending_reports});
    if (!credit) return;
    credit_ += credit->jobs();
    link_.Ask(*credit);
  }

  void SendHeartbeatIfDue() {
    if (link_.HeartbeatIsDue()) link_.SendHeartbeat(Held(), departure_.leaving());
  }

  SteadyTime NextDeadline() const {
    const std::vector<RunningAttempt> running = slots_.Running();
    SteadyTime next =
        link_.NextLook(SecondsAfter(clock_.Steady(), kLookAgain_s), HasWorkUnderLease(running));
    next =
        departure_.leaving() ? std::min(next, departure_.deadline()) : retirement_.NextLook(next);
    const std::optional<double> to_hang_s = SecondsToHang(running, options_.hang_s);
    if (options_.hang_s > 0 && to_hang_s) {
      next = std::min(next, SecondsAfter(clock_.Steady(), *to_hang_s));
    }
    // Progress does not wake this thread.
    if (link_.IsWelcomed() && !departure_.leaving() && options_.ahead_s > 0 && slots_.busy() > 0) {
      next = std::min(next, SecondsAfter(clock_.Steady(), options_.ahead_s / 4));
    }
    return next;
  }

  // ---- The end
  void HandleDrain() {
    const Departure::Step step = departure_.Advance(control_.order(), clock_.Steady());
    if (step.begins) BeginDrain();
    if (step.grace_s) {
      LogInfo("draining", {{"running", slots_.busy()}, {"grace_s", *step.grace_s}});
    }
    if (!departure_.leaving()) return;
    if (step.hands_back) {
      LogInfo("handing back", {{"running", slots_.busy()}});
      slots_.StopAll(StopCause::kHandBack);
      return;
    }
    const bool idle = Unfinished() <= 0;
    HandleEnded();  // Jobs that ended meanwhile: hand-backs go out before the goodbye.
    const bool nothing_to_send = reports_.Pending(link_.coordinator_id()).empty();
    const bool over = departure_.IsOver(clock_.Steady());
    if (over) {
      for (const RunningAttempt& run : slots_.Running()) {
        if (run.stop == StopCause::kHung) continue;
        ++summary_.handed_back;
        link_.HandBack(run.attempt, "drained");
      }
    }
    finished_ = (idle && nothing_to_send) || over;
  }

  void BeginDrain() {
    link_.HurryHeartbeat();  // Tells the coordinator at once.
    for (const v1::AttemptId& attempt : slots_.TakeWaiting()) {
      ++summary_.handed_back;
      link_.HandBack(attempt, "draining");
    }
  }

  // Waits until the coordinator has read the hand-backs, before the process ends.
  void SayGoodbye() {
    if (!link_.IsOpen()) return;
    link_.HurryHeartbeat();
    SendHeartbeatIfDue();
    link_.Finish();
    const SteadyTime deadline = SecondsAfter(clock_.Steady(), kGoodbye_s);
    while (link_.IsOpen() && clock_.Steady() < deadline) {
      control_.WaitUntil(deadline);
      link_.HandleEnd();
    }
    link_.Close();
  }

  const AgentOptions options_;
  const JobHandlers& handlers_;
  Clock& clock_;

  AgentControl control_{clock_};
  const std::unique_ptr<Outbox> outbox_;
  const std::unique_ptr<v1::Coordinator::Stub> coordinator_;

  // Run()'s own.
  AttemptFolders folders_;
  GrpcPort port_;
  CoordinatorLink link_;
  Departure departure_;
  int credit_ = 0;  // Leases asked for in this session and not given yet.
  bool finished_ = false;
  absl::Status fatal_;
  AgentSummary summary_;

  // Last, so that their threads end first.
  ReportSender reports_;
  JobSlots slots_;
  Retirement retirement_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<Agent>> Agent::Create(const AgentOptions& options,
                                                     const JobHandlers& handlers, Clock& clock) {
  if (options.slots < 1 || options.slots > 1024) {
    return InvalidArgument("slots must be in [1, 1024], not {}", options.slots);
  }
  if (options.kinds.empty()) return InvalidArgument("a worker without kinds of jobs");
  for (const std::string& kind : options.kinds) {
    if (FindHandler(handlers, kind) != nullptr) continue;
    return InvalidArgument("this worker does no jobs of kind '{}'", kind);
  }
  ASSIGN_OR_RETURN(auto channel, ConnectRpc(options.coordinator, options.security));
  ASSIGN_OR_RETURN(auto outbox, Outbox::Open(options.outbox_root, options.name));
  return std::unique_ptr<Agent>(
      new AgentImpl(options, handlers, clock, std::move(outbox), channel));
}

}  // namespace parallax
