#include "coordinator/rpc/content_keeper.h"

#include <chrono>
#include <iterator>

#include "common/base/hash.h"
#include "common/base/names.h"
#include "common/base/seconds.h"
#include "common/base/system/log.h"
#include "common/config/content_folders.h"
#include "common/store/content.h"
#include "common/store/store.h"

namespace parallax {
namespace {

// From when a study is checked until its own names keep its content: far more than a commit takes.
constexpr double kSubmit_s = 60;

}  // namespace

void ContentKeeper::Note(const std::string& sha256) {
  const std::lock_guard lock(mu_);
  unused_since_.erase(sha256);
}

absl::Status ContentKeeper::CheckStudy(v1::StudySpec& study) {
  std::set<std::string> checked;
  std::optional<std::map<std::string, int64_t>> sizes;
  for (v1::VariantSpec& variant : *study.mutable_variants()) {
    for (const std::string* folder : ContentFoldersOf(*variant.mutable_config())) {
      RETURN_IF_ERROR(CheckContent(*folder, "variant " + variant.name(), checked, sizes));
    }
  }
  for (const v1::OwnBenchmark& own : study.evaluate().own_benchmarks()) {
    RETURN_IF_ERROR(
        CheckContent(PathOfBenchmark(own), "evaluate.benchmarks: " + own.name(), checked, sizes));
  }
  return absl::OkStatus();
}

absl::Status ContentKeeper::CheckContent(const std::string& name, const std::string& user,
                                         std::set<std::string>& checked,
                                         std::optional<std::map<std::string, int64_t>>& sizes) {
  const auto reference = FindContentReference(name);
  if (!reference || !checked.insert(reference->sha256).second) return absl::OkStatus();
  Note(reference->sha256);  // First: no sweep may take the list that is found here.
  ASSIGN_OR_RETURN(const bool has, store_.Has(ContentPath(reference->sha256)));
  if (has) {
    {
      const std::lock_guard lock(mu_);
      submitted_[reference->sha256] = options_.clock->Steady();
    }
    return WithContext(CheckList(reference->sha256, sizes),
                       user + ": own content " + Quoted("/" + reference->path));
  }
  return FailedPrecondition(
      "{}: own content {} (list {}) is not in this coordinator's store, or no longer; submit the "
      "study where it is, which brings it, or with --no-content if each worker has a copy",
      user, Quoted("/" + reference->path), reference->sha256);
}

absl::Status ContentKeeper::CheckList(const std::string& list,
                                      std::optional<std::map<std::string, int64_t>>& sizes) {
  ASSIGN_OR_RETURN(const std::string text,
                   store_.GetPiece(ContentPath(list), 0, kMostContentListBytes + 1));
  if (Sha256Hex(text) != list) {
    return InvalidArgument("its list {} is not what its name says, or longer than {} bytes", list,
                           kMostContentListBytes);
  }
  ASSIGN_OR_RETURN(const std::vector<ContentFile> files, ParseContentList(text));
  if (!sizes) {
    sizes.emplace();
    ASSIGN_OR_RETURN(const std::vector<StoreEntry> entries, store_.List(kContentFolder));
    for (const StoreEntry& entry : entries) {
      (*sizes)[entry.path.substr(entry.path.rfind('/') + 1)] = entry.size;
    }
  }
  for (const ContentFile& file : files) {
    const auto found = sizes->find(file.sha256);
    if (found == sizes->end()) {
      return FailedPrecondition(
          "{} ({}) is not in this coordinator's store; submit the study where "
          "that folder is, which brings it",
          Quoted(file.name), file.sha256);
    }
    if (found->second == file.size) continue;
    return InvalidArgument("list of content: {} of {} bytes, and the file has {}",
                           Quoted(file.name), file.size, found->second);
  }
  return absl::OkStatus();
}

absl::Status ContentKeeper::TakeRoom(const std::string& sha256, int64_t bytes) {
  const std::lock_guard lock(mu_);
  if (const auto known = on_way_.find(sha256); known != on_way_.end()) {
    ++known->second.senders;
    return absl::OkStatus();
  }
  if (bytes_ < 0) {
    ASSIGN_OR_RETURN(const std::vector<StoreEntry> entries, store_.List(kContentFolder));
    bytes_ = 0;
    for (const StoreEntry& entry : entries) bytes_ += entry.size;
  }
  if (bytes_ + bytes > options_.most_bytes) {
    return ResourceExhausted(
        "users' content in the store has {} bytes, {} more are wanted, and {} are allowed; content "
        "goes a day after the last study that names it is forgotten (`parallax forget STUDY`)",
        bytes_, bytes, options_.most_bytes);
  }
  bytes_ += bytes;
  on_way_[sha256] = {.bytes = bytes, .senders = 1};
  return absl::OkStatus();
}

void ContentKeeper::EndRoom(const std::string& sha256, bool stored) {
  const std::lock_guard lock(mu_);
  const auto file = on_way_.find(sha256);
  if (file == on_way_.end()) return;
  file->second.stored |= stored;
  if (--file->second.senders > 0) return;
  if (!file->second.stored && bytes_ >= 0) bytes_ -= file->second.bytes;
  on_way_.erase(file);
}

std::set<std::string> ContentKeeper::ListsOfSubmits() {
  const SteadyTime now = options_.clock->Steady();
  const std::lock_guard lock(mu_);
  std::set<std::string> lists;
  for (auto it = submitted_.begin(); it != submitted_.end();) {
    const bool over = SecondsBetween(it->second, now) >= kSubmit_s;
    if (!over) lists.insert(it->first);
    it = over ? submitted_.erase(it) : std::next(it);
  }
  return lists;
}

absl::StatusOr<int> ContentKeeper::Sweep(const std::vector<std::string>& lists) {
  ASSIGN_OR_RETURN(const std::vector<StoreEntry> entries, store_.List(kContentFolder));
  if (entries.empty()) return 0;
  std::set<std::string> used = ListsOfSubmits();
  used.insert(lists.begin(), lists.end());
  for (const std::string& list : std::vector<std::string>(used.begin(), used.end())) {
    const absl::StatusOr<std::string> text = store_.Get(ContentPath(list));
    if (!text.ok() && !absl::IsNotFound(text.status())) return text.status();
    const auto files = text.ok() ? ParseContentList(*text)
                                 : absl::StatusOr<std::vector<ContentFile>>(text.status());
    if (!files.ok()) {
      LogWarning("a study names a list of content that can't be read; its files are not kept",
                 {{"list", list}, {"error", files.status()}});
      continue;
    }
    for (const ContentFile& file : *files) used.insert(file.sha256);
  }
  const SteadyTime now = options_.clock->Steady();
  int removed = 0;
  for (const StoreEntry& entry : entries) {
    const std::string sha256 = entry.path.substr(entry.path.rfind('/') + 1);
    const std::lock_guard lock(mu_);
    if (used.count(sha256) > 0) {
      unused_since_.erase(sha256);
      continue;
    }
    // Who notes the file after this finds it gone, and puts it again.
    const SteadyTime since = unused_since_.try_emplace(sha256, now).first->second;
    if (SecondsBetween(since, now) < options_.keep_s) continue;
    RETURN_IF_ERROR(store_.RemoveTree(entry.path));
    unused_since_.erase(sha256);
    if (bytes_ >= 0) bytes_ -= entry.size;
    ++removed;
  }
  return removed;
}

}  // namespace parallax
