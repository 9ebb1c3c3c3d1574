// Sends HTTP requests that are signed for S3 (AWS Signature Version 4) over connections that stay
// open.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"

namespace parallax {

// A request's body: bytes in memory, or a piece of an open file, which is read while it is sent.
// Borrows both; they must outlive the call.
struct HttpBody {
  std::string_view bytes = {};
  int fd = -1;  // Open file; < 0: the body is `bytes`.
  int64_t offset = 0;
  int64_t file_bytes = 0;  // Length of the piece from `offset`.

  int64_t size() const { return fd < 0 ? static_cast<int64_t>(bytes.size()) : file_bytes; }
  // Returns `length` bytes from `begin` on of this body. Requires that they are within it.
  HttpBody Piece(int64_t begin, int64_t length) const;
  // Returns the body's digest. Errors: those of pread(2); kDataLoss if the file has become shorter.
  absl::StatusOr<std::string> Sha256Hex() const;
};

// A request; HttpClient adds the signature.
struct HttpRequest {
  std::string method;
  std::string url;  // Path and query percent-encoded, the query sorted.
  std::vector<std::pair<std::string, std::string>> headers = {};
  HttpBody body = {};       // A POST's must be in memory.
  std::string sha256 = "";  // Digest of the body; "": not known yet.
};

// The answer to a request, or the reason why none exists.
struct HttpAnswer {
  int code = 0;  // HTTP status; 0: no answer, see `error`.
  std::string error;
  std::string body;
  std::map<std::string, std::string> headers;  // Names in lower case.
};

// Credentials and region for signatures; see s3_options.h.
struct HttpSigner {
  std::string access_key;
  std::string secret_key;
  std::string session_token;
  std::string region;
};

// Thread-safe: each thread that sends has a connection of its own.
class HttpClient {
 public:
  explicit HttpClient(HttpSigner signer);
  ~HttpClient();
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  // Sends one request and returns its answer. Does not retry.
  HttpAnswer Send(const HttpRequest& request) const;

 private:
  class Handles;
  const HttpSigner signer_;
  const std::unique_ptr<Handles> handles_;
};

}  // namespace parallax
