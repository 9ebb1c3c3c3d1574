#include "coordinator/http/web.h"

#include <nlohmann/json.hpp>

#include "coordinator/rpc/access.h"

namespace parallax {
namespace {

int HttpStatusOf(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kOutOfRange:
      return 400;
    case absl::StatusCode::kUnauthenticated:
      return 401;
    case absl::StatusCode::kPermissionDenied:
      return 403;
    case absl::StatusCode::kNotFound:
      return 404;
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kAborted:
      return 409;
    case absl::StatusCode::kDeadlineExceeded:
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kResourceExhausted:
      return 503;
    default:
      return 500;
  }
}

}  // namespace

WebReply ErrorReply(const absl::Status& status) {
  const nlohmann::json body = {{"error",
                                {{"code", absl::StatusCodeToString(status.code())},
                                 {"message", std::string(status.message())}}}};
  return WebReply{
      .status = HttpStatusOf(status.code()),
      .body = body.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n"};
}

absl::Status CheckWebAccess(const WebRoute& route, const WebCaller* caller) {
  if (route.access == WebAccess::kAnybody) return absl::OkStatus();
  if (caller == nullptr) {
    return Unauthenticated(
        "who are you? A client certificate, the token of the coordinator's http.token, or a link "
        "of `parallax page` is needed");
  }
  if (route.access == WebAccess::kKnown) return absl::OkStatus();
  return CheckAccess(caller->rpc, std::string("/parallax.v1.Coordinator/") + route.rpc);
}

}  // namespace parallax
