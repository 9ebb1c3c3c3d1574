// HTTP requests signed for S3 (AWS Signature Version 4), on connections that stay open.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"

namespace parallax {

// Bytes in memory, or a piece of an open file, which is read as it is sent. Outlives the call.
struct HttpBody {
  std::string_view bytes = {};
  int fd = -1;  // < 0: `bytes`.
  int64_t offset = 0;
  int64_t file_bytes = 0;  // From `offset` on.

  int64_t size() const { return fd < 0 ? static_cast<int64_t>(bytes.size()) : file_bytes; }
  HttpBody Piece(int64_t begin, int64_t length) const;
  // Errors: as pread(2); kDataLoss when the file is shorter than `file_bytes`.
  absl::StatusOr<std::string> Sha256Hex() const;
};

struct HttpRequest {
  std::string method;
  std::string url;  // Path and query percent-encoded, the query sorted.
  std::vector<std::pair<std::string, std::string>> headers = {};
  HttpBody body = {};       // Of a POST: in memory.
  std::string sha256 = "";  // Of the body; "": not known yet.
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
