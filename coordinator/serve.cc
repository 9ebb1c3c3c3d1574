#include "coordinator/serve.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <string_view>

#include "common/base/system/log.h"
#include "common/base/system/memory_end.h"
#include "common/base/version.h"
#include "common/rpc/endpoint.h"
#include "common/store/store.h"
#include "coordinator/http/http_server.h"
#include "coordinator/process_limits.h"
#include "coordinator/queue/database/database_file.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/coordinator_server.h"
#include "coordinator/rpc/janitor.h"
#include "coordinator/rpc/notifier.h"
#include "coordinator/rpc/storage/store_claim.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

// A file written and removed: permissions, a full and a read-only disk show now and not in the
// middle of the first render.
absl::Status CheckStoreWritable(Store& store) {
  const std::string probe = fmt::format(".probe-{}", getpid());
  const absl::Status put = store.Put(probe + "/file", "probe");
  const absl::Status removed = store.RemoveTree(probe);
  return put.ok() ? removed : put;
}

absl::StatusOr<std::unique_ptr<Store>> OpenWritableStore(const ServeOptions& options,
                                                         const KnownStore& known) {
  ASSIGN_OR_RETURN(auto store, ClaimStore(options.store, known, options.adopt_store));
  RETURN_IF_ERROR(
      WithContext(CheckStoreWritable(*store), "store " + store->Uri() + " can't be written"));
  return store;
}

v1::StoreAccess AccessOf(const std::string& name) {
  return name == "direct"   ? v1::STORE_ACCESS_DIRECT
         : name == "stream" ? v1::STORE_ACCESS_STREAM
                            : v1::STORE_ACCESS_AUTO;
}

// Folder for incoming files: on the store's disk, so that they are moved and not copied, else
// beside the database.
std::string SpoolFor(const Store& store, const std::string& db) {
  const auto local = store.LocalPath("spool");
  return local.ok() ? fs::path(*local).parent_path().string() + "/.tmp-incoming" : db + ".incoming";
}

ProgramError ListenError(const absl::Status& status) {
  if (status.ok()) return {};
  switch (status.code()) {
    case absl::StatusCode::kAlreadyExists:
      return {status, kExitAddressInUse};
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kFailedPrecondition:
      return {status, kExitUsage};
    default:
      return {status, kExitFailed};
  }
}

// Blocks them in this thread and those that it starts, so that WaitForSignal gets them.
sigset_t BlockStopSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  signal(SIGPIPE, SIG_IGN);
  return signals;
}

int WaitForSignal(const sigset_t& set) {
  int signal = 0;
  while (sigwait(&set, &signal) != 0) {
  }
  return signal;
}

absl::StatusOr<NotifierOptions> NotifierOptionsOf(const ServeOptions& options) {
  NotifierOptions notifier;
  notifier.url = options.notify;
  notifier.command = options.notify_command;
  notifier.stall_s = options.notify_stall_min * 60;
  ASSIGN_OR_RETURN(notifier.hosts, NotifyHosts::Of(options.notify_hosts));
  RETURN_IF_ERROR(CheckNotifierOptions(notifier));
  return notifier;
}

JobQueueOptions QueueOptionsOf(const ServeOptions& options, const LimitRules& limits) {
  JobQueueOptions queue;
  queue.limits = limits;
  queue.db_path = options.db;
  if (options.kinds != nullptr) queue.kinds = options.kinds;
  queue.lease_s = options.lease_s;
  queue.retry.backoff_min_s = options.backoff_s;
  // Callers that wait for a commit wait for a checkpoint too, so it runs often and briefly.
  queue.checkpoint_pages = 200;
  queue.archive_after_s = options.archive_after_days * 86400;
  return queue;
}

CoordinatorServerOptions ServerOptionsOf(const ServeOptions& options, const RpcSecurity& security,
                                         const ListenerLimits& connections, Store& store) {
  CoordinatorServerOptions server;
  server.listen = options.listen;
  server.security = security;
  server.revoked = options.revoked;
  server.store_uri = store.Uri();
  server.store = &store;
  server.store_access = AccessOf(options.store_access);
  server.check_outputs = !options.trust_workers;
  server.spool_dir = SpoolFor(store, options.db);
  server.reconnect_grace_s = options.reconnect_grace_s;
  server.connections = connections;
  if (options.scrub_mb_s > 0) {
    server.scrub = ScrubOptions{.bytes_per_s = options.scrub_mb_s * 1e6,
                                .every_s = options.scrub_days * 86400};
  }
  return server;
}

HttpServerOptions HttpOptionsOf(const ServeOptions& options, const RpcSecurity& security,
                                const ListenerLimits& connections, Store& store) {
  HttpServerOptions http;
  http.limits = connections;
  http.listen = options.http;
  http.security = security;
  http.revoked = options.revoked;
  http.store_uri = store.Uri();
  http.db_path = options.db;
  http.store = &store;
  return http;
}

// Returns whether `path` is a file with content that does not begin as a database does.
bool IsOtherFile(const std::string& path) {
  constexpr std::string_view kMagic{"SQLite format 3\0", 16};
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return false;
  std::ifstream file(path, std::ios::binary);
  std::string begin(kMagic.size(), '\0');
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return file.gcount() > 0 && begin != kMagic;
}

// Says on standard output where it listens: who started it waits for these lines.
void Announce(const CoordinatorServer& server, const HttpServer* http) {
  for (const std::string& address : server.addresses()) {
    std::cout << "listening on " << address << "\n";
  }
  if (http != nullptr) std::cout << "http on " << http->url() << "\n";
  std::cout << std::flush;
}

}  // namespace

ProgramError CheckDatabasePlace(const std::string& db) {
  const std::string folder = fs::absolute(db).parent_path().string();
  if (access(folder.c_str(), F_OK) != 0) {
    return {ErrnoError(errno, "database folder " + folder), kExitDatabaseUnwritable};
  }
  // Looked at first: beside somebody's other file no lock file is left.
  if (IsOtherFile(db)) {
    return {DataLoss("{}: does not begin as a database does: another file, or damaged", db),
            kExitDatabaseDamaged};
  }
  // Opening tells more than permission bits: root may do anything but write to a read-only disk.
  const std::string lock = db + ".lock";
  const int fd = open(lock.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) return {ErrnoError(errno, "database " + db), kExitDatabaseUnwritable};
  close(fd);
  if (access(db.c_str(), F_OK) == 0 && access(db.c_str(), W_OK) != 0) {
    return {ErrnoError(errno, "database " + db), kExitDatabaseUnwritable};
  }
  const auto held = DatabaseLock::Acquire(db);
  if (!held.ok()) return {held.status(), kExitDatabaseLocked};
  return {};
}

ProgramError ExplainOpenError(const absl::Status& status, const std::string& db) {
  switch (status.code()) {
    case absl::StatusCode::kFailedPrecondition:
      if (const absl::Status local = CheckLocalFileSystem(db); !local.ok()) {
        return {local, kExitDatabaseUnwritable};
      }
      return {status, kExitNewerDatabase};
    case absl::StatusCode::kDataLoss:
      return {status, kExitDatabaseDamaged};
    case absl::StatusCode::kPermissionDenied:
    case absl::StatusCode::kResourceExhausted:
      return {status, kExitDatabaseUnwritable};
    default:
      return {status, kExitFailed};
  }
}

ProgramError Serve(const ServeOptions& options) {
  EndWhenMemoryRunsOut("coordinator", 1);
  const sigset_t signals = BlockStopSignals();
  if (const absl::Status status = CheckThreads(); !status.ok()) return {status, kExitFailed};
  const auto budget = RaiseDescriptors();
  if (!budget.ok()) return {budget.status(), kExitFailed};
  auto security = MakeRpcSecurity(options.insecure, options.tls_dir, Clock::System());
  if (!security.ok()) return {security.status(), kExitUsage};
  LimitRules limits;
  if (!options.limits.empty()) {
    auto loaded = LimitRules::Load(options.limits);
    if (!loaded.ok()) return {loaded.status(), kExitUsage};
    limits = *std::move(loaded);
  }
  auto samplers = LoadSamplers(options.samplers);
  if (!samplers.ok()) return {samplers.status(), kExitUsage};
  const absl::StatusOr<NotifierOptions> notify = NotifierOptionsOf(options);
  if (!notify.ok()) return {notify.status(), kExitUsage};
  if (ProgramError error = CheckDatabasePlace(options.db); !error.status.ok()) return error;
  absl::StatusOr<std::unique_ptr<Store>> store = Internal("not opened");
  std::optional<FilePresence> presence;
  JobQueueOptions queue_options = QueueOptionsOf(options, limits);
  queue_options.notice_targets = notify->Targets();
  queue_options.open_store = [&](const KnownStore& known) -> absl::StatusOr<std::string> {
    store = OpenWritableStore(options, known);
    RETURN_IF_ERROR(store.status());
    presence.emplace(**store);
    return (*store)->Id();
  };
  queue_options.files_there = [&presence](const std::vector<JobKind::OutputFile>& files) {
    return presence->Has(files);
  };
  auto queue = JobQueue::Open(queue_options);
  if (!queue.ok() && queue.status() == store.status()) {
    return {store.status(), kExitStoreUnwritable};
  }
  if (!queue.ok()) return ExplainOpenError(queue.status(), options.db);

  CoordinatorServerOptions server_options =
      ServerOptionsOf(options, *security, budget->rpc, **store);
  if (options.scores != nullptr) {
    server_options.scorer = [&](const ScoreQuery& query) {
      return options.scores(**queue, **store, query);
    };
  }
  server_options.samplers = *std::move(samplers);
  server_options.notify_hosts = notify->hosts;
  auto server = CoordinatorServer::Start(server_options, **queue);
  if (!server.ok()) return ListenError(server.status());
  Janitor janitor(**queue, **store, (*server)->content(),
                  {.lease_s = options.lease_s,
                   .unknown_s = options.sweep_days * 86400,
                   .keep = {.keep_s = options.keep_days * 86400,
                            .keep_bytes = static_cast<int64_t>(options.keep_gb * 1e9)},
                   .database = options.db});
  std::optional<Notifier> notifier;
  if (!notify->Targets().empty()) notifier.emplace(**queue, (*server)->waits(), *notify);
  std::unique_ptr<HttpServer> http;
  if (!options.http.empty()) {
    HttpServerOptions page = HttpOptionsOf(options, *security, budget->http, **store);
    page.space = [&janitor] { return janitor.space(); };
    if (options.table != nullptr) {
      page.table = [&](int64_t study) { return options.table(**queue, **store, study); };
    }
    page.picture = options.picture;
    auto started = HttpServer::Start(page, **queue, **server);
    if (!started.ok()) return ListenError(started.status());
    http = *std::move(started);
    (*server)->SetPage([&http](const RpcCaller& caller) { return http->link_url(caller); });
  }

  Announce(**server, http.get());
  LogInfo("coordinator serves", {{"version", kProgramVersion},
                                 {"db", options.db},
                                 {"store", (*store)->Uri()},
                                 {"epoch", (*queue)->epoch()},
                                 {"limits", limits.Describe()},
                                 {"descriptors", budget->descriptors},
                                 {"lease_s", options.lease_s}});
  const int signal = WaitForSignal(signals);
  LogInfo("coordinator stops", {{"signal", signal}});
  notifier.reset();
  (*server)->SetPage(nullptr);
  if (http != nullptr) http->Stop();
  (*server)->Shutdown();
  return {};
}

}  // namespace parallax
