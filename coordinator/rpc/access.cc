#include "coordinator/rpc/access.h"

#include <algorithm>

namespace parallax {
namespace {

struct Row {
  std::string_view method;
  std::vector<Role> roles;
};

const std::vector<Row>& Table() {
  static const auto* const table = new std::vector<Row>{
      // ---- Workers
      {"/parallax.v1.Coordinator/Work", {Role::kWorker}},
      {"/parallax.v1.Coordinator/Complete", {Role::kWorker}},
      {"/parallax.v1.Coordinator/Fail", {Role::kWorker}},
      // ---- Studies. A submitter steers what it submitted; the service sees to that.
      {"/parallax.v1.Coordinator/Submit", {Role::kSubmitter, Role::kOperator}},
      {"/parallax.v1.Coordinator/Cancel", {Role::kSubmitter, Role::kOperator}},
      {"/parallax.v1.Coordinator/Pause", {Role::kSubmitter, Role::kOperator}},
      {"/parallax.v1.Coordinator/Resume", {Role::kSubmitter, Role::kOperator}},
      {"/parallax.v1.Coordinator/Retry", {Role::kSubmitter, Role::kOperator}},
      {"/parallax.v1.Coordinator/Forget", {Role::kSubmitter, Role::kOperator}},
      {"/parallax.v1.Coordinator/SetMaxRunning", {Role::kSubmitter, Role::kOperator}},
      {"/parallax.v1.Coordinator/SetPriority", {Role::kSubmitter, Role::kOperator}},
      {"/parallax.v1.Coordinator/RetryJob", {Role::kSubmitter, Role::kOperator}},
      {"/parallax.v1.Coordinator/Comment", {Role::kSubmitter, Role::kOperator}},
      {"/parallax.v1.Coordinator/DrainWorkers", {Role::kOperator}},
      // ---- Looking
      {"/parallax.v1.Coordinator/ListStudies",
       {Role::kSubmitter, Role::kOperator, Role::kReadOnly}},
      {"/parallax.v1.Coordinator/GetStudy", {Role::kSubmitter, Role::kOperator, Role::kReadOnly}},
      {"/parallax.v1.Coordinator/ListJobs", {Role::kSubmitter, Role::kOperator, Role::kReadOnly}},
      {"/parallax.v1.Coordinator/ListAttempts",
       {Role::kSubmitter, Role::kOperator, Role::kReadOnly}},
      {"/parallax.v1.Coordinator/ListWorkers",
       {Role::kSubmitter, Role::kOperator, Role::kReadOnly}},
      {"/parallax.v1.Coordinator/ListUsers", {Role::kSubmitter, Role::kOperator, Role::kReadOnly}},
      {"/parallax.v1.Coordinator/ListFrames", {Role::kSubmitter, Role::kOperator, Role::kReadOnly}},
      {"/parallax.v1.Coordinator/ListResults",
       {Role::kSubmitter, Role::kOperator, Role::kReadOnly}},
      {"/parallax.v1.Coordinator/GetScene", {Role::kSubmitter, Role::kOperator, Role::kReadOnly}},
      {"/parallax.v1.Coordinator/GetInfo",
       {Role::kWorker, Role::kSubmitter, Role::kOperator, Role::kReadOnly}},
      {"/parallax.v1.Coordinator/ListAudit", {Role::kOperator}},
      {"/parallax.v1.Coordinator/OpenPage", {Role::kSubmitter, Role::kOperator, Role::kReadOnly}},
      // ---- Streams. A submitter takes pairs of its own streams; the service sees to that.
      {"/parallax.v1.Streams/Open", {Role::kSubmitter, Role::kOperator}},
      {"/parallax.v1.Streams/Close", {Role::kSubmitter, Role::kOperator}},
      {"/parallax.v1.Streams/Next", {Role::kSubmitter, Role::kOperator}},
      {"/parallax.v1.Streams/List", {Role::kSubmitter, Role::kOperator, Role::kReadOnly}},
      // ---- Searches. A submitter stops its own ones; the service sees to that.
      {"/parallax.v1.Searches/Open", {Role::kSubmitter, Role::kOperator}},
      {"/parallax.v1.Searches/Stop", {Role::kSubmitter, Role::kOperator}},
      {"/parallax.v1.Searches/List", {Role::kSubmitter, Role::kOperator, Role::kReadOnly}},
      // ---- Files
      // Submitters bring the content that their studies name; the service sees to that.
      {"/parallax.v1.Artifacts/Put", {Role::kWorker, Role::kSubmitter, Role::kOperator}},
      {"/parallax.v1.Artifacts/Remove", {Role::kWorker}},
      // Workers read the pairs that they train on, and earlier attempts' checkpoints.
      {"/parallax.v1.Artifacts/Get",
       {Role::kWorker, Role::kSubmitter, Role::kOperator, Role::kReadOnly}},
      {"/parallax.v1.Artifacts/List",
       {Role::kWorker, Role::kSubmitter, Role::kOperator, Role::kReadOnly}},
  };
  return *table;
}

std::string NamesOf(const std::vector<Role>& roles) {
  std::string names;
  for (size_t i = 0; i < roles.size(); ++i) {
    names += (i == 0 ? "" : i + 1 < roles.size() ? ", " : " or ") + std::string(RoleName(roles[i]));
  }
  return names;
}

}  // namespace

std::optional<std::vector<Role>> RolesOf(std::string_view method) {
  for (const Row& row : Table()) {
    if (row.method == method) return row.roles;
  }
  return std::nullopt;
}

absl::Status CheckAccess(const RpcCaller& caller, std::string_view method) {
  if (!caller.has_certificate) return absl::OkStatus();
  const std::string call(method.substr(method.rfind('/') + 1));
  const std::optional<std::vector<Role>> allowed = RolesOf(method);
  if (!allowed) return PermissionDenied("{} is open to no role", call);
  if (caller.role && std::count(allowed->begin(), allowed->end(), *caller.role) > 0) {
    return absl::OkStatus();
  }
  const std::string role(caller.role ? RoleName(*caller.role) : "none of a client");
  return PermissionDenied(
      "{} is for the role {}; the certificate of '{}' has the role {} (the farm's operator issues "
      "others with `coordinator init DIR --issue ROLE NAME`)",
      call, NamesOf(*allowed), caller.name, role);
}

}  // namespace parallax
