// Finished work that the coordinator has not acknowledged yet: one file a report, on disk from
// before it is sent until a definitive answer. A worker that is killed in between loses nothing.
//
//   <root>/<worker>/lock                                   held by the living worker of that name
//   <root>/<worker>/<coordinator>-<job>-<fence>.complete   CompleteRequest or
//   <root>/<worker>/<coordinator>-<job>-<fence>.fail       FailRequest, after their SHA-256
//   <root>/<worker>/staging/                               attempts on their way to a store
//
// A worker that starts adopts the reports of dead workers under the same root: default names
// contain a process id, so nobody else would return for them.
#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

// A finished attempt's message to the coordinator.
struct Report {
  std::variant<v1::CompleteRequest, v1::FailRequest> body;

  const v1::AttemptId& attempt() const;
  const std::string& coordinator_id() const;
};

// The reports of one worker. Thread-safe: one file a report, and two reports never share a name.
class Outbox {
 public:
  // Makes the folder and locks it. `worker` is a file name (see CheckWorkerName). Errors:
  // kAlreadyExists when a living worker of that name holds it; those of the file system.
  static absl::StatusOr<std::unique_ptr<Outbox>> Open(const std::string& root,
                                                      const std::string& worker);
  ~Outbox();
  Outbox(const Outbox&) = delete;
  Outbox& operator=(const Outbox&) = delete;

  // Returns the reports that Open found, in order of file names. Damaged files are renamed to
  // *.damaged and logged.
  std::vector<Report> TakeLeftovers() { return std::move(leftovers_); }
  // Writes a report, durably. The same report again replaces it. Errors: those of the file system.
  absl::Status Put(const Report& report);
  // Removes a report that the coordinator has answered; none is fine. Errors: those of the file
  // system.
  absl::Status Remove(const Report& report);
  const std::string& directory() const { return directory_; }
  // Returns the folder for files on their way to a store that this machine does not see. Open
  // empties it: a dead worker's files there were not reported.
  std::string staging() const;

 private:
  Outbox(std::string directory, int lock_fd)
      : directory_(std::move(directory)), lock_fd_(lock_fd) {}
  void AdoptFrom(const std::string& sibling);
  void LoadLeftovers();
  std::string PathOf(const Report& report) const;

  const std::string directory_;
  const int lock_fd_;
  std::vector<Report> leftovers_;
};

// Checks a worker's name, which is a folder, a log field and a metric's label:
// [A-Za-z0-9][A-Za-z0-9._-]*, at most 100 characters. Errors: kInvalidArgument.
absl::Status CheckWorkerName(std::string_view name);

}  // namespace parallax
