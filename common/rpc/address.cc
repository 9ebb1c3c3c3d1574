#include "common/rpc/address.h"

#include <arpa/inet.h>
#include <fmt/core.h>
#include <strings.h>
#include <sys/un.h>

namespace parallax {
namespace {

constexpr std::string_view kUnixScheme = "unix:";

absl::Status BadAddress(std::string_view text, std::string_view why) {
  return InvalidArgument("address '{}': {} (wanted HOST:PORT or unix:/absolute/path)", text, why);
}

absl::StatusOr<RpcAddress> ParseUnix(std::string_view text) {
  RpcAddress address;
  address.unix_path = text.substr(kUnixScheme.size());
  if (address.unix_path.empty() || address.unix_path[0] != '/') {
    return BadAddress(text, "the socket's path is not absolute");
  }
  if (address.unix_path.size() >= sizeof(sockaddr_un::sun_path)) {
    return BadAddress(text, "the socket's path is longer than the system allows (107 characters)");
  }
  return address;
}

bool ParsePort(std::string_view digits, int* port) {
  if (digits.empty() || digits.size() > 5) return false;
  int value = 0;
  for (char c : digits) {
    if (c < '0' || c > '9') return false;
    value = value * 10 + (c - '0');
  }
  *port = value;
  return value <= 65535;
}

}  // namespace

bool IsIpAddress(const std::string& host) {
  in6_addr address;
  return inet_pton(AF_INET, host.c_str(), &address) == 1 ||
         inet_pton(AF_INET6, host.c_str(), &address) == 1;
}

bool IsLoopbackHost(const std::string& host) {
  if (strcasecmp(host.c_str(), "localhost") == 0) return true;
  in_addr v4;
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return ntohl(v4.s_addr) >> 24 == 127;
  in6_addr v6;
  return inet_pton(AF_INET6, host.c_str(), &v6) == 1 && IN6_IS_ADDR_LOOPBACK(&v6);
}

bool RpcAddress::is_local() const { return is_unix() || IsLoopbackHost(host); }

std::string RpcAddress::ToString() const {
  if (is_unix()) return std::string(kUnixScheme) + unix_path;
  const bool ipv6 = host.find(':') != std::string::npos;
  return fmt::format("{}:{}", ipv6 ? "[" + host + "]" : host, port);
}

absl::StatusOr<RpcAddress> ParseRpcAddress(std::string_view text) {
  if (text.substr(0, kUnixScheme.size()) == kUnixScheme) return ParseUnix(text);
  const size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return BadAddress(text, "no port");
  RpcAddress address;
  std::string_view host = text.substr(0, colon);
  if (host.size() >= 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    return BadAddress(text, "an IPv6 address needs brackets, as in [::1]:7070");
  }
  if (host.empty()) return BadAddress(text, "no host");
  if (host.find_first_of(" \t\n/\\,[]") != std::string_view::npos) {
    return BadAddress(text, "the host has a character that no host name has");
  }
  address.host = host;
  if (!ParsePort(text.substr(colon + 1), &address.port)) {
    return BadAddress(text, "the port is not a number in [0, 65535]");
  }
  return address;
}

}  // namespace parallax
