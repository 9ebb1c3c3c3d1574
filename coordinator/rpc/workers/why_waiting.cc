#include "coordinator/rpc/workers/why_waiting.h"

#include <fmt/core.h>

#include <algorithm>
#include <optional>

#include "common/base/ability_tags.h"

namespace parallax {
namespace {

// A need that workers may lack.
struct Need {
  std::string code;
  std::string name;    // "the trainer raftstereo"
  std::string remedy;  // How a worker gets it.
  std::string tag;     // Empty: memory.
  int64_t memory_mb = 0;
};

std::string Megabytes(int64_t mb) {
  return mb < 10'000 ? fmt::format("{} MB", mb) : fmt::format("{} GB", (mb + 500) / 1000);
}

Need NeedOfTag(const std::string& tag) {
  const std::string trainer = TrainerTag(""), benchmark = BenchmarkTag(""),
                    network = NetworkTag("");
  if (tag.rfind(trainer, 0) == 0) {
    const std::string name = tag.substr(trainer.size());
    return {"trainer", "the trainer " + name,
            "worker --allow-trainers " + name + ", or install its program", tag};
  }
  if (tag.rfind(benchmark, 0) == 0) {
    const std::string name = tag.substr(benchmark.size());
    return {"benchmark", "the benchmark " + name,
            "worker --benchmarks FOLDER, with " + name + " in it", tag};
  }
  if (tag.rfind(network, 0) == 0) {
    return {"tag", "the network with the SHA-256 " + tag.substr(network.size()),
            "the coordinator's version of Parallax, or $PARALLAX_NETWORK", tag};
  }
  if (tag == kGpuTag) return {"gpu", "a GPU", "worker --tags gpu", tag};
  return {"tag", "the tag " + tag, "worker --tags " + tag, tag};
}

// In the order of kWaitCodes.
std::vector<Need> NeedsOf(const ReadyKey& jobs) {
  std::vector<Need> needs;
  for (const std::string& tag : jobs.tags) needs.push_back(NeedOfTag(tag));
  const auto rank = [](const Need& need) {
    return std::find(std::begin(kWaitCodes), std::end(kWaitCodes), need.code) -
           std::begin(kWaitCodes);
  };
  std::stable_sort(needs.begin(), needs.end(),
                   [&](const Need& a, const Need& b) { return rank(a) < rank(b); });
  if (jobs.memory_mb > 0) {
    needs.push_back({"memory", Megabytes(jobs.memory_mb) + " of memory", "", "", jobs.memory_mb});
  }
  return needs;
}

bool Has(const std::vector<std::string>& list, const std::string& word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

bool Meets(const WorkerGroup& group, const Need& need) {
  return need.tag.empty() ? group.memory_mb >= need.memory_mb : Has(group.tags, need.tag);
}

// Returns why none of the workers that take the kind suits; nothing if one does.
std::optional<WaitReason> WhyNoneSuits(const std::vector<Need>& needs, const std::string& kind,
                                       std::span<const WorkerGroup* const> takers) {
  for (const Need& need : needs) {
    const bool met = std::any_of(takers.begin(), takers.end(),
                                 [&](const WorkerGroup* group) { return Meets(*group, need); });
    if (met) continue;
    std::string remedy = need.remedy;
    if (need.tag.empty()) {
      int64_t most = 0;
      for (const WorkerGroup* group : takers) most = std::max(most, group->memory_mb);
      remedy = "the most that one offers is " + Megabytes(most);
    }
    return WaitReason{need.code, "no connected worker for " + kind + " jobs has " + need.name +
                                     " (" + remedy + ")"};
  }
  // Each need is met by some worker. The one that lacks least says what is missing.
  const Need* lacking = nullptr;
  size_t least = needs.size() + 1;
  for (const WorkerGroup* group : takers) {
    size_t lacks = 0;
    const Need* first = nullptr;
    for (const Need& need : needs) {
      if (Meets(*group, need)) continue;
      if (++lacks == 1) first = &need;
    }
    if (lacks < least) {
      least = lacks;
      lacking = first;
    }
  }
  if (least == 0) return std::nullopt;
  std::string all;
  for (const Need& need : needs) all += (all.empty() ? "" : ", ") + need.name;
  return WaitReason{lacking->code, "no connected worker for " + kind + " jobs has all of " + all};
}

}  // namespace

bool IsUnservable(const std::string& code) {
  const auto at = std::find(std::begin(kWaitCodes), std::end(kWaitCodes), code);
  const auto last = std::find(std::begin(kWaitCodes), std::end(kWaitCodes), std::string("memory"));
  return code != "pause" && at <= last;
}

bool NeedsPerson(const std::string& code) { return IsUnservable(code) && code != "no_worker"; }

WaitReason WhyWaiting(const ReadyKey& jobs, const StudyHold& study,
                      std::span<const WorkerGroup> workers) {
  if (study.paused) return {"pause", "the study is paused (parallax resume STUDY)"};
  std::vector<const WorkerGroup*> takers;
  int64_t connected = 0;
  for (const WorkerGroup& group : workers) {
    connected += group.workers();
    if (group.workers() > 0 && Has(group.kinds, jobs.kind)) takers.push_back(&group);
  }
  if (connected == 0) return {"no_worker", "no worker is connected"};
  if (takers.empty()) {
    return {"kind",
            "no connected worker takes " + jobs.kind + " jobs (worker --role " + jobs.kind + ")"};
  }
  const std::vector<Need> needs = NeedsOf(jobs);
  if (auto none = WhyNoneSuits(needs, jobs.kind, takers)) return *std::move(none);

  WorkerGroup suitable;
  for (const WorkerGroup* group : takers) {
    if (!std::all_of(needs.begin(), needs.end(),
                     [&](const Need& need) { return Meets(*group, need); })) {
      continue;
    }
    suitable.free += group->free;
    suitable.busy += group->busy;
    suitable.drained += group->drained;
    suitable.suspended += group->suspended;
  }
  const int64_t all = suitable.workers();
  const std::string which =
      all == 1 ? "the only suitable worker is " : fmt::format("all {} suitable workers are ", all);
  if (suitable.free + suitable.busy == 0) {
    if (suitable.drained == all)
      return {"drain", which + "drained (parallax workers drain NAME --undo)"};
    if (suitable.suspended == all) {
      return {"suspended", which + "suspended, having failed all jobs of late"};
    }
    return {"drain", which + fmt::format("unavailable: {} drained, {} suspended", suitable.drained,
                                         suitable.suspended)};
  }
  if (!study.at_limit.empty()) return {"limit", "the study is at its limit: " + study.at_limit};
  if (suitable.free == 0) {
    std::string text = which + "busy";
    if (suitable.busy < all) {
      text = fmt::format("{} of {} suitable workers {} busy, the others take no jobs",
                         suitable.busy, all, suitable.busy == 1 ? "is" : "are");
    }
    return {"busy", text};
  }
  return {"starting", fmt::format("{} suitable worker{} free: next to start", suitable.free,
                                  suitable.free == 1 ? " is" : "s are")};
}

}  // namespace parallax
