// Sends HTTP requests over connections that stay open, for S3 signed by AWS Signature Version 4.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
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

// A request; HttpClient adds the signature, if there is a signer.
struct HttpRequest {
  std::string method;
  std::string url;  // Path and query percent-encoded, the query sorted.
  std::vector<std::pair<std::string, std::string>> headers = {};
  HttpBody body = {};                            // A POST's must be in memory.
  std::string content_type = "application/xml";  // The type of a POST's body.
  std::string sha256 = "";                       // Digest of the body; "": not known yet.
  long most_s = 0;  // Longest time of the request and its answer; 0: as long as bytes come.
  // Gets the answer's body piece by piece, in place of HttpAnswer::body; false ends the transfer.
  std::function<bool(std::string_view piece)> receive = nullptr;
};

// The answer to a request, or the reason why none exists.
struct HttpAnswer {
  int code = 0;  // HTTP status; 0: no answer, see `error`.
  std::string error;
  std::string body;
  std::map<std::string, std::string> headers;  // Names in lower case.
};

// Credentials and region for signatures; see s3_options.h. Without access key, nothing is signed.
struct HttpSigner {
  std::string access_key;
  std::string secret_key;
  std::string session_token;
  std::string region;
};

// Chooses the file of the web's certificate authorities: `named` unless it is empty, else the first
// of `candidates` that exists; "" if none does.
std::string ChooseCaFile(const std::string& named, const std::vector<std::string>& candidates);

// A server of a farm: it is reached directly, without a proxy, and shows a certificate of the farm.
struct HttpFarm {
  std::string ca_file;           // The authority; empty: any certificate will do.
  std::string certificate_file;  // Shown to the server; empty: none.
  std::string key_file;
  long most_s = 10;  // Longest time of a request and its answer.
};

// Thread-safe: each thread that sends has a connection of its own.
class HttpClient {
 public:
  HttpClient();  // Trusts the authorities of $SSL_CERT_FILE, else those of this system.
  explicit HttpClient(HttpFarm farm);
  ~HttpClient();
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  // Sends one request, signed by `signer`, and returns its answer. Does not retry.
  HttpAnswer Send(const HttpRequest& request, const HttpSigner& signer = {}) const;

 private:
  class Handles;
  const std::optional<HttpFarm> farm_;
  const std::string ca_file_;  // Empty: libcurl's own.
  const std::unique_ptr<Handles> handles_;
};

}  // namespace parallax
