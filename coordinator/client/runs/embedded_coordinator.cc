#include "coordinator/client/runs/embedded_coordinator.h"

#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "common/base/system/file.h"
#include "common/base/system/memory_end.h"
#include "common/store/store.h"
#include "coordinator/client/exit_code.h"
#include "coordinator/http/http_server.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/coordinator_server.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;

constexpr size_t kLongestSocketPath = 107;
constexpr char kSocketName[] = "/coordinator";
// A broken Unix socket means a dead worker; it does not come back under the same stream.
constexpr double kReconnectGrace_s = 1;
// Workers are on this machine and their streams break when they die, so a lease that runs out is
// the rare case of a worker that hangs.
constexpr double kLease_s = 30;

[[noreturn]] void EndOnCommitFailure(const absl::Status& status) {
  const std::string line =
      "error: the run's database could not be written: " + std::string(status.message()) +
      "; nothing finished is lost, run the same command again to go on\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, line.data(), line.size());
  // Workers die with us; nothing may touch the database any more.
  _exit(kExitDisk);
}

// Without memory or threads, gRPC's shutdown may wait for ever.
constexpr unsigned kLongestShutdown_s = 60;

void EndOnLongShutdown(int) {
  constexpr char kLine[] =
      "error: the run's coordinator did not shut down in 60 s; nothing finished is lost\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, kLine, sizeof kLine - 1);
  _exit(kExitFailed);
}

// A killed run leaves its socket's folder behind; `note`, in the run's own folder, says where it
// is. Removes no more than the socket and an empty folder of our kind of name.
void RemoveLeftSocket(const std::string& note) {
  const absl::StatusOr<std::string> folder = ReadFile(note, 4096);
  if (!folder.ok() || fs::path(*folder).filename().string().rfind("parallax-", 0) != 0) return;
  std::error_code error;
  fs::remove(*folder + kSocketName, error);
  fs::remove(*folder, error);
  fs::remove(note, error);
}

}  // namespace

absl::StatusOr<std::string> MakeSocketFolder() {
  const char* const candidates[] = {std::getenv("XDG_RUNTIME_DIR"), std::getenv("TMPDIR"), "/tmp"};
  for (const char* candidate : candidates) {
    if (candidate == nullptr || candidate[0] != '/') continue;
    std::string folder = std::string(candidate) + "/parallax-XXXXXX";
    if (folder.size() + std::strlen(kSocketName) > kLongestSocketPath) continue;
    if (mkdtemp(folder.data()) != nullptr) return folder;
  }
  return Internal("no folder for a socket: $XDG_RUNTIME_DIR, $TMPDIR and /tmp are unusable");
}

absl::StatusOr<std::unique_ptr<EmbeddedCoordinator>> EmbeddedCoordinator::Start(
    const std::string& work_dir) {
  EndWhenMemoryRunsOut("the run's coordinator", kExitFailed);
  std::unique_ptr<EmbeddedCoordinator> coordinator(new EmbeddedCoordinator);
  const std::string store = work_dir + "/store";
  std::error_code error;
  ASSIGN_OR_RETURN(coordinator->store_, OpenStore(store));
  coordinator->socket_note_ = work_dir + "/socket";
  RemoveLeftSocket(coordinator->socket_note_);
  ASSIGN_OR_RETURN(coordinator->socket_dir_, MakeSocketFolder());
  RETURN_IF_ERROR(WriteFile(coordinator->socket_note_, coordinator->socket_dir_));

  JobQueueOptions queue;
  queue.db_path = work_dir + "/queue.db";
  // Reports that wait there belong to a database that is gone.
  if (!fs::exists(queue.db_path, error)) fs::remove_all(work_dir + "/outbox", error);
  queue.lease_s = kLease_s;
  queue.on_fatal = EndOnCommitFailure;
  ASSIGN_OR_RETURN(coordinator->queue_, JobQueue::Open(queue));
  coordinator->db_path_ = queue.db_path;

  CoordinatorServerOptions server;
  coordinator->address_ = "unix:" + coordinator->socket_dir_ + kSocketName;
  server.listen = {coordinator->address_};
  server.store_uri = coordinator->store_->Uri();
  server.store = coordinator->store_.get();
  server.spool_dir = store + "/.tmp-incoming";
  server.reconnect_grace_s = kReconnectGrace_s;
  ASSIGN_OR_RETURN(coordinator->server_, CoordinatorServer::Start(server, *coordinator->queue_));
  return coordinator;
}

absl::StatusOr<std::string> EmbeddedCoordinator::ServePage(const std::string& listen) {
  HttpServerOptions options;
  options.listen = listen;
  options.store_uri = store_->Uri();
  options.store = store_.get();
  options.db_path = db_path_;
  options.by_link_only = true;
  ASSIGN_OR_RETURN(page_, HttpServer::Start(options, *queue_, *server_));
  return page_->link_url();
}

EmbeddedCoordinator::~EmbeddedCoordinator() {
  const auto handler_before = std::signal(SIGALRM, EndOnLongShutdown);
  alarm(kLongestShutdown_s);
  page_.reset();
  if (server_ != nullptr) server_->Shutdown();
  server_.reset();
  queue_.reset();
  alarm(0);
  std::signal(SIGALRM, handler_before);
  std::error_code error;
  if (socket_dir_.empty()) return;
  fs::remove_all(socket_dir_, error);
  fs::remove(socket_note_, error);
}

}  // namespace parallax::client
