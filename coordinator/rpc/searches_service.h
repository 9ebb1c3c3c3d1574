// The service `parallax.v1.Searches`: roles and bounds on top of SearchKeeper.
//
// Thread-safe. Has one thread, which keeps the searches going.
#pragma once

#include <condition_variable>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "coordinator/rpc/pooled_calls.h"
#include "coordinator/search/search_keeper.h"
#include "coordinator/study/notify_hosts.h"
#include "parallax/v1/search.grpc.pb.h"

namespace parallax {

class ContentKeeper;
class JobQueue;

class SearchesService final : public v1::Searches::CallbackService {
 public:
  // All must outlive the service. Without a scorer, it begins no search. `content` checks that the
  // content of studies is in the store; null: not checked. A study's notices may go to
  // `notify_hosts` only.
  SearchesService(JobQueue& queue, TaskPool& pool, Clock& clock, TrialScorer scorer,
                  std::map<std::string, Sampler> samplers, ContentKeeper* content,
                  NotifyHosts notify_hosts);
  ~SearchesService() override { Stop(); }

  // Begins to keep the searches going.
  void Start();
  // Returns all searches whole, by name. Errors: the database's.
  absl::StatusOr<std::vector<v1::SearchStatus>> Statuses() { return keeper_.ListWhole(); }
  // Ends that, and waits until no call is in progress. Idempotent.
  void Stop();

  using Context = PooledCalls::Context;
  using Reactor = PooledCalls::Reactor;
  Reactor* Open(Context*, const v1::OpenSearchRequest*, v1::SearchStatus*) override;
  Reactor* List(Context*, const v1::ListSearchesRequest*, v1::ListSearchesReply*) override;
  Reactor* Stop(Context*, const v1::StopSearchRequest*, v1::SearchStatus*) override;

 private:
  void Loop();

  SearchKeeper keeper_;
  PooledCalls calls_;
  ContentKeeper* const content_;
  const NotifyHosts notify_hosts_;
  std::mutex mu_;
  std::condition_variable stop_;
  bool stopping_ = false;  // Guarded by mu_.
  std::thread thread_;
};

}  // namespace parallax
