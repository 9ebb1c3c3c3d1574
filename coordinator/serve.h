// `coordinator serve`: runs queue, gRPC service and HTTP server in one process until a signal.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/exit_status.h"
#include "coordinator/search/trial_scores.h"

namespace parallax {

class JobQueue;
class KindRegistry;
class Store;

// Options of `coordinator serve`; `coordinator serve --help` explains them.
struct ServeOptions {
  std::string db;
  std::string store;
  std::vector<std::string> listen;
  std::string http;  // "HOST:PORT" of the HTTP server; empty: none.
  bool insecure = false;
  std::string tls_dir;                // Folder with the coordinator's certificate; empty: none.
  std::string revoked;                // List of revoked certificates; empty: the one in `tls_dir`.
  std::string store_access = "auto";  // "direct", "stream", "auto"
  bool trust_workers = false;         // Publish results without checking their files.
  double lease_s = 60;
  double reconnect_grace_s = 10;
  double archive_after_days = 30;  // 0: never.
  double keep_days = 0;            // After its end, a study is then forgotten; 0: never.
  double keep_gb = 0;              // Bound on the results of all studies, 1e9 bytes; 0: none.
  std::string limits;              // File with the limits of users; empty: none.
  std::string samplers;            // Folder of programs that propose trials; empty: none.
  bool adopt_store = false;        // Take whatever is at `store` for the database's store.
  double scrub_mb_s = 8;           // Rate at which results are read for damage; 0: never.
  double scrub_days = 7;           // From the begin of a pass to that of the next one.
  double sweep_days = 7;           // Age at which unknown folders are removed; 0: never.
  double backoff_s = 5;            // Least wait before a failed job's first retry.
  std::string notify;              // URL that notices are posted to; empty: none.
  std::string notify_command;      // Program that notices are given to; empty: none.
  std::vector<std::string> notify_hosts;  // Hosts of studies' own receivers of notices.
  double notify_stall_min = 30;  // Minutes without a running job that are a stall; 0: never.
  // Makes the table of results of a study for the page; null: the page shows none.
  std::function<absl::StatusOr<std::string>(JobQueue&, const Store&, int64_t study)> table;
  std::function<std::string(const v1::SearchStatus&)> picture;  // Draws a search as SVG; or null.
  // Scores the studies of searches; null: this coordinator doesn't search.
  std::function<absl::StatusOr<std::vector<TrialScore>>(JobQueue&, const Store&, const ScoreQuery&)>
      scores;
  const KindRegistry* kinds = nullptr;  // Null: the program's own. Must outlive the call.
};

// An error of the program, with its exit status.
struct ProgramError {
  absl::Status status;
  CoordinatorExit exit = kExitFailed;
};

// Checks that a database at path `db` can be opened: its folder must exist and be writable, a file
// that is there must be a database, and no other coordinator may have it open. The status is OK if
// no problem was found. Leaves a lock file beside the database, but not beside another file.
ProgramError CheckDatabasePlace(const std::string& db);
// Explains an error of JobQueue::Open for which CheckDatabasePlace found no problem.
ProgramError ExplainOpenError(const absl::Status& status, const std::string& db);

// Serves until SIGTERM or SIGINT, then stops gracefully and returns. Prints "listening on ADDRESS"
// for each address and "http on URL" to stdout when it is ready. Call it before other threads
// exist.
ProgramError Serve(const ServeOptions& options);

}  // namespace parallax
