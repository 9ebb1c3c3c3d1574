// A study: progress, problems, pairs, scores, jobs; and what may be done with it.
#include <fmt/core.h>

#include <charconv>

#include "common/base/names.h"
#include "common/base/status.h"
#include "common/config/check/limit_rules.h"
#include "common/config/check/limits.h"
#include "coordinator/http/api.h"
#include "coordinator/http/api_json.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/access.h"
#include "coordinator/rpc/coordinator_server.h"
#include "coordinator/rpc/workers/steering.h"
#include "coordinator/rpc/workers/wait_reasons.h"
#include "coordinator/view/json_list.h"

namespace parallax {
namespace {

using Reply = absl::StatusOr<WebReply>;
using StudyCall = absl::Status (JobQueue::*)(StudyId, std::string_view, std::string_view);

constexpr int kMostStudies = 200;
constexpr int kMostJobs = 1000;
constexpr int kMostResults = 1000;

Reply Studies(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const int64_t limit, NumberIn(request, "limit", 50, 1, kMostStudies));
  ASSIGN_OR_RETURN(const int64_t before, NumberIn(request, "before", 0, 0, INT64_MAX));
  ASSIGN_OR_RETURN(auto studies, parts.queue.ListStudies(static_cast<int>(limit), before));
  for (v1::StudyStatus& study : studies) parts.server.waits().AddTo(study);
  const auto row = [](const v1::StudyStatus& study) { return StudyRowJson(study, -1); };
  return JsonReply(JsonText({{"studies", JsonList(studies, row)}}));
}

// Words of the actions that the caller may take now.
Json ActionsFor(ApiParts& parts, const WebCaller& caller, const v1::StudyStatus& study) {
  Json actions = Json::array();
  if (!CheckAccess(caller.rpc, "/parallax.v1.Coordinator/Pause").ok()) return actions;
  if (!CheckSteering(parts.queue, caller.rpc, StudyId{study.study_id()}).ok()) return actions;
  const bool running = study.state() == v1::STUDY_STATE_RUNNING;
  const bool paused = study.state() == v1::STUDY_STATE_PAUSED;
  bool has_failed = study.state() == v1::STUDY_STATE_FAILED;
  for (const v1::VariantStatus& variant : study.variants()) {
    for (const v1::JobCount& count : variant.jobs()) {
      has_failed |= count.state() == "FAILED" || count.state() == "QUARANTINED";
    }
  }
  if (running) actions.push_back("pause");
  if (paused) actions.push_back("resume");
  if (has_failed && study.state() != v1::STUDY_STATE_CANCELLED) actions.push_back("retry");
  if (running || paused) actions.insert(actions.end(), {"limit", "priority"});
  if (running || paused) actions.push_back("cancel");
  actions.push_back("comment");
  if (study.finished_unix_s() > 0) actions.push_back("forget");
  return actions;
}

Reply StudyReply(ApiParts& parts, const WebCaller& caller, int64_t id) {
  ASSIGN_OR_RETURN(v1::StudyStatus study, parts.queue.GetStudy(StudyId{id}));
  parts.server.waits().AddTo(study);
  ASSIGN_OR_RETURN(const auto causes, parts.reader.Problems(id));
  ASSIGN_OR_RETURN(const auto snapshot, parts.sampler.Take());
  const auto eta = snapshot->eta_s.find(id);
  Json json = StudyPageJson(study, eta == snapshot->eta_s.end() ? -1 : eta->second, causes);
  json["actions"] = ActionsFor(parts, caller, study);
  json["now_unix_s"] = snapshot->now_unix_s;
  return JsonReply(JsonText(json));
}

Reply Study(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const int64_t id, NumberOf(request, 0));
  return StudyReply(parts, request.caller, id);
}

// Returns the number of the study that the path names. Errors: kNotFound if none exists.
absl::StatusOr<int64_t> KnownStudy(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const int64_t id, NumberOf(request, 0));
  RETURN_IF_ERROR(parts.queue.GetStudy(StudyId{id}).status());
  return id;
}

Reply Pairs(ApiParts& parts, const WebRequest& request) {
  PairQuery query;
  ASSIGN_OR_RETURN(query.study_id, KnownStudy(parts, request));
  ASSIGN_OR_RETURN(query.before, NumberIn(request, "before", 0, 0, INT64_MAX));
  ASSIGN_OR_RETURN(const int64_t limit, NumberIn(request, "limit", query.limit, 1, 200));
  query.limit = static_cast<int>(limit);
  if (const auto variant = request.query.find("variant"); variant != request.query.end()) {
    query.variant = variant->second;
  }
  ASSIGN_OR_RETURN(const auto pairs, parts.reader.NewestPairs(query));
  return JsonReply(JsonText({{"pairs", JsonList(pairs, PairLineJson)}}));
}

Reply Scores(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const int64_t id, KnownStudy(parts, request));
  ASSIGN_OR_RETURN(const auto scores, parts.reader.Scores(id));
  return JsonReply(JsonText(ScoresJson(scores)));
}

// Results with files, other than pairs: trained networks and scores.
Reply Results(ApiParts& parts, const WebRequest& request) {
  v1::ListResultsRequest asked;
  ASSIGN_OR_RETURN(const int64_t id, KnownStudy(parts, request));
  ASSIGN_OR_RETURN(const int64_t after, NumberIn(request, "after", 0, 0, INT64_MAX));
  asked.set_study_id(id);
  asked.set_cursor(after);
  asked.set_limit(kMostResults);
  ASSIGN_OR_RETURN(const auto results, parts.queue.ListResults(asked));
  const bool more = results.size() == static_cast<size_t>(kMostResults);
  Json json = {{"results", Json::array()},
               {"next", more ? Json(results.back().cursor()) : Json(nullptr)}};
  for (const v1::JobResult& result : results) {
    Json files = Json::array();
    for (const v1::FileEntry& file : result.files()) files.push_back(file.name());
    json["results"].push_back({{"job", result.job_id()},
                               {"kind", result.kind()},
                               {"variant", result.variant()},
                               {"label", result.label()},
                               {"files", std::move(files)}});
  }
  return JsonReply(JsonText(json));
}

// The table of results with intervals and verdicts, as `parallax table` prints it.
Reply Table(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const int64_t id, KnownStudy(parts, request));
  if (parts.table == nullptr) return NotFound("this coordinator makes no tables");
  ASSIGN_OR_RETURN(const std::string json, parts.table(id));
  return JsonReply(json);
}

// Where a page of jobs ends, "STATE:ID", and how the next one is asked for.
std::string EndOfPage(const v1::JobStatus& last) {
  return fmt::format("{}:{}", last.state(), last.job_id());
}
absl::Status GoOnBehind(const std::string& text, v1::ListJobsRequest& asked) {
  const size_t colon = std::min(text.find(':'), text.size());
  int64_t job = 0;
  const char* const end = text.data() + text.size();
  const auto number = std::from_chars(text.data() + std::min(colon + 1, text.size()), end, job);
  if (colon == 0 || number.ec != std::errc() || number.ptr != end || job <= 0) {
    return InvalidArgument("after={}: wanted STATE:ID, as in `next`", Quoted(text));
  }
  asked.set_after_state(text.substr(0, colon));
  asked.set_after_job(job);
  return absl::OkStatus();
}

Reply Jobs(ApiParts& parts, const WebRequest& request) {
  v1::ListJobsRequest asked;
  ASSIGN_OR_RETURN(const int64_t id, KnownStudy(parts, request));
  ASSIGN_OR_RETURN(const int64_t limit, NumberIn(request, "limit", 200, 1, kMostJobs));
  asked.set_study_id(id);
  asked.set_limit(static_cast<int>(limit));
  if (const auto state = request.query.find("state"); state != request.query.end()) {
    asked.set_state(state->second);
  }
  if (const auto after = request.query.find("after"); after != request.query.end()) {
    RETURN_IF_ERROR(GoOnBehind(after->second, asked));
  }
  ASSIGN_OR_RETURN(auto jobs, parts.queue.ListJobs(asked));
  RETURN_IF_ERROR(parts.server.waits().AddTo(jobs, id));
  const bool more = static_cast<int64_t>(jobs.size()) == limit;
  return JsonReply(JsonText({{"jobs", JsonList(jobs, JobLineJson)},
                             {"limit", limit},
                             {"next", more ? Json(EndOfPage(jobs.back())) : Json(nullptr)}}));
}

// ---- Actions
Reply Steer(ApiParts& parts, const WebRequest& request, StudyCall call) {
  ASSIGN_OR_RETURN(const int64_t id, NumberOf(request, 0));
  ASSIGN_OR_RETURN(const std::string reason, TextIn(request, "reason", kMaxReasonBytes));
  RETURN_IF_ERROR(CheckSteering(parts.queue, request.caller.rpc, StudyId{id}));
  JobQueue& queue = parts.queue;
  RETURN_IF_ERROR((queue.*call)(StudyId{id}, reason, request.caller.actor));
  return StudyReply(parts, request.caller, id);
}

Reply Limit(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const int64_t id, NumberOf(request, 0));
  ASSIGN_OR_RETURN(const std::string reason, TextIn(request, "reason", kMaxReasonBytes));
  ASSIGN_OR_RETURN(const int64_t most, WholeNumberIn(request, "max_running", 0, kMostRunning));
  RETURN_IF_ERROR(CheckSteering(parts.queue, request.caller.rpc, StudyId{id}));
  RETURN_IF_ERROR(parts.queue.SetMaxRunning(StudyId{id}, most, reason, request.caller.actor));
  return StudyReply(parts, request.caller, id);
}

Reply Priority(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const int64_t id, NumberOf(request, 0));
  ASSIGN_OR_RETURN(const std::string reason, TextIn(request, "reason", kMaxReasonBytes));
  ASSIGN_OR_RETURN(const int64_t priority,
                   WholeNumberIn(request, "priority", -kMaxPriority, kMaxPriority));
  RETURN_IF_ERROR(CheckSteering(parts.queue, request.caller.rpc, StudyId{id}));
  RETURN_IF_ERROR(CheckPriority(request.caller.rpc, static_cast<int>(priority)));
  RETURN_IF_ERROR(parts.queue.SetPriority(StudyId{id}, static_cast<int>(priority), reason,
                                          request.caller.actor));
  return StudyReply(parts, request.caller, id);
}

Reply Retry(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const int64_t id, NumberOf(request, 0));
  ASSIGN_OR_RETURN(const std::string reason, TextIn(request, "reason", kMaxReasonBytes));
  RETURN_IF_ERROR(CheckSteering(parts.queue, request.caller.rpc, StudyId{id}));
  RETURN_IF_ERROR(parts.queue.Retry(StudyId{id}, request.caller.actor, reason).status());
  return StudyReply(parts, request.caller, id);
}

Reply RetryJob(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const int64_t id, NumberOf(request, 0));
  ASSIGN_OR_RETURN(const int64_t job, NumberOf(request, 1));
  ASSIGN_OR_RETURN(const std::string reason, TextIn(request, "reason", kMaxReasonBytes));
  RETURN_IF_ERROR(CheckSteering(parts.queue, request.caller.rpc, StudyId{id}));
  RETURN_IF_ERROR(parts.queue.RetryJob(StudyId{id}, job, reason, request.caller.actor));
  return StudyReply(parts, request.caller, id);
}

Reply Forget(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const int64_t id, NumberOf(request, 0));
  ASSIGN_OR_RETURN(const std::string reason, TextIn(request, "reason", kMaxReasonBytes));
  RETURN_IF_ERROR(CheckSteering(parts.queue, request.caller.rpc, StudyId{id}));
  ASSIGN_OR_RETURN(const v1::ForgetReply had,
                   parts.queue.Forget(StudyId{id}, reason, request.caller.actor));
  return JsonReply(JsonText({{"forgotten", true},
                             {"jobs", had.jobs()},
                             {"pairs", had.pairs()},
                             {"results", had.results()}}));
}

}  // namespace

void AddStudyRoutes(ApiParts& parts, std::vector<WebRoute>& routes) {
  const auto add = [&](const char* method, const char* pattern, const char* example,
                       const char* rpc, Reply (*handler)(ApiParts&, const WebRequest&)) {
    routes.push_back({method, pattern, example, WebAccess::kRoles, rpc,
                      [&parts, handler](const WebRequest& r) { return handler(parts, r); }});
  };
  const auto steer = [&](const char* pattern, const char* example, const char* rpc,
                         StudyCall call) {
    routes.push_back({"POST", pattern, example, WebAccess::kRoles, rpc,
                      [&parts, call](const WebRequest& r) { return Steer(parts, r, call); }});
  };
  add("GET", "/api/v1/studies", "/api/v1/studies", "ListStudies", Studies);
  add("GET", "/api/v1/studies/(\\d+)", "/api/v1/studies/1", "GetStudy", Study);
  add("GET", "/api/v1/studies/(\\d+)/pairs", "/api/v1/studies/1/pairs", "ListFrames", Pairs);
  add("GET", "/api/v1/studies/(\\d+)/scores", "/api/v1/studies/1/scores", "ListResults", Scores);
  add("GET", "/api/v1/studies/(\\d+)/results", "/api/v1/studies/1/results", "ListResults", Results);
  add("GET", "/api/v1/studies/(\\d+)/table", "/api/v1/studies/1/table", "ListResults", Table);
  add("GET", "/api/v1/studies/(\\d+)/jobs", "/api/v1/studies/1/jobs", "ListJobs", Jobs);
  steer("/api/v1/studies/(\\d+)/pause", "/api/v1/studies/1/pause", "Pause", &JobQueue::Pause);
  steer("/api/v1/studies/(\\d+)/resume", "/api/v1/studies/1/resume", "Resume", &JobQueue::Resume);
  steer("/api/v1/studies/(\\d+)/cancel", "/api/v1/studies/1/cancel", "Cancel", &JobQueue::Cancel);
  steer("/api/v1/studies/(\\d+)/comment", "/api/v1/studies/1/comment", "Comment",
        &JobQueue::Comment);
  add("POST", "/api/v1/studies/(\\d+)/limit", "/api/v1/studies/1/limit", "SetMaxRunning", Limit);
  add("POST", "/api/v1/studies/(\\d+)/priority", "/api/v1/studies/1/priority", "SetPriority",
      Priority);
  add("POST", "/api/v1/studies/(\\d+)/jobs/(\\d+)/retry", "/api/v1/studies/1/jobs/1/retry",
      "RetryJob", RetryJob);
  add("POST", "/api/v1/studies/(\\d+)/retry", "/api/v1/studies/1/retry", "Retry", Retry);
  add("POST", "/api/v1/studies/(\\d+)/forget", "/api/v1/studies/1/forget", "Forget", Forget);
}

}  // namespace parallax
