#include "coordinator/http/page_replies.h"

#include <algorithm>

#include "coordinator/http/page_files.h"

namespace parallax {
namespace {

constexpr char kPolicy[] =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

}  // namespace

std::vector<std::pair<std::string, std::string>> PageHeaders() {
  return {{"X-Content-Type-Options", "nosniff"},
          {"Referrer-Policy", "no-referrer"},
          {"Cross-Origin-Resource-Policy", "same-origin"},
          {"Content-Security-Policy", kPolicy}};
}

std::optional<ServerReply> PageFileReply(const ServerRequest& request) {
  const auto file = std::find_if(PageFiles().begin(), PageFiles().end(),
                                 [&](const PageFile& one) { return one.path == request.path; });
  if (file == PageFiles().end() || request.method != "GET") return std::nullopt;
  ServerReply reply;
  reply.reply.type = std::string(file->type);
  reply.reply.headers = {{"Cache-Control", "no-cache"}, {"ETag", std::string(file->etag)}};
  if (request.Header("if-none-match") == file->etag) {
    reply.reply.status = 304;
  } else {
    reply.reply.body = std::string(file->bytes);
  }
  return reply;
}

}  // namespace parallax
