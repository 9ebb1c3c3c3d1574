#include "coordinator/rpc/storage/store_claim.h"

#include "common/base/seconds.h"
#include "coordinator/rpc/workers/output_check.h"

namespace parallax {
namespace {

constexpr size_t kMostSeen = 100'000;
constexpr double kRestsPerWait = 10;
constexpr char kAdopt[] =
    "; if this is to be the database's store from now on, start once with --adopt-store; "
    "what is missing there is then found and made again";

absl::Status CheckSample(const Store& store, const KnownStore& known) {
  ASSIGN_OR_RETURN(const std::string why, WhyNotInStore(store, known.sample));
  if (why.empty()) return absl::OkStatus();
  return FailedPrecondition(
      "store {}: the database's newest results are not there ({}); is the "
      "right disk mounted here?{}",
      store.Uri(), why, kAdopt);
}

absl::Status CheckOwner(const Store& store, const KnownStore& known) {
  ASSIGN_OR_RETURN(const std::string owner, store.Owner());
  if (owner.empty() || owner == known.database_id) return absl::OkStatus();
  return FailedPrecondition("store {}: it belongs to the database {}, and this one is {}{}",
                            store.Uri(), owner, known.database_id, kAdopt);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Store>> ClaimStore(const std::string& uri, const KnownStore& known,
                                                  bool adopt) {
  const bool is_new = known.id.empty() && known.sample.empty();
  // Older object stores have no marker; their results tell them.
  const bool is_older = known.id.empty() && uri.starts_with("s3://");
  absl::StatusOr<std::unique_ptr<Store>> store =
      OpenStore(uri, {.create = is_new || is_older || adopt, .id = adopt ? "" : known.id});
  const bool is_other =
      absl::IsNotFound(store.status()) || absl::IsFailedPrecondition(store.status());
  if (is_other && !is_new) {
    const std::string mine = known.id.empty()
                                 ? "the database has results in its store"
                                 : "the database's results are in the store " + known.id;
    return FailedPrecondition("{}: {}{}", mine, ToStd(store.status().message()), kAdopt);
  }
  if (!store.ok() || (*store)->Id().empty()) return store;
  if (!adopt) {
    if (known.id.empty()) RETURN_IF_ERROR(CheckSample(**store, known));
    RETURN_IF_ERROR(CheckOwner(**store, known));
  }
  ASSIGN_OR_RETURN(const std::string owner, (*store)->Owner());
  if (owner != known.database_id) RETURN_IF_ERROR((*store)->SetOwner(known.database_id));
  return store;
}

FilePresence::FilePresence(const Store& store, Clock& clock)
    : store_(store), clock_(clock), is_far_(!store.LocalPath("here").ok()) {}

bool FilePresence::Has(const std::vector<JobKind::OutputFile>& files) {
  if (!is_far_) return MayBeThere(WhyNotInStore(store_, files));
  const std::string folder = CommonFolder(files);
  const std::lock_guard lock(mutex_);
  const SteadyTime begin = clock_.Steady();
  if (begin < ask_at_ || seen_.count(folder) > 0) return true;
  const auto why = WhyNotThere(files);
  if (!why.ok()) {
    const SteadyTime now = clock_.Steady();
    ask_at_ = SecondsAfter(now, kRestsPerWait * SecondsBetween(begin, now));
  }
  const bool may_be = MayBeThere(why);
  if (!why.ok() || !why->empty()) return may_be;
  if (seen_.size() >= kMostSeen) seen_.clear();
  seen_.insert(folder);
  return true;
}

bool FilePresence::MayBeThere(const absl::StatusOr<std::string>& why_not) const {
  // A store that can't be asked, or is not there at all, says nothing of its files.
  return !why_not.ok() || why_not->empty() || !store_.CheckMarker().ok();
}

absl::StatusOr<std::string> FilePresence::WhyNotThere(
    const std::vector<JobKind::OutputFile>& files) {
  const auto list = [this](const std::string& folder) -> absl::StatusOr<std::vector<StoreEntry>> {
    if (folder != listed_) {
      ASSIGN_OR_RETURN(entries_, store_.List(folder));
      listed_ = folder;
    }
    return entries_;
  };
  ASSIGN_OR_RETURN(const std::string why, WhyNotListed(list, files));
  if (why.empty()) return why;
  return WhyNotInStore(store_, files);  // The list may be old.
}

}  // namespace parallax
