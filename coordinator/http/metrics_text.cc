#include "coordinator/http/metrics_text.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <map>

#include "coordinator/view/search_json.h"

namespace parallax {
namespace {

using Labels = std::vector<std::pair<std::string, std::string>>;

class Writer {
 public:
  void Head(const std::string& name, const char* type, const char* help) {
    text_ +=
        "# HELP parallax_" + name + " " + help + "\n# TYPE parallax_" + name + " " + type + "\n";
  }
  void Sample(const std::string& name, const Labels& labels, auto value) {
    text_ += "parallax_" + name;
    for (size_t i = 0; i < labels.size(); ++i) {
      text_ +=
          (i == 0 ? "{" : ",") + labels[i].first + "=\"" + EscapeLabel(labels[i].second) + "\"";
    }
    text_ += fmt::format("{}{:.10g}\n", labels.empty() ? " " : "} ", static_cast<double>(value));
  }
  void One(const std::string& name, const char* type, const char* help, auto value) {
    Head(name, type, help);
    Sample(name, {}, value);
  }
  std::string Take() { return std::move(text_); }

 private:
  std::string text_;
};

template <typename Count>
void WriteHistogram(const std::string& name, const char* help, const std::vector<double>& bounds,
                    const std::vector<Count>& counts, auto sum, Writer& out) {
  out.Head(name, "histogram", help);
  for (size_t i = 0; i < counts.size(); ++i) {
    out.Sample(name + "_bucket",
               {{"le", i < bounds.size() ? fmt::format("{:.10g}", bounds[i]) : "+Inf"}}, counts[i]);
  }
  out.Sample(name + "_sum", {}, sum);
  out.Sample(name + "_count", {}, counts.empty() ? 0 : counts.back());
}

void WriteQueue(const JobQueueStats& queue, Writer& out) {
  out.Head("jobs", "gauge", "Jobs by kind and state.");
  for (const auto& [key, count] : queue.jobs) {
    out.Sample("jobs", {{"kind", key.first}, {"state", key.second}}, count);
  }
  out.One("leases_held", "gauge", "Attempts that workers hold.", queue.leases_held);
  out.One("completions_total", "counter", "Results committed since start.", queue.completions);
  out.One("app_failures_total", "counter", "Attempts whose work failed, since start.",
          queue.failures);
  out.One("infra_losses_total", "counter", "Attempts lost with their worker, since start.",
          queue.losses);
  out.One("stale_reports_total", "counter", "Late reports refused by their fence, since start.",
          queue.stale_reports);
  out.Head("attempts_total", "counter", "Attempts by what became of them, since start.");
  const std::pair<const char*, uint64_t> attempts[] = {{"leased", queue.leases_granted},
                                                       {"completed", queue.completions},
                                                       {"failed", queue.failures},
                                                       {"lost", queue.losses},
                                                       {"stale", queue.stale_reports}};
  for (const auto& [outcome, count] : attempts) {
    out.Sample("attempts_total", {{"outcome", outcome}}, count);
  }
  out.One("splits_total", "counter", "Jobs made from rigs of another, since start.", queue.splits);
  out.One("archived_jobs_total", "counter", "Jobs moved to the archive since start.",
          queue.archived_jobs);
  WriteHistogram("commit_seconds", "Time in COMMIT, fsync included.", queue.commit_bounds_s,
                 queue.commit_counts, queue.commit_seconds, out);
  WriteHistogram("commit_batch", "Commands in one commit.", queue.batch_bounds, queue.batch_counts,
                 queue.commands, out);
  out.One("commits_total", "counter", "Group commits since start.", queue.commits);
  out.One("commands_total", "counter", "Commands in group commits since start.", queue.commands);
  out.One("commit_seconds_total", "counter", "Time in COMMIT, fsync included.",
          queue.commit_seconds);
  out.One("commit_seconds_max", "gauge", "The longest COMMIT since start.",
          queue.commit_seconds_max);
  out.One("checkpoints_total", "counter", "Checkpoints of the WAL.", queue.checkpoints);
  out.One("checkpoint_seconds_total", "counter", "Time in checkpoints, in which no commit is made.",
          queue.checkpoint_seconds);
  out.One("checkpoint_seconds_max", "gauge", "The longest checkpoint since start.",
          queue.checkpoint_seconds_max);
  out.One("commit_batch_max", "gauge", "The largest number of commands in one commit.",
          queue.largest_batch);
  out.One("wal_pages", "gauge", "Pages in the write-ahead log.", queue.wal_pages);
}

// Writes the slots that work wants, which autoscalers follow. Jobs of paused studies wait for a
// person, not for a slot; those that limits hold back wait for other jobs' ends.
void WriteDemand(const StatusSnapshot& snapshot, Writer& out) {
  const auto waits = [](const std::string& state) {
    return state == "READY" || state == "RETRY_WAIT";
  };
  std::map<std::string, int64_t> slots;
  for (const auto& [key, count] : snapshot.queue.jobs) {
    slots[key.first] += waits(key.second) || key.second == "LEASED" ? count : 0;
  }
  const auto leave_out_held = [&](const v1::StudyStatus& study) {
    int64_t held = study.state() == v1::STUDY_STATE_PAUSED ? std::numeric_limits<int64_t>::max()
                                                           : study.held_jobs();
    for (const v1::VariantStatus& variant : study.variants()) {
      for (const v1::JobCount& count : variant.jobs()) {
        if (!waits(count.state())) continue;
        const int64_t less = std::min(held, count.jobs());
        slots[count.kind()] -= less;
        held -= less;
      }
    }
  };
  for (const v1::StudyStatus& study : snapshot.studies) leave_out_held(study);
  for (const v1::StudyStatus& study : snapshot.older_unfinished) leave_out_held(study);
  out.Head("demand_slots", "gauge", "Slots that leased jobs and those that may start would fill.");
  for (const auto& [kind, count] : slots) {
    out.Sample("demand_slots", {{"kind", kind}}, std::max<int64_t>(0, count));
  }
}

// The metric counts jobs for which no connected worker will do under their own reasons: an alert
// must not fire because a farm is busy.
void WriteWaiting(const StatusSnapshot& snapshot, Writer& out) {
  std::map<std::pair<std::string, std::string>, int64_t> waiting;
  for (const auto* studies : {&snapshot.studies, &snapshot.older_unfinished}) {
    for (const v1::StudyStatus& study : *studies) {
      for (const v1::WaitingJobs& jobs : study.waiting()) {
        waiting[{jobs.kind(), jobs.reason()}] += jobs.jobs();
      }
    }
  }
  out.Head("jobs_waiting", "gauge", "READY jobs by the reason for which they do not run.");
  for (const auto& [key, jobs] : waiting) {
    out.Sample("jobs_waiting", {{"kind", key.first}, {"reason", key.second}}, jobs);
  }
}

void WriteWorkers(const StatusSnapshot& snapshot, Writer& out) {
  std::map<std::string, int> by_state;
  for (const v1::WorkerStatus& worker : snapshot.workers) ++by_state[worker.state()];
  out.Head("workers", "gauge", "Workers by state.");
  for (const auto& [state, count] : by_state) out.Sample("workers", {{"state", state}}, count);
  const ServerMetrics& server = snapshot.server;
  out.One("worker_slots", "gauge", "Slots of connected workers.", server.slots);
  out.One("worker_running", "gauge", "Slots of connected workers that hold an attempt.",
          server.running);
  out.One("workers_lost_total", "counter", "Workers given up since start.", server.workers_lost);
  out.One("leases_total", "counter", "Leases sent since start.", server.leases);
  out.Head("reports_total", "counter", "Reports of attempts by outcome since start.");
  for (const auto& [outcome, count] : server.reports) {
    out.Sample("reports_total", {{"outcome", outcome}}, count);
  }
}

void WriteStore(const ServerMetrics& server, Writer& out) {
  const ScrubFigures& scrub = server.scrub;
  out.One("store_ok", "gauge", "1 while the store is there, else 0: nothing is leased.",
          server.store_problem.empty() ? 1 : 0);
  out.One("scrub_files_total", "counter", "Files of results that were read to look for damage.",
          scrub.files);
  out.One("scrub_bytes_total", "counter", "Bytes of them.", scrub.bytes);
  out.One("scrub_damaged_total", "counter", "Damaged results that were found, since start.",
          scrub.damaged);
  out.One("scrub_pairs_taken_back_total", "counter", "Pairs of studies that are made again.",
          scrub.pairs_taken_back);
  out.One("scrub_pass_began_seconds", "gauge", "Unix time at which the last pass began; 0: none.",
          scrub.pass.began_unix_s);
  out.One("scrub_pass_ended_seconds", "gauge", "Unix time at which it ended; 0: under way.",
          scrub.pass.ended_unix_s.value_or(0));
}

void WriteSpace(const FarmSpace& space, Writer& out) {
  if (space.results_bytes) {
    out.One("store_results_bytes", "gauge",
            "Bytes of the results that studies have, each counted once.", *space.results_bytes);
  }
  if (space.disks.empty()) return;
  out.Head("disk_free_bytes", "gauge", "Free bytes on the disk of store and database.");
  for (const auto& [name, disk] : space.disks) {
    out.Sample("disk_free_bytes", {{"of", name}}, disk.free_bytes);
  }
  out.Head("disk_bytes", "gauge", "Bytes that the disk has.");
  for (const auto& [name, disk] : space.disks) {
    out.Sample("disk_bytes", {{"of", name}}, disk.total_bytes);
  }
}

void WriteLatency(const ServerMetrics& server, Writer& out) {
  WriteHistogram(
      "lease_latency_seconds", "From credit and a ready job to the lease on the worker's stream.",
      server.lease_latency_bounds_s, server.lease_latency_counts, server.lease_latency_sum_s, out);
}

void WriteWork(const ServerMetrics& server, Writer& out) {
  out.Head("stage_seconds_total", "counter", "Seconds that results spent in each stage.");
  for (const auto& [stage, total] : server.stages) {
    out.Sample("stage_seconds_total", {{"stage", stage}}, total.seconds);
  }
  out.Head("stage_runs_total", "counter", "How often results went through each stage.");
  for (const auto& [stage, total] : server.stages) {
    out.Sample("stage_runs_total", {{"stage", stage}}, total.count);
  }
  const auto each = [&](const char* name, const char* help, auto value) {
    out.Head(name, "counter", help);
    for (const auto& [kind, work] : server.work) out.Sample(name, {{"kind", kind}}, value(work));
  };
  each("job_results_total", "Results accepted, by kind of job.",
       [](const ServerMetrics::Work& work) { return work.jobs; });
  each("job_wall_seconds_total", "Wall time of jobs whose results were accepted.",
       [](const ServerMetrics::Work& work) { return work.wall_s; });
  each("job_cpu_seconds_total", "CPU time of jobs whose results were accepted.",
       [](const ServerMetrics::Work& work) { return work.cpu_s; });
}

void WritePairs(const StatusSnapshot& snapshot, Writer& out) {
  const auto each = [&](const char* name, auto value) {
    for (const v1::StudyStatus& study : snapshot.studies) {
      for (const v1::VariantStatus& variant : study.variants()) {
        // The id too: a name may be submitted twice.
        out.Sample(name,
                   {{"study", study.name()},
                    {"study_id", std::to_string(study.study_id())},
                    {"variant", variant.name()}},
                   value(variant));
      }
    }
  };
  out.Head("pairs_published", "gauge", "Stereo pairs published, of the newest studies.");
  each("pairs_published", [](const v1::VariantStatus& variant) { return variant.pairs_done(); });
  out.Head("pairs_wanted", "gauge", "Stereo pairs asked for, of the newest studies.");
  each("pairs_wanted", [](const v1::VariantStatus& variant) { return variant.pairs_wanted(); });
  out.One("pairs_per_hour", "gauge", "Rate of publication over the last minutes.",
          snapshot.pairs_per_hour);
  out.Head("study_eta_seconds", "gauge",
           "Until the pairs of a running study are there, at its present rate.");
  for (const v1::StudyStatus& study : snapshot.studies) {
    const auto eta = snapshot.eta_s.find(study.study_id());
    if (eta == snapshot.eta_s.end()) continue;
    out.Sample("study_eta_seconds",
               {{"study", study.name()}, {"study_id", std::to_string(study.study_id())}},
               eta->second);
  }
}

void WriteRunning(const StatusSnapshot& snapshot, Writer& out) {
  out.Head("job_figure", "gauge", "What running jobs tell of themselves: loss, step, eta_s.");
  for (const RunningJob& job : snapshot.running) {
    for (const auto& [figure, value] : job.figures) {
      out.Sample("job_figure",
                 {{"study", job.study},
                  {"kind", job.kind},
                  {"job_id", std::to_string(job.job_id)},
                  {"label", job.label},
                  {"figure", figure}},
                 value);
    }
  }
}

void WriteStreams(const StatusSnapshot& snapshot, Writer& out) {
  const auto each = [&](const char* name, const char* help, auto value) {
    out.Head(name, "gauge", help);
    for (const v1::StreamStatus& stream : snapshot.streams) {
      out.Sample(name, {{"stream", stream.name()}}, value(stream));
    }
  };
  each("stream_chunks_begun", "Chunks that were begun since the stream was opened.",
       [](const v1::StreamStatus& stream) { return stream.chunks_begun(); });
  each("stream_chunks_made", "Chunks of which all pairs were made.",
       [](const v1::StreamStatus& stream) { return stream.chunks_made(); });
  each("stream_chunks_forgotten", "Chunks that are used up and gone.",
       [](const v1::StreamStatus& stream) { return stream.chunks_forgotten(); });
  each("stream_pairs_kept", "Pairs that are made and not forgotten.",
       [](const v1::StreamStatus& stream) { return stream.pairs_kept(); });
  each("stream_consumers", "Ranks of all consumers.",
       [](const v1::StreamStatus& stream) { return stream.consumers_size(); });
  each("stream_needs_person", "1 if the stream can't go on until a person acts, else 0.",
       [](const v1::StreamStatus& stream) { return !stream.needs().empty() && !stream.closed(); });
  out.Head("stream_consumer_silent_seconds", "gauge", "Since the rank of a consumer was heard.");
  for (const v1::StreamStatus& stream : snapshot.streams) {
    for (const v1::StreamConsumer& consumer : stream.consumers()) {
      if (consumer.heard_unix_s() <= 0) continue;  // Only other ranks of it were heard so far.
      out.Sample("stream_consumer_silent_seconds",
                 {{"stream", stream.name()},
                  {"consumer", consumer.name()},
                  {"rank", std::to_string(consumer.rank())}},
                 std::max(0.0, snapshot.now_unix_s - consumer.heard_unix_s()));
    }
  }
}

void WriteSearches(const StatusSnapshot& snapshot, Writer& out) {
  const auto is_open = [](const v1::SearchStatus& search) {
    return search.state() != "ended" && search.state() != "stopped";
  };
  const auto each = [&](const char* name, const char* help, auto value) {
    out.Head(name, "gauge", help);
    for (const v1::SearchStatus& search : snapshot.searches) {
      out.Sample(name, {{"search", search.name()}}, value(search));
    }
  };
  out.Head("search_trials", "gauge", "Trials: open, dropped by their scores, or failed.");
  for (const v1::SearchStatus& search : snapshot.searches) {
    for (const auto& [state, trials] : TrialStates(search)) {
      out.Sample("search_trials", {{"search", search.name()}, {"state", state}}, trials);
    }
  }
  each("search_rung", "The rung that runs, from 1.",
       [](const v1::SearchStatus& search) { return search.rung() + 1; });
  each("search_core_hours", "Core-hours of its results that were made for it.",
       [](const v1::SearchStatus& search) { return search.core_hours(); });
  each("search_core_hours_most", "Core-hours beyond which no rung begins; 0: no limit.",
       [](const v1::SearchStatus& search) { return search.study().search().core_hours(); });
  each("search_open", "1 until the search has ended or was stopped, then 0.", is_open);
  each("search_needs_person", "1 if the search can't go on until a person acts, else 0.",
       [&](const v1::SearchStatus& search) { return is_open(search) && !search.needs().empty(); });
}

}  // namespace

std::string EscapeLabel(std::string_view value) {
  std::string escaped;
  for (char c : value) {
    if (c == '\\' || c == '"') escaped += '\\';
    if (c == '\n') {
      escaped += "\\n";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

std::string MetricsText(const StatusSnapshot& snapshot) {
  Writer out;
  out.Head("info", "gauge", "What runs here.");
  out.Sample(
      "info",
      {{"version", snapshot.version}, {"schema_version", std::to_string(snapshot.schema_version)}},
      1);
  out.One("epoch", "gauge", "Of this start: the upper half of its fences.", snapshot.epoch);
  out.One("uptime_seconds", "gauge", "Since this start.", snapshot.uptime_s);
  WriteQueue(snapshot.queue, out);
  WriteDemand(snapshot, out);
  WriteWaiting(snapshot, out);
  WriteWorkers(snapshot, out);
  WriteStore(snapshot.server, out);
  WriteSpace(snapshot.space, out);
  WriteLatency(snapshot.server, out);
  WriteWork(snapshot.server, out);
  WritePairs(snapshot, out);
  WriteRunning(snapshot, out);
  WriteStreams(snapshot, out);
  WriteSearches(snapshot, out);
  return out.Take();
}

}  // namespace parallax
