#include "worker/agent/agent.h"

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <set>

#include "common/base/hash.h"
#include "common/base/log.h"
#include "common/base/version.h"
#include "common/rpc/grpc_status.h"
#include "worker/agent/attempt_folders.h"
#include "worker/agent/backoff.h"
#include "worker/agent/job_slots.h"
#include "worker/agent/retirement.h"
#include "worker/agent/work_session.h"

namespace parallax {
namespace {

using Seconds = std::chrono::duration<double>;

// How long the goodbye may take.
constexpr double kGoodbye_s = 2;

// How far a worker has been told to leave. Later ones are sharper.
enum DrainLevel : int { kStay = 0, kDrainLong = 1, kDrain = 2, kHandBack = 3 };

RetirementOptions RetirementOf(const AgentOptions& options, Clock& clock) {
  RetirementOptions out{.idle_s = options.idle_exit_s, .deadline = {}, .margin_s = options.grace_s};
  if (options.deadline_unix_s > 0) {
    const Seconds left(options.deadline_unix_s - clock.UnixSeconds());
    out.deadline = clock.Steady() + std::chrono::duration_cast<SteadyTime::duration>(left);
  }
  return out;
}

SteadyTime After(SteadyTime from, double seconds) {
  return from + std::chrono::duration_cast<SteadyTime::duration>(Seconds(seconds));
}

// What no waiting mends.
bool IsFatal(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kUnimplemented:
    case absl::StatusCode::kPermissionDenied:
    case absl::StatusCode::kUnauthenticated:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kAlreadyExists:
      return true;
    default:
      return false;
  }
}

// The machine's number for a name: workers draw different back-offs.
SceneSeed SeedOf(const std::string& name) {
  const Sha256Digest digest = Sha256Of(name);
  SceneSeed seed;
  for (int i = 0; i < 8; ++i) seed.value = seed.value << 8 | digest[static_cast<size_t>(i)];
  return seed;
}

std::pair<int64_t, uint64_t> KeyOf(const v1::AttemptId& attempt) {
  return {attempt.job_id(), attempt.fence()};
}

// One thread, the caller of Run(), holds all of the state below "Run()'s own"; the others leave
// notes in the inbox and wake it.
class AgentImpl final : public Agent {
 public:
  AgentImpl(const AgentOptions& options, const JobHandlers& handlers, Clock& clock,
            std::unique_ptr<Outbox> outbox, const std::shared_ptr<grpc::Channel>& channel)
      : options_(options),
        handlers_(handlers),
        clock_(clock),
        outbox_(std::move(outbox)),
        coordinator_(v1::Coordinator::NewStub(channel)),
        folders_(
            {.store_uri = options.store_uri, .staging = outbox_->staging(), .worker = options.name},
            channel),
        reconnect_backoff_(Rng(SeedOf(options.name), "agent/reconnect"),
                           Seconds(options.backoff_base_s), Seconds(options.backoff_cap_s)),
        reports_(options.reports, *outbox_, *coordinator_, clock,
                 Rng(SeedOf(options.name), "agent/reports"), [this] { Wake(); }),
        slots_(
            options.slots, options.name, handlers, clock,
            [this](Report report) { reports_.Submit(std::move(report)); }, [this] { Wake(); }),
        retirement_(RetirementOf(options, clock), clock.Steady()) {}

  ~AgentImpl() override { CloseSession(); }

  absl::StatusOr<AgentSummary> Run() override {
    LogContext names;
    names.worker = options_.name;
    ScopedLogContext scope(names);
    reconnect_at_ = clock_.Steady();
    while (true) {
      if (session_ == nullptr && clock_.Steady() >= reconnect_at_) Connect();
      HandleMessages();
      HandleSessionEnd();
      HandleEnded();
      CheckLease();
      CheckHung();
      CheckRetirement();
      HandleDrain();
      if (!fatal_.ok()) {
        slots_.StopAll(StopCause::kLeaseLost);
        return fatal_;
      }
      if (finished_) break;
      GiveCredit();
      SendHeartbeatIfDue();
      WaitUntil(NextDeadline());
    }
    SayGoodbye();
    summary_.reports_left = reports_.pending_in_all();
    summary_.stuck = slots_.busy();
    summary_.hung = summary_.stuck - std::max(0, Unfinished());
    return summary_;
  }

  void DrainLong() override { RaiseDrain(kDrainLong); }
  void Drain() override { RaiseDrain(kDrain); }
  void HandBack() override { RaiseDrain(kHandBack); }

 private:
  // ---- Notes from other threads ----
  struct Inbox {
    std::deque<v1::CoordinatorMessage> messages;
    std::optional<absl::Status> session_end;
  };

  void Wake() {
    std::lock_guard lock(mu_);
    WakeLocked();
  }

  // Requires mu_.
  void WakeLocked() {
    woken_ = true;
    wake_.notify_all();
  }

  void RaiseDrain(DrainLevel level) {
    std::lock_guard lock(mu_);
    drain_wanted_ = std::max(drain_wanted_, level);
    WakeLocked();
  }

  void WaitUntil(SteadyTime deadline) {
    std::unique_lock lock(mu_);
    wake_.wait_until(lock, deadline, [this] { return woken_; });
    woken_ = false;
  }

  // ---- The stream ----
  void Connect() {
    v1::GetInfoReply info;
    absl::Status status = AskInfo(&info);
    // Before it ever worked: a wrong certificate is told at once and not waited for.
    if (absl::IsUnavailable(status) && coordinator_id_.empty()) {
      if (const absl::Status why = ExplainRpcSecurity(options_.coordinator, options_.security);
          !why.ok()) {
        fatal_ = why;
        return;
      }
    }
    if (!status.ok()) return Disconnected(status);
    if (info.protocol() != kWorkProtocol) {
      return Disconnected(absl::FailedPreconditionError(
          "it speaks work protocol " + std::to_string(info.protocol()) + " (version " +
          info.version() + "), this worker speaks " + std::to_string(kWorkProtocol) +
          ": give both the same release"));
    }
    if (!coordinator_id_.empty() && info.coordinator_id() != coordinator_id_) {
      LogWarning("another coordinator answers: its predecessor's work is stopped");
      slots_.StopAll(StopCause::kCoordinator);
    }
    coordinator_id_ = info.coordinator_id();
    session_ = WorkSession::Open(*coordinator_, {[this](v1::CoordinatorMessage message) {
                                                   std::lock_guard lock(mu_);
                                                   inbox_.messages.push_back(std::move(message));
                                                   WakeLocked();
                                                 },
                                                 [this](absl::Status end) {
                                                   std::lock_guard lock(mu_);
                                                   inbox_.session_end = std::move(end);
                                                   WakeLocked();
                                                 }});
    credit_ = 0;
    sent_at_.clear();
    hello_at_ = clock_.Steady();
    SendHello();
  }

  absl::Status AskInfo(v1::GetInfoReply* info) {
    grpc::ClientContext context;
    SetRpcTimeout(context, Seconds(options_.connect_timeout_s));
    return FromGrpc(coordinator_->GetInfo(&context, v1::GetInfoRequest(), info));
  }

  void SendHello() {
    v1::WorkerMessage message;
    v1::Hello& hello = *message.mutable_hello();
    hello.set_name(options_.name);
    hello.set_protocol(kWorkProtocol);
    for (const std::string& kind : options_.kinds) hello.add_kinds(kind);
    hello.set_slots(options_.slots);
    hello.set_cores(options_.cores);
    hello.set_memory_mb(options_.memory_mb);
    for (const std::string& tag : options_.tags) hello.add_tags(tag);
    hello.set_version(options_.version);
    hello.set_build_id(options_.build_id);
    for (const auto& [stage, version] : ListVersions(options_.versions)) {
      (*hello.mutable_stage_versions())[stage] = version;
    }
    hello.set_instance(options_.instance);
    for (const v1::Progress& held : Held()) *hello.add_holding() = held.attempt();
    session_->Send(std::move(message));
  }

  // What is ours: what runs, and what is finished but not answered.
  std::vector<v1::Progress> Held() {
    std::vector<v1::Progress> held;
    for (const RunningAttempt& run : slots_.Running()) {
      if (run.stop != StopCause::kNone) continue;
      v1::Progress& progress = held.emplace_back();
      *progress.mutable_attempt() = run.attempt;
      progress.set_fraction(run.fraction);
      progress.set_stage(run.stage);
      progress.mutable_figures()->insert(run.figures.begin(), run.figures.end());
    }
    for (const v1::AttemptId& attempt : reports_.Pending(coordinator_id_)) {
      v1::Progress& progress = held.emplace_back();
      *progress.mutable_attempt() = attempt;
      progress.set_fraction(1);
      progress.set_stage("report");
    }
    return held;
  }

  void CloseSession() {
    session_.reset();
    welcomed_ = false;
    std::lock_guard lock(mu_);
    inbox_ = Inbox();
  }

  // The session is over or did not come about.
  void Disconnected(const absl::Status& status) {
    CloseSession();
    reports_.SetCoordinator(std::nullopt);
    if (IsFatal(status.code())) {
      // Of the coordinator, and not of this machine's disk: the two have different exit statuses.
      const bool refused = absl::IsPermissionDenied(status);
      fatal_ = WithContext(
          refused ? absl::Status(absl::StatusCode::kUnauthenticated, status.message()) : status,
          "coordinator " + options_.coordinator.ToString());
      return;
    }
    // Once when it goes, not at every try.
    if (!complained_) {
      LogWarning("coordinator can't be reached; trying again",
                 {{"coordinator", options_.coordinator.ToString()}, {"error", status}});
      complained_ = true;
    }
    reconnect_at_ = clock_.Steady() +
                    std::chrono::duration_cast<SteadyTime::duration>(reconnect_backoff_.Next());
  }

  void HandleMessages() {
    std::deque<v1::CoordinatorMessage> messages;
    {
      std::lock_guard lock(mu_);
      messages.swap(inbox_.messages);
    }
    for (v1::CoordinatorMessage& message : messages) {
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
          HandleAck(message.heartbeat_ack().sequence());
          break;
        case v1::CoordinatorMessage::MESSAGE_NOT_SET:
          break;  // Of a newer coordinator.
      }
    }
  }

  void HandleSessionEnd() {
    std::optional<absl::Status> end;
    {
      std::lock_guard lock(mu_);
      end.swap(inbox_.session_end);
    }
    if (!end) return;
    Disconnected(end->ok() ? absl::UnavailableError("the coordinator ended the stream") : *end);
  }

  bool NeedsStore() const {
    return std::any_of(options_.kinds.begin(), options_.kinds.end(), [this](const auto& kind) {
      return FindHandler(handlers_, kind)->writes_output();
    });
  }

  void HandleWelcome(const v1::Welcome& welcome) {
    if (!(welcome.lease_s() > 0)) {
      fatal_ = absl::InvalidArgumentError("the coordinator's lease is not positive");
      return;
    }
    if (NeedsStore()) {
      fatal_ = folders_.Use(welcome);
      if (!fatal_.ok()) return;
    }
    welcomed_ = true;
    complained_ = false;
    lease_s_ = welcome.lease_s();
    heard_at_ = hello_at_;
    heartbeat_at_ = After(clock_.Steady(), lease_s_ / 4);
    reconnect_backoff_.Reset();
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
                          {"lease_s", lease_s_},
                          {"adopted", adopted.size()}});
    reports_.SetCoordinator(coordinator_id_);
  }

  void HandleLease(v1::Lease lease) {
    credit_ = std::max(0, credit_ - 1);
    const v1::AttemptId attempt = lease.attempt();
    if (drain_ > 0) return SendHandBack(attempt, "draining");
    AttemptFolder folder;
    const JobHandler* handler = FindHandler(handlers_, lease.kind());
    if (handler == nullptr) {
      return ReportUnusable(lease, absl::UnimplementedError("this worker does no jobs of kind '" +
                                                            lease.kind() + "'"));
    }
    if (handler->writes_output()) {
      absl::StatusOr<AttemptFolder> found = folders_.Of(lease);
      if (!found.ok()) return ReportUnusable(lease, found.status());
      folder = *std::move(found);
    }
    if (!slots_.Start(std::move(lease), std::move(folder), coordinator_id_)) {
      return SendHandBack(attempt, "no free slot");
    }
    retirement_.Began(KeyOf(attempt), clock_.Steady());
  }

  void ReportUnusable(const v1::Lease& lease, const absl::Status& status) {
    v1::FailRequest fail;
    *fail.mutable_attempt() = lease.attempt();
    fail.set_worker(options_.name);
    fail.set_coordinator_id(coordinator_id_);
    fail.set_error(status.ToString());
    fail.set_fingerprint(absl::StatusCodeToString(status.code()) + "@lease");
    reports_.Submit({std::move(fail)});
  }

  void HandleStop(const v1::Stop& stop) {
    if (!slots_.Stop(stop.attempt(), StopCause::kCoordinator)) return;
    LogInfo("told to stop an attempt", {{"job", stop.attempt().job_id()},
                                        {"attempt", stop.attempt().fence()},
                                        {"reason", stop.reason()}});
  }

  void HandleAck(int64_t sequence) {
    const auto sent = sent_at_.find(sequence);
    if (sent == sent_at_.end()) return;
    heard_at_ = sent->second;
    sent_at_.erase(sent_at_.begin(), std::next(sent));
  }

  void SendHandBack(const v1::AttemptId& attempt, const std::string& reason) {
    if (session_ == nullptr) return;  // Its lease runs out instead.
    v1::WorkerMessage message;
    *message.mutable_hand_back()->mutable_attempt() = attempt;
    message.mutable_hand_back()->set_reason(reason);
    session_->Send(std::move(message));
  }

  // ---- Upkeep ----
  void HandleEnded() {
    for (const EndedAttempt& ended : slots_.TakeEnded()) {
      retirement_.Ended(KeyOf(ended.attempt), clock_.Steady());
      if (ended.reported) {
        ++(ended.succeeded ? summary_.succeeded : summary_.failed);
      } else if (ended.stop == StopCause::kHandBack) {
        ++summary_.handed_back;
        SendHandBack(ended.attempt, "drained");
      }
    }
  }

  // Ours no longer: the time since the last proof that the coordinator hears us is longer than the
  // lease.
  void CheckLease() {
    if (session_ != nullptr && !welcomed_ &&
        clock_.Steady() >= After(hello_at_, options_.connect_timeout_s)) {
      return Disconnected(absl::DeadlineExceededError("no welcome from the coordinator"));
    }
    if (lease_s_ <= 0 || clock_.Steady() < After(heard_at_, lease_s_)) return;
    for (const RunningAttempt& run : slots_.Running()) {
      if (run.stop != StopCause::kNone) continue;
      LogWarning("coordinator out of reach for longer than the lease; work stopped",
                 {{"job", run.attempt.job_id()}, {"attempt", run.attempt.fence()}});
      slots_.Stop(run.attempt, StopCause::kLeaseLost);
    }
    if (session_ != nullptr && welcomed_) {
      Disconnected(absl::DeadlineExceededError("the coordinator does not answer heartbeats"));
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
    if (why == nullptr || drain_ > 0) return;
    LogInfo("leaving", {{"why", why}});
    Drain();
  }

  // Attempts that may still come to their end.
  int Unfinished() const {
    int hung = 0;
    for (const RunningAttempt& run : slots_.Running()) hung += run.stop == StopCause::kHung;
    return slots_.busy() - hung;
  }

  void GiveCredit() {
    if (session_ == nullptr || !welcomed_ || drain_ > 0) return;
    if (!retirement_.TakesWork(clock_.Steady())) return;
    if (reports_.HasUntriedLeftovers(coordinator_id_)) return;
    const int taken = slots_.busy() + credit_;
    const int free = std::max(0, options_.slots - taken);
    // Work whose reports nobody takes is likely in vain.
    const int room = options_.slots + options_.max_pending_reports - taken -
                     static_cast<int>(reports_.pending_in_all());
    const int more = std::min(options_.slots + EndingSoon() - taken, room);
    if (more <= 0) return;
    credit_ += more;
    v1::WorkerMessage message;
    message.mutable_credit()->set_jobs(more);
    message.mutable_credit()->set_ahead(std::max(0, more - free));
    session_->Send(std::move(message));
  }

  int EndingSoon() const {
    if (options_.ahead_s <= 0) return 0;
    int soon = 0;
    for (const RunningAttempt& run : slots_.Running()) soon += run.remaining_s <= options_.ahead_s;
    return soon;
  }

  void SendHeartbeatIfDue() {
    if (session_ == nullptr || !welcomed_ || clock_.Steady() < heartbeat_at_) return;
    v1::WorkerMessage message;
    v1::Heartbeat& heartbeat = *message.mutable_heartbeat();
    for (v1::Progress& progress : Held()) *heartbeat.add_running() = std::move(progress);
    heartbeat.set_draining(drain_ > 0);
    heartbeat.set_sequence(++sequence_);
    sent_at_[sequence_] = clock_.Steady();
    session_->Send(std::move(message));
    heartbeat_at_ = After(clock_.Steady(), lease_s_ / 4);
  }

  SteadyTime NextDeadline() const {
    SteadyTime next = After(clock_.Steady(), 60);
    if (session_ == nullptr) {
      next = std::min(next, reconnect_at_);
    } else if (welcomed_) {
      next = std::min(next, heartbeat_at_);
    } else {
      next = std::min(next, After(hello_at_, options_.connect_timeout_s));
    }
    // Work told to stop needs no watch: its end wakes this thread.
    if (lease_s_ > 0 && (welcomed_ || HasWorkUnderLease())) {
      next = std::min(next, After(heard_at_, lease_s_));
    }
    next = drain_ > 0 ? std::min(next, drain_deadline_) : retirement_.NextLook(next);
    if (options_.hang_s > 0) {
      for (const RunningAttempt& run : slots_.Running()) {
        if (run.stop != StopCause::kNone) continue;
        next = std::min(next, After(clock_.Steady(), options_.hang_s - run.idle_s));
      }
    }
    // Progress doesn't wake this thread.
    if (welcomed_ && drain_ == 0 && options_.ahead_s > 0 && slots_.busy() > 0) {
      next = std::min(next, After(clock_.Steady(), options_.ahead_s / 4));
    }
    return next;
  }

  bool HasWorkUnderLease() const {
    for (const RunningAttempt& run : slots_.Running()) {
      if (run.stop == StopCause::kNone) return true;
    }
    return false;
  }

  // ---- The end ----
  void HandleDrain() {
    DrainLevel wanted;
    {
      std::lock_guard lock(mu_);
      wanted = drain_wanted_;
    }
    if (wanted > kStay && drain_ == 0) BeginDrain();
    if (drain_ == 1 && wanted > drain_level_) {  // Sharper than before: the end comes nearer.
      drain_level_ = wanted;
      const double grace_s = wanted == kDrainLong ? options_.long_grace_s : options_.grace_s;
      drain_deadline_ = std::min(drain_deadline_, After(clock_.Steady(), grace_s));
      LogInfo("draining", {{"running", slots_.busy()}, {"grace_s", grace_s}});
    }
    if (drain_ == 0) return;
    const bool late = clock_.Steady() >= drain_deadline_;
    if (drain_ == 1 && (wanted == kHandBack || late)) {
      drain_ = 2;
      drain_deadline_ = After(clock_.Steady(), options_.hand_back_s);
      LogInfo("handing back", {{"running", slots_.busy()}});
      slots_.StopAll(StopCause::kHandBack);
      return;
    }
    const bool idle = Unfinished() <= 0;
    HandleEnded();  // Those that ended since: their hand-backs go out before the goodbye.
    const bool nothing_to_send = reports_.Pending(coordinator_id_).empty();
    if (drain_ == 2 && late) {
      for (const RunningAttempt& run : slots_.Running()) {
        if (run.stop == StopCause::kHung) continue;
        ++summary_.handed_back;
        SendHandBack(run.attempt, "drained");
      }
    }
    finished_ = (idle && nothing_to_send) || (drain_ == 2 && late);
  }

  void BeginDrain() {
    drain_ = 1;
    drain_deadline_ = SteadyTime::max();
    heartbeat_at_ = clock_.Steady();  // The coordinator is to know now.
    for (const v1::AttemptId& attempt : slots_.TakeWaiting()) {
      ++summary_.handed_back;
      SendHandBack(attempt, "draining");
    }
  }

  // So that the coordinator has read the hand-backs when the process ends.
  void SayGoodbye() {
    if (session_ == nullptr) return;
    heartbeat_at_ = clock_.Steady();
    if (welcomed_) SendHeartbeatIfDue();
    complained_ = true;  // That the stream ends now is no news.
    session_->Finish();
    const SteadyTime deadline = After(clock_.Steady(), kGoodbye_s);
    while (session_ != nullptr && clock_.Steady() < deadline) {
      WaitUntil(deadline);
      HandleSessionEnd();
    }
    CloseSession();
  }

  const AgentOptions options_;
  const JobHandlers& handlers_;
  Clock& clock_;

  std::mutex mu_;
  std::condition_variable wake_;
  // Guarded by mu_.
  bool woken_ = false;
  DrainLevel drain_wanted_ = kStay;
  Inbox inbox_;  // Of session_.

  const std::unique_ptr<Outbox> outbox_;
  const std::unique_ptr<v1::Coordinator::Stub> coordinator_;

  // Run()'s own.
  AttemptFolders folders_;
  Backoff reconnect_backoff_;
  std::unique_ptr<WorkSession> session_;  // Null between connections.
  bool welcomed_ = false;
  bool complained_ = false;
  std::string coordinator_id_;
  int credit_ = 0;  // Given on this stream, not used by a lease yet.
  double lease_s_ = 0;
  SteadyTime reconnect_at_{};
  SteadyTime hello_at_{};
  SteadyTime heard_at_{};  // When the last message that is known to have arrived was sent.
  SteadyTime heartbeat_at_{};
  SteadyTime drain_deadline_{};
  int64_t sequence_ = 0;
  std::map<int64_t, SteadyTime> sent_at_;  // Of heartbeats without answer.
  int drain_ = 0;                          // 1: finish; 2: hand back.
  DrainLevel drain_level_ = kStay;         // What drain_deadline_ stands for.
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
    return absl::InvalidArgumentError("slots must be in [1, 1024], not " +
                                      std::to_string(options.slots));
  }
  if (options.kinds.empty()) return absl::InvalidArgumentError("a worker without kinds of jobs");
  for (const std::string& kind : options.kinds) {
    if (FindHandler(handlers, kind) != nullptr) continue;
    return absl::InvalidArgumentError("this worker does no jobs of kind '" + kind + "'");
  }
  ASSIGN_OR_RETURN(auto channel, ConnectRpc(options.coordinator, options.security));
  ASSIGN_OR_RETURN(auto outbox, Outbox::Open(options.outbox_root, options.name));
  return std::unique_ptr<Agent>(
      new AgentImpl(options, handlers, clock, std::move(outbox), channel));
}

}  // namespace parallax
