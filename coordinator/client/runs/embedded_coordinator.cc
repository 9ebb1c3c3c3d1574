#include "coordinator/client/runs/embedded_coordinator.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/base/system/memory_end.h"
#include "common/rpc/endpoint.h"
#include "common/store/store.h"
#include "coordinator/client/exit_code.h"
#include "coordinator/client/scores/page_table.h"
#include "coordinator/client/scores/score_trials.h"
#include "coordinator/http/http_server.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/coordinator_server.h"
#include "coordinator/rpc/janitor.h"
#include "coordinator/rpc/notifier.h"

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
// A run's end waits for its last notices. What is not taken then is told by the next run.
constexpr double kNotice_s = 5;
constexpr double kNoticeGather_s = 5;

[[noreturn]] void EndOnCommitFailure(const absl::Status& status) {
  const std::string line =
      "error: the run's database could not be written: " + std::string(status.message()) +
      "; finished pairs are kept, run the same command again to resume\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, line.data(), line.size());
  // Workers die with us; nothing may touch the database any more.
  _exit(kExitDisk);
}

// Without memory or threads, gRPC's shutdown may wait for ever.
constexpr unsigned kLongestShutdown_s = 60;

void EndOnLongShutdown(int) {
  constexpr char kLine[] =
      "error: the run's coordinator did not shut down in 60 s; finished pairs are kept\n";
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

// Gives back what the workers of a run that was killed held: they are gone.
absl::Status EndLeases(JobQueue& queue) {
  ASSIGN_OR_RETURN(const std::vector<v1::StudyStatus> studies, queue.ListStudies(1000));
  for (const v1::StudyStatus& study : studies) {
    v1::ListJobsRequest leased;
    leased.set_study_id(study.study_id());
    leased.set_state("LEASED");
    ASSIGN_OR_RETURN(const std::vector<v1::JobStatus> jobs, queue.ListJobs(leased));
    for (const v1::JobStatus& job : jobs) RETURN_IF_ERROR(queue.WorkerLost(job.worker()).status());
  }
  return absl::OkStatus();
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

absl::StatusOr<std::string> AddressOfRun(const std::string& work_dir) {
  ASSIGN_OR_RETURN(const std::string folder, ReadFile(work_dir + "/socket", 4096));
  ASSIGN_OR_RETURN(const RpcAddress address, ParseRpcAddress("unix:" + folder + kSocketName));
  // The note of a run that was killed names a socket that nobody listens to.
  const int probe = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  std::snprintf(name.sun_path, sizeof name.sun_path, "%s%s", folder.c_str(), kSocketName);
  const int failed = ::connect(probe, reinterpret_cast<const sockaddr*>(&name), sizeof name);
  ::close(probe);
  if (failed != 0) return NotFound("{}: no run writes there now", work_dir);
  return address.ToString();
}

absl::Status EmbeddedCoordinator::Listen() {
  CoordinatorServerOptions server;
  address_ = "unix:" + socket_dir_ + kSocketName;
  server.listen = {address_};
  server.store_uri = store_->Uri();
  server.store = store_.get();
  server.spool_dir = copy_dir_.empty()
                         ? store_->Uri().substr(sizeof "file://" - 1) + "/.tmp-incoming"
                         : copy_dir_ + "/incoming";
  server.reconnect_grace_s = kReconnectGrace_s;
  // The study's author and the coordinator's operator are one.
  ASSIGN_OR_RETURN(server.notify_hosts, NotifyHosts::Of({"*"}));
  if (!view_only_) {
    server.scorer = [this](const ScoreQuery& query) {
      return ScoreTrials(*queue_, *store_, query);
    };
  }
  ASSIGN_OR_RETURN(server_, CoordinatorServer::Start(server, *queue_));
  if (view_only_) return absl::OkStatus();
  notifier_ = std::make_unique<Notifier>(
      *queue_, server_->waits(),
      NotifierOptions{.hosts = server.notify_hosts, .most_s = kNotice_s});
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<EmbeddedCoordinator>> EmbeddedCoordinator::StartToView(
    const std::string& work_dir) {
  std::error_code error;
  if (!fs::exists(work_dir + "/queue.db", error)) {
    return NotFound(
        "{}/queue.db: missing: `parallax run` leaves it in its folder, `fetch` does not", work_dir);
  }
  std::unique_ptr<EmbeddedCoordinator> coordinator(new EmbeddedCoordinator);
  coordinator->view_only_ = true;
  ASSIGN_OR_RETURN(coordinator->store_,
                   OpenStore(work_dir + "/store", {.create = false, .read_only = true}));
  ASSIGN_OR_RETURN(coordinator->socket_dir_, MakeSocketFolder());
  std::string copy = (fs::temp_directory_path(error) / "parallax-view-XXXXXX").string();
  if (error || ::mkdtemp(copy.data()) == nullptr) {
    return ErrnoError(error ? error.value() : errno, "make a folder for temporary files");
  }
  coordinator->copy_dir_ = copy;
  JobQueueOptions queue;
  queue.db_path = copy + "/queue.db";
  queue.own_timer = false;
  queue.archive_after_s = 0;
  // A run that was killed has left a part of its database in the write-ahead log.
  for (const char* name : {"/queue.db", "/queue.db-wal"}) {
    if (!fs::exists(work_dir + name, error)) continue;
    fs::copy_file(work_dir + name, copy + name, error);
    if (error) return ErrnoError(error.value(), "copy " + work_dir + name + " to " + copy);
    fs::permissions(copy + name, fs::perms::owner_read | fs::perms::owner_write, error);
  }
  ASSIGN_OR_RETURN(coordinator->queue_, JobQueue::Open(queue));
  coordinator->db_path_ = queue.db_path;
  RETURN_IF_ERROR(EndLeases(*coordinator->queue_));
  RETURN_IF_ERROR(coordinator->Listen());
  return coordinator;
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
  queue.notice_targets = {kStudyTarget};
  queue.notice_gather_s = kNoticeGather_s;
  ASSIGN_OR_RETURN(coordinator->queue_, JobQueue::Open(queue));
  coordinator->db_path_ = queue.db_path;

  RETURN_IF_ERROR(coordinator->Listen());
  coordinator->server_->SetPage(
      [it = coordinator.get()](const RpcCaller&) { return it->ServePage("127.0.0.1:0"); });
  return coordinator;
}

absl::StatusOr<std::string> EmbeddedCoordinator::PageLink() {
  return view_only_
             ? page_->link_url(
                   {.has_certificate = true, .name = "this machine", .role = Role::kReadOnly})
             : page_->link_url();
}

absl::StatusOr<std::string> EmbeddedCoordinator::ServePage(const std::string& listen) {
  const std::lock_guard lock(page_mu_);
  if (page_ != nullptr) return PageLink();
  HttpServerOptions options;
  options.table = [this](int64_t study) { return PageTable(*queue_, *store_, study); };
  options.listen = listen;
  options.store_uri = store_->Uri();
  options.store = store_.get();
  options.db_path = db_path_;
  options.by_link_only = true;
  ASSIGN_OR_RETURN(page_, HttpServer::Start(options, *queue_, *server_));
  return PageLink();
}

void EmbeddedCoordinator::RemoveLitter() {
  const JanitorOptions options{.lease_s = kLease_s, .database = db_path_};
  janitor_ = std::make_unique<Janitor>(*queue_, *store_, server_->content(), options);
}

EmbeddedCoordinator::~EmbeddedCoordinator() {
  const auto handler_before = std::signal(SIGALRM, EndOnLongShutdown);
  alarm(kLongestShutdown_s);
  if (notifier_ != nullptr) notifier_->Finish();
  notifier_.reset();
  janitor_.reset();
  if (server_ != nullptr) server_->SetPage(nullptr);
  page_.reset();
  if (server_ != nullptr) server_->Shutdown();
  server_.reset();
  queue_.reset();
  alarm(0);
  std::signal(SIGALRM, handler_before);
  std::error_code error;
  if (!copy_dir_.empty()) fs::remove_all(copy_dir_, error);
  if (socket_dir_.empty()) return;
  fs::remove_all(socket_dir_, error);
  if (!socket_note_.empty()) fs::remove(socket_note_, error);
}

}  // namespace parallax::client
