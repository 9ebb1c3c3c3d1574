// The agent's sessions with its coordinator, one after another: identifies the coordinator, opens
// the stream, says hello, retries after a break, and knows until when the coordinator has surely
// heard from this worker.
//
// Used by the agent's own thread. The streams' threads only fill the inbox and call Hooks::wake.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "parallax/v1/service.pb.h"
#include "worker/agent/agent.h"
#include "worker/agent/session/backoff.h"
#include "worker/agent/session/work_session.h"

namespace parallax {

// One link serves the agent for its whole life; sessions come and go within it.
class CoordinatorLink {
 public:
  struct Hooks {
    std::function<void()> wake;      // From any thread: the inbox has something.
    std::function<void()> on_break;  // A session is over or did not come about.
  };

  // `options`, `port` and `clock` outlive the link. `rng` draws the waits between tries.
  CoordinatorLink(const AgentOptions& options, CoordinatorPort& port, Clock& clock, Rng rng,
                  Hooks hooks);
  ~CoordinatorLink() { Close(); }

  bool IsOpen() const { return session_ != nullptr; }
  bool IsWelcomed() const { return welcomed_; }
  // Returns the id of the coordinator that answered last; "" before the first answer.
  const std::string& coordinator_id() const { return coordinator_id_; }
  // Returns an error that no retry mends; OK if none exists.
  const absl::Status& fatal() const { return fatal_; }

  // Returns whether there is no session and the back-off has passed.
  bool ConnectIsDue() const { return session_ == nullptr && clock_.Steady() >= connect_at_; }
  // Asks the coordinator for its identity. False if none answers, or none that this worker can use.
  bool Meet();
  // Opens a session with the coordinator that Meet found, and says hello. `held`: attempts that run
  // here.
  void Open(const std::vector<v1::Progress>& held);
  // Handles the welcome: leases count from now on.
  void Welcomed(const v1::Welcome& welcome);

  // Returns the messages received since the last call.
  std::deque<v1::CoordinatorMessage> TakeMessages();
  // Ends the session if its stream has ended.
  void HandleEnd();
  // Ends a session that has no welcome in time, or no answer to heartbeats for as long as a lease.
  void BreakIfSilent();

  // Ask for jobs, or hand one back. Do nothing between sessions: then the lease runs out instead.
  void Ask(const v1::Credit& credit);
  void HandBack(const v1::AttemptId& attempt, const std::string& reason);
  bool HeartbeatIsDue() const { return welcomed_ && clock_.Steady() >= heartbeat_at_; }
  void HurryHeartbeat() { heartbeat_at_ = clock_.Steady(); }
  void SendHeartbeat(std::vector<v1::Progress> held, bool draining);
  // Notes the answer to a heartbeat, which extends the leases.
  void Answered(int64_t heartbeat_sequence);
  // Returns whether the coordinator may have given our leases away: the last message that surely
  // arrived was sent longer than a lease ago.
  bool LeaseIsOver() const;

  // Half-closes the stream: the agent sends nothing more and expects its end.
  void Finish();
  void Close();

  // Returns the time at which the link must be looked at again, at the latest `until`. `has_work`:
  // leased work runs.
  SteadyTime NextLook(SteadyTime until, bool has_work) const;

 private:
  // Filled by the stream of session_.
  struct Inbox {
    std::deque<v1::CoordinatorMessage> messages;
    std::optional<absl::Status> end;
  };

  void Send(v1::WorkerMessage message);  // Does nothing between sessions.
  void SendHello(const std::vector<v1::Progress>& held);
  void Break(const absl::Status& status);

  const AgentOptions& options_;
  CoordinatorPort& port_;
  Clock& clock_;
  const Hooks hooks_;

  std::mutex mu_;
  Inbox inbox_;  // Guarded by mu_.

  Backoff backoff_;
  std::unique_ptr<WorkSession> session_;  // Null between sessions.
  bool welcomed_ = false;
  bool complained_ = false;  // Whether this break was logged.
  std::string coordinator_id_;
  double lease_s_ = 0;  // 0 before the first welcome.
  SteadyTime connect_at_;
  SteadyTime hello_at_{};
  SteadyTime heard_at_{};  // When the last message that is known to have arrived was sent.
  SteadyTime heartbeat_at_{};
  int64_t sequence_ = 0;
  std::map<int64_t, SteadyTime> sent_at_;  // Heartbeats without answer.
  absl::Status fatal_;
};

}  // namespace parallax
