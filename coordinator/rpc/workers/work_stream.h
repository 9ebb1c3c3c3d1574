// The coordinator's end of one `Work` stream. Reads messages in order, writes from any thread, and
// never blocks gRPC's threads.
#pragma once

#include <grpcpp/grpcpp.h>

#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/call_watch.h"
#include "coordinator/rpc/task_pool.h"
#include "coordinator/rpc/workers/dispatcher.h"
#include "parallax/v1/service.grpc.pb.h"

namespace parallax {

// The store as it is announced to workers.
struct AnnouncedStore {
  std::string uri;
  std::string id;
  v1::StoreAccess access = v1::STORE_ACCESS_DIRECT;
};

// The objects that all streams share. Must outlive all streams.
struct WorkStreamContext {
  JobQueue& queue;
  Dispatcher& dispatcher;
  TaskPool& pool;
  AnnouncedStore store;
  std::string coordinator_id;
  double lease_s;
  std::function<void()> on_done;  // Called once by each stream, as its last action.
  CallWatch& watch;
  double hello_s;  // A stream that has not said hello by then is closed.
};

// One stream. Keeps itself alive until gRPC has finished with it.
class WorkStream final : public grpc::ServerBidiReactor<v1::WorkerMessage, v1::CoordinatorMessage>,
                         public WorkerLink,
                         public std::enable_shared_from_this<WorkStream> {
 public:
  // Opens a stream. gRPC uses the raw pointer until the stream is done; the stream deletes itself
  // then.
  static WorkStream* Open(const WorkStreamContext& shared, grpc::CallbackServerContext* call);

  // WorkerLink.
  void Send(v1::CoordinatorMessage message) override;
  void Close(const absl::Status& status, bool abort) override;

 private:
  WorkStream(const WorkStreamContext& shared, grpc::CallbackServerContext* call)
      : shared_(shared), call_(call) {}

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone() override;

  void ReadNext();
  void Join();
  void HandleHandBack();
  void EndUnlessOk(const absl::Status& status);

  const WorkStreamContext& shared_;
  grpc::CallbackServerContext* const call_;
  std::shared_ptr<WorkStream> self_;
  v1::WorkerMessage incoming_;               // Belongs to gRPC during a read, else to the handler.
  std::string worker_;                       // Empty before Hello. Set before the next read starts.
  std::optional<CallWatch::Call> no_hello_;  // Set until the first message.

  std::mutex mu_;
  // Guarded by mu_.
  std::deque<v1::CoordinatorMessage> waiting_;
  v1::CoordinatorMessage outgoing_;
  bool writing_ = false;
  // True when nothing is read or sent any more. Finish is called when the current write has ended.
  bool closing_ = false;
  grpc::Status end_;
};

}  // namespace parallax
