#include "common/store/http_client.h"

#include <curl/curl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <mutex>

#include "common/base/hash.h"

namespace parallax {
namespace {

constexpr long kConnectPatience_s = 10;
// A transfer that is slower than this for so long is given up.
constexpr long kSlowest_bytes_per_s = 1000;
constexpr long kSlowPatience_s = 30;
constexpr size_t kHashedAtOnce = 1 << 18;

size_t TakeBody(char* data, size_t size, size_t count, void* answer) {
  static_cast<HttpAnswer*>(answer)->body.append(data, size * count);
  return size * count;
}

size_t TakeHeader(char* data, size_t size, size_t count, void* answer) {
  std::string_view line(data, size * count);
  const size_t colon = line.find(':');
  if (colon != std::string_view::npos) {
    std::string name(line.substr(0, colon));
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    line.remove_prefix(colon + 1);
    while (!line.empty() && line.front() == ' ') line.remove_prefix(1);
    while (!line.empty() && (line.back() == '\r' || line.back() == '\n')) line.remove_suffix(1);
    static_cast<HttpAnswer*>(answer)->headers[name] = line;
  }
  return size * count;
}

// Progress of sending a body.
struct Sending {
  const HttpBody* body;
  int64_t sent = 0;
};

// Reads at most `size` bytes from `at` on. Returns their number; less than 0 is an error.
ssize_t ReadBody(const HttpBody& body, int64_t at, char* data, size_t size) {
  size = std::min(size, static_cast<size_t>(body.size() - at));
  if (body.fd >= 0) return size == 0 ? 0 : pread(body.fd, data, size, body.offset + at);
  std::memcpy(data, body.bytes.data() + at, size);
  return static_cast<ssize_t>(size);
}

size_t GiveBody(char* data, size_t size, size_t count, void* user) {
  auto& sending = *static_cast<Sending*>(user);
  const ssize_t bytes = ReadBody(*sending.body, sending.sent, data, size * count);
  if (bytes < 0) return CURL_READFUNC_ABORT;
  sending.sent += bytes;
  return static_cast<size_t>(bytes);
}

// A kept connection that turns out to be closed is replaced, and the body begins anew.
int SeekBody(void* user, curl_off_t offset, int origin) {
  if (origin != SEEK_SET) return CURL_SEEKFUNC_CANTSEEK;
  static_cast<Sending*>(user)->sent = offset;
  return CURL_SEEKFUNC_OK;
}

}  // namespace

// Handles keep their connections.
class HttpClient::Handles {
 public:
  Handles() {
    static const CURLcode initialised = curl_global_init(CURL_GLOBAL_DEFAULT);
    (void)initialised;
  }
  ~Handles() {
    for (CURL* handle : free_) curl_easy_cleanup(handle);
  }
  CURL* Take() {
    std::lock_guard lock(mu_);
    if (free_.empty()) return curl_easy_init();
    CURL* const handle = free_.back();
    free_.pop_back();
    curl_easy_reset(handle);
    return handle;
  }
  void Return(CURL* handle) {
    std::lock_guard lock(mu_);
    free_.push_back(handle);
  }

 private:
  std::mutex mu_;
  std::vector<CURL*> free_;  // Guarded by mu_.
};

HttpBody HttpBody::Piece(int64_t begin, int64_t length) const {
  length = std::min(length, size() - begin);
  if (fd >= 0) return {.fd = fd, .offset = offset + begin, .file_bytes = length};
  return {.bytes = bytes.substr(static_cast<size_t>(begin), static_cast<size_t>(length))};
}

absl::StatusOr<std::string> HttpBody::Sha256Hex() const {
  if (fd < 0) return parallax::Sha256Hex(bytes);
  Sha256 hash;
  std::string buffer(kHashedAtOnce, '\0');
  for (int64_t at = 0; at < size();) {
    const ssize_t n = ReadBody(*this, at, buffer.data(), buffer.size());
    if (n < 0) return ErrnoError(errno, "read what is to be sent");
    if (n == 0) return DataLoss("a file shrank while it was sent");
    hash.Update({buffer.data(), static_cast<size_t>(n)});
    at += n;
  }
  return HexOf(hash.Finish());
}

HttpClient::HttpClient(HttpSigner signer)
    : signer_(std::move(signer)), handles_(std::make_unique<Handles>()) {}
HttpClient::~HttpClient() = default;

HttpAnswer HttpClient::Send(const HttpRequest& request) const {
  HttpAnswer answer;
  CURL* const curl = handles_->Take();
  if (curl == nullptr) {
    answer.error = "no memory for a connection";
    return answer;
  }
  const std::string user = signer_.access_key + ":" + signer_.secret_key;
  const std::string scheme = "aws:amz:" + signer_.region + ":s3";
  char error[CURL_ERROR_SIZE] = "";
  curl_slist* headers = nullptr;
  const auto add = [&headers](const std::string& line) {
    headers = curl_slist_append(headers, line.c_str());
  };
  for (const auto& [name, value] : request.headers) add(name + ": " + value);
  // The server checks the body against it, and it is part of the signature.
  std::string sha256 = request.sha256;
  if (sha256.empty()) {
    auto hashed = request.body.Sha256Hex();
    if (!hashed.ok()) {
      answer.error = std::string(hashed.status().message());
      curl_slist_free_all(headers);
      handles_->Return(curl);
      return answer;
    }
    sha256 = *std::move(hashed);
  }
  add("x-amz-content-sha256: " + sha256);
  if (!signer_.session_token.empty()) add("x-amz-security-token: " + signer_.session_token);

  Sending sending{&request.body};
  curl_easy_setopt(curl, CURLOPT_URL, request.url.c_str());
  curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(curl, CURLOPT_PATH_AS_IS, 1L);
  curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(curl, CURLOPT_ERRORBUFFER, error);
  curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT, kConnectPatience_s);
  curl_easy_setopt(curl, CURLOPT_LOW_SPEED_LIMIT, kSlowest_bytes_per_s);
  curl_easy_setopt(curl, CURLOPT_LOW_SPEED_TIME, kSlowPatience_s);
  // "Expect:" can't be left away by a header of ours: libcurl 7.88 would sign the empty line.
  curl_easy_setopt(curl, CURLOPT_EXPECT_100_TIMEOUT_MS, 200L);
  curl_easy_setopt(curl, CURLOPT_AWS_SIGV4, scheme.c_str());
  curl_easy_setopt(curl, CURLOPT_USERPWD, user.c_str());
  curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, &TakeBody);
  curl_easy_setopt(curl, CURLOPT_WRITEDATA, &answer);
  curl_easy_setopt(curl, CURLOPT_HEADERFUNCTION, &TakeHeader);
  curl_easy_setopt(curl, CURLOPT_HEADERDATA, &answer);
  if (request.method == "HEAD") {
    curl_easy_setopt(curl, CURLOPT_NOBODY, 1L);
  } else if (request.method == "PUT") {
    curl_easy_setopt(curl, CURLOPT_UPLOAD, 1L);
    curl_easy_setopt(curl, CURLOPT_READFUNCTION, &GiveBody);
    curl_easy_setopt(curl, CURLOPT_READDATA, &sending);
    curl_easy_setopt(curl, CURLOPT_SEEKFUNCTION, &SeekBody);
    curl_easy_setopt(curl, CURLOPT_SEEKDATA, &sending);
    curl_easy_setopt(curl, CURLOPT_INFILESIZE_LARGE, static_cast<curl_off_t>(request.body.size()));
  } else if (request.method == "POST") {
    add("Content-Type: application/xml");
    curl_easy_setopt(curl, CURLOPT_POST, 1L);
    curl_easy_setopt(curl, CURLOPT_POSTFIELDS,
                     request.body.bytes.empty() ? "" : request.body.bytes.data());
    curl_easy_setopt(curl, CURLOPT_POSTFIELDSIZE_LARGE,
                     static_cast<curl_off_t>(request.body.size()));
  } else if (request.method != "GET") {
    curl_easy_setopt(curl, CURLOPT_CUSTOMREQUEST, request.method.c_str());
  }
  curl_easy_setopt(curl, CURLOPT_HTTPHEADER, headers);

  const CURLcode result = curl_easy_perform(curl);
  long code = 0;
  curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &code);
  if (result == CURLE_OK) {
    answer.code = static_cast<int>(code);
  } else {
    answer.error = *error != '\0' ? error : curl_easy_strerror(result);
  }
  curl_slist_free_all(headers);
  handles_->Return(curl);
  return answer;
}

}  // namespace parallax
