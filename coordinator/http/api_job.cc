// A job: its attempts, its stages, its log.
#include "common/base/names.h"
#include "common/base/status.h"
#include "coordinator/http/api.h"
#include "coordinator/http/api_json.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/coordinator_server.h"
#include "coordinator/rpc/workers/wait_reasons.h"

namespace parallax {
namespace {

using Reply = absl::StatusOr<WebReply>;

constexpr int64_t kMostJobFileBytes = 100'000'000;

// Adds what is not in the database: the progress of a leased job, the reason of a READY one.
absl::Status AddPresent(ApiParts& parts, JobDetail& job) {
  ASSIGN_OR_RETURN(v1::ListAttemptsReply now, parts.queue.ListAttempts(job.status.job_id()));
  if (now.job().state() != job.status.state()) return absl::OkStatus();  // It has just moved.
  job.status.Swap(now.mutable_job());
  return parts.server.waits().AddTo({&job.status, 1}, job.study_id);
}

Reply Job(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const int64_t id, NumberOf(request, 0));
  ASSIGN_OR_RETURN(JobDetail job, parts.reader.Job(id));
  RETURN_IF_ERROR(AddPresent(parts, job));
  return JsonReply(JsonText(JobJson(job)));
}

// The last lines of the attempt that runs and of each that failed, the newest attempt first.
Reply Log(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const int64_t id, NumberOf(request, 0));
  ASSIGN_OR_RETURN(const JobDetail job, parts.reader.Job(id));
  ASSIGN_OR_RETURN(const v1::ListAttemptsReply now, parts.queue.ListAttempts(id));
  Json json = {{"attempts", Json::array()}};
  for (const v1::AttemptStatus& attempt : now.attempts()) {
    if (attempt.ending() != "running") continue;
    json["attempts"].push_back({{"fence", std::to_string(attempt.attempt().fence())},
                                {"worker", attempt.worker()},
                                {"unix_s", nullptr},
                                {"error", ""},
                                {"log", attempt.log_tail()}});
  }
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

// A file of the job's result as it is: a checkpoint, a curve, scores.
Reply JobFile(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const int64_t id, NumberOf(request, 0));
  ASSIGN_OR_RETURN(const JobDetail job, parts.reader.Job(id));
  const std::string& name = request.parts.at(1);
  for (const v1::FileEntry& file : job.result_files) {
    if (file.name() != name) continue;
    if (file.size() > kMostJobFileBytes) {
      return FailedPrecondition(
          "job {}: {} has {} MB, the page gives files of at most {} MB; "
          "`parallax fetch` copies it",
          id, name, file.size() / 1'000'000, kMostJobFileBytes / 1'000'000);
    }
    RETURN_IF_ERROR(request.reserve(file.size()));
    WebReply reply;
    reply.type = "application/octet-stream";
    ASSIGN_OR_RETURN(reply.body, parts.pictures.File(job.result_path + "/" + name));
    return reply;
  }
  return NotFound("job {} has no file {}", id, Quoted(name));
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
  add("/api/v1/jobs/(\\d+)/file/([^/]+)", "/api/v1/jobs/1/file/log.txt", JobFile);
}

}  // namespace parallax
