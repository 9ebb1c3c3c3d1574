// The gRPC service `parallax.v1.Coordinator` on top of a JobQueue. It is the same in `coordinator
// serve` (TCP or Unix socket) and in `parallax run` (in process, workers on a Unix socket).
//
// The server owns what the database does not: the workers' streams, their credit, liveness and
// progress. A worker that is not heard for the lease's time is lost, and its jobs go back to the
// queue under new fences.
//
// Thread-safe.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/base/status.h"
#include "common/rpc/endpoint.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

class JobQueue;
class Store;

struct CoordinatorServerOptions {
  // "HOST:PORT" (port 0: any free one) or "unix:/path"; at least one. Anything but loopback and
  // Unix sockets is refused without TLS, unless `security` says insecure.
  std::vector<std::string> listen;
  RpcSecurity security;
  // Where workers put attempts' folders: "file:///abs/dir".
  std::string store_uri;
  // The same, opened: for the files of workers and clients that do not see it. Null: they can't
  // send or fetch any. Outlives the server.
  Store* store = nullptr;
  v1::StoreAccess store_access = v1::STORE_ACCESS_DIRECT;
  // Look for the files that a result names in `store` before it is published. Costs a listing of
  // the attempt's folder.
  bool check_outputs = true;
  // Folder for files that are coming in, best on the store's own disk.
  std::string spool_dir;
  // What workers are told. 0, or more than the queue's lease: the queue's. Shorter ones make them
  // beat more often and stop sooner when they hear nothing.
  double lease_s = 0;
  // A stream that broke may come back within this before the worker counts as lost and its jobs go
  // to others. A stream that is open but silent has the queue's whole lease.
  double reconnect_grace_s = 10;
  // A worker's stream that has not said hello is ended after this.
  double hello_s = 10;
  Clock* clock = &Clock::System();
};

// What /metrics and the status page show and the queue does not know.
struct ServerMetrics {
  int64_t workers_connected = 0;
  int64_t slots = 0;
  int64_t running = 0;
  int64_t leases = 0;  // Since start, as are the following.
  int64_t workers_lost = 0;
  std::map<std::string, int64_t> reports;  // By outcome: "OK", "STALE_FENCE"..., "FAIL"
  // Work that results told of, by stage: "layout", "dress", "build", "trace"...
  struct Stage {
    int64_t count = 0;
    double seconds = 0;
  };
  std::map<std::string, Stage> stages;
  struct Work {
    int64_t jobs = 0;
    double wall_s = 0;
    double cpu_s = 0;
  };
  std::map<std::string, Work> work;  // Of results, by kind of job.
  // Seconds from "a worker has credit and a job is ready" to the lease on its stream; cumulative
  // counts by bound.
  std::vector<double> lease_latency_bounds_s;
  std::vector<uint64_t> lease_latency_counts;  // One longer than the bounds: +Inf.
  double lease_latency_sum_s = 0;
};

class CoordinatorServer {
 public:
  // Listens and serves. `queue` outlives the server.
  // Errors: kInvalidArgument for a bad or refused address; kAlreadyExists for an address in use
  // (named in the message); kPermissionDenied and others from the socket.
  static absl::StatusOr<std::unique_ptr<CoordinatorServer>> Start(
      const CoordinatorServerOptions& options, JobQueue& queue);
  virtual ~CoordinatorServer() = default;  // Shuts down.

  // Where it listens, ports filled in, in the order of the options.
  virtual std::vector<std::string> addresses() const = 0;
  virtual std::vector<v1::WorkerStatus> Workers() const = 0;
  virtual ServerMetrics Metrics() const = 0;

  // Ends all streams (workers go on with what they hold and reconnect) and waits for calls in
  // progress. Idempotent.
  virtual void Shutdown() = 0;
};

}  // namespace parallax
