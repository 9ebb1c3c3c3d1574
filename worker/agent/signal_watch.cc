#include "worker/agent/signal_watch.h"

#include <poll.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>

namespace parallax {

SignalWatch::SignalWatch(Handlers handlers) : handlers_(std::move(handlers)) {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGUSR1);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  signal(SIGPIPE, SIG_IGN);
  stop_ = eventfd(0, EFD_CLOEXEC);
  const int signals = signalfd(-1, &set, SFD_CLOEXEC);
  // poll skips a descriptor of -1 (an old kernel, or a parent that is gone already).
  const int parent = handlers_.on_orphaned == nullptr
                         ? -1
                         : static_cast<int>(syscall(SYS_pidfd_open, getppid(), 0));
  thread_ = std::thread([this, signals, parent] { Loop(signals, parent); });
}

SignalWatch::~SignalWatch() {
  const uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = write(stop_, &one, sizeof one);
  thread_.join();
  close(stop_);
}

void SignalWatch::Loop(int signals, int parent) const {
  int count = 0;
  pollfd watched[] = {{stop_, POLLIN, 0}, {signals, POLLIN, 0}, {parent, POLLIN, 0}};
  while (poll(watched, 3, -1) >= 0 || errno == EINTR) {
    if (watched[0].revents != 0) break;
    if (watched[1].revents != 0) {
      signalfd_siginfo info;
      if (read(signals, &info, sizeof info) != sizeof info) continue;
      if (info.ssi_signo != SIGUSR1) {
        handlers_.on_signal(++count);
      } else if (handlers_.on_long_drain != nullptr) {
        handlers_.on_long_drain();
      }
    }
    if (watched[2].revents != 0) {
      watched[2].fd = -1;
      handlers_.on_orphaned();
    }
  }
  close(signals);
  if (parent >= 0) close(parent);
}

}  // namespace parallax
