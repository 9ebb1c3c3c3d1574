// A pair: its pictures, its maps, and what it was made from.
#include <fmt/core.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <functional>

#include "common/base/hash.h"
#include "common/base/status.h"
#include "coordinator/http/api.h"
#include "coordinator/http/api_json.h"
#include "coordinator/queue/job_queue.h"

namespace parallax {
namespace {

using Reply = absl::StatusOr<WebReply>;

constexpr int kLeastWidth_px = 64, kMostWidth_px = 4096;
// Browsers keep what they have of a pair and ask each time whether it is still the same: the number
// of a forgotten study's pair may be given again.
constexpr char kKeep[] = "private, no-cache";

absl::StatusOr<PublishedPair> PairOf(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const int64_t number, NumberOf(request, 0));
  return parts.reader.Pair(number);
}

// Path in the store of one of the pair's files. Errors: kNotFound.
absl::StatusOr<std::string> FileOf(const PublishedPair& pair, const std::string& name) {
  const auto& files = pair.frame.files();
  if (std::any_of(files.begin(), files.end(), [&](const auto& f) { return f.name() == name; })) {
    return pair.frame.path() + "/" + name;
  }
  return NotFound("pair {} has no {}", pair.number, name);
}

// Answers with what `make` returns, or with status 304 if the caller has it already. A folder of
// the store belongs to one attempt for ever.
Reply Kept(const WebRequest& request, const PublishedPair& pair, const char* type,
           const std::function<absl::StatusOr<std::string>()>& make) {
  WebReply reply;
  const std::string etag =
      "\"" + Sha256Hex(fmt::format("{} {}", pair.study_id, pair.frame.path())).substr(0, 16) + "\"";
  reply.headers = {{"Cache-Control", kKeep}, {"ETag", etag}};
  reply.type = type;
  if (request.if_none_match == etag) {
    reply.status = 304;
    return reply;
  }
  ASSIGN_OR_RETURN(reply.body, make());
  return reply;
}

Reply Pair(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const PublishedPair pair, PairOf(parts, request));
  ASSIGN_OR_RETURN(const auto neighbours, parts.reader.NeighboursOf(pair));
  return JsonReply(JsonText(PairJson(pair, neighbours)));
}

Reply Picture(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const int64_t width,
                   NumberIn(request, "width", kMostWidth_px, kLeastWidth_px, kMostWidth_px));
  ASSIGN_OR_RETURN(const PublishedPair pair, PairOf(parts, request));
  ASSIGN_OR_RETURN(const std::string path, FileOf(pair, request.parts[1] + ".png"));
  return Kept(request, pair, "image/jpeg",
              [&] { return parts.pictures.Jpeg(path, static_cast<int>(width)); });
}

Reply Map(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const PublishedPair pair, PairOf(parts, request));
  auto path = FileOf(pair, request.parts[1] + ".exr");
  if (!path.ok()) path = FileOf(pair, request.parts[1] + ".png");
  if (!path.ok()) return path.status();
  return Kept(request, pair, "application/octet-stream", [&] { return parts.pictures.Map(*path); });
}

Reply Normals(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const PublishedPair pair, PairOf(parts, request));
  ASSIGN_OR_RETURN(const std::string path, FileOf(pair, "normals_" + request.parts[1] + ".exr"));
  return Kept(request, pair, "image/jpeg", [&] { return parts.pictures.Normals(path); });
}

// One of the pair's files as it is.
Reply PairFile(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const PublishedPair pair, PairOf(parts, request));
  ASSIGN_OR_RETURN(const std::string path, FileOf(pair, request.parts[1]));
  return Kept(request, pair, "application/octet-stream", [&] { return parts.pictures.File(path); });
}

// frame.json as the worker wrote it.
Reply Frame(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const PublishedPair pair, PairOf(parts, request));
  ASSIGN_OR_RETURN(const std::string path, FileOf(pair, "frame.json"));
  return Kept(request, pair, "application/json", [&] { return parts.pictures.File(path); });
}

absl::StatusOr<std::string> RecipeOf(ApiParts& parts, const PublishedPair& pair) {
  v1::GetSceneRequest asked;
  asked.set_study_id(pair.study_id);
  asked.set_variant(pair.variant);
  asked.set_scene(pair.scene);
  ASSIGN_OR_RETURN(const v1::Scene scene, parts.queue.GetScene(asked));
  std::string json;
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.preserve_proto_field_names = true;
  if (!google::protobuf::util::MessageToJsonString(scene, &json, options).ok()) {
    return Internal("this recipe has no JSON form");
  }
  return json;
}

Reply Recipe(ApiParts& parts, const WebRequest& request) {
  ASSIGN_OR_RETURN(const PublishedPair pair, PairOf(parts, request));
  return Kept(request, pair, "application/json", [&] { return RecipeOf(parts, pair); });
}

}  // namespace

void AddPairRoutes(ApiParts& parts, std::vector<WebRoute>& routes) {
  const auto add = [&](const char* pattern, const char* example, const char* rpc,
                       Reply (*handler)(ApiParts&, const WebRequest&)) {
    routes.push_back({"GET", pattern, example, WebAccess::kRoles, rpc,
                      [&parts, handler](const WebRequest& r) { return handler(parts, r); }});
  };
  add("/api/v1/pairs/(\\d+)", "/api/v1/pairs/1", "ListFrames", Pair);
  add("/api/v1/pairs/(\\d+)/picture/(left|right)", "/api/v1/pairs/1/picture/left", "ListFrames",
      Picture);
  add("/api/v1/pairs/(\\d+)/map/([a-z_]+[0-9]?_(?:left|right))",
      "/api/v1/pairs/1/map/disparity_left", "ListFrames", Map);
  add("/api/v1/pairs/(\\d+)/normals/(left|right)", "/api/v1/pairs/1/normals/left", "ListFrames",
      Normals);
  add("/api/v1/pairs/(\\d+)/file/([^/]+)", "/api/v1/pairs/1/file/left.png", "ListFrames", PairFile);
  add("/api/v1/pairs/(\\d+)/frame", "/api/v1/pairs/1/frame", "ListFrames", Frame);
  add("/api/v1/pairs/(\\d+)/recipe", "/api/v1/pairs/1/recipe", "GetScene", Recipe);
}

}  // namespace parallax
