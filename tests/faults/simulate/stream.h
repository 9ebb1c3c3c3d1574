// Both ends of one `Work` stream, and the network between. Each direction keeps its order; a
// closed line holds its messages back. The coordinator's end does what its WorkStream does.
#pragma once

#include <deque>
#include <memory>
#include <string>

#include "coordinator/rpc/workers/worker_link.h"
#include "tests/faults/simulate/world.h"
#include "worker/agent/session/work_session.h"

namespace parallax::faults {

class SimCoordinator;

class SimStream final : public WorkerLink, public std::enable_shared_from_this<SimStream> {
 public:
  // `life`: the coordinator's start to which it belongs.
  SimStream(World& world, SimCoordinator& coordinator, Line& line, WorkSession::Events events,
            int life)
      : world_(world),
        coordinator_(coordinator),
        line_(line),
        events_(std::move(events)),
        life_(life) {}

  // ---- The worker's end
  void FromWorker(v1::WorkerMessage message);
  void Finish();  // The worker sends nothing more.
  void Drop();    // The worker's end is gone: no events come any more.
  void Vanish();  // The same, without a word: its machine has no power.
  // The connection breaks: both ends hear of it, unless the line is closed.
  void Break();

  // ---- The coordinator's end
  void Send(v1::CoordinatorMessage message) override;
  void Close(const absl::Status& status, bool abort) override;

 private:
  void Arrive(v1::WorkerMessage message);
  void EndUp();  // The coordinator's read fails.
  void ReadNext();
  void Handle(v1::WorkerMessage message);
  void Join(v1::Hello hello);
  void Heartbeat(const v1::Heartbeat& heartbeat);
  void HandBack(const v1::HandBack& back);
  void GoOn(const absl::Status& status);
  void EndDown(const absl::Status& status);
  void Up(std::function<void()> event);
  void Down(std::function<void()> event);

  World& world_;
  SimCoordinator& coordinator_;
  Line& line_;
  WorkSession::Events events_;
  const int life_;
  double last_up_s_ = 0;  // The newest message arrives then.
  double last_down_s_ = 0;
  bool worker_open_ = true;
  bool closed_ = false;  // The coordinator's end.
  bool busy_ = false;    // A message is being handled.
  std::deque<v1::WorkerMessage> incoming_;
  std::string worker_;
};

// A worker's session over a simulated stream.
class SimSession final : public WorkSession {
 public:
  explicit SimSession(std::shared_ptr<SimStream> stream) : stream_(std::move(stream)) {}
  ~SimSession() override { stream_->Drop(); }
  void Send(v1::WorkerMessage message) override { stream_->FromWorker(std::move(message)); }
  void Finish() override { stream_->Finish(); }
  void Cancel() override { stream_->Drop(); }

 private:
  const std::shared_ptr<SimStream> stream_;
};

}  // namespace parallax::faults
