// The store at a coordinator's start: it must be the database's own.
//
// A database keeps the id of its store, and a store the id of its database. So neither an empty
// folder where a disk is not mounted nor another database's store is taken for the database's own.
#pragma once

#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/store/store.h"
#include "coordinator/queue/stored_outputs.h"

namespace parallax {

// Opens the store at `uri` for a database that knows `known`. A new database may take a new store;
// a database from before it kept an id must find its newest results there. With `adopt`, whatever
// is there becomes the database's store. Errors: those of OpenStore; kFailedPrecondition for a
// store that is another database's, or that lacks the results; each names the database's id and
// what to do.
absl::StatusOr<std::unique_ptr<Store>> ClaimStore(const std::string& uri, const KnownStore& known,
                                                  bool adopt);

// Answers whether results' files are in the store, for JobQueueOptions::files_there. Folders of a
// store that is far away are asked for once. Thread-safe.
class FilePresence {
 public:
  // `store` must outlive the object.
  explicit FilePresence(const Store& store);
  // Returns false only if the store is the right one and lacks a file, or has it with another size.
  bool Has(const std::vector<JobKind::OutputFile>& files);

 private:
  const Store& store_;
  const bool is_far_;
  std::mutex mutex_;
  std::set<std::string> seen_;  // Folders of a far store that were whole. Guarded by mutex_.
};

}  // namespace parallax
