// Routes that sign a caller in and out: sessions and one-time links.
#include "common/base/status.h"
#include "common/base/system/secret.h"
#include "coordinator/http/api.h"
#include "coordinator/http/api_json.h"

namespace parallax {
namespace {

constexpr size_t kLongestSecret = 200;
constexpr double kLinkValid_s = 600;

std::string CookieHeader(const ApiParts& parts, const std::string& session) {
  return parts.cookie + "=" + session + "; Path=/; HttpOnly; SameSite=Strict" +
         (parts.secure_cookie ? "; Secure" : "") + (session.empty() ? "; Max-Age=0" : "");
}

absl::StatusOr<WebReply> Me(const WebRequest& request) {
  const RpcCaller& caller = request.caller.rpc;
  return JsonReply(
      JsonText({{"name", caller.has_certificate ? caller.name : "this machine"},
                {"role", std::string(!caller.has_certificate ? RoleName(Role::kOperator)
                                     : caller.role           ? RoleName(*caller.role)
                                                             : "none")},
                {"session", !request.caller.session.empty()},
                {"csrf", request.caller.csrf}}));
}

absl::StatusOr<WebReply> OpenSession(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const std::string code, TextIn(request, "code", kLongestSecret));
  ASSIGN_OR_RETURN(const std::string token, TextIn(request, "token", kLongestSecret));
  std::string session;
  if (!code.empty()) {
    ASSIGN_OR_RETURN(session, parts.sessions.Redeem(code));
  } else if (!parts.token.empty() && SameSecret(token, parts.token)) {
    ASSIGN_OR_RETURN(session, parts.sessions.Open(TokenCaller()));
  } else {
    return Unauthenticated("this is not the token of the coordinator's http.token");
  }
  WebReply reply = JsonReply("{}\n");
  reply.headers.emplace_back("Set-Cookie", CookieHeader(parts, session));
  return reply;
}

absl::StatusOr<WebReply> EndSession(ApiParts& parts, const WebRequest& request) {
  parts.sessions.End(request.caller.session);
  WebReply reply = JsonReply("{}\n");
  reply.headers.emplace_back("Set-Cookie", CookieHeader(parts, ""));
  return reply;
}

// Needs a certificate or the token itself: a session cannot extend itself.
absl::StatusOr<WebReply> NewLink(ApiParts& parts, const WebRequest& request) {
  if (!request.caller.session.empty()) {
    return PermissionDenied("a session makes no links; `parallax page` does");
  }
  ASSIGN_OR_RETURN(const std::string code,
                   parts.sessions.NewCode(request.caller.rpc, kLinkValid_s));
  return JsonReply(JsonText({{"code", code}, {"valid_s", kLinkValid_s}}));
}

}  // namespace

void AddSessionRoutes(ApiParts& parts, std::vector<WebRoute>& routes) {
  routes.push_back({"GET", "/api/v1/me", "/api/v1/me", WebAccess::kKnown, "", Me});
  routes.push_back({"POST", "/api/v1/session", "/api/v1/session", WebAccess::kAnybody, "",
                    [&parts](const WebRequest& r) { return OpenSession(parts, r); }});
  routes.push_back({"POST", "/api/v1/session/end", "/api/v1/session/end", WebAccess::kKnown, "",
                    [&parts](const WebRequest& r) { return EndSession(parts, r); }});
  routes.push_back({"POST", "/api/v1/links", "/api/v1/links", WebAccess::kKnown, "",
                    [&parts](const WebRequest& r) { return NewLink(parts, r); }});
}

}  // namespace parallax
