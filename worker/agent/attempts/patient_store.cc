#include "worker/agent/attempts/patient_store.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>

#include "common/base/system/log.h"

namespace parallax {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirstPause{100};
constexpr milliseconds kLongestPause{5000};
constexpr milliseconds kReadPatience{600'000};
constexpr milliseconds kCancelPoll{20};

// kCancelled means that the coordinator ended a stalled transfer; our own end comes by the token.
bool IsWorthAnotherTry(const absl::Status& status, bool is_put) {
  return absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status) ||
         absl::IsCancelled(status) || (is_put && absl::IsResourceExhausted(status));
}

// Sleeps, but wakes at a cancellation.
void Pause(milliseconds pause, const CancelToken& cancel) {
  std::mutex mu;
  std::condition_variable never;
  std::unique_lock lock(mu);
  for (auto left = pause; left.count() > 0 && !cancel.cancelled(); left -= kCancelPoll) {
    never.wait_for(lock, std::min(left, kCancelPoll));
  }
}

const absl::Status& StatusOf(const absl::Status& status) { return status; }
template <typename T>
const absl::Status& StatusOf(const absl::StatusOr<T>& result) {
  return result.status();
}

class PatientStore final : public Store {
 public:
  PatientStore(std::shared_ptr<Store> store, CancelToken cancel, std::function<void()> alive)
      : store_(std::move(store)), cancel_(std::move(cancel)), alive_(std::move(alive)) {}

  std::string Uri() const override { return store_->Uri(); }
  std::string Id() const override { return store_->Id(); }
  absl::Status CheckMarker() const override { return store_->CheckMarker(); }
  absl::StatusOr<std::string> Owner() const override { return store_->Owner(); }
  absl::Status SetOwner(const std::string& database_id) override {
    return store_->SetOwner(database_id);
  }
  absl::Status Put(std::string_view path, std::string_view bytes) override {
    return Repeat(path, /*is_put=*/true, [&] { return store_->Put(path, bytes); });
  }
  absl::Status PutFile(std::string_view path, const std::string& local_path, const StoreFile& facts,
                       bool may_move) override {
    return Repeat(path, /*is_put=*/true,
                  [&] { return store_->PutFile(path, local_path, facts, may_move); });
  }
  absl::StatusOr<std::string> Get(std::string_view path) const override {
    return Repeat(path, /*is_put=*/false, [&] { return store_->Get(path); });
  }
  absl::StatusOr<std::string> GetPiece(std::string_view path, int64_t offset,
                                       size_t max_bytes) const override {
    return Repeat(path, /*is_put=*/false,
                  [&] { return store_->GetPiece(path, offset, max_bytes); });
  }
  absl::StatusOr<bool> Has(std::string_view path) const override {
    return Repeat(path, /*is_put=*/false, [&] { return store_->Has(path); });
  }
  absl::StatusOr<std::vector<StoreEntry>> List(std::string_view prefix) const override {
    return Repeat(prefix, /*is_put=*/false, [&] { return store_->List(prefix); });
  }
  absl::Status RemoveTree(std::string_view path) override { return store_->RemoveTree(path); }
  absl::StatusOr<std::string> LocalPath(std::string_view path) const override {
    return store_->LocalPath(path);
  }

 private:
  template <typename Call>
  auto Repeat(std::string_view path, bool is_put, const Call& call) const -> decltype(call()) {
    milliseconds pause = kFirstPause, waited{0};
    while (true) {
      alive_();
      auto result = call();
      const absl::Status& status = StatusOf(result);
      const bool ends = status.ok() || !IsWorthAnotherTry(status, is_put) || cancel_.cancelled() ||
                        (!is_put && waited >= kReadPatience);
      if (ends) return result;
      if (waited.count() == 0) {
        LogWarning("the store does not answer; trying again",
                   {{"file", std::string(path)}, {"error", status}});
      }
      Pause(pause, cancel_);
      waited += pause;
      pause = std::min(pause * 2, kLongestPause);
    }
  }

  const std::shared_ptr<Store> store_;
  const CancelToken cancel_;
  const std::function<void()> alive_;
};

}  // namespace

std::shared_ptr<Store> MakePatientStore(std::shared_ptr<Store> store, const CancelToken& cancel,
                                        std::function<void()> alive) {
  if (store == nullptr || store->LocalPath("any").ok()) return store;
  return std::make_shared<PatientStore>(std::move(store), cancel, std::move(alive));
}

}  // namespace parallax
