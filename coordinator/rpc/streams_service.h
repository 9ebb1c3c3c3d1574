// The service `parallax.v1.Streams`: roles, bounds and waiting calls on top of StreamKeeper. A call
// of Next that finds no pairs waits without a thread, until there are some or its time is over.
//
// Thread-safe. Has one thread, which also keeps the streams going.
#pragma once

#include <grpcpp/grpcpp.h>

#include <condition_variable>
#include <list>
#include <mutex>
#include <string>
#include <thread>

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "coordinator/rpc/pooled_calls.h"
#include "coordinator/rpc/task_pool.h"
#include "coordinator/stream/stream_keeper.h"
#include "coordinator/study/notify_hosts.h"
#include "parallax/v1/stream.grpc.pb.h"

namespace parallax {

class ContentKeeper;
class JobQueue;

class StreamsService final : public v1::Streams::CallbackService {
 public:
  // All must outlive the service. `content` checks that the content of studies is in the store;
  // null: not checked. A study's notices may go to `notify_hosts` only.
  StreamsService(JobQueue& queue, TaskPool& pool, Clock& clock, std::string store_uri,
                 ContentKeeper* content, NotifyHosts notify_hosts);
  ~StreamsService() override { Stop(); }

  // Begins to keep the streams going.
  void Start();
  // Returns all streams, by name. Errors: the database's.
  absl::StatusOr<std::vector<v1::StreamStatus>> Statuses() { return keeper_.List(""); }
  // Ends all waiting calls and waits until no call is in progress. Idempotent.
  void Stop();

  using Context = grpc::CallbackServerContext;
  using Reactor = grpc::ServerUnaryReactor;
  Reactor* Open(Context*, const v1::OpenStreamRequest*, v1::StreamStatus*) override;
  Reactor* Next(Context*, const v1::NextPairsRequest*, v1::NextPairsReply*) override;
  Reactor* List(Context*, const v1::ListStreamsRequest*, v1::ListStreamsReply*) override;
  Reactor* Close(Context*, const v1::CloseStreamRequest*, v1::StreamStatus*) override;

 private:
  // A call of Next.
  struct Waiting {
    Context* context;
    Reactor* reactor;
    const v1::NextPairsRequest* request;
    v1::NextPairsReply* reply;
    SteadyTime until;
  };

  // Answers the call, or keeps it among those that wait.
  void Answer(const Waiting& call);
  // Checks that the caller opened the stream, or is an operator.
  absl::Status CheckOwner(const Context& context, const std::string& stream);
  void Loop();

  StreamKeeper keeper_;
  TaskPool& pool_;
  PooledCalls calls_;
  Clock& clock_;
  const std::string store_uri_;
  ContentKeeper* const content_;
  const NotifyHosts notify_hosts_;

  std::mutex mu_;
  std::condition_variable changed_;
  // Guarded by mu_.
  bool stopping_ = false;
  std::list<Waiting> waiting_;
  std::thread thread_;
};

}  // namespace parallax
