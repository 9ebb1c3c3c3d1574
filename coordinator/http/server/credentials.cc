#include "coordinator/http/server/credentials.h"

#include <strings.h>
#include <unistd.h>

#include <algorithm>

#include "common/rpc/address.h"

namespace parallax {
namespace {

// Decodes up to the first character that is not a Base64 digit, such as the padding.
std::string DecodeBase64(const std::string& text) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    const size_t digit = kDigits.find(c);
    if (digit == std::string_view::npos) break;
    bits = bits << 6 | static_cast<unsigned>(digit);
    count += 6;
    if (count >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 255);
  }
  return bytes;
}

}  // namespace

std::string TokenIn(const std::string& authorization) {
  if (authorization.rfind("Bearer ", 0) == 0) return authorization.substr(7);
  if (authorization.rfind("Basic ", 0) != 0) return "";
  const std::string pair = DecodeBase64(authorization.substr(6));
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
