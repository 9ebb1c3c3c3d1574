// Sends a test's requests to the page.
#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>

#include "common/store/http_client.h"

namespace parallax {

struct WebAnswer {
  int status = 0;
  std::string body;
  std::map<std::string, std::string> headers;  // Names in lower case.

  std::string get_header_value(std::string name) const {
    std::transform(name.begin(), name.end(), name.begin(), ::tolower);
    const auto found = headers.find(name);
    return found == headers.end() ? "" : found->second;
  }
};

class Browser {
 public:
  using Headers = std::map<std::string, std::string>;
  using Result = std::optional<WebAnswer>;  // Nothing if there was no answer.

  // `site` is like "https://127.0.0.1:7080".
  explicit Browser(std::string site, HttpFarm farm = {}) : site_(std::move(site)), http_(farm) {}

  Result Get(const std::string& path, const Headers& headers = {},
             std::function<bool(std::string_view)> receive = nullptr) const {
    HttpRequest request{.method = "GET", .url = site_ + path};
    request.headers.assign(headers.begin(), headers.end());
    request.receive = std::move(receive);
    return Send(request);
  }
  Result Post(const std::string& path, const std::string& body, const Headers& headers = {}) const {
    HttpRequest request{.method = "POST", .url = site_ + path};
    request.headers.assign(headers.begin(), headers.end());
    request.body.bytes = body;
    request.content_type = "application/json";
    return Send(request);
  }

 private:
  Result Send(const HttpRequest& request) const {
    HttpAnswer answer = http_.Send(request);
    if (answer.code == 0) return std::nullopt;
    return WebAnswer{answer.code, std::move(answer.body), std::move(answer.headers)};
  }

  const std::string site_;
  const HttpClient http_;
};

// Returns a socket that is connected to a port of this machine; -1 if it can't.
inline int ConnectTo(int port) {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  name.sin_port = htons(static_cast<uint16_t>(port));
  if (connect(fd, reinterpret_cast<sockaddr*>(&name), sizeof name) == 0) return fd;
  close(fd);
  return -1;
}

// Reads until the other side closes, for at most `limit_s`.
inline std::string ReadAll(int fd, int limit_s = 20) {
  const timeval limit{limit_s, 0};
  setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  std::string text;
  char bytes[1 << 14];
  for (ssize_t n; (n = recv(fd, bytes, sizeof bytes, 0)) > 0;) {
    text.append(bytes, static_cast<size_t>(n));
  }
  return text;
}

// Sends these bytes and returns all that comes back.
inline std::string Exchange(int port, const std::string& bytes) {
  const int fd = ConnectTo(port);
  if (fd < 0) return "";
  (void)!send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  std::string text = ReadAll(fd);
  close(fd);
  return text;
}

}  // namespace parallax
