// The farm's status at one moment, from which /metrics and the page are made.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/coordinator_server.h"
#include "coordinator/rpc/storage/farm_space.h"
#include "parallax/v1/search.pb.h"
#include "parallax/v1/service.pb.h"
#include "parallax/v1/stream.pb.h"

namespace parallax {

struct StatusSnapshot {
  std::string version;
  uint64_t epoch = 0;
  int64_t schema_version = 0;
  std::string store_uri;
  double uptime_s = 0;
  double now_unix_s = 0;
  double pairs_per_hour = 0;
  std::map<int64_t, double> eta_s;       // By id; only of running studies with a known rate.
  std::vector<v1::StudyStatus> studies;  // The newest ones, the newest first.
  std::vector<v1::StudyStatus> older_unfinished;  // The unfinished ones that are older.
  std::vector<v1::WorkerStatus> workers;
  ServerMetrics server;
  JobQueueStats queue;
  std::vector<RunningJob> running;         // Jobs that report figures.
  std::vector<v1::StreamStatus> streams;   // By name.
  std::vector<v1::SearchStatus> searches;  // By name, whole.
  FarmSpace space;
};

}  // namespace parallax
