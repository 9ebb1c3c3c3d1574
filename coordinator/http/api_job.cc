// A job: its attempts, its stages, its log.
#include "coordinator/http/api.h"
#include "coordinator/http/api_json.h"
#include "coordinator/queue/job_queue.h"

namespace parallax {
namespace {

using Reply = absl::StatusOr<WebReply>;

constexpr int kMostLeased = 10'000;

// Adds the progress of a leased job, which is known only from its worker's heartbeats.
absl::Status AddProgress(JobQueue& queue, JobDetail& job) {
  if (job.status.state() != "LEASED") return absl::OkStatus();
  v1::ListJobsRequest asked;
  asked.set_study_id(job.study_id);
  asked.set_state("LEASED");
  asked.set_limit(kMostLeased);
  ASSIGN_OR_RETURN(const auto leased, queue.ListJobs(asked));
  for (const v1::JobStatus& one : leased) {
    if (one.job_id() != job.status.job_id()) continue;
    job.status.set_fraction(one.fraction());
    job.status.set_stage(one.stage());
    *job.status.mutable_figures() = one.figures();
  }
  return absl::OkStatus();
}

Reply Job(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const int64_t id, NumberOf(request, 0));
  ASSIGN_OR_RETURN(JobDetail job, parts.reader.Job(id));
  RETURN_IF_ERROR(AddProgress(parts.queue, job));
  return JsonReply(JsonText(JobJson(job)));
}

// The last lines of each attempt that failed, the newest attempt first.
Reply Log(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const int64_t id, NumberOf(request, 0));
  ASSIGN_OR_RETURN(const JobDetail job, parts.reader.Job(id));
  Json json = {{"attempts", Json::array()}};
  for (auto attempt = job.attempts.rbegin(); attempt != job.attempts.rend(); ++attempt) {
    if (attempt->log_tail.empty()) continue;
    json["attempts"].push_back({{"fence", std::to_string(attempt->fence)},
                                {"worker", attempt->worker},
                                {"unix_s", attempt->unix_s},
                                {"error", attempt->error},
                                {"log", attempt->log_tail}});
  }
  return JsonReply(JsonText(json));
}

}  // namespace

void AddJobRoutes(ApiParts& parts, std::vector<WebRoute>& routes) {
  const auto add = [&](const char* pattern, const char* example,
                       Reply (*handler)(ApiParts&, const WebRequest&)) {
    routes.push_back({"GET", pattern, example, WebAccess::kRoles, "ListJobs",
                      [&parts, handler](const WebRequest& r) { return handler(parts, r); }});
  };
  add("/api/v1/jobs/(\\d+)", "/api/v1/jobs/1", Job);
  add("/api/v1/jobs/(\\d+)/log", "/api/v1/jobs/1/log", Log);
}

}  // namespace parallax
