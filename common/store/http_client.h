// HTTP requests signed for S3 (AWS Signature Version 4), on connections that stay open.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace parallax {

struct HttpRequest {
  std::string method;
  std::string url;  // Path and query percent-encoded, the query sorted.
  std::vector<std::pair<std::string, std::string>> headers = {};
  std::string_view body = {};  // Outlives the call.
};

struct HttpAnswer {
  int code = 0;  // 0: there was none, see `error`.
  std::string error;
  std::string body;
  std::map<std::string, std::string> headers;  // Names in lower case.
};

struct HttpSigner {
  std::string access_key;
  std::string secret_key;
  std::string session_token;
  std::string region;
};

// Thread-safe: as many connections as threads are at it.
class HttpClient {
 public:
  explicit HttpClient(HttpSigner signer);
  ~HttpClient();
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  HttpAnswer Send(const HttpRequest& request) const;

 private:
  class Handles;
  const HttpSigner signer_;
  const std::unique_ptr<Handles> handles_;
};

}  // namespace parallax
