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
#include "common/base/system/clock.h"
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

// Answers whether results' files are in the store, for JobQueueOptions::files_there: all that the
// queue writes waits for the answer. A store that is far away is asked once for each folder, and
// lists an attempt once for its results in a row. If it can't be asked, it is not asked again for
// ten times as long as that took. Thread-safe.
class FilePresence {
 public:
  // `store` and `clock` must outlive the object.
  explicit FilePresence(const Store& store, Clock& clock = Clock::System());
  // Returns false only if the store is the right one and lacks a file, or has it with another size.
  bool Has(const std::vector<JobKind::OutputFile>& files);

 private:
  // Whether the store's answer says that the files are there.
  bool MayBeThere(const absl::StatusOr<std::string>& why_not) const;
  // WhyNotInStore for a store that is far away. Requires mutex_.
  absl::StatusOr<std::string> WhyNotThere(const std::vector<JobKind::OutputFile>& files);

  const Store& store_;
  Clock& clock_;
  const bool is_far_;
  std::mutex mutex_;
  // Answers of a store that is far away. Guarded by mutex_.
  std::set<std::string> seen_;  // Folders that were whole.
  std::string listed_;          // The last attempt's folder that was listed.
  std::vector<StoreEntry> entries_;
  SteadyTime ask_at_{};
};

}  // namespace parallax
