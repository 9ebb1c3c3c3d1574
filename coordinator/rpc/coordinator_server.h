// Serves `parallax.v1.Coordinator` on top of a JobQueue, for `coordinator serve` (TCP or Unix
// socket) and for `parallax run` (in process, with workers on a Unix socket).
//
// The server keeps the state that is not in the database: workers' streams, their credit, liveness
// and progress. A worker that is silent for the time of a lease is lost: its jobs go back to the
// queue and are leased again under new fences.
//
// Thread-safe.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "common/rpc/endpoint.h"
#include "coordinator/rpc/storage/scrubber.h"
#include "coordinator/search/samplers.h"
#include "coordinator/search/trial_scores.h"
#include "coordinator/study/notify_hosts.h"
#include "parallax/v1/search.pb.h"
#include "parallax/v1/service.pb.h"
#include "parallax/v1/stream.pb.h"

namespace parallax {

class ContentKeeper;
class JobQueue;
class Store;
class WaitReasons;

struct CoordinatorServerOptions {
  // "HOST:PORT" (port 0: any free one) or "unix:/path"; at least one. Without TLS, only loopback
  // and Unix sockets are allowed, unless security.insecure.
  std::vector<std::string> listen;
  RpcSecurity security;
  // List of revoked certificates (common/rpc/revocation.h); empty: kRevokedFile in security.tls.
  std::string revoked;
  // URI of the store to which workers write attempts' folders: "file:///abs/dir".
  std::string store_uri;
  // The same store, opened, for workers and clients that cannot reach it. Null: they can't send or
  // fetch files. Must outlive the server.
  Store* store = nullptr;
  v1::StoreAccess store_access = v1::STORE_ACCESS_DIRECT;
  // Before a result is published, check that its files are in `store`. Costs a listing of the
  // attempt's folder.
  bool check_outputs = true;
  // Look so often whether `store` is still there. While it is not, nothing is leased or published.
  double store_look_s = 2;
  // Read all files of results again and again, and make damaged ones anew; absent: don't.
  std::optional<ScrubOptions> scrub;
  // Folder for files that are being received, best on the store's own disk.
  std::string spool_dir;
  // Length of a lease in seconds, as announced to workers. 0, or a value above the queue's lease,
  // means the queue's lease. With a shorter one, workers send heartbeats more often and stop sooner
  // when they hear nothing.
  double lease_s = 0;
  // Seconds that a worker has to reconnect after its stream broke, before it counts as lost and its
  // jobs go to others. A stream that is open but silent has the queue's whole lease.
  double reconnect_grace_s = 10;
  // Seconds after which a worker's stream without a Hello is ended.
  double hello_s = 10;
  ListenerLimits connections;
  // Reads what the studies of searches have shown; null: this coordinator doesn't search.
  TrialScorer scorer;
  // Programs that searches may name to propose trials.
  std::map<std::string, Sampler> samplers;
  // Hosts to which studies may have notices posted; another is refused with the study.
  NotifyHosts notify_hosts;
  Clock* clock = &Clock::System();
};

// Figures of /metrics and the status page that the queue does not have.
struct ServerMetrics {
  int64_t workers_connected = 0;
  int64_t slots = 0;
  int64_t running = 0;
  int64_t leases = 0;  // Since the start, like all below.
  int64_t workers_lost = 0;
  std::map<std::string, int64_t> reports;  // By outcome: "OK", "STALE_FENCE"..., "FAIL"
  // Work that results reported, by stage: "layout", "dress", "build", "trace"...
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
  std::map<std::string, Work> work;  // Work that results reported, by kind of job.
  // Histogram of the seconds from "a worker has credit and a job is ready" to the lease on its
  // stream: cumulative counts by bound.
  std::vector<double> lease_latency_bounds_s;
  std::vector<uint64_t> lease_latency_counts;  // One longer than the bounds: +Inf.
  double lease_latency_sum_s = 0;
  std::string store_problem;  // Why the store is not there; empty: it is.
  ScrubFigures scrub;
};

class CoordinatorServer {
 public:
  // Listens and serves. `queue` must outlive the server.
  // Errors: kInvalidArgument for a bad or refused address; kAlreadyExists for an address in use,
  // named in the message; kPermissionDenied and others of the socket.
  static absl::StatusOr<std::unique_ptr<CoordinatorServer>> Start(
      const CoordinatorServerOptions& options, JobQueue& queue);
  virtual ~CoordinatorServer() = default;  // Shuts down.

  // Returns the addresses in the order of the options, with actual ports.
  virtual std::vector<std::string> addresses() const = 0;
  // Return the workers that the server knows now, and the server's figures.
  virtual std::vector<v1::WorkerStatus> Workers() const = 0;
  virtual ServerMetrics Metrics() const = 0;
  // Returns the streams that are not gone, by name. Errors: the database's.
  virtual absl::StatusOr<std::vector<v1::StreamStatus>> Streams() const = 0;
  // Returns the searches that are not gone, whole, by name. Errors: the database's.
  virtual absl::StatusOr<std::vector<v1::SearchStatus>> Searches() const = 0;
  // Connects to its own addresses and waits for an answer, at most once a second: calls in between
  // get the same answer. Errors: kUnavailable that names the address that does not answer.
  virtual absl::Status CheckAnswers() const = 0;
  // Returns the reasons of READY jobs; they live as long as the server.
  virtual const WaitReasons& waits() const = 0;
  // Sets what answers OpenPage: it returns the web page's address with a code that opens a session
  // of the caller. Null: there is no page. Waits until a call in progress returns.
  using PageOpener = std::function<absl::StatusOr<std::string>(const RpcCaller& caller)>;
  virtual void SetPage(PageOpener page) = 0;
  // Returns the keeper of the users' content, which lives as long as the server; null without a
  // store.
  virtual ContentKeeper* content() = 0;
  // Returns OK while the store is there. Errors: kUnavailable with the reason.
  virtual absl::Status StoreStatus() const = 0;

  // Ends all streams and waits for calls in progress. Workers continue their jobs and reconnect.
  // Idempotent.
  virtual void Shutdown() = 0;
};

}  // namespace parallax
