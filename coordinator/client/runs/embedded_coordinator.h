// A coordinator in this process for one folder, which holds its database and store. Workers and
// client reach it on a Unix socket that only this user can open. Queue and service are those of the
// daemon.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "common/base/status.h"

namespace parallax {
class CoordinatorServer;
class HttpServer;
class Janitor;
class JobQueue;
class Notifier;
class Store;
}  // namespace parallax

namespace parallax::client {

class EmbeddedCoordinator {
 public:
  // Starts a coordinator on the database "queue.db" and the folder "store" in `work_dir`. If the
  // disk later refuses a commit, the process ends with one line and exit code 4, as the queue
  // demands. Errors: those of JobQueue::Open and CoordinatorServer::Start.
  static absl::StatusOr<std::unique_ptr<EmbeddedCoordinator>> Start(const std::string& work_dir);
  // Serves what a run has left in `work_dir`, to look at: writes nothing there. Works on a copy of
  // the database, which may be as large as it, in the folder for temporary files; what ran when the
  // run was killed counts as waiting. Errors: kNotFound if no run has left a database there; those
  // of Start and of copying.
  static absl::StatusOr<std::unique_ptr<EmbeddedCoordinator>> StartToView(
      const std::string& work_dir);
  ~EmbeddedCoordinator();

  const std::string& address() const { return address_; }  // "unix:/..."

  // Serves the web page on `listen` ("127.0.0.1:0": any free port of this machine) until the object
  // is destroyed. Returns the page's address with a code that opens it once; of one that was
  // started to view, it only opens for looking. Errors: those of HttpServer::Start.
  absl::StatusOr<std::string> ServePage(const std::string& listen);
  // Begins to remove files from the store that nothing needs any more.
  void RemoveLitter();

 private:
  EmbeddedCoordinator() = default;
  absl::Status Listen();
  absl::StatusOr<std::string> PageLink();

  std::string socket_dir_;
  // A file with the path of socket_dir_, by which a later run removes it if this one is killed.
  std::string socket_note_;
  std::string address_;
  std::unique_ptr<Store> store_;
  std::unique_ptr<JobQueue> queue_;
  std::unique_ptr<CoordinatorServer> server_;
  std::unique_ptr<Notifier> notifier_;
  std::unique_ptr<Janitor> janitor_;
  std::string db_path_;
  std::string copy_dir_;    // Folder of the database's copy; empty: none.
  bool view_only_ = false;  // The page only shows.
  std::mutex page_mu_;
  std::unique_ptr<HttpServer> page_;  // Guarded by page_mu_.
};

// Returns the address of the coordinator of the run that writes to `work_dir` now: "unix:/...".
// Errors: kNotFound if none exists.
absl::StatusOr<std::string> AddressOfRun(const std::string& work_dir);

// Makes a folder that only this user may enter, with a path short enough for a socket in it (a
// socket's path has at most 107 bytes). Errors: kInternal if none of $XDG_RUNTIME_DIR, $TMPDIR and
// /tmp will do.
absl::StatusOr<std::string> MakeSocketFolder();

}  // namespace parallax::client
