// Requests, replies and routes of the web page's API, without types of the HTTP library.
//
// The table of routes is closed: the server registers only its rows, and every row names the RPC
// whose roles may use it. A test tries all rows as a stranger, so a new row can't be forgotten.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "common/rpc/endpoint.h"

namespace parallax {

// The caller of a request.
struct WebCaller {
  RpcCaller rpc;        // Name and role, as for an RPC.
  std::string actor;    // Entry in the audit table: "submitter ada https:10.0.0.7".
  std::string session;  // Name of the session; empty without one.
  std::string csrf;     // Value of the CSRF header that a request needs to change something.
};

// A request that has matched a route.
struct WebRequest {
  std::vector<std::string> parts;  // Matches of the groups in the route's pattern.
  std::map<std::string, std::string> query;
  std::string body;
  std::string if_none_match;
  std::function<absl::Status(int64_t bytes)> reserve;  // As ServerRequest has it.
  WebCaller caller;
};

struct WebReply {
  int status = 200;
  std::string type = "application/json";
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers;
};

// The callers that a route accepts.
enum class WebAccess {
  kRoles,    // Callers with a role of WebRoute::rpc.
  kKnown,    // Callers with any certificate, token or session.
  kAnybody,  // All callers, strangers too.
};

// A row of the table: which requests it matches, who may use it, and what answers it.
struct WebRoute {
  const char* method;   // "GET" or "POST". A POST changes something and needs the CSRF header.
  const char* pattern;  // A regular expression for the whole path.
  const char* example;  // A path that it matches, for tests.
  WebAccess access = WebAccess::kRoles;
  const char* rpc = "";  // For example "ListStudies": see coordinator/rpc/access.h.
  std::function<absl::StatusOr<WebReply>(const WebRequest&)> handler;
  bool events = false;  // Answered by the server with the stream of events, not by a handler.
};

// Returns the reply for an error: 400, 401, 403, 404, 409, 503 or 500 by its code, with the body
// {"error": {"code", "message"}}.
WebReply ErrorReply(const absl::Status& status);

// Checks that the caller may use the route. Errors: kUnauthenticated for a stranger (`caller`
// null); kPermissionDenied for a role that may not.
absl::Status CheckWebAccess(const WebRoute& route, const WebCaller* caller);

}  // namespace parallax
