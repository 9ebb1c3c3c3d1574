#include "coordinator/http/server/credentials.h"

#include <absl/strings/escaping.h>
#include <strings.h>
#include <unistd.h>

#include <algorithm>

#include "common/rpc/address.h"

namespace parallax {

std::string TokenIn(const std::string& authorization) {
  if (authorization.rfind("Bearer ", 0) == 0) return authorization.substr(7);
  if (authorization.rfind("Basic ", 0) != 0) return "";
  std::string pair;
  if (!absl::Base64Unescape(authorization.substr(6), &pair)) return "";
  return pair.substr(std::min(pair.size(), pair.find(':') + 1));
}

std::string CookieIn(const std::string& header, const std::string& name) {
  for (size_t at = 0; at < header.size();) {
    const size_t end = std::min(header.find(';', at), header.size());
    const size_t begin = header.find_first_not_of(' ', at);
    if (begin == std::string::npos) break;
    if (header.compare(begin, name.size() + 1, name + "=") == 0) {
      return header.substr(begin + name.size() + 1, end - begin - name.size() - 1);
    }
    at = end + 1;
  }
  return "";
}

std::optional<std::string> HostIn(const std::string& header) {
  // With a port of its own, for the parser of addresses.
  const bool has_port = !header.empty() && header.back() != ']' && header.find(':') != header.npos;
  const auto address = ParseRpcAddress(has_port ? header : header + ":0");
  if (!address.ok() || address->is_unix()) return std::nullopt;
  return address->host;
}

bool IsOwnName(const std::string& host) {
  char own[256] = "";
  gethostname(own, sizeof own - 1);
  const bool has_dot = host.find_first_of(".:") != host.npos;
  return !has_dot || strcasecmp(host.c_str(), own) == 0;
}

}  // namespace parallax
