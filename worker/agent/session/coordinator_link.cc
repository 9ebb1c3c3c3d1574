#include "worker/agent/session/coordinator_link.h"

#include <algorithm>
#include <utility>

#include "common/base/seconds.h"
#include "common/base/system/log.h"
#include "common/base/version.h"

namespace parallax {
namespace {

using Seconds = std::chrono::duration<double>;

// Number of heartbeats in the time of a lease.
constexpr double kHeartbeatsPerLease = 4;

// Whether waiting can't mend the error.
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

}  // namespace

CoordinatorLink::CoordinatorLink(const AgentOptions& options, CoordinatorPort& port, Clock& clock,
                                 Rng rng, Hooks hooks)
    : options_(options),
      port_(port),
      clock_(clock),
      hooks_(std::move(hooks)),
      backoff_(std::move(rng), Seconds(options.backoff_base_s), Seconds(options.backoff_cap_s)),
      connect_at_(clock.Steady()) {}

bool CoordinatorLink::Meet() {
  v1::GetInfoReply info;
  const absl::Status status = port_.GetInfo(options_.connect_timeout_s, &info);
  // Before the first success, a wrong certificate is reported at once and not waited for.
  if (absl::IsUnavailable(status) && coordinator_id_.empty()) {
    if (absl::Status why = ExplainRpcSecurity(options_.coordinator, options_.security); !why.ok()) {
      fatal_ = std::move(why);
      return false;
    }
  }
  if (!status.ok()) {
    Break(status);
    return false;
  }
  if (info.protocol() != kWorkProtocol) {
    Break(
        FailedPrecondition("it speaks work protocol {} (version {}), this worker speaks {}: give "
                           "both the same release",
                           info.protocol(), info.version(), kWorkProtocol));
    return false;
  }
  coordinator_id_ = info.coordinator_id();
  return true;
}

void CoordinatorLink::Open(const std::vector<v1::Progress>& held) {
  session_ = port_.Open({[this](v1::CoordinatorMessage message) {
                           {
                             std::lock_guard lock(mu_);
                             inbox_.messages.push_back(std::move(message));
                           }
                           hooks_.wake();
                         },
                         [this](absl::Status end) {
                           {
                             std::lock_guard lock(mu_);
                             inbox_.end = std::move(end);
                           }
                           hooks_.wake();
                         }});
  sent_at_.clear();
  hello_at_ = clock_.Steady();
  SendHello(held);
}

void CoordinatorLink::SendHello(const std::vector<v1::Progress>& held) {
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
  hello.set_machine(options_.machine);
  for (const v1::Progress& progress : held) *hello.add_holding() = progress.attempt();
  session_->Send(std::move(message));
}

void CoordinatorLink::Welcomed(const v1::Welcome& welcome) {
  welcomed_ = true;
  complained_ = false;
  lease_s_ = welcome.lease_s();
  heard_at_ = hello_at_;
  heartbeat_at_ = SecondsAfter(clock_.Steady(), lease_s_ / kHeartbeatsPerLease);
  backoff_.Reset();
}

std::deque<v1::CoordinatorMessage> CoordinatorLink::TakeMessages() {
  std::lock_guard lock(mu_);
  return std::exchange(inbox_.messages, {});
}

void CoordinatorLink::HandleEnd() {
  std::optional<absl::Status> end;
  {
    std::lock_guard lock(mu_);
    end.swap(inbox_.end);
  }
  if (!end) return;
  Break(end->ok() ? Unavailable("the coordinator ended the stream") : *end);
}

void CoordinatorLink::BreakIfSilent() {
  if (session_ == nullptr) return;
  if (!welcomed_) {
    if (clock_.Steady() < SecondsAfter(hello_at_, options_.connect_timeout_s)) return;
    Break(DeadlineExceeded("no welcome from the coordinator"));
  } else if (LeaseIsOver()) {
    Break(DeadlineExceeded("the coordinator does not answer heartbeats"));
  }
}

void CoordinatorLink::Break(const absl::Status& status) {
  Close();
  hooks_.on_break();
  if (IsFatal(status.code())) {
    // Distinguished from an error of this machine's disk, which has another exit status.
    const bool refused = absl::IsPermissionDenied(status);
    fatal_ = WithContext(refused ? Unauthenticated("{}", status.message()) : status,
                         "coordinator " + options_.coordinator.ToString());
    return;
  }
  // Logged once when the connection breaks, not at every try.
  if (!complained_) {
    LogWarning("coordinator can't be reached; trying again",
               {{"coordinator", options_.coordinator.ToString()}, {"error", status}});
    complained_ = true;
  }
  connect_at_ = SecondsAfter(clock_.Steady(), backoff_.Next().count());
}

void CoordinatorLink::Send(v1::WorkerMessage message) {
  if (session_ != nullptr) session_->Send(std::move(message));
}

void CoordinatorLink::Ask(const v1::Credit& credit) {
  v1::WorkerMessage message;
  *message.mutable_credit() = credit;
  Send(std::move(message));
}

void CoordinatorLink::HandBack(const v1::AttemptId& attempt, const std::string& reason) {
  v1::WorkerMessage message;
  *message.mutable_hand_back()->mutable_attempt() = attempt;
  message.mutable_hand_back()->set_reason(reason);
  Send(std::move(message));
}

void CoordinatorLink::SendHeartbeat(std::vector<v1::Progress> held, bool draining) {
  v1::WorkerMessage message;
  v1::Heartbeat& heartbeat = *message.mutable_heartbeat();
  for (v1::Progress& progress : held) *heartbeat.add_running() = std::move(progress);
  heartbeat.set_draining(draining);
  heartbeat.set_sequence(++sequence_);
  sent_at_[sequence_] = clock_.Steady();
  Send(std::move(message));
  heartbeat_at_ = SecondsAfter(clock_.Steady(), lease_s_ / kHeartbeatsPerLease);
}

void CoordinatorLink::Answered(int64_t heartbeat_sequence) {
  const auto sent = sent_at_.find(heartbeat_sequence);
  if (sent == sent_at_.end()) return;
  heard_at_ = sent->second;
  sent_at_.erase(sent_at_.begin(), std::next(sent));
}

bool CoordinatorLink::LeaseIsOver() const {
  return lease_s_ > 0 && clock_.Steady() >= SecondsAfter(heard_at_, lease_s_);
}

void CoordinatorLink::Finish() {
  complained_ = true;
  if (session_ != nullptr) session_->Finish();
}

void CoordinatorLink::Close() {
  session_.reset();
  welcomed_ = false;
  std::lock_guard lock(mu_);
  inbox_ = Inbox();
}

SteadyTime CoordinatorLink::NextLook(SteadyTime until, bool has_work) const {
  if (session_ == nullptr) {
    until = std::min(until, connect_at_);
  } else if (welcomed_) {
    until = std::min(until, heartbeat_at_);
  } else {
    until = std::min(until, SecondsAfter(hello_at_, options_.connect_timeout_s));
  }
  // Stopped work needs no watch: its end wakes the agent.
  if (lease_s_ > 0 && (welcomed_ || has_work)) {
    until = std::min(until, SecondsAfter(heard_at_, lease_s_));
  }
  return until;
}

}  // namespace parallax
