#include "coordinator/http/api.h"

#include <charconv>
#include <nlohmann/json.hpp>

#include "common/base/names.h"
#include "common/base/status.h"

namespace parallax {

std::vector<WebRoute> ApiRoutes(ApiParts& parts) {
  std::vector<WebRoute> routes;
  AddSessionRoutes(parts, routes);
  AddFarmRoutes(parts, routes);
  AddStudyRoutes(parts, routes);
  AddSearchRoutes(parts, routes);
  AddPairRoutes(parts, routes);
  AddJobRoutes(parts, routes);
  return routes;
}

RpcCaller TokenCaller() {
  return {.has_certificate = true, .name = "http.token", .role = Role::kReadOnly};
}

RpcCaller MachineCaller() {
  return {.has_certificate = true, .name = "this machine", .role = Role::kReadOnly};
}

WebReply JsonReply(const std::string& json) {
  WebReply reply;
  reply.body = json;
  return reply;
}

absl::StatusOr<int64_t> NumberOf(const WebRequest& request, size_t part) {
  const std::string& text = request.parts.at(part);
  int64_t number = 0;
  const auto end = std::from_chars(text.data(), text.data() + text.size(), number);
  if (end.ec == std::errc() && end.ptr == text.data() + text.size()) return number;
  return InvalidArgument("no number: {}", Quoted(text));
}

absl::StatusOr<int64_t> NumberIn(const WebRequest& request, const std::string& name,
                                 int64_t otherwise, int64_t least, int64_t most) {
  const auto given = request.query.find(name);
  if (given == request.query.end() || given->second.empty()) return otherwise;
  const std::string& text = given->second;
  int64_t number = 0;
  const auto end = std::from_chars(text.data(), text.data() + text.size(), number);
  if (end.ec == std::errc() && end.ptr == text.data() + text.size() && number >= least &&
      number <= most) {
    return number;
  }
  return InvalidArgument("{}={}: wanted {} to {}", name, Quoted(text), least, most);
}

absl::StatusOr<int64_t> WholeNumberIn(const WebRequest& request, const std::string& name,
                                      int64_t least, int64_t most) {
  const auto body = nlohmann::json::parse(request.body, nullptr, /*allow_exceptions=*/false);
  const bool there = body.is_object() && body.contains(name) && body[name].is_number_integer();
  const auto number = there ? body[name].get<int64_t>() : least - 1;
  if (number >= least && number <= most) return number;
  return InvalidArgument("{}: wanted a whole number from {} to {}", name, least, most);
}

absl::StatusOr<std::string> TextIn(const WebRequest& request, const std::string& name,
                                   size_t most) {
  if (request.body.empty()) return "";
  const auto body = nlohmann::json::parse(request.body, nullptr, /*allow_exceptions=*/false);
  if (!body.is_object()) return InvalidArgument("the body is no JSON object");
  const auto found = body.find(name);
  if (found == body.end()) return "";
  if (!found->is_string()) return InvalidArgument("{}: wanted a text", name);
  const std::string text = found->get<std::string>();
  RETURN_IF_ERROR(CheckPlainText(name, text, most));
  return text;
}

}  // namespace parallax
