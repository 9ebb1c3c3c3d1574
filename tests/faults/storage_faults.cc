// Experiments 2 and 6, and their controls: faults of the coordinator's process and of its disk,
// seen from its clients. The database is small and in a child process.
#include <signal.h>
#include <sys/mman.h>

#include <array>
#include <filesystem>

#include "tests/faults/life.h"
#include "tests/faults/power_cut_vfs.h"

namespace parallax::faults {
namespace {

constexpr int kSampledPoints = 45;  // Points of a round that isn't full.
constexpr int kMostSteps = 512;     // Steps of a command; more count as the last.

// A value that a child hands to its parent.
template <typename T>
class Shared {
 public:
  Shared()
      : value_(static_cast<T*>(
            mmap(nullptr, sizeof(T), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0))) {
    if (value_ == MAP_FAILED) std::abort();
    new (value_) T();
  }
  ~Shared() { munmap(value_, sizeof(T)); }
  T& operator*() { return *value_; }

 private:
  T* value_;
};

LifeOptions SmallLife(const std::string& folder, FakeClock& clock) {
  LifeOptions life;
  life.clock = &clock;
  life.queue.db_path = folder + "/queue.db";
  life.queue.clock = &clock;
  life.queue.lease_s = 30;
  life.queue.own_timer = false;
  life.queue.linger_s = 0;
  life.queue.scenes_ahead = 4;
  life.queue.checkpoint_pages = 40;
  life.queue.readers = 1;
  life.queue.notice_targets = {"webhook"};
  return life;
}

void Sabotage(const ExperimentOptions& options, JobQueueOptions& queue) {
  queue.unsafe_for_test.synchronous_off = options.sabotage == "synchronous-off";
  queue.unsafe_for_test.ignore_fences = options.sabotage == "no-fence-check";
  queue.unsafe_for_test.keep_epoch = options.sabotage == "no-epoch-bump";
}

// A life that ends at a fault, what must be true after it, and the work's end. False when it came
// to its end without: what the writer groups depends on the moment, so a life may have a few hits
// less than the one before.
bool OneDeath(const LifeOptions& life, FakeClock& clock, const Rng& rng, Tally& tally,
              const std::string& what) {
  AckLog acks;
  const int end = InChild([&] { Live(life, rng, acks); });
  SetVfsPlan({});  // It was for the child.
  if (end == 0) return false;
  if (end != 128 + SIGKILL) tally.Lost(what + ": the child ended with " + std::to_string(end));
  ++tally.faults;
  clock.Advance(1);
  Witness witness(life, tally);
  witness.Verify(acks);
  witness.Finish();
  return true;
}

struct Point {
  std::string command;
  int step;
  int hit;
};
using Hits = std::array<std::array<uint32_t, kMostSteps>, kFailPointCommands.size()>;

size_t IndexOf(const std::string& command) {
  return static_cast<size_t>(
      std::find(kFailPointCommands.begin(), kFailPointCommands.end(), command) -
      kFailPointCommands.begin());
}

// Lives once in peace: every point that the program has, each at a random one of its hits.
std::vector<Point> PointsOf(const LifeOptions& life, const Rng& rng, Rng choice, Tally& tally) {
  Shared<Hits> hits;
  LifeOptions peaceful = life;
  peaceful.queue.fail_point = [&](const std::string& command, int step) {
    ++(*hits)[IndexOf(command)][static_cast<size_t>(std::min(step, kMostSteps - 1))];
    return absl::OkStatus();
  };
  AckLog acks;
  const int end = InChild([&] { Live(peaceful, rng, acks); });
  if (end != 0) tally.Lost("a life in peace ended with " + std::to_string(end));
  std::vector<Point> points;
  for (size_t command = 0; command < kFailPointCommands.size(); ++command) {
    for (size_t step = 0; step < kMostSteps; ++step) {
      const auto n = static_cast<int>((*hits)[command][step]);
      if (n == 0) continue;
      points.push_back(
          {kFailPointCommands[command], static_cast<int>(step), choice.UniformInt(1, n)});
    }
  }
  return points;
}

template <typename T>
void Thin(std::vector<T>& points, const ExperimentOptions& options, Rng& choice) {
  if (options.full || points.size() <= kSampledPoints) return;
  choice.Shuffle(points);
  points.erase(points.begin() + kSampledPoints, points.end());
}

}  // namespace

void FailPoints(const ExperimentOptions& options, Tally& tally) {
  std::set<std::string> commands;
  std::set<std::pair<std::string, int>> points_seen;
  for (int round = 0; round < options.rounds; ++round) {
    Rng choice = RoundRng(options, "fail-points", round);
    const Rng rng = choice.Child("life");
    const auto life_in = [&](const std::string& folder, FakeClock& clock) {
      LifeOptions life = SmallLife(folder, clock);
      life.steps = 120;
      life.rare_commands = true;
      return life;
    };
    std::vector<Point> points;
    {
      const TempFolder folder(true);
      FakeClock clock;
      points = PointsOf(life_in(folder.path(), clock), rng, choice.Child("hits"), tally);
    }
    for (const Point& point : points) commands.insert(point.command);
    Thin(points, options, choice);
    for (const Point& point : points) {
      points_seen.insert({point.command, point.step});
      const auto die_at = [&](int hit) {
        const TempFolder folder(true);
        FakeClock clock;
        LifeOptions life = life_in(folder.path(), clock);
        auto left = std::make_shared<int>(hit);
        life.queue.fail_point = [=](const std::string& command, int step) {
          if (command == point.command && std::min(step, kMostSteps - 1) == point.step &&
              --*left == 0) {
            raise(SIGKILL);
          }
          return absl::OkStatus();
        };
        return OneDeath(life, clock, rng, tally,
                        point.command + ":" + std::to_string(point.step) + ":" +
                            std::to_string(hit) + " in round " + std::to_string(round));
      };
      if (!die_at(point.hit) && !die_at(1)) {
        tally.Lost(point.command + ":" + std::to_string(point.step) + " was not reached again");
      }
    }
    ++tally.rounds;
  }
  for (const char* command : kFailPointCommands) {
    if (commands.count(command) == 0) {
      tally.Lost(std::string("no round reached a fail point of '") + command + "'");
    }
  }
  tally.figures["commands"] = static_cast<double>(commands.size());
  tally.figures["points"] = static_cast<double>(points_seen.size());
}

void FilePoints(const ExperimentOptions& options, Tally& tally) {
  RegisterPowerCutVfs();
  double operations_seen = 0;
  double missed = 0;
  for (int round = 0; round < options.rounds; ++round) {
    Rng choice = RoundRng(options, "file-points", round);
    const Rng rng = choice.Child("life");
    Shared<int64_t> operations;
    {
      const TempFolder folder(true);
      FakeClock clock;
      LifeOptions life = SmallLife(folder.path(), clock);
      life.queue.vfs = kPowerCutVfs;
      AckLog acks;
      InChild([&] {
        SetVfsPlan({});
        Live(life, rng, acks);
        *operations = VfsOperations();
      });
    }
    operations_seen += static_cast<double>(*operations);
    std::vector<int64_t> points;
    for (int64_t at = 1; at <= *operations; ++at) points.push_back(at);
    Thin(points, options, choice);
    for (const int64_t at : points) {
      const TempFolder folder(true);
      FakeClock clock;
      LifeOptions life = SmallLife(folder.path(), clock);
      life.queue.vfs = kPowerCutVfs;
      SetVfsPlan({.die_at = at});
      if (!OneDeath(life, clock, rng, tally, "file operation " + std::to_string(at))) ++missed;
    }
    ++tally.rounds;
  }
  tally.figures["file_operations"] = operations_seen;
  tally.figures["missed"] = missed;
  if (missed > operations_seen / 50) tally.Lost("too many operations were not reached again");
}

void PowerCut(const ExperimentOptions& options, Tally& tally) {
  RegisterPowerCutVfs();
  for (int round = 0; round < options.rounds; ++round) {
    Rng choice = RoundRng(options, "power-cut", round);
    const TempFolder folder(true);
    FakeClock clock;
    LifeOptions life = SmallLife(folder.path(), clock);
    life.queue.vfs = kPowerCutVfs;
    life.queue.linger_s = 0.0005;
    life.queue.scenes_ahead = 16;
    life.clients = 3;
    life.steps = 60;
    Sabotage(options, life.queue);
    Witness witness(life, tally);
    const int cuts = choice.UniformInt(1, 4);
    for (int cut = 0; cut < cuts; ++cut) {
      SetVfsPlan(
          {.die_at = choice.UniformInt(1, 900), .lose_unsynced = true, .seed = choice.Bits64()});
      AckLog acks;
      const int end =
          InChild([&] { Live(life, choice.Child("life", static_cast<uint64_t>(cut)), acks); });
      SetVfsPlan({});
      if (end == 128 + SIGKILL) {
        ++tally.faults;
      } else if (end != 0) {
        tally.Lost("round " + std::to_string(round) + ": the child ended with " +
                   std::to_string(end));
      }
      // Half of the machines come back within the same second.
      if (choice.Bernoulli(0.5)) clock.Advance(1000);
      witness.Verify(acks);
    }
    witness.Finish();
    ++tally.rounds;
  }
}

}  // namespace parallax::faults
