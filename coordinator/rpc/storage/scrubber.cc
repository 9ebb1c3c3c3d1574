#include "coordinator/rpc/storage/scrubber.h"

#include <fmt/core.h>
#include <pthread.h>

#include <algorithm>
#include <chrono>

#include "common/base/hash.h"
#include "common/base/system/log.h"

namespace parallax {
namespace {

constexpr int kResultsAtOnce = 50;
constexpr int kUnreadableInARow = 3;  // So many are no damage: the store can't be read.
constexpr size_t kPieceBytes = 1 << 20;
constexpr double kTryAgain_s = 60;

}  // namespace

Scrubber::~Scrubber() {
  {
    const std::lock_guard lock(mu_);
    stopping_ = true;
  }
  stop_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Scrubber::Start() {
  thread_ = std::thread([this] { Loop(); });
}

ScrubFigures Scrubber::figures() const {
  const std::lock_guard lock(mu_);
  return figures_;
}

bool Scrubber::WaitFor(double seconds) {
  std::unique_lock lock(mu_);
  if (seconds <= 0) return !stopping_;
  return !stop_.wait_for(lock, std::chrono::duration<double>(seconds),
                         [this] { return stopping_; });
}

void Scrubber::Loop() {
  pthread_setname_np(pthread_self(), "scrubber");
  double wait_s = 0;
  while (WaitFor(wait_s)) {
    wait_s = kTryAgain_s;
    const auto last = queue_.GetScrub();
    if (!last.ok()) continue;
    const double now = options_.clock->UnixSeconds();
    if (*last && (*last)->ended_unix_s && now >= (*last)->began_unix_s &&
        now < (*last)->began_unix_s + options_.every_s) {
      const std::lock_guard lock(mu_);
      figures_.pass = **last;
      continue;
    }
    const auto pass = Pass([](const DamagedResult& damaged) {
      LogError("a result in the store is damaged",
               {{"folder", damaged.folder}, {"error", damaged.why}});
    });
    if (pass.ok()) {
      if (pass->files > 0) {
        LogInfo("all results in the store were read",
                {{"files", pass->files}, {"bytes", pass->bytes}, {"damaged", pass->damaged}});
      }
    } else if (!absl::IsCancelled(pass.status())) {
      LogWarning("the store is not read to its end; tried again",
                 {{"error", pass.status()}, {"seconds", kTryAgain_s}});
    }
  }
}

absl::StatusOr<ScrubState> Scrubber::Pass(const std::function<void(const DamagedResult&)>& found) {
  ASSIGN_OR_RETURN(const std::optional<ScrubState> last, queue_.GetScrub());
  ScrubState pass;
  // Damage that was only told of before is found again, to be repaired.
  if (last && !last->ended_unix_s && !(options_.repair && last->damaged > 0)) {
    pass = *last;
  } else {
    pass.began_unix_s = options_.clock->UnixSeconds();
  }
  int unreadable = 0;
  while (true) {
    ASSIGN_OR_RETURN(const std::vector<StoredOutput> outputs,
                     queue_.ListStoredOutputs(pass.position, kResultsAtOnce));
    ASSIGN_OR_RETURN(const std::vector<DamagedResult> damaged, DamagedOf(outputs, unreadable));
    for (const StoredOutput& output : outputs) {
      pass.files += static_cast<int64_t>(output.files.size());
      for (const JobKind::OutputFile& file : output.files) pass.bytes += file.size;
      pass.position.assign(output.key.begin(), output.key.end());
    }
    // The disk may have gone meanwhile, and its files with it.
    RETURN_IF_ERROR(store_.CheckMarker());
    pass.damaged += static_cast<int64_t>(damaged.size());
    for (const DamagedResult& result : damaged) found(result);
    RETURN_IF_ERROR(TakeBack(damaged));
    if (outputs.empty()) pass.ended_unix_s = options_.clock->UnixSeconds();
    RETURN_IF_ERROR(queue_.KeepScrub(pass));
    {
      const std::lock_guard lock(mu_);
      figures_.pass = pass;
      figures_.damaged += static_cast<int64_t>(damaged.size());
    }
    if (outputs.empty()) return pass;
  }
}

absl::StatusOr<std::vector<DamagedResult>> Scrubber::DamagedOf(
    const std::vector<StoredOutput>& outputs, int& unreadable) {
  std::vector<DamagedResult> damaged;
  const auto add = [&damaged](const StoredOutput& output, std::string why) {
    if (!why.empty()) damaged.push_back({output.key, output.folder, std::move(why)});
  };
  std::vector<const StoredOutput*> again;
  for (const StoredOutput& output : outputs) {
    absl::StatusOr<std::string> why = WhyDamaged(output);
    if (absl::IsCancelled(why.status())) return why.status();
    unreadable = why.ok() ? 0 : unreadable + 1;
    if (unreadable >= kUnreadableInARow) return why.status();
    if (why.ok()) {
      add(output, *std::move(why));
    } else {
      again.push_back(&output);
    }
  }
  // While the store is away, a second look tells nothing.
  if (!again.empty()) RETURN_IF_ERROR(store_.CheckMarker());
  for (const StoredOutput* output : again) {
    absl::StatusOr<std::string> why = WhyDamaged(*output);
    if (absl::IsCancelled(why.status())) return why.status();
    add(*output, why.ok() ? *std::move(why) : std::string(ToStd(why.status().message())));
  }
  return damaged;
}

absl::Status Scrubber::TakeBack(const std::vector<DamagedResult>& damaged) {
  if (damaged.empty() || !options_.repair) return absl::OkStatus();
  ASSIGN_OR_RETURN(const TakenBack taken, queue_.TakeBack(damaged, "coordinator"));
  LogWarning("damaged results are made again",
             {{"results", taken.results}, {"pairs", taken.pairs}, {"jobs", taken.jobs}});
  const std::lock_guard lock(mu_);
  figures_.pairs_taken_back += taken.pairs;
  return absl::OkStatus();
}

absl::StatusOr<std::string> Scrubber::WhyDamaged(const StoredOutput& output) {
  for (const JobKind::OutputFile& file : output.files) {
    ASSIGN_OR_RETURN(std::string why, WhyDamagedFile(file));
    const std::lock_guard lock(mu_);
    ++figures_.files;
    if (!why.empty()) return why;
  }
  return std::string();
}

absl::StatusOr<std::string> Scrubber::WhyDamagedFile(const JobKind::OutputFile& file) {
  Sha256 hash;
  int64_t size = 0;
  while (true) {
    const absl::StatusOr<std::string> piece = store_.GetPiece(file.path, size, kPieceBytes);
    if (absl::IsNotFound(piece.status())) return file.path + ": is not in the store";
    if (!piece.ok()) {
      return Unavailable("{}: can't be read: {}", file.path, ToStd(piece.status().message()));
    }
    hash.Update(*piece);
    size += static_cast<int64_t>(piece->size());
    {
      const std::lock_guard lock(mu_);
      figures_.bytes += static_cast<int64_t>(piece->size());
    }
    const double pause_s =
        options_.bytes_per_s > 0 ? static_cast<double>(piece->size()) / options_.bytes_per_s : 0;
    if (!WaitFor(pause_s)) return Cancelled("the scrubber ends");
    if (piece->size() < kPieceBytes || size > file.size) break;
  }
  if (size != file.size) {
    return fmt::format("{}: has {} bytes, not {}", file.path, size, file.size);
  }
  if (HexOf(hash.Finish()) != file.sha256) {
    return file.path + ": its content is not what it was (SHA-256)";
  }
  return std::string();
}

}  // namespace parallax
