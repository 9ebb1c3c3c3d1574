// The routes of /api/v1, through which the web page reads and changes the queue. Thread-safe.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "coordinator/http/pictures.h"
#include "coordinator/http/sessions.h"
#include "coordinator/http/status_sampler.h"
#include "coordinator/http/web.h"
#include "coordinator/queue/reads/page_reader.h"

namespace parallax {

class CoordinatorServer;
class JobQueue;

// The objects behind the routes. All must outlive the routes.
struct ApiParts {
  JobQueue& queue;
  const CoordinatorServer& server;
  StatusSampler& sampler;
  PageReader& reader;
  Pictures& pictures;
  Sessions& sessions;
  // The token that opens a read-only session; if empty, no token does.
  std::string token;
  // Name of the session's cookie, and whether it is sent over HTTPS only.
  std::string cookie;
  bool secure_cookie = false;
  std::function<absl::StatusOr<std::string>(int64_t study)> table;  // See HttpServerOptions.
  std::function<std::string(const v1::SearchStatus&)> picture;      // See HttpServerOptions.
};

// Returns all routes, health and metrics too. `parts` must outlive them.
std::vector<WebRoute> ApiRoutes(ApiParts& parts);

// Add the routes of one subject; each function has a file of its own.
void AddSessionRoutes(ApiParts& parts, std::vector<WebRoute>& routes);
void AddFarmRoutes(ApiParts& parts, std::vector<WebRoute>& routes);
void AddStudyRoutes(ApiParts& parts, std::vector<WebRoute>& routes);
void AddSearchRoutes(ApiParts& parts, std::vector<WebRoute>& routes);
void AddPairRoutes(ApiParts& parts, std::vector<WebRoute>& routes);
void AddJobRoutes(ApiParts& parts, std::vector<WebRoute>& routes);

// Returns the caller for a request with the farm's token: it may read.
RpcCaller TokenCaller();

// Returns the caller for a request from the coordinator's machine, in a farm whose RPCs want
// certificates: it may read.
RpcCaller MachineCaller();

// ---- For the routes' files.
WebReply JsonReply(const std::string& json);
// Returns the number that group `part` of the route's pattern matched. Errors: kInvalidArgument if
// it is too large.
absl::StatusOr<int64_t> NumberOf(const WebRequest& request, size_t part);
// Returns a number of the query string; `otherwise` if it is absent. Errors: kInvalidArgument for a
// number outside [least, most].
absl::StatusOr<int64_t> NumberIn(const WebRequest& request, const std::string& name,
                                 int64_t otherwise, int64_t least, int64_t most);
// Returns a text of the JSON body; empty if it is absent. Errors: kInvalidArgument if the body is
// not an object, or the value is not a plain text of at most `most` bytes.
absl::StatusOr<std::string> TextIn(const WebRequest& request, const std::string& name, size_t most);
// Returns a whole number of the JSON body. Errors: kInvalidArgument if the body is not an object,
// or the number is absent or outside [least, most].
absl::StatusOr<int64_t> WholeNumberIn(const WebRequest& request, const std::string& name,
                                      int64_t least, int64_t most);

}  // namespace parallax
