// Experiment 6 outside of the database: kill -9 of a daemon before each of its operations on
// outputs, outbox and store, and in the midst of each write. For half of the deaths the machine
// loses its power too: what was not synced by then is there in part or not at all.
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "tests/faults/farm.h"

namespace parallax::faults {
namespace {

namespace fs = std::filesystem;

constexpr int kSampledPoints = 4;  // Points of a case, in a round that isn't full.

// Small, but all of it is made as in any study.
constexpr char kStudy[] = R"(study: points
seed: 5
pairs: %d
rigs_per_scene: %d
variants:
  - name: v
    set:
      floating: {count: 1}
      furniture: {enabled: false}
      rigs: {count: %d, width_px: 32, height_px: 18}
      render: {profile: preview, denoise: "off"}
)";

struct Case {
  const char* name;
  bool coordinator;   // It dies; otherwise a worker.
  bool real_worker;   // The program `worker`, with its own frames.
  bool stream;        // Files go through the coordinator.
  const char* under;  // Part of the farm's folder whose operations are counted.
  bool heir = false;  // Another worker was killed before it, in the midst of the job.
};
constexpr Case kCases[] = {
    {"a worker that writes into the store", false, true, false, ""},
    {"a worker that sends its files", false, false, true, "/outbox"},
    {"a coordinator that takes files", true, false, true, "/store"},
    {"a worker that goes on from another's pairs", false, true, false, "", true},
};

// Follows the logged operations that have not reached the disk.
class Disk {
 public:
  explicit Disk(std::string root) : root_(std::move(root)) {}

  // "" or what is wrong with this operation at this moment.
  std::string Do(const std::string& line) {
    std::istringstream words(line);
    std::string operation, path, to;
    words >> operation >> path >> to;
    ++operations_;
    if (operation == "failed") return "";
    if (operation == "link") {
      entries_.try_emplace(path);  // Its bytes are those of a file that is on disk.
    } else if (operation == "create") {
      entries_.try_emplace(path);
      dirty_.insert(path);
    } else if (operation == "write") {
      dirty_.insert(path);
    } else if (operation == "mkdir") {
      entries_.try_emplace(path);
      if (fs::path(path).filename().string().rfind(".attempt-", 0) == 0) attempts_.insert(path);
    } else if (operation == "sync") {
      dirty_.erase(path);
      std::erase_if(entries_, [&](const auto& entry) { return Parent(entry.first) == path; });
    } else if (operation == "remove") {
      entries_.erase(path);
      dirty_.erase(path);
    } else if (operation == "rename") {
      std::string wrong;
      if (dirty_.count(path) != 0) wrong = to + " is renamed before its bytes are on disk";
      if (wrong.empty()) wrong = NotDurableBefore(to);
      entries_.erase(path);
      entries_[to] = path;
      dirty_.erase(path);
      return wrong;
    }
    return "";
  }

  // The power goes: of what is not on disk, any part is there or not.
  void LosePower(Rng& rng) const {
    for (const std::string& path : dirty_) {
      struct stat facts;
      if (stat(path.c_str(), &facts) != 0 || !S_ISREG(facts.st_mode)) continue;
      const off_t size = static_cast<off_t>(rng.Uniform() * static_cast<double>(facts.st_size));
      if (truncate(path.c_str(), size) != 0) std::perror(path.c_str());
    }
    // The deepest first.
    for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) {
      if (rng.Bernoulli(0.5)) continue;
      std::error_code ignored;
      if (entry->second.empty()) {
        fs::remove_all(entry->first, ignored);
      } else {
        fs::rename(entry->first, entry->second, ignored);
      }
    }
  }
  int64_t operations() const { return operations_; }

 private:
  static std::string Parent(const std::string& path) { return fs::path(path).parent_path(); }

  // A report says that the work is done: all of its attempt must be on disk, and the way to it.
  std::string NotDurableBefore(const std::string& report) const {
    if (fs::path(report).extension() != ".complete") return "";
    const std::string name = fs::path(report).stem();  // <coordinator>-<job>-<fence>
    const std::string folder = "/.attempt-" + name.substr(name.rfind('-') + 1);
    const auto is_part = [&](const std::string& path) {
      const size_t at = (path + "/").find(folder + "/");
      return at != std::string::npos;
    };
    for (const std::string& path : dirty_) {
      if (is_part(path)) return "reported before the bytes are on disk: " + path;
    }
    for (const auto& [path, from] : entries_) {
      if (is_part(path)) return "reported before its name is on disk: " + path;
    }
    for (const std::string& attempt : attempts_) {
      if (is_part(attempt) && !NotDurableAbove(attempt).empty()) return NotDurableAbove(attempt);
    }
    return NotDurableAbove(report);
  }
  std::string NotDurableAbove(const std::string& path) const {
    for (std::string above = Parent(path); above.size() > root_.size(); above = Parent(above)) {
      if (entries_.count(above) != 0) return "reported before the way to it is on disk: " + above;
    }
    return "";
  }

  const std::string root_;
  std::map<std::string, std::string> entries_;  // Not synced; a renamed one with its old name.
  std::set<std::string> dirty_;                 // Files with bytes that are not synced.
  std::set<std::string> attempts_;
  int64_t operations_ = 0;
};

using Files =
    std::map<std::tuple<std::string, uint32_t, uint32_t>, std::map<std::string, std::string>>;

struct Death {
  int64_t at = 0;  // The operation that is not done; 0: it lives.
  bool power_cut = false;
};

struct Outcome {
  bool died = false;
  int64_t operations = 0;
  Files files;
};

// One study, and a death in it.
class Life {
 public:
  Life(const Case& what, const Death& death, Rng rng, Tally& tally)
      : what_(what),
        death_(death),
        rng_(rng),
        tally_(tally),
        where_(std::string(what.name) + ", operation " + std::to_string(death.at) +
               (death.power_cut ? " with a power cut" : "")),
        farm_({.lease_s = 5,
               .reconnect_s = 0.2,
               .coordinator_arguments = {"--store-access", what.stream ? "stream" : "direct"}}),
        disk_(farm_.folder()) {}

  Outcome Run() {
    const std::vector<std::string> shim = {
        "LD_PRELOAD=" PARALLAX_FILE_POINT_SHIM,
        "PARALLAX_FILE_POINT_UNDER=" + farm_.folder() + what_.under,
        "PARALLAX_FILE_POINT_LOG=" + logs_.path() + "/log",
        "PARALLAX_FILE_POINT_DIE=" + std::to_string(death_.at),
    };
    const std::vector<std::string> none;
    farm_.StartCoordinator(what_.coordinator ? shim : none);
    const int64_t study = what_.real_worker ? farm_.SubmitFile(StudyOf(pairs_))
                                            : farm_.Submit({.pairs = 2, .rigs_per_scene = 2});
    if (what_.heir) KillInTheMidst();
    auto worker = StartWorker("first", what_.coordinator ? none : shim);
    if (what_.coordinator) {
      // All that it writes into the store lies between the worker's start and the study's end.
      outcome_.died = farm_.starts() > 1;  // While it made the store.
      if (outcome_.died) {
        ++tally_.faults;
      } else if (WaitForDeath(farm_.coordinator(), worker.get())) {
        AfterDeath(farm_.coordinator());
        farm_.StartCoordinator();
      }
    } else {
      const auto over = [&](const v1::StudyStatus& status) {
        return status.state() == v1::STUDY_STATE_SUCCEEDED || !worker->Running();
      };
      if (!farm_.WaitFor(study, over)) tally_.Lost(where_ + ": the study does not end");
      // The worker may still die while it ends.
      if (worker->Running()) worker->Signal(SIGTERM);
      const int end = worker->Wait(Process::Seconds(30));
      if (end == 128 + SIGKILL) {
        AfterDeath(*worker);
      } else if (end != 0) {
        tally_.Lost(where_ + ": the worker ended with " + std::to_string(end));
      }
      worker = StartWorker("second", none);
    }
    if (!farm_.WaitForEnd(study)) tally_.Lost(where_ + ": the study does not end");
    // Not before it is there: a signal then would be its end.
    const auto begin = std::chrono::steady_clock::now();
    while (CountOf(worker->Err(), "connected") == 0 && SecondsSince(begin) < 30) Sleep(0.005);
    Drain(*worker, tally_);
    if (!outcome_.died) ReadLog();
    farm_.CheckPairs(study, static_cast<size_t>(pairs_), tally_);
    for (const auto& [key, frame] : farm_.Frames(study, tally_)) {
      outcome_.files[key] = frame.sha256;
      outcome_.files[key].erase("frame.json");  // Tells how long it took.
    }
    CheckOutboxes();
    farm_.StopAndAudit(tally_, where_);
    outcome_.operations = disk_.operations();
    return outcome_;
  }

 private:
  static std::string StudyOf(int pairs) {
    char text[1024];
    std::snprintf(text, sizeof text, kStudy, pairs, pairs, pairs);
    return text;
  }

  // A worker that is killed once it has finished a pair.
  void KillInTheMidst() {
    const auto earlier = StartWorker("earlier", {});
    const auto finished_one = [this] {
      std::error_code error;
      const fs::recursive_directory_iterator end;
      for (fs::recursive_directory_iterator it(farm_.store(), error); !error && it != end;
           it.increment(error)) {
        if (it->path().parent_path().filename() == "finished") return true;
      }
      return false;
    };
    const auto begin = std::chrono::steady_clock::now();
    while (!finished_one() && SecondsSince(begin) < 60) Sleep(0.001);
    earlier->Signal(SIGKILL);
    if (earlier->Wait() != 128 + SIGKILL) tally_.Lost(where_ + ": it was no kill that ended it");
  }

  std::unique_ptr<Process> StartWorker(const std::string& name,
                                       const std::vector<std::string>& environment) {
    return farm_.StartWorker(name, 0, "", environment, 1,
                             what_.real_worker ? PARALLAX_WORKER_PROGRAM : "",
                             what_.real_worker ? std::vector<std::string>{"--threads", "1"}
                                               : std::vector<std::string>());
  }

  // True when it died; false when its study came to its end.
  bool WaitForDeath(Process& coordinator, Process* worker) {
    const auto begin = std::chrono::steady_clock::now();
    while (coordinator.Running() && SecondsSince(begin) < 60) {
      if (CountOf(worker->Err(), "job done") >= 2) return false;
      Sleep(0.005);
    }
    return !coordinator.Running();
  }

  void AfterDeath(Process& victim) {
    outcome_.died = true;
    ++tally_.faults;
    if (victim.Wait() != 128 + SIGKILL) tally_.Lost(where_ + ": " + victim.Err().substr(0, 2000));
    ReadLog();
    if (death_.power_cut) disk_.LosePower(rng_);
  }

  void ReadLog() {
    std::ifstream lines(logs_.path() + "/log");
    for (std::string line; std::getline(lines, line);) {
      const std::string wrong = disk_.Do(line);
      if (!wrong.empty()) tally_.Lost(where_ + ": " + wrong);
    }
  }

  // When all is told, nothing is left in them but what living workers need.
  void CheckOutboxes() {
    std::error_code error;
    for (const auto& entry : fs::recursive_directory_iterator(farm_.folder() + "/outbox", error)) {
      // The empty files by whose locks a worker's programs share out its cores.
      const bool of_cores =
          entry.path().parent_path().filename() == "cores" && fs::file_size(entry, error) == 0;
      if (entry.is_regular_file() && entry.path().filename() != "lock" && !of_cores) {
        tally_.Found({"left in an outbox: " + entry.path().string()}, where_);
      }
    }
  }

  const Case& what_;
  const Death death_;
  Rng rng_;
  Tally& tally_;
  const std::string where_;
  const int pairs_ = what_.heir ? 4 : 2;
  const TempFolder logs_{true};
  Farm farm_;
  Disk disk_;
  Outcome outcome_;
};

}  // namespace

void DaemonFilePoints(const ExperimentOptions& options, Tally& tally) {
  for (int round = 0; round < options.rounds; ++round) {
    Rng choice = RoundRng(options, "daemon-file-points", round);
    for (const Case& what : kCases) {
      const Outcome peace = Life(what, {}, choice.Child("peace"), tally).Run();
      if (peace.operations == 0) tally.Lost(std::string(what.name) + " does nothing");
      tally.figures["operations"] += static_cast<double>(peace.operations);
      std::vector<int64_t> points;
      for (int64_t at = 1; at <= peace.operations; ++at) points.push_back(at);
      if (!options.full) {
        choice.Shuffle(points);
        points.resize(std::min<size_t>(points.size(), kSampledPoints));
      }
      for (const int64_t at : points) {
        const bool power_cut = choice.Bernoulli(0.5);
        const Outcome outcome =
            Life(what, {at, power_cut}, choice.Child("power", static_cast<uint64_t>(at)), tally)
                .Run();
        // The number of writes to the threads' own logs differs from life to life.
        if (!outcome.died) tally.figures["missed"] += 1;
        if (power_cut && outcome.died) tally.figures["power_cuts"] += 1;
        if (outcome.files != peace.files) {
          tally.Lost(std::string(what.name) + ", operation " + std::to_string(at) +
                     ": the files are not those of a life in peace");
        }
      }
    }
    ++tally.rounds;
  }
  if (tally.figures["missed"] > tally.figures["operations"] / 10) {
    tally.Lost("too many operations were not reached again");
  }
}

}  // namespace parallax::faults
