#include "coordinator/http/api_json.h"

#include <cmath>

#include "coordinator/study/rigs.h"
#include "coordinator/view/json_list.h"
#include "coordinator/view/search_json.h"
#include "coordinator/view/status_view.h"

namespace parallax {
namespace {

Json OrNull(double unix_s) { return unix_s > 0 ? Json(unix_s) : Json(nullptr); }
Json SceneOrNull(uint32_t scene) { return scene == kNoScene ? Json(nullptr) : Json(scene); }

std::string RigsOf(const v1::JobStatus& job) {
  return RigsText({job.rigs().data(), static_cast<size_t>(job.rigs_size())});
}

Json FiguresJson(const google::protobuf::Map<std::string, double>& figures) {
  Json json = Json::object();
  for (const auto& [name, value] : figures) json[name] = value;
  return json;
}

}  // namespace

std::string JsonText(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json FarmJson(const StatusSnapshot& snapshot) {
  PairCounts pairs;
  Json studies = Json::array();
  for (const v1::StudyStatus& study : snapshot.studies) {
    const PairCounts of_study = CountsOf(study);
    pairs.done += of_study.done;
    pairs.wanted += of_study.wanted;
    const auto eta = snapshot.eta_s.find(study.study_id());
    studies.push_back(StudyRowJson(study, eta == snapshot.eta_s.end() ? -1 : eta->second));
  }
  Json jobs = Json::array();
  for (const auto& [key, count] : snapshot.queue.jobs) {
    if (count > 0) jobs.push_back({{"kind", key.first}, {"state", key.second}, {"jobs", count}});
  }
  std::map<std::string, int64_t> states;
  for (const v1::WorkerStatus& worker : snapshot.workers) ++states[worker.state()];
  Json running = Json::array();
  for (const RunningJob& job : snapshot.running) {
    running.push_back({{"job", job.job_id},
                       {"study", job.study},
                       {"kind", job.kind},
                       {"label", job.label},
                       {"figures", job.figures}});
  }
  return {{"version", snapshot.version},
          {"epoch", snapshot.epoch},
          {"store", snapshot.store_uri},
          {"store_problem", snapshot.server.store_problem},
          {"uptime_s", snapshot.uptime_s},
          {"now_unix_s", snapshot.now_unix_s},
          {"pairs_per_hour", snapshot.pairs_per_hour},
          {"pairs", {{"done", pairs.done}, {"wanted", pairs.wanted}}},
          {"jobs", jobs},
          {"workers",
           {{"connected", snapshot.server.workers_connected},
            {"slots", snapshot.server.slots},
            {"busy", snapshot.server.running},
            {"states", states}}},
          {"studies", studies},
          {"streams", JsonList(snapshot.streams, StreamJson)},
          {"searches", JsonList(snapshot.searches, SearchLineJson)},
          {"running", running}};
}

Json HistoryJson(const std::vector<HistorySample>& samples) {
  Json json = {{"every_s", History::kEvery_s}};
  for (const char* name :
       {"unix_s", "pairs_per_hour", "ready", "running", "waiting", "workers", "slots", "busy"}) {
    json[name] = Json::array();
  }
  for (const HistorySample& sample : samples) {
    json["unix_s"].push_back(std::round(sample.unix_s));
    json["pairs_per_hour"].push_back(std::round(sample.pairs_per_hour * 10) / 10);
    json["ready"].push_back(sample.ready);
    json["running"].push_back(sample.running);
    json["waiting"].push_back(sample.waiting);
    json["workers"].push_back(sample.workers);
    json["slots"].push_back(sample.slots);
    json["busy"].push_back(sample.busy);
  }
  return json;
}

Json WorkersJson(const std::vector<v1::WorkerStatus>& all) {
  return {{"workers", JsonList(all, WorkerJson)}};
}

Json StudyRowJson(const v1::StudyStatus& study, double eta_s) {
  Json json = StudyLineJson(study);
  json["eta_s"] = eta_s < 0 ? Json(nullptr) : Json(eta_s);
  return json;
}

Json StudyPageJson(const v1::StudyStatus& study, double eta_s,
                   const std::vector<ProblemCause>& causes) {
  Json json = StudyJson(study);
  json["eta_s"] = eta_s < 0 ? Json(nullptr) : Json(eta_s);
  json["causes"] = Json::array();
  for (const ProblemCause& cause : causes) {
    json["causes"].push_back({{"error", cause.error},
                              {"fingerprint", cause.fingerprint},
                              {"kind", cause.kind},
                              {"jobs", cause.jobs},
                              {"states", cause.states},
                              {"examples", cause.examples},
                              {"newest_unix_s", cause.newest_unix_s}});
  }
  json["trains"] = study.spec().has_train() || study.spec().has_evaluate();
  json["tags"] = std::vector<std::string>(study.spec().tags().begin(), study.spec().tags().end());
  json["yaml"] = study.spec().source_yaml();
  return json;
}

Json UsersJson(const std::vector<v1::UserStatus>& all) {
  return {{"users", JsonList(all, UserJson)}};
}

Json JobLineJson(const v1::JobStatus& job) {
  return {{"id", job.job_id()},
          {"kind", job.kind()},
          {"state", job.state()},
          {"variant", job.variant()},
          {"scene", job.label().empty() ? SceneOrNull(job.scene()) : Json(nullptr)},
          {"rigs", RigsOf(job)},
          {"label", job.label()},
          {"attempts", job.attempts()},
          {"worker", job.worker()},
          {"fraction", job.fraction()},
          {"stage", job.stage()},
          {"figures", FiguresJson(job.figures())},
          {"error", job.error()},
          {"waits_reason", job.waits_reason()},
          {"waits_text", job.waits_text()}};
}

Json JobJson(const JobDetail& job) {
  Json json = JobLineJson(job.status);
  json["study_id"] = job.study_id;
  json["study"] = job.study;
  json["fence"] = job.fence == 0 ? Json(nullptr) : Json(std::to_string(job.fence));
  json["generation"] = job.generation;
  json["app_failures"] = job.app_failures;
  json["infra_losses"] = job.infra_losses;
  json["reused"] = job.reused;
  json["awaits_job"] = job.awaits_job == 0 ? Json(nullptr) : Json(job.awaits_job);
  json["ready_unix_s"] = OrNull(job.ready_unix_s);
  json["finished_unix_s"] = OrNull(job.finished_unix_s);
  json["not_before_unix_s"] = OrNull(job.not_before_unix_s);
  json["lost_attempts"] = Json::array();
  for (const LostAttempt& attempt : job.attempts) {
    json["lost_attempts"].push_back({{"fence", std::to_string(attempt.fence)},
                                     {"end", attempt.ledger},
                                     {"worker", attempt.worker},
                                     {"fingerprint", attempt.fingerprint},
                                     {"error", attempt.error},
                                     {"unix_s", attempt.unix_s},
                                     {"has_log", !attempt.log_tail.empty()}});
  }
  json["files"] = Json::array();
  for (const v1::FileEntry& file : job.result_files) {
    json["files"].push_back({{"name", file.name()}, {"size", file.size()}});
  }
  std::map<std::string, double> stages;
  json["pairs"] = Json::array();
  for (const PublishedPair& pair : job.pairs) {
    json["pairs"].push_back(PairLineJson(pair));
    for (const auto& [stage, seconds] : pair.frame.stage_s()) stages[stage] += seconds;
  }
  json["stage_s"] = stages;
  return json;
}

Json PairLineJson(const PublishedPair& pair) {
  return {{"id", pair.number},
          {"variant", pair.variant},
          {"scene", pair.scene},
          {"rig", pair.frame.rig()},
          {"reused", pair.reused}};
}

Json PairJson(const PublishedPair& pair, const PageReader::Neighbours& neighbours) {
  Json json = PairLineJson(pair);
  json["study_id"] = pair.study_id;
  json["study"] = pair.study;
  json["older"] = neighbours.older == 0 ? Json(nullptr) : Json(neighbours.older);
  json["newer"] = neighbours.newer == 0 ? Json(nullptr) : Json(neighbours.newer);
  json["path"] = pair.frame.path();
  json["files"] = Json::array();
  for (const v1::FileEntry& file : pair.frame.files()) {
    json["files"].push_back({{"name", file.name()}, {"size", file.size()}});
  }
  json["statistics"] = FiguresJson(pair.frame.statistics());
  json["stage_s"] = FiguresJson(pair.frame.stage_s());
  return json;
}

}  // namespace parallax
