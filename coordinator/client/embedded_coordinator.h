// A coordinator in this process, for one folder: its database and store live there, and workers and
// client talk to it on a Unix socket that only this user can reach. The same queue and service as
// the daemon's.
#pragma once

#include <memory>
#include <string>

#include "common/base/status.h"

namespace parallax {
class CoordinatorServer;
class HttpServer;
class JobQueue;
class Store;
}  // namespace parallax

namespace parallax::client {

class EmbeddedCoordinator {
 public:
  // `work_dir`: database "queue.db" and folder "store". Errors: those of JobQueue::Open and
  // CoordinatorServer::Start. When the disk refuses a commit the process ends with one line and
  // exit code 4, as the queue demands.
  static absl::StatusOr<std::unique_ptr<EmbeddedCoordinator>> Start(const std::string& work_dir);
  ~EmbeddedCoordinator();

  const std::string& address() const { return address_; }  // "unix:/..."

  // Serves the page on `listen` ("127.0.0.1:0": any free port of this machine) until the end.
  // Returns its address with a code that opens it once. Errors: those of HttpServer::Start.
  absl::StatusOr<std::string> ServePage(const std::string& listen);

 private:
  EmbeddedCoordinator() = default;

  std::string socket_dir_;
  // The file that names socket_dir_ for a later run, should this one be killed.
  std::string socket_note_;
  std::string address_;
  std::unique_ptr<Store> store_;
  std::unique_ptr<JobQueue> queue_;
  std::unique_ptr<CoordinatorServer> server_;
  std::string db_path_;
  std::unique_ptr<HttpServer> page_;
};

// A new folder that only this user may enter, whose path leaves room for a socket's name (a
// socket's path has at most 107 bytes). Errors: kInternal when none of $XDG_RUNTIME_DIR, $TMPDIR
// and /tmp will do.
absl::StatusOr<std::string> MakeSocketFolder();

}  // namespace parallax::client
