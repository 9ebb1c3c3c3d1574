// The base of keepers of streams and of searches: records by name, which the queue's database keeps
// and a keeper takes further. All that a keeper knows beside its records is lost by a restart.
//
// Thread-safe: the public functions take the lock, all others need it. Blocks on the queue.
#pragma once

#include <fmt/core.h>

#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "common/base/names.h"
#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "coordinator/queue/job_queue.h"

namespace parallax {

// `Entry` has a public `record`, a message with `study` and `actor`. `StatusMessage` is what is
// shown of it.
template <typename Entry, typename StatusMessage>
class RecordKeeper {
 public:
  // Returns the statuses by name, short ones; or the whole one of that name. Errors: kNotFound; the
  // database's.
  absl::StatusOr<std::vector<StatusMessage>> List(const std::string& name) {
    std::lock_guard lock(mu_);
    RETURN_IF_ERROR(Load());
    std::vector<StatusMessage> all;
    if (!name.empty()) {
      ASSIGN_OR_RETURN(Entry * entry, Find(name));
      all.push_back(StatusOf(*entry, /*whole=*/true));
      return all;
    }
    for (auto& entry : entries_) all.push_back(StatusOf(entry.second, /*whole=*/false));
    return all;
  }
  // Returns who opened it, as in AuditEntry. Errors: those of List.
  absl::StatusOr<std::string> OpenedBy(const std::string& name) {
    std::lock_guard lock(mu_);
    ASSIGN_OR_RETURN(const Entry* entry, Find(name));
    return entry->record.actor();
  }

 protected:
  using Record = decltype(Entry::record);
  // The queue's functions for these records.
  struct Table {
    absl::StatusOr<std::vector<Record>> (JobQueue::*list)();
    absl::Status (JobQueue::*keep)(const Record&);
    absl::Status (JobQueue::*remove)(const std::string&);
  };
  // `noun` is what a record is, and the command that begins one: "stream". Both objects must
  // outlive the keeper.
  RecordKeeper(JobQueue& queue, Clock& clock, const char* noun, Table table)
      : queue_(queue), clock_(clock), noun_(noun), table_(table) {}
  virtual ~RecordKeeper() = default;

  virtual StatusMessage StatusOf(Entry& entry, bool whole) const = 0;
  // Enters into a new entry what follows from its record.
  virtual void Fill(Entry&) const {}
  // Takes an entry further. Returns whether nothing is left but its record. Errors: the database's.
  virtual absl::StatusOr<bool> Advance(Entry& entry) = 0;

  // Reads the records when first called. Errors: the database's.
  absl::Status Load() {
    if (loaded_) return absl::OkStatus();
    ASSIGN_OR_RETURN(std::vector<Record> records, (queue_.*table_.list)());
    for (Record& record : records) Enter(std::move(record));
    loaded_ = true;
    return absl::OkStatus();
  }
  // Returns the entry of that name. Errors: kNotFound; the database's.
  absl::StatusOr<Entry*> Find(const std::string& name) {
    RETURN_IF_ERROR(Load());
    const auto found = entries_.find(name);
    if (found != entries_.end()) return &found->second;
    std::string known;
    for (const auto& entry : entries_) known += (known.empty() ? "" : ", ") + entry.first;
    return NotFound("{} {} is not known; {}", noun_, Quoted(name),
                    known.empty() ? fmt::format("`parallax {} FILE` begins one", noun_)
                                  : "known are: " + known);
  }
  // Keeps a record durably, in a new entry that takes the place of an earlier one of its name.
  // Errors: the database's.
  absl::StatusOr<Entry*> Begin(Record record) {
    RETURN_IF_ERROR((queue_.*table_.keep)(record));
    return Enter(std::move(record));
  }
  // Keeps a changed record durably. Errors: the database's.
  absl::Status Keep(Entry& entry, Record record) {
    RETURN_IF_ERROR((queue_.*table_.keep)(record));
    entry.record = std::move(record);
    return absl::OkStatus();
  }
  // Takes all entries further, and removes those of which nothing is left. Errors: the database's.
  absl::Status AdvanceAll() {
    RETURN_IF_ERROR(Load());
    for (auto entry = entries_.begin(); entry != entries_.end();) {
      ASSIGN_OR_RETURN(const bool is_gone, Advance(entry->second));
      if (is_gone) RETURN_IF_ERROR((queue_.*table_.remove)(entry->first));
      entry = is_gone ? entries_.erase(entry) : std::next(entry);
    }
    return absl::OkStatus();
  }

  JobQueue& queue_;
  Clock& clock_;
  std::mutex mu_;
  std::map<std::string, Entry> entries_;  // By name. Guarded by mu_.

 private:
  Entry* Enter(Record record) {
    const std::string name = record.study().name();
    Entry& entry = entries_[name] = Entry();
    entry.record = std::move(record);
    Fill(entry);
    return &entry;
  }

  const char* const noun_;
  const Table table_;
  bool loaded_ = false;  // Guarded by mu_.
};

}  // namespace parallax
