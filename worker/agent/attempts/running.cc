#include "worker/agent/attempts/running.h"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "common/base/system/log_capture.h"
#include "worker/agent/attempts/failure.h"

namespace parallax {
namespace {

constexpr size_t kMostLiveLogBytes = 2048;

// The end of a running attempt's log.
std::string LiveLogOf(const RunningAttempt& run) {
  std::string text = run.log == nullptr ? "" : run.log->Text();
  if (!run.program_log.empty()) {
    std::ifstream file(run.program_log, std::ios::binary | std::ios::ate);
    const std::streamoff size = file.tellg();
    if (size > 0) {
      file.seekg(std::max<std::streamoff>(0, size - std::streamoff{kMostLiveLogBytes}));
      text.assign(std::istreambuf_iterator<char>(file), {});
    }
  }
  // A progress bar draws over its line again and again.
  std::replace(text.begin(), text.end(), '\r', '\n');
  return EndOfLog(text, kMostLiveLogBytes);
}

}  // namespace

std::vector<v1::Progress> ProgressOf(const std::vector<RunningAttempt>& running,
                                     const std::vector<v1::AttemptId>& unanswered) {
  std::vector<v1::Progress> held;
  for (const RunningAttempt& run : running) {
    if (run.stop != StopCause::kNone) continue;
    v1::Progress& progress = held.emplace_back();
    *progress.mutable_attempt() = run.attempt;
    progress.set_fraction(run.fraction);
    progress.set_stage(run.stage);
    progress.mutable_figures()->insert(run.figures.begin(), run.figures.end());
    progress.set_log_tail(LiveLogOf(run));
  }
  for (const v1::AttemptId& attempt : unanswered) {
    v1::Progress& progress = held.emplace_back();
    *progress.mutable_attempt() = attempt;
    progress.set_fraction(1);
    progress.set_stage("report");
  }
  return held;
}

bool HasWorkUnderLease(const std::vector<RunningAttempt>& running) {
  return std::any_of(running.begin(), running.end(),
                     [](const auto& run) { return run.stop == StopCause::kNone; });
}

int CountEndingSoon(const std::vector<RunningAttempt>& running, double seconds) {
  return static_cast<int>(std::count_if(
      running.begin(), running.end(), [&](const auto& run) { return run.remaining_s <= seconds; }));
}

std::optional<double> SecondsToHang(const std::vector<RunningAttempt>& running, double hang_s) {
  std::optional<double> seconds;
  for (const RunningAttempt& run : running) {
    if (run.stop != StopCause::kNone) continue;
    seconds = std::min(seconds.value_or(hang_s), hang_s - run.idle_s);
  }
  return seconds;
}

int CountHung(const std::vector<RunningAttempt>& running) {
  return static_cast<int>(std::count_if(running.begin(), running.end(), [](const auto& run) {
    return run.stop == StopCause::kHung;
  }));
}

}  // namespace parallax
