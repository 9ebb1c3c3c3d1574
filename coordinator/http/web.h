// Requests and replies of the web page's API, free of the HTTP library, and the table of its
// routes.
//
// The table is closed: the server registers nothing but its rows, and every row says which RPC's
// roles may use it. A test walks it with a stranger, so that a new row can't be forgotten.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "common/rpc/endpoint.h"

namespace parallax {

// Who asks.
struct WebCaller {
  RpcCaller rpc;        // As of an RPC.
  std::string actor;    // For the audit table: "submitter ada https:10.0.0.7".
  std::string session;  // Name of the session; empty without one.
  std::string csrf;     // What the header of a request that changes something must say.
};

struct WebRequest {
  std::vector<std::string> parts;  // What the groups of the route's pattern matched.
  std::map<std::string, std::string> query;
  std::string body;
  std::string if_none_match;
  WebCaller caller;
};

struct WebReply {
  int status = 200;
  std::string type = "application/json";
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers;
};

// Whom a route lets in.
enum class WebAccess {
  kRoles,    // The roles of WebRoute::rpc.
  kKnown,    // Whoever shows any certificate, token or session.
  kAnybody,  // Strangers too.
};

struct WebRoute {
  const char* method;   // "GET" or "POST". A POST changes something and needs the CSRF header.
  const char* pattern;  // A regular expression for the whole path.
  const char* example;  // A path that it matches, for tests.
  WebAccess access = WebAccess::kRoles;
  const char* rpc = "";  // For example "ListStudies": see coordinator/rpc/access.h.
  std::function<absl::StatusOr<WebReply>(const WebRequest&)> handler;
  bool events = false;  // Answered by the server with the stream of events, not by a handler.
};

// 400, 401, 403, 404, 409, 503 or 500, with {"error": {"code", "message"}}.
WebReply ErrorReply(const absl::Status& status);

// Whether the caller may use the route. Errors: kUnauthenticated for a stranger (`caller` null);
// kPermissionDenied.
absl::Status CheckWebAccess(const WebRoute& route, const WebCaller* caller);

}  // namespace parallax
