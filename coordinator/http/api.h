// /api/v1: what the page shows and does, on top of the queue. Thread-safe.
#pragma once

#include <string>
#include <vector>

#include "coordinator/http/pictures.h"
#include "coordinator/http/sessions.h"
#include "coordinator/http/status_sampler.h"
#include "coordinator/http/web.h"
#include "coordinator/queue/page_reader.h"

namespace parallax {

class CoordinatorServer;
class JobQueue;

// What the routes work with. All outlive them.
struct ApiParts {
  JobQueue& queue;
  const CoordinatorServer& server;
  StatusSampler& sampler;
  PageReader& reader;
  Pictures& pictures;
  Sessions& sessions;
  // Opens a read-only session; empty: none does.
  std::string token;
  // Of the session's cookie: its name, and whether it goes over HTTPS only.
  std::string cookie;
  bool secure_cookie = false;
};

// All routes, health and metrics too. The parts outlive them.
std::vector<WebRoute> ApiRoutes(ApiParts& parts);

// By subject, each in a file of its own.
void AddSessionRoutes(ApiParts& parts, std::vector<WebRoute>& routes);
void AddFarmRoutes(ApiParts& parts, std::vector<WebRoute>& routes);
void AddStudyRoutes(ApiParts& parts, std::vector<WebRoute>& routes);
void AddPairRoutes(ApiParts& parts, std::vector<WebRoute>& routes);
void AddJobRoutes(ApiParts& parts, std::vector<WebRoute>& routes);

// Who a stranger with the farm's token is: it may look.
RpcCaller TokenCaller();

// Who is on the coordinator's machine, in a farm whose RPCs want certificates: it may look.
RpcCaller MachineCaller();

// ---- For the routes' files.
WebReply JsonReply(const std::string& json);
// The number that the pattern's group matched. Errors: kInvalidArgument for one that is too large.
absl::StatusOr<int64_t> NumberOf(const WebRequest& request, size_t part);
// A number of the query; `otherwise` when it isn't there. Errors: kInvalidArgument outside of
// [least, most].
absl::StatusOr<int64_t> NumberIn(const WebRequest& request, const std::string& name,
                                 int64_t otherwise, int64_t least, int64_t most);
// A text of the JSON body; empty when it isn't there. Errors: kInvalidArgument for a body that is
// no object or a value that is no plain text of at most `most` bytes.
absl::StatusOr<std::string> TextIn(const WebRequest& request, const std::string& name, size_t most);
// A whole number of the JSON body, which must be there. Errors: kInvalidArgument for a body that is
// no object or a number outside of [least, most].
absl::StatusOr<int64_t> WholeNumberIn(const WebRequest& request, const std::string& name,
                                      int64_t least, int64_t most);

}  // namespace parallax
