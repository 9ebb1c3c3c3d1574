// The simulated users of a farm: they submit studies until they hear of it, and steer them.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/faults/simulate/coordinator.h"
#include "tests/faults/simulate/world.h"

namespace parallax::faults {

class SimClient {
 public:
  // `workers`: names that may be drained.
  SimClient(World& world, SimCoordinator& coordinator, std::vector<std::string> workers);

  void Start();
  // The faults are over: everything is undone that would keep studies from ending.
  void Settle();
  // Returns whether all studies are submitted and everything is undone.
  bool is_done() const { return open_ == 0; }

  // Calls until the coordinator answers. `call` runs in its pool and returns whether it is done.
  void CallUntilDone(std::function<bool()> call);
  // Calls once. The request may be lost.
  void Call(std::function<void()> call);

 private:
  v1::SubmitRequest StudyOf(int index);
  void Submit(const v1::SubmitRequest& request);
  // Again and again: forgets a study that has ended, and submits the next.
  void ReplaceLater();
  void OrderLater();
  void GiveOrder();
  void Steer(int64_t study, int draw);
  void SetDrain(const std::string& worker, bool undo);
  struct OpenCall {
    std::function<bool()> call;
    bool done = false;
  };
  void Repeat(const std::shared_ptr<OpenCall>& open);
  // Asks the queue to do something about a study and tells the model.
  // Returns whether it does.
  bool Order(int64_t study, const char* name, const std::function<absl::Status()>& ask,
             const std::function<void()>& tell);
  bool Forget(int64_t study);

  World& world_;
  SimCoordinator& coordinator_;
  const std::vector<std::string> workers_;
  Rng dice_;
  std::vector<int64_t> studies_;  // Acknowledged.
  int submitted_ = 0;
  int open_ = 0;  // Calls that must still be answered.
};

}  // namespace parallax::faults
