// Searches over the settings of a generator: all, one with its trials, and its picture.
#include "common/base/names.h"
#include "coordinator/http/api.h"
#include "coordinator/http/api_json.h"
#include "coordinator/view/json_list.h"
#include "coordinator/view/search_json.h"

namespace parallax {
namespace {

using Reply = absl::StatusOr<WebReply>;

Reply Searches(ApiParts& parts, const WebRequest&) {
  ASSIGN_OR_RETURN(const auto snapshot, parts.sampler.Take());
  return JsonReply(JsonText({{"searches", JsonList(snapshot->searches, SearchLineJson)}}));
}

absl::StatusOr<v1::SearchStatus> KnownSearch(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const auto snapshot, parts.sampler.Take());
  for (const v1::SearchStatus& search : snapshot->searches) {
    if (search.name() == request.parts.at(0)) return search;
  }
  return NotFound("search {} is not known", Quoted(request.parts.at(0)));
}

Reply Search(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const v1::SearchStatus search, KnownSearch(parts, request));
  return JsonReply(JsonText(SearchJson(search)));
}

Reply SearchPicture(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const v1::SearchStatus search, KnownSearch(parts, request));
  if (parts.picture == nullptr) return NotFound("this coordinator draws no pictures");
  return WebReply{.type = "image/svg+xml", .body = parts.picture(search)};
}

}  // namespace

void AddSearchRoutes(ApiParts& parts, std::vector<WebRoute>& routes) {
  const auto add = [&](const char* pattern, const char* example,
                       Reply (*handler)(ApiParts&, const WebRequest&)) {
    routes.push_back({"GET", pattern, example, WebAccess::kRoles, "ListStudies",
                      [&parts, handler](const WebRequest& r) { return handler(parts, r); }});
  };
  add("/api/v1/searches", "/api/v1/searches", Searches);
  add("/api/v1/searches/([a-z0-9_-]+)", "/api/v1/searches/camera", Search);
  add("/api/v1/searches/([a-z0-9_-]+)/picture\\.svg", "/api/v1/searches/camera/picture.svg",
      SearchPicture);
}

}  // namespace parallax
