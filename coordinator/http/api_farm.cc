// The farm as a whole: figures, history, workers, who did what, health and metrics.
#include "common/base/names.h"
#include "common/base/version.h"
#include "coordinator/http/api.h"
#include "coordinator/http/api_json.h"
#include "coordinator/http/metrics_text.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/validation.h"
#include "coordinator/view/json_list.h"
#include "coordinator/view/status_view.h"

namespace parallax {
namespace {

using Reply = absl::StatusOr<WebReply>;

Reply Farm(ApiParts& parts, const WebRequest&) {
  ASSIGN_OR_RETURN(const auto snapshot, parts.sampler.Take());
  return JsonReply(JsonText(FarmJson(*snapshot)));
}

Reply FarmHistory(ApiParts& parts, const WebRequest&) {
  return JsonReply(JsonText(HistoryJson(parts.sampler.History())));
}

Reply Workers(ApiParts& parts, const WebRequest&) {
  ASSIGN_OR_RETURN(const auto snapshot, parts.sampler.Take());
  return JsonReply(JsonText(WorkersJson(snapshot->workers)));
}

// An order to drain, or its end: workers whose names match go on with what they have and get
// nothing new.
Reply Drain(ApiParts& parts, const WebRequest& request, bool undo) {
  v1::DrainWorkersRequest asked;
  ASSIGN_OR_RETURN(*asked.mutable_pattern(), TextIn(request, "pattern", kMaxNameBytes));
  ASSIGN_OR_RETURN(*asked.mutable_reason(), TextIn(request, "reason", kMaxReasonBytes));
  RETURN_IF_ERROR(CheckDrain(asked));
  v1::DrainOrder order;
  order.set_pattern(asked.pattern());
  order.set_reason(asked.reason());
  order.set_actor(request.caller.actor);
  RETURN_IF_ERROR(parts.queue.Drain(order, undo));
  return JsonReply(JsonText(WorkersJson(parts.server.Workers())));
}

Reply Users(ApiParts& parts, const WebRequest&) {
  ASSIGN_OR_RETURN(const auto users, parts.queue.ListUsers());
  return JsonReply(JsonText(UsersJson(users)));
}

Reply Audit(ApiParts& parts, const WebRequest& request) {
  v1::ListAuditRequest asked;
  ASSIGN_OR_RETURN(const int64_t study, NumberIn(request, "study", 0, 0, INT64_MAX));
  ASSIGN_OR_RETURN(const int64_t before, NumberIn(request, "before", 0, 0, INT64_MAX));
  asked.set_study_id(study);
  asked.set_before(before);
  ASSIGN_OR_RETURN(const auto entries, parts.queue.ListAudit(asked));
  return JsonReply(JsonText({{"entries", JsonList(entries, AuditEntryJson)}}));
}

Reply Metrics(ApiParts& parts, const WebRequest&) {
  ASSIGN_OR_RETURN(const auto snapshot, parts.sampler.Take());
  WebReply reply;
  reply.type = "text/plain; version=0.0.4; charset=utf-8";
  reply.body = MetricsText(*snapshot);
  return reply;
}

// Healthy: the database answers, the store is there, and gRPC answers at its own addresses.
// Strangers learn no more than that.
Reply Health(ApiParts& parts, const WebRequest& request) {
  absl::Status status = parts.queue.ListStudies(1).status();
  if (status.ok()) status = parts.server.StoreStatus();
  if (status.ok()) status = parts.server.CheckAnswers();
  Json body = {{"status", status.ok() ? "ok" : "failing"}};
  if (!request.caller.actor.empty()) {
    body["version"] = kProgramVersion;
    body["epoch"] = parts.queue.epoch();
    body["schema_version"] = parts.queue.schema_version();
    body["uptime_s"] = parts.sampler.Uptime();
    body["workers"] = parts.server.Metrics().workers_connected;
    if (!status.ok()) body["error"] = status.ToString();
  }
  WebReply reply = JsonReply(JsonText(body));
  reply.status = status.ok() ? 200 : 503;
  return reply;
}

}  // namespace

void AddFarmRoutes(ApiParts& parts, std::vector<WebRoute>& routes) {
  const auto add = [&](const char* path, WebAccess access, const char* rpc,
                       Reply (*handler)(ApiParts&, const WebRequest&)) {
    routes.push_back({"GET", path, path, access, rpc,
                      [&parts, handler](const WebRequest& r) { return handler(parts, r); }});
  };
  add("/healthz", WebAccess::kAnybody, "", Health);
  add("/metrics", WebAccess::kRoles, "ListStudies", Metrics);
  add("/api/v1/farm", WebAccess::kRoles, "ListStudies", Farm);
  add("/api/v1/history", WebAccess::kRoles, "ListStudies", FarmHistory);
  add("/api/v1/users", WebAccess::kRoles, "ListUsers", Users);
  add("/api/v1/workers", WebAccess::kRoles, "ListWorkers", Workers);
  routes.push_back({"POST", "/api/v1/workers/drain", "/api/v1/workers/drain", WebAccess::kRoles,
                    "DrainWorkers",
                    [&parts](const WebRequest& r) { return Drain(parts, r, /*undo=*/false); }});
  routes.push_back({"POST", "/api/v1/workers/undrain", "/api/v1/workers/undrain", WebAccess::kRoles,
                    "DrainWorkers",
                    [&parts](const WebRequest& r) { return Drain(parts, r, /*undo=*/true); }});
  add("/api/v1/audit", WebAccess::kRoles, "ListAudit", Audit);
  WebRoute& events = routes.emplace_back();
  events = {"GET", "/api/v1/events", "/api/v1/events", WebAccess::kRoles, "ListStudies"};
  events.events = true;
}

}  // namespace parallax
