// The simulated machine of the coordinator: its own queue, dispatcher and pool of tasks, run by
// events instead of threads, on a disk that loses what was not synced.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/storage/store_claim.h"
#include "coordinator/rpc/task_pool.h"
#include "coordinator/rpc/workers/dispatcher.h"
#include "coordinator/search/search_keeper.h"
#include "coordinator/stream/stream_keeper.h"
#include "tests/faults/simulate/liar.h"
#include "tests/faults/simulate/model.h"
#include "tests/faults/simulate/points.h"
#include "tests/faults/simulate/power_cut_vfs.h"
#include "tests/faults/simulate/shared_disk.h"
#include "tests/faults/simulate/stream.h"
#include "tests/faults/simulate/world.h"

namespace parallax::faults {

class SimCoordinator final : public JobQueueObserver {
 public:
  SimCoordinator(World& world, const std::string& folder);
  ~SimCoordinator() override;

  void Start();
  // Ends it for good. Its streams close, so their lines must still exist.
  void End() { life_.reset(); }
  // Ends the process, or its machine's power.
  void Die(bool power_cut);
  // From now on, for many leases, it is killed more often than a lease lasts. The worker has died
  // with these attempts.
  void BeginCrashLoop(const std::string& worker, const std::vector<v1::AttemptId>& attempts);
  bool IsInCrashLoop() const { return world_.schedule.now() < loop_.until_s; }
  // Its disk makes no errors any more.
  void Mend() { MendDisk(); }
  // Returns whether it, or the audit, has noticed that its disk lies: nothing goes on.
  bool has_refused() const { return refused_ || model_.found_damage(); }
  bool is_up() const { return life_ != nullptr; }
  bool Lives(int life) const { return is_up() && life == lives_; }
  int lives() const { return lives_; }

  // Runs `event` in the coordinator's process, which may die of it.
  void Enter(const std::function<void()>& event);
  // Opens a stream of a worker; null if nobody listens.
  std::shared_ptr<SimStream> Open(Line& line, WorkSession::Events events);
  // Takes a report in. `reply` is called with its outcome.
  using Reply = std::function<void(const absl::StatusOr<v1::ReportOutcome>&)>;
  void Complete(const v1::CompleteRequest& request, Reply reply);
  void Fail(const v1::FailRequest& request, Reply reply);

  JobQueue& queue() { return *life_->queue; }
  Dispatcher& dispatcher() { return *life_->dispatcher; }
  TaskPool& pool() { return life_->pool; }
  StreamKeeper& streams() { return *life_->streams; }
  SearchKeeper& searches() { return *life_->searches; }
  SharedDisk& disk() { return disk_; }
  // Returns a file of a published result that is not on the disk as it was put there; empty: all
  // are.
  std::string WrongFile();
  // Returns a study that has ended, and of which the operator was not told; empty: there is none.
  std::string UntoldStudy();
  const Points& points() const { return points_; }
  StageVersions versions() const { return World::VersionsOf(release_); }
  // Notes, or returns, the process of this worker that said hello last.
  void TookIn(const std::string& worker, const std::string& process) {
    process_of_[worker] = process;
  }
  const std::string& ProcessOf(const std::string& worker) { return process_of_[worker]; }
  QueueModel& model() { return model_; }
  MachineClock& clock() { return clock_; }
  static std::string NameOf(const absl::StatusOr<v1::ReportOutcome>& outcome);

  // JobQueueObserver: tells the model, and goes on to the dispatcher.
  void OnWorkReady() override;
  void OnStop(const std::string& worker, const v1::AttemptId& attempt,
              const std::string& reason) override;
  void OnDrains(const std::vector<v1::DrainOrder>& drains) override;

 private:
  // One start's. Destroyed in reverse order.
  struct Life {
    std::unique_ptr<Store> store;
    std::unique_ptr<FilePresence> there;
    std::unique_ptr<JobQueue> queue;
    TaskPool pool{0};
    std::unique_ptr<Dispatcher> dispatcher;
    std::unique_ptr<StreamKeeper> streams;
    std::unique_ptr<SearchKeeper> searches;
  };
  struct Loop {
    double until_s = 0;
    std::string worker;
    std::vector<v1::AttemptId> attempts;
    bool checks = false;  // It is planned when they must be with other workers.
  };
  VfsPlan DrawPlan();
  absl::Status Pass(const std::string& command, int step);
  absl::Status OpenQueue();
  // Opens the database after its disk may have lied, or puts back what was there before.
  absl::Status OpenOrPutBack();
  void BackUpLater(int life);
  void HandleFatal(const absl::Status& status);
  std::string Plain(const absl::Status& status) const;
  void Bury(const char* how);
  // Its threads get their turns soon.
  void Stir();
  void TurnSoon(bool& planned, bool (SimCoordinator::*turn)(), double within_s);
  bool QueueTurn();
  bool PoolTurn();
  bool DispatcherTurn();
  void TickLater(int life);
  // Does a task in the pool again and again, for the life.
  void Often(int life, double every_s, std::function<absl::Status()> task);
  absl::Status DeliverNotices();
  void CheckCrashLoop();
  // Reads the store again, as `coordinator check --deep` does, and removes litter.
  void LookIntoStoreLater(int life);
  void ReadStore(bool repair);
  // Returns why a result is wrong, for its files; empty: it is not.
  absl::StatusOr<std::string> WhyWrong(const v1::CompleteRequest& request);

  World& world_;
  const std::string folder_;
  MachineClock clock_;
  QueueModel model_;
  Rng dice_;
  DatabaseLiar liar_;
  SharedDisk disk_;
  Loop loop_;
  std::map<std::string, std::string> process_of_;
  std::set<int64_t> told_;  // Studies of whose end the operator has heard.
  Points points_;
  double end_chance_ = 0;  // At a step of a command in this life; 0: it has no such end.
  bool dies_of_power_ = false;
  int release_ = 0;
  std::unique_ptr<QueueModel> backup_;  // The model when the backup was made.
  std::unique_ptr<Life> life_;
  int lives_ = 0;
  bool refused_ = false;
  bool queue_turn_ = false, pool_turn_ = false, dispatcher_turn_ = false;  // Planned.
  double look_at_s_ = 0;  // The dispatcher's next turn, if nothing happens before.
};

}  // namespace parallax::faults
