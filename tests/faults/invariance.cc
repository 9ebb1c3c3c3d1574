// Experiment 10: the real study with the real programs, once in peace and once under everything -
// workers and coordinator killed at random, a fifth of the replies lost, a zombie - gives the same
// dataset; and asked for again it renders nothing.
#include <signal.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/image/io.h"
#include "tests/faults/farm.h"
#include "tests/faults/tcp_proxy.h"
#include "tests/job_messages.h"

namespace parallax::faults {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr char kStudy[] = R"(study: invariance
seed: 11
pairs: %d
rigs_per_scene: 2
variants:
  - name: narrow
    set:
      floating: {count: 3}
      rigs: {count: 2, width_px: 96, height_px: 54, baseline_m: {uniform: [0.04, 0.1]}}
      render: {profile: preview}
  - name: wide
    set:
      floating: {count: 3}
      rigs: {count: 2, width_px: 96, height_px: 54, baseline_m: {uniform: [0.2, 0.3]}}
      render: {profile: preview}
)";

// A dataset's content without its costs: ground truth and recipes by bytes, the index line by line
// without times. Images are kept apart: they may differ with the number of denoiser threads.
struct Dataset {
  std::map<std::string, std::string> exact;   // Path -> SHA-256.
  std::map<std::string, std::string> images;  // Path -> content.
  std::string Hash() const {
    std::string text;
    for (const auto& [path, sha256] : exact) text += sha256 + " " + path + "\n";
    return Sha256Hex(text);
  }
};

bool IsImage(const std::string& name) { return name == "left.png" || name == "right.png"; }

std::string IndexOf(const std::string& path) {
  std::ifstream lines(path);
  std::set<std::string> facts;  // Its order is that of publication.
  for (std::string line; std::getline(lines, line);) {
    const Json json = Json::parse(line, nullptr, false);
    Json fact = {{"scene", json["scene"]}, {"rig", json["rig"]}};
    for (const auto& [name, sha256] : json["files"].items()) {
      if (!IsImage(name) && name != "frame.json") fact["files"][name] = sha256;
    }
    facts.insert(fact.dump());
  }
  std::string text;
  for (const std::string& fact : facts) text += fact + "\n";
  return text;
}

Dataset ReadDataset(const std::string& out) {
  Dataset dataset;
  for (const auto& entry : fs::recursive_directory_iterator(out)) {
    const std::string path = fs::relative(entry.path(), out);
    if (!entry.is_regular_file() || path.rfind(".parallax", 0) == 0) continue;
    const std::string name = entry.path().filename();
    if (IsImage(name)) {
      dataset.images[path] = *ReadFile(entry.path());
    } else if (name == "index.jsonl") {
      dataset.exact[path] = Sha256Hex(IndexOf(entry.path()));
    } else if (entry.path().extension() == ".exr" || entry.path().extension() == ".png" ||
               entry.path().extension() == ".pb") {
      if (path.find("contact") != std::string::npos) continue;
      dataset.exact[path] = Sha256Hex(*ReadFile(entry.path()));
    }
  }
  return dataset;
}

// The largest difference of any value, in 1/255; 256 when they can't be compared.
int ImageDifference(const std::string& a, const std::string& b) {
  const auto first = DecodePngRgb8(a);
  const auto second = DecodePngRgb8(b);
  if (!first.ok() || !second.ok() || first->values().size() != second->values().size()) return 256;
  int worst = 0;
  for (size_t i = 0; i < first->values().size(); ++i) {
    worst = std::max(worst, std::abs(int{first->values()[i]} - int{second->values()[i]}));
  }
  return worst;
}

class Runs {
 public:
  Runs(Farm& farm, int pairs) : farm_(farm) {
    char text[2048];
    std::snprintf(text, sizeof text, kStudy, pairs);
    yaml_ = farm.folder() + "/study.yaml";
    std::ofstream(yaml_) << text;
  }

  // Through the client, as a user does; again until it is answered.
  Json Client(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), PARALLAX_CLIENT_PROGRAM);
    for (const char* word : {"--coordinator", farm_.address().c_str(), "--json"}) {
      arguments.push_back(word);
    }
    std::string error;
    for (int i = 0; i < 20; ++i) {
      Process process(arguments);
      if (process.Wait() == 0) return Json::parse(process.Out(), nullptr, false);
      error = process.Err();
      Sleep(0.2);
    }
    std::fprintf(stderr, "parallax %s: %s\n", arguments[1].c_str(), error.c_str());
    return Json();
  }
  int64_t Submit(bool again) {
    std::vector<std::string> command{"submit", yaml_};
    if (again) command.push_back("--again");
    return Client(command).value("study_id", int64_t{0});
  }
  Dataset Fetch(int64_t study, const std::string& name) {
    const std::string out = farm_.folder() + "/" + name;
    Client({"fetch", std::to_string(study), "--out", out});
    return ReadDataset(out);
  }
  std::unique_ptr<Process> Worker(const std::string& name, const std::string& address) {
    return farm_.StartWorker(name, 0, address, {}, 1, PARALLAX_WORKER_PROGRAM, {"--threads", "1"});
  }

 private:
  Farm& farm_;
  std::string yaml_;
};

bool Succeeded(const v1::StudyStatus& status) {
  return status.state() == v1::STUDY_STATE_SUCCEEDED;
}

Dataset Calm(int pairs, Tally& tally, double* wall_s) {
  Farm farm({.lease_s = 10});
  farm.StartCoordinator();
  Runs runs(farm, pairs);
  const auto begin = std::chrono::steady_clock::now();
  const int64_t study = runs.Submit(false);
  const auto worker = runs.Worker("calm", "");
  if (!farm.WaitFor(study, Succeeded, 300)) tally.Lost("the calm study does not end");
  *wall_s = SecondsSince(begin);
  Dataset dataset = runs.Fetch(study, "calm");
  Drain(*worker, tally);
  farm.StopAndAudit(tally, "calm");
  return dataset;
}

// Kills and stops any worker and the coordinator at random for `chaos_s` seconds, or until the
// study has ended; then lets it end. No scene may be blamed for that.
Dataset Chaos(int pairs, double chaos_s, Rng rng, double calm_s, Tally& tally) {
  Farm farm({.lease_s = 2, .reconnect_s = 0.5});
  farm.StartCoordinator();
  Runs runs(farm, pairs);
  TcpProxy proxy(farm.address(), {.unary = 0.2, .stream = 0.1}, rng.Bits64());
  const int64_t study = runs.Submit(false);
  std::vector<std::unique_ptr<Process>> workers;
  for (int i = 0; i < 3; ++i) {
    workers.push_back(runs.Worker("w" + std::to_string(i), proxy.address()));
  }
  size_t stopped = workers.size();
  const auto begin = std::chrono::steady_clock::now();
  const double pause_s = std::max(0.3, calm_s / 6);
  while (!Succeeded(farm.Status(study)) && SecondsSince(begin) < chaos_s) {
    Sleep(rng.Uniform(0.2 * pause_s, pause_s));
    const auto i = static_cast<size_t>(rng.UniformInt(0, 2));
    if (rng.Bernoulli(0.4)) {
      farm.KillCoordinator();
      farm.StartCoordinator();
    } else if (stopped < workers.size()) {
      workers[stopped]->Signal(SIGCONT);  // The zombie wakes.
      stopped = workers.size();
    } else if (rng.Bernoulli(0.5)) {
      stopped = i;
      workers[i]->Signal(SIGSTOP);
    } else {
      workers[i]->Signal(SIGKILL);
      workers[i]->Wait();
      workers[i] = runs.Worker("w" + std::to_string(i), proxy.address());
    }
    ++tally.faults;
  }
  if (stopped < workers.size()) workers[stopped]->Signal(SIGCONT);
  if (!farm.WaitFor(study, Succeeded, 300)) tally.Lost("the study under chaos does not end");
  v1::ListJobsRequest quarantined;
  quarantined.set_study_id(study);
  quarantined.set_state("QUARANTINED");
  for (const v1::JobStatus& job : farm.Jobs(quarantined)) {
    tally.Lost("a good scene is quarantined: " + job.ShortDebugString());
  }
  tally.faults += proxy.counts().lost;
  farm.CheckPairs(study, 2 * static_cast<size_t>(pairs), tally);

  // Again: all of it is there.
  const double leases = farm.Metric("parallax_leases_total");
  const int64_t again = runs.Submit(true);
  if (again == study) tally.Lost("the second submit made no study of its own");
  if (!farm.WaitFor(again, Succeeded, 60)) tally.Lost("the study asked for again does not end");
  const double done_again = farm.Metric("parallax_leases_total") - leases;
  if (done_again != 0) tally.Doubled(std::to_string(done_again) + " jobs for what was there");
  tally.figures["jobs_done_again"] += done_again;
  Dataset dataset = runs.Fetch(study, "chaos");
  const Dataset second = runs.Fetch(again, "again");
  if (second.Hash() != dataset.Hash()) tally.Doubled("the study asked for again differs");
  for (const auto& worker : workers) {
    worker->Signal(SIGTERM);
    worker->Wait(Process::Seconds(20));
  }
  farm.StopAndAudit(tally, "chaos");
  return dataset;
}

}  // namespace

void Invariance(const ExperimentOptions& options, Tally& tally) {
  const int pairs = options.jobs > 0 ? static_cast<int>(options.jobs) : 4;
  const double chaos_s = options.seconds > 0 ? options.seconds : 20;
  double calm_s = 0;
  const Dataset calm = Calm(pairs, tally, &calm_s);
  for (int round = 0; round < options.rounds; ++round) {
    const Dataset chaos =
        Chaos(pairs, chaos_s, RoundRng(options, "invariance", round), calm_s, tally);
    if (chaos.Hash() != calm.Hash()) {
      for (const auto& [path, sha256] : calm.exact) {
        const auto found = chaos.exact.find(path);
        if (found == chaos.exact.end() || found->second != sha256) {
          tally.Lost("under chaos " + path + " is another");
        }
      }
      if (chaos.exact.size() > calm.exact.size()) tally.Doubled("files that a calm run has not");
    }
    for (const auto& [path, bytes] : calm.images) {
      const auto found = chaos.images.find(path);
      const int difference =
          found == chaos.images.end() ? 256 : ImageDifference(bytes, found->second);
      if (difference > 1) tally.Lost("image " + path + " differs by " + std::to_string(difference));
      tally.figures["image_difference_max"] =
          std::max(tally.figures["image_difference_max"], static_cast<double>(difference));
    }
    ++tally.rounds;
  }
  tally.figures["files_compared"] = static_cast<double>(calm.exact.size());
  std::fprintf(stderr, "dataset hash %s\n", calm.Hash().c_str());
}

}  // namespace parallax::faults
