#include "worker/agent/attempts/upload.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>

#include "common/base/system/log.h"

namespace parallax {
namespace {

constexpr std::chrono::milliseconds kFirstPause{100};
constexpr std::chrono::milliseconds kLongestPause{5000};
constexpr std::chrono::milliseconds kCancelPoll{20};

// kCancelled means that the coordinator ended a stalled transfer; our own end comes by the token.
bool IsWorthAnotherTry(absl::StatusCode code) {
  return code == absl::StatusCode::kUnavailable || code == absl::StatusCode::kResourceExhausted ||
         code == absl::StatusCode::kDeadlineExceeded || code == absl::StatusCode::kCancelled;
}

// Sleeps, but wakes at a cancellation.
void Pause(std::chrono::milliseconds pause, const CancelToken& cancel) {
  std::mutex mu;
  std::condition_variable never;
  std::unique_lock lock(mu);
  for (auto left = pause; left.count() > 0 && !cancel.cancelled(); left -= kCancelPoll) {
    never.wait_for(lock, std::min(left, kCancelPoll));
  }
}

absl::Status PutUntilThere(Store& store, const std::string& path, const std::string& local,
                           const StoreFile& facts, const CancelToken& cancel) {
  for (auto pause = kFirstPause;; pause = std::min(pause * 2, kLongestPause)) {
    if (cancel.cancelled()) return Cancelled("while its files were sent");
    const absl::Status status = store.PutFile(path, local, facts, /*may_move=*/false);
    if (status.ok() || !IsWorthAnotherTry(status.code()))
      return WithContext(status, "send " + path);
    if (pause == kFirstPause) {
      LogWarning("file not sent yet; trying again", {{"file", path}, {"error", status}});
    }
    Pause(pause, cancel);
  }
}

}  // namespace

absl::Status UploadFiles(Store& store, const std::string& dir, const std::string& path,
                         const std::vector<OutputFile>& files, const CancelToken& cancel) {
  for (const OutputFile& file : files) {
    if (file.sent) continue;
    RETURN_IF_ERROR(PutUntilThere(store, path + "/" + file.name, dir + "/" + file.name,
                                  {file.size, file.sha256}, cancel));
  }
  return absl::OkStatus();
}

}  // namespace parallax
