// `coordinator serve`: queue, gRPC service and HTTP side in one process until a signal.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/exit_status.h"

namespace parallax {

class KindRegistry;

struct ServeOptions {
  std::string db;
  std::string store;
  std::vector<std::string> listen;
  std::string http;  // Empty: none.
  bool insecure = false;
  std::string tls_dir;                // Empty: none.
  std::string store_access = "auto";  // "direct", "stream", "auto"
  bool trust_workers = false;         // Results are published without a look at their files.
  double lease_s = 60;
  double reconnect_grace_s = 10;
  double archive_after_days = 30;       // 0: never.
  std::string limits;                   // File with the limits of users; empty: none.
  double backoff_s = 5;                 // Before a failed job's first retry, at least.
  const KindRegistry* kinds = nullptr;  // Null: the program's own. Outlives the call.
};

// A status with the exit status that tells it apart.
struct ProgramError {
  absl::Status status;
  CoordinatorExit exit = kExitFailed;
};

// Whether a database of this name can be opened by us, and if not, why: its folder must exist and
// be writable, and no other coordinator may have it open. OK status: nothing found.
ProgramError CheckDatabasePlace(const std::string& db);
// What the queue's error at opening means, given that CheckDatabasePlace found nothing.
ProgramError ExplainOpenError(const absl::Status& status, const std::string& db);

// Prints "listening on ADDRESS" for each address and "http on URL" on stdout when it is ready.
// Returns after SIGTERM or SIGINT and a graceful stop. Call it before other threads exist.
ProgramError Serve(const ServeOptions& options);

}  // namespace parallax
