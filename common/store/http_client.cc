#include "common/store/http_client.h"

#include <curl/curl.h>

#include <algorithm>
#include <cstring>
#include <mutex>

#include "common/base/hash.h"

namespace parallax {
namespace {

constexpr long kConnectPatience_s = 10;
// A transfer below this speed for so long has died.
constexpr long kSlowest_bytes_per_s = 1000;
constexpr long kSlowPatience_s = 30;

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

size_t GiveBody(char* data, size_t size, size_t count, void* rest) {
  auto& body = *static_cast<std::string_view*>(rest);
  const size_t bytes = std::min(size * count, body.size());
  std::memcpy(data, body.data(), bytes);
  body.remove_prefix(bytes);
  return bytes;
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
  add("x-amz-content-sha256: " + Sha256Hex(request.body));
  if (!signer_.session_token.empty()) add("x-amz-security-token: " + signer_.session_token);

  std::string_view rest = request.body;
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
    curl_easy_setopt(curl, CURLOPT_READDATA, &rest);
    curl_easy_setopt(curl, CURLOPT_INFILESIZE_LARGE, static_cast<curl_off_t>(request.body.size()));
  } else if (request.method == "POST") {
    add("Content-Type: application/xml");
    curl_easy_setopt(curl, CURLOPT_POST, 1L);
    curl_easy_setopt(curl, CURLOPT_POSTFIELDS, request.body.empty() ? "" : request.body.data());
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
