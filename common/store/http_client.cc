#include "common/store/http_client.h"

#include <curl/curl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
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

// An answer that comes in.
struct Receiving {
  const HttpRequest* request;
  HttpAnswer* answer;
  bool stopped = false;  // By who receives it.
};

size_t TakeBody(char* data, size_t size, size_t count, void* user) {
  auto& receiving = *static_cast<Receiving*>(user);
  if (!receiving.request->receive) {
    receiving.answer->body.append(data, size * count);
  } else if (!receiving.request->receive({data, size * count})) {
    receiving.stopped = true;
    return CURL_WRITEFUNC_ERROR;
  }
  return size * count;
}

size_t TakeHeader(char* data, size_t size, size_t count, void* user) {
  std::string_view line(data, size * count);
  const size_t colon = line.find(':');
  if (colon != std::string_view::npos) {
    std::string name(line.substr(0, colon));
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    line.remove_prefix(colon + 1);
    while (!line.empty() && line.front() == ' ') line.remove_prefix(1);
    while (!line.empty() && (line.back() == '\r' || line.back() == '\n')) line.remove_suffix(1);
    static_cast<Receiving*>(user)->answer->headers[name] = line;
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

std::string ChooseCaFile(const std::string& named, const std::vector<std::string>& candidates) {
  if (!named.empty()) return named;
  for (const std::string& file : candidates) {
    if (access(file.c_str(), R_OK) == 0) return file;
  }
  return "";
}

namespace {

// Packages bring Debian's libcurl, whose own path is Debian's and which reads no variable.
std::string CaFileOfThisSystem() {
  const char* const named = std::getenv("SSL_CERT_FILE");
  return ChooseCaFile(named == nullptr ? "" : named,
                      {"/etc/ssl/certs/ca-certificates.crt",  // Debian, Ubuntu, Arch.
                       "/etc/pki/tls/certs/ca-bundle.crt",    // RHEL, Rocky, Fedora.
                       "/etc/ssl/ca-bundle.pem",              // SUSE.
                       "/etc/ssl/cert.pem"});                 // Alpine.
}

}  // namespace

HttpClient::HttpClient() : ca_file_(CaFileOfThisSystem()), handles_(std::make_unique<Handles>()) {}
HttpClient::HttpClient(HttpFarm farm)
    : farm_(std::move(farm)), handles_(std::make_unique<Handles>()) {}
HttpClient::~HttpClient() = default;

namespace {

// The headers of a request; curl reads the list while it sends.
class HeaderList {
 public:
  HeaderList() = default;
  ~HeaderList() { curl_slist_free_all(list_); }
  HeaderList(const HeaderList&) = delete;
  HeaderList& operator=(const HeaderList&) = delete;

  void Add(const std::string& line) { list_ = curl_slist_append(list_, line.c_str()); }
  curl_slist* get() const { return list_; }

 private:
  curl_slist* list_ = nullptr;
};

// The body's hash: the server checks the body against it, and it is part of the signature.
absl::StatusOr<std::string> BodyHash(const HttpRequest& request) {
  if (!request.sha256.empty()) return request.sha256;
  return request.body.Sha256Hex();
}

void SetConnection(CURL* curl, const HttpRequest& request) {
  curl_easy_setopt(curl, CURLOPT_URL, request.url.c_str());
  curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(curl, CURLOPT_PATH_AS_IS, 1L);
  curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT, kConnectPatience_s);
  curl_easy_setopt(curl, CURLOPT_LOW_SPEED_LIMIT, kSlowest_bytes_per_s);
  curl_easy_setopt(curl, CURLOPT_LOW_SPEED_TIME, kSlowPatience_s);
  curl_easy_setopt(curl, CURLOPT_TIMEOUT, request.most_s);
  // "Expect:" can't be left away by a header of ours: libcurl 7.88 would sign the empty line.
  curl_easy_setopt(curl, CURLOPT_EXPECT_100_TIMEOUT_MS, 200L);
}

// libcurl copies the strings.
void SetSigner(CURL* curl, const HttpSigner& signer) {
  const std::string user = signer.access_key + ":" + signer.secret_key;
  const std::string scheme = "aws:amz:" + signer.region + ":s3";
  curl_easy_setopt(curl, CURLOPT_AWS_SIGV4, scheme.c_str());
  curl_easy_setopt(curl, CURLOPT_USERPWD, user.c_str());
}

// libcurl copies the strings.
void SetFarm(CURL* curl, const HttpFarm& farm) {
  curl_easy_setopt(curl, CURLOPT_PROXY, "");
  curl_easy_setopt(curl, CURLOPT_TIMEOUT, farm.most_s);
  if (farm.ca_file.empty()) {
    curl_easy_setopt(curl, CURLOPT_SSL_VERIFYPEER, 0L);
    curl_easy_setopt(curl, CURLOPT_SSL_VERIFYHOST, 0L);
  } else {
    curl_easy_setopt(curl, CURLOPT_CAINFO, farm.ca_file.c_str());
    curl_easy_setopt(curl, CURLOPT_CAPATH, nullptr);
  }
  if (farm.certificate_file.empty()) return;
  curl_easy_setopt(curl, CURLOPT_SSLCERT, farm.certificate_file.c_str());
  curl_easy_setopt(curl, CURLOPT_SSLKEY, farm.key_file.c_str());
}

void SetAnswer(CURL* curl, Receiving& receiving) {
  curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, &TakeBody);
  curl_easy_setopt(curl, CURLOPT_WRITEDATA, &receiving);
  curl_easy_setopt(curl, CURLOPT_HEADERFUNCTION, &TakeHeader);
  curl_easy_setopt(curl, CURLOPT_HEADERDATA, &receiving);
}

// The method, and what it sends; `sending` lives until the transfer ends.
void SetMethod(CURL* curl, const HttpRequest& request, Sending& sending, HeaderList& headers) {
  const HttpBody& body = request.body;
  if (request.method == "HEAD") {
    curl_easy_setopt(curl, CURLOPT_NOBODY, 1L);
  } else if (request.method == "PUT") {
    curl_easy_setopt(curl, CURLOPT_UPLOAD, 1L);
    curl_easy_setopt(curl, CURLOPT_READFUNCTION, &GiveBody);
    curl_easy_setopt(curl, CURLOPT_READDATA, &sending);
    curl_easy_setopt(curl, CURLOPT_SEEKFUNCTION, &SeekBody);
    curl_easy_setopt(curl, CURLOPT_SEEKDATA, &sending);
    curl_easy_setopt(curl, CURLOPT_INFILESIZE_LARGE, static_cast<curl_off_t>(body.size()));
  } else if (request.method == "POST") {
    headers.Add("Content-Type: " + request.content_type);
    curl_easy_setopt(curl, CURLOPT_POST, 1L);
    curl_easy_setopt(curl, CURLOPT_POSTFIELDS, body.bytes.empty() ? "" : body.bytes.data());
    curl_easy_setopt(curl, CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(body.size()));
  } else if (request.method != "GET") {
    curl_easy_setopt(curl, CURLOPT_CUSTOMREQUEST, request.method.c_str());
  }
}

void Perform(CURL* curl, const Receiving& receiving) {
  HttpAnswer& answer = *receiving.answer;
  char error[CURL_ERROR_SIZE] = "";
  curl_easy_setopt(curl, CURLOPT_ERRORBUFFER, error);
  const CURLcode result = curl_easy_perform(curl);
  long code = 0;
  curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &code);
  if (result == CURLE_OK || receiving.stopped) {
    answer.code = static_cast<int>(code);
  } else {
    answer.error = *error != '\0' ? error : curl_easy_strerror(result);
  }
  curl_easy_setopt(curl, CURLOPT_ERRORBUFFER, nullptr);
}

}  // namespace

HttpAnswer HttpClient::Send(const HttpRequest& request, const HttpSigner& signer) const {
  HttpAnswer answer;
  const bool is_signed = !signer.access_key.empty();
  const auto sha256 = is_signed ? BodyHash(request) : absl::StatusOr<std::string>("");
  if (!sha256.ok()) {
    answer.error = std::string(sha256.status().message());
    return answer;
  }
  CURL* const curl = handles_->Take();
  if (curl == nullptr) {
    answer.error = "no memory for a connection";
    return answer;
  }
  HeaderList headers;
  for (const auto& [name, value] : request.headers) headers.Add(name + ": " + value);
  if (is_signed) headers.Add("x-amz-content-sha256: " + *sha256);
  if (!signer.session_token.empty()) headers.Add("x-amz-security-token: " + signer.session_token);
  Sending sending{&request.body};
  Receiving receiving{&request, &answer};
  SetConnection(curl, request);
  if (is_signed) SetSigner(curl, signer);
  if (!ca_file_.empty()) curl_easy_setopt(curl, CURLOPT_CAINFO, ca_file_.c_str());
  if (farm_) SetFarm(curl, *farm_);
  SetAnswer(curl, receiving);
  SetMethod(curl, request, sending, headers);
  curl_easy_setopt(curl, CURLOPT_HTTPHEADER, headers.get());
  Perform(curl, receiving);
  handles_->Return(curl);
  return answer;
}

}  // namespace parallax
