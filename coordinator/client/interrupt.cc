#include "coordinator/client/interrupt.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>

namespace parallax::client {
namespace {

// A handler may only touch these: lock-free, and a pipe that wakes up the wait.
std::atomic<int> signals{0};
int wake_pipe[2] = {-1, -1};
struct sigaction previous[3];
constexpr int kSignals[3] = {SIGINT, SIGTERM, SIGPIPE};

void OnSignal(int) {
  const int saved = errno;
  signals.fetch_add(1);
  [[maybe_unused]] const ssize_t written = write(wake_pipe[1], "!", 1);
  errno = saved;
}

}  // namespace

InterruptScope::InterruptScope() {
  signals = 0;
  if (pipe2(wake_pipe, O_CLOEXEC | O_NONBLOCK) != 0) wake_pipe[0] = wake_pipe[1] = -1;
  struct sigaction action {};
  sigemptyset(&action.sa_mask);
  for (int i = 0; i < 3; ++i) {
    action.sa_handler = kSignals[i] == SIGPIPE ? SIG_IGN : OnSignal;
    sigaction(kSignals[i], &action, &previous[i]);
  }
}

InterruptScope::~InterruptScope() {
  for (int i = 0; i < 3; ++i) sigaction(kSignals[i], &previous[i], nullptr);
  close(wake_pipe[0]);
  close(wake_pipe[1]);
}

int InterruptScope::count() const { return signals.load(); }

bool InterruptScope::WaitFor(std::chrono::duration<double> time) {
  const auto deadline = std::chrono::steady_clock::now() + time;
  while (count() == answered_) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        deadline - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    pollfd readable{wake_pipe[0], POLLIN, 0};
    poll(&readable, 1, static_cast<int>(left.count()) + 1);
    char drained[16];
    while (read(wake_pipe[0], drained, sizeof drained) > 0) {
    }
  }
  answered_ = count();
  return true;
}

}  // namespace parallax::client
