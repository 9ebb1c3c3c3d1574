// The experiments `simulate` and `simulate-controls`: many runs of the simulated farm, each from
// its own seed.
#include <fmt/core.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <ctime>
#include <fstream>
#include <iostream>
#include <new>
#include <thread>

#include "common/base/system/clock.h"
#include "common/base/system/log.h"
#include "tests/faults/experiment.h"
#include "tests/faults/simulate/simulation.h"

namespace parallax::faults {
namespace {

constexpr uint64_t kSeedsForControls = 200;
constexpr size_t kKeptSeedsToRunTwice = 5;
constexpr int64_t kSeedsForAllPoints = 1500;
constexpr int kFoundSomething = 3;  // Exit status of a child.
constexpr unsigned kMostChildren = 64;
constexpr time_t kMostCpu_s = 120;  // A run that takes more hangs.

struct NamedMutation {
  const char* name;
  Mutation mutation;
};
const NamedMutation kMutations[] = {
    {"no-fence-check", {.queue = {.ignore_fences = true}}},
    {"no-epoch-bump", {.queue = {.keep_epoch = true}}},
    {"synchronous-off", {.queue = {.synchronous_off = true}}},
    {"keep-waiters", {.queue = {.keep_waiters = true}}},
    {"adopt-nothing", {.queue = {.adopt_nothing = true}}},
    {"expire-early", {.queue = {.expire_early = true}}},
    {"ignore-limits", {.queue = {.ignore_limits = true}}},
    {"keep-generation", {.queue = {.keep_generation = true}}},
    {"forget-unfinished", {.queue = {.forget_unfinished = true}}},
    {"archive-newest", {.queue = {.archive_newest = true}}},
    {"hear-at-start", {.queue = {.hear_at_start = true}}},
    {"any-version", {.queue = {.any_version = true}}},
    {"any-worker", {.any_worker = true}},
    {"no-acknowledging", {.no_acknowledging = true}},
    {"sizes-only", {.sizes_only = true}},
    {"no-outbox", {.no_outbox = true}},
    {"send-once", {.send_once = true}},
    {"remove-early", {.remove_early = true}},
};

double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// The totals of all children, in memory that they share.
struct Totals {
  std::atomic<uint64_t> next{0};  // Index of a seed.
  std::atomic<int64_t> seeds{0}, events{0}, jobs{0}, stale{0}, starts{0}, refused{0};
  std::atomic<double> virtual_s{0}, cpu_s{0};
  std::atomic<int64_t> failed{0};
  std::atomic<uint64_t> first_failed{0};
  std::atomic<uint64_t> current[kMostChildren] = {};  // The seed of each child.
  std::atomic<uint64_t> seen[kFailPointCommands.size()] = {};
  std::atomic<uint64_t> died[kFailPointCommands.size()] = {};
};

class SharedTotals {
 public:
  SharedTotals()
      : totals_(static_cast<Totals*>(mmap(nullptr, sizeof(Totals), PROT_READ | PROT_WRITE,
                                          MAP_SHARED | MAP_ANONYMOUS, -1, 0))) {
    if (totals_ == MAP_FAILED) std::abort();
    new (totals_) Totals();
  }
  ~SharedTotals() { munmap(totals_, sizeof(Totals)); }
  Totals* operator->() { return totals_; }
  Totals& operator*() { return *totals_; }

 private:
  Totals* totals_;
};

void PrintFailure(uint64_t seed, const std::vector<std::string>& complaints) {
  std::string text = "seed " + std::to_string(seed) + " fails; `faults simulate --seed " +
                     std::to_string(seed) + " --trace` replays it\n";
  for (const std::string& complaint : complaints) text += "  " + complaint + "\n";
  std::cerr << text << std::flush;
}

// Runs one seed. Returns whether nothing was found. `twice`: it must tell the same story again.
bool Count(uint64_t seed, bool twice, Totals& totals) {
  const double before_s = CpuSeconds();
  RunResult result = RunSeed({.seed = seed, .tells = twice});
  if (twice && RunSeed({.seed = seed, .tells = true}).story != result.story) {
    result.complaints.push_back("it tells two stories");
  }
  ++totals.seeds;
  totals.events += result.events;
  totals.jobs += result.jobs;
  totals.stale += result.stale;
  totals.starts += result.starts;
  totals.refused += result.refused ? 1 : 0;
  totals.virtual_s += result.virtual_s;
  totals.cpu_s += CpuSeconds() - before_s;
  for (size_t i = 0; i < kFailPointCommands.size(); ++i) {
    totals.seen[i] |= result.points.seen[i];
    totals.died[i] |= result.points.died[i];
  }
  if (result.complaints.empty()) return true;
  if (totals.failed++ == 0) totals.first_failed = seed;
  PrintFailure(seed, result.complaints);
  return false;
}

// The farm logs the errors that it is meant to have.
void LogNothing() {
  InitLogging({.level = LogLevel::kError, .program = "faults", .file = "/dev/null"});
}

std::vector<uint64_t> KeptSeeds() {
  std::ifstream file(std::string(PARALLAX_FAULTS_DATA) + "/simulate_seeds.txt");
  std::vector<uint64_t> seeds;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty() && line[0] != '#') seeds.push_back(std::stoull(line));
  }
  return seeds;
}

// Runs the kept seeds, then those from `first` to `last`, on all cores.
void RunMany(const std::vector<uint64_t>& kept, uint64_t first, uint64_t last, SharedTotals& totals,
             Tally& tally) {
  std::vector<pid_t> children;
  const unsigned cores = std::clamp(std::thread::hardware_concurrency(), 1u, kMostChildren);
  for (unsigned i = 0; i < cores; ++i) {
    const pid_t pid = fork();
    if (pid != 0) {
      children.push_back(pid);
      continue;
    }
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // A test that is killed leaves nobody behind.
    bool sound = true;
    for (uint64_t index; (index = totals->next++) < kept.size() + (last - first + 1);) {
      const uint64_t seed = index < kept.size() ? kept[index] : first + (index - kept.size());
      totals->current[i] = seed;
      // A run that does not come to its end is a failure, too.
      const itimerval limit{.it_interval = {}, .it_value = {.tv_sec = kMostCpu_s, .tv_usec = 0}};
      setitimer(ITIMER_PROF, &limit, nullptr);
      sound &= Count(seed, /*twice=*/index < std::min(kept.size(), kKeptSeedsToRunTwice), *totals);
    }
    _exit(sound ? 0 : kFoundSomething);
  }
  for (size_t i = 0; i < children.size(); ++i) {
    int status = 0;
    waitpid(children[i], &status, 0);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) continue;
    if (WIFEXITED(status) && WEXITSTATUS(status) == kFoundSomething) continue;
    PrintFailure(totals->current[i], {"its process ended with " + std::to_string(status)});
    tally.Lost("seed " + std::to_string(totals->current[i]) + " ended its process");
  }
  if (totals->failed > 0) {
    tally.Lost(std::to_string(totals->failed) + " seeds fail, the first was " +
               std::to_string(totals->first_failed));
  }
}

// Where lives ended: in many runs, at some step of each command.
void CheckPoints(Totals& totals, Tally& tally) {
  Points points;
  std::copy(std::begin(totals.seen), std::end(totals.seen), points.seen.begin());
  std::copy(std::begin(totals.died), std::end(totals.died), points.died.begin());
  tally.figures["fail_points"] = Points::CountOf(points.seen);
  tally.figures["fail_points_died_at"] = Points::CountOf(points.died);
  for (size_t i = 0; i < kFailPointCommands.size(); ++i) {
    if (totals.seeds < kSeedsForAllPoints || points.died[i] != 0) continue;
    tally.Lost(std::string("no life ended in the command ") + kFailPointCommands[i]);
  }
}

// Returns the first of seeds that are others each minute, and tell when: 2026-11-30 09:07 has
// 202611300907'00000.
uint64_t FirstNewSeed() {
  const std::time_t now = static_cast<std::time_t>(Clock::System().UnixSeconds());
  std::tm utc{};
  gmtime_r(&now, &utc);
  uint64_t seed = static_cast<uint64_t>(utc.tm_year) + 1900;
  for (const int part : {utc.tm_mon + 1, utc.tm_mday, utc.tm_hour, utc.tm_min}) {
    seed = 100 * seed + static_cast<uint64_t>(part);
  }
  return 100'000 * seed;
}

// "5..9", both ends included.
bool ParseRange(const std::string& text, uint64_t* first, uint64_t* last) {
  const size_t dots = text.find("..");
  if (dots == std::string::npos || dots == 0 || dots + 2 == text.size()) return false;
  if (text.find_first_not_of("0123456789.") != std::string::npos) return false;
  *first = std::stoull(text);
  *last = std::stoull(text.substr(dots + 2));
  return *first <= *last;
}

// A page of the database is kept by its writer and its reader; the rest is for caches that fill.
constexpr double kMostGrowth = 1 << 20;
constexpr double kCopiesOfPages = 2;

}  // namespace

void Simulate(const ExperimentOptions& options, Tally& tally) {
  LogNothing();
  uint64_t first = options.seed;
  uint64_t last = options.seed;
  if (!options.seeds.empty() && !ParseRange(options.seeds, &first, &last)) {
    return tally.Lost("--seeds " + options.seeds + ": wanted two numbers, as in 1..1000");
  }
  if (options.trace) {
    for (uint64_t seed = first; seed <= last; ++seed) {
      const RunResult result = RunSeed({.seed = seed, .tells = true});
      std::cout << result.story;
      for (const std::string& complaint : result.complaints) tally.Lost(complaint);
    }
    return;
  }
  std::vector<uint64_t> kept;
  if (options.new_seeds > 0) {
    kept = KeptSeeds();
    first = FirstNewSeed();
    last = first + static_cast<uint64_t>(options.new_seeds) - 1;
    std::cerr << kept.size() << " kept seeds, then --seeds " << first << ".." << last << std::endl;
  }
  SharedTotals totals;
  RunMany(kept, first, last, totals, tally);
  CheckPoints(*totals, tally);
  tally.rounds = totals->seeds;
  tally.jobs = totals->jobs;
  tally.faults = totals->starts - totals->seeds;
  tally.figures["events"] = static_cast<double>(totals->events);
  tally.figures["stale_reports"] = static_cast<double>(totals->stale);
  tally.figures["refused"] = static_cast<double>(totals->refused);
  tally.figures["virtual_s"] = totals->virtual_s;
  tally.figures["cpu_s"] = totals->cpu_s;
  tally.figures["virtual_s_per_cpu_s"] = totals->virtual_s / std::max(1e-9, totals->cpu_s.load());
}

void SimulateControls(const ExperimentOptions& options, Tally& tally) {
  LogNothing();
  for (const NamedMutation& named : kMutations) {
    if (!options.guard.empty() && options.guard != named.name) continue;
    std::vector<uint64_t> needed;
    for (int round = 0; round < options.rounds; ++round) {
      const uint64_t first = options.seed + static_cast<uint64_t>(round) * kSeedsForControls;
      uint64_t tried = 0;
      std::vector<std::string> found;
      while (found.empty() && tried < kSeedsForControls) {
        found = RunSeed({.seed = first + tried++, .mutation = named.mutation}).complaints;
      }
      if (found.empty()) tally.Lost(std::string(named.name) + " is not found within 200 seeds");
      std::cerr << named.name << ": " << tried
                << " seeds: " << (found.empty() ? "nothing" : found.front()) << std::endl;
      needed.push_back(tried);
      ++tally.rounds;
    }
    std::sort(needed.begin(), needed.end());
    tally.figures[std::string("median_seeds ") + named.name] =
        static_cast<double>(needed[needed.size() / 2]);
  }
}

void SimulateGrowth(const ExperimentOptions& options, Tally& tally) {
  LogNothing();
  for (int round = 0; round < options.rounds; ++round) {
    const uint64_t seed = options.seed + static_cast<uint64_t>(round);
    const RunResult result = RunSeed({.seed = seed, .events = options.events});
    for (const std::string& complaint : result.complaints) tally.Lost(complaint);
    const double bound = kMostGrowth + kCopiesOfPages * result.database_bytes;
    const std::string what = fmt::format(
        "seed {}: {} events, {} jobs, {:.0f} days, database of {:.0f} kB: memory grew by {:.0f} kB",
        seed, result.events, result.jobs, result.virtual_s / 86400, result.database_bytes / 1e3,
        result.grown_bytes / 1e3);
    std::cerr << what << std::endl;
    if (result.grown_bytes > bound)
      tally.Lost(fmt::format("{}; allowed are {:.0f} kB", what, bound / 1e3));
    ++tally.rounds;
    tally.jobs += result.jobs;
    tally.figures["events"] += static_cast<double>(result.events);
    tally.figures["grown_kb"] = std::max(tally.figures["grown_kb"], result.grown_bytes / 1e3);
  }
}

}  // namespace parallax::faults
