#include "coordinator/process_limits.h"

#include <sys/resource.h>

#include <algorithm>
#include <cerrno>
#include <latch>
#include <system_error>
#include <thread>
#include <vector>

namespace parallax {
namespace {

// More are not asked for: a worker has one connection, so this is for some 60,000.
constexpr rlim_t kEnough = 65'536;
constexpr size_t kLeast = 64;
// The process itself has some 30; each file that comes or goes has up to two for a moment.
constexpr size_t kLeastFiles = 40, kMostFiles = 512;
constexpr size_t kLeastHttp = 8, kMostHttp = 512;

// 55 at rest and gRPC's for each core; with calls there are more.
constexpr size_t kThreads = 72, kThreadsACore = 4;

// Strangers have half of a small port and few places of a large one. A stranger that has to leave
// counts until it is closed, so they have room twice.
ListenerLimits LimitsFor(size_t connections) {
  ListenerLimits limits;
  limits.strangers = std::clamp<size_t>(connections / 4, 2, 256);
  limits.strangers_an_address = std::max<size_t>(1, limits.strangers / 2);
  limits.known = connections - 2 * limits.strangers;
  limits.known_an_address = limits.known - limits.known / 4;
  return limits;
}

}  // namespace

absl::StatusOr<DescriptorBudget> SplitDescriptors(size_t descriptors) {
  if (descriptors < kLeast) {
    return ResourceExhausted(
        "the process may have {} open files and connections, and needs {} (`ulimit -n`, "
        "LimitNOFILE of a unit)",
        descriptors, kLeast);
  }
  DescriptorBudget budget{.descriptors = descriptors};
  const size_t files = std::clamp(descriptors / 4, kLeastFiles, kMostFiles);
  const size_t http = std::clamp(descriptors / 8, kLeastHttp, kMostHttp);
  budget.http = LimitsFor(http);
  budget.rpc = LimitsFor(descriptors - files - http);
  return budget;
}

absl::Status CheckThreads() {
  const size_t wanted = kThreads + kThreadsACore * std::thread::hardware_concurrency();
  std::latch end(1);
  std::vector<std::thread> threads;
  try {
    while (threads.size() < wanted) threads.emplace_back([&end] { end.wait(); });
  } catch (const std::system_error&) {  // These are all that there are.
  }
  end.count_down();
  for (std::thread& thread : threads) thread.join();
  if (threads.size() == wanted) return absl::OkStatus();
  return ResourceExhausted(
      "{} threads are needed, and only {} can be made (`ulimit -u`, TasksMax of a unit, the pids "
      "limit of a container)",
      wanted, threads.size());
}

absl::StatusOr<DescriptorBudget> RaiseDescriptors() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return ErrnoError(errno, "limit of open files");
  const rlim_t wanted = std::min(limit.rlim_max, std::max(limit.rlim_cur, kEnough));
  if (wanted > limit.rlim_cur) {
    limit.rlim_cur = wanted;
    if (setrlimit(RLIMIT_NOFILE, &limit) != 0) return ErrnoError(errno, "limit of open files");
  }
  return SplitDescriptors(static_cast<size_t>(std::min(limit.rlim_cur, kEnough)));
}

}  // namespace parallax
