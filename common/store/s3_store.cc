#include "common/store/s3_store.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <condition_variable>
#include <cstdlib>
#include <map>
#include <mutex>
#include <set>

#include "common/base/hash.h"
#include "common/base/log.h"
#include "common/base/status.h"
#include "common/store/http_client.h"
#include "common/store/local_store.h"

namespace parallax {
namespace {

constexpr std::string_view kScheme = "s3://";
constexpr char kHashHeader[] = "x-amz-meta-sha256";

std::string Environment(std::initializer_list<const char*> names) {
  for (const char* name : names) {
    const char* value = std::getenv(name);
    if (value != nullptr && *value != '\0') return value;
  }
  return "";
}

bool IsUnreserved(unsigned char c) {
  return std::isalnum(c) || c == '-' || c == '.' || c == '_' || c == '~';
}

// RFC 3986, as SigV4 wants it. `/` stays in paths.
std::string PercentEncode(std::string_view text, bool keep_slash) {
  std::string encoded;
  for (const unsigned char c : text) {
    if (IsUnreserved(c) || (keep_slash && c == '/')) {
      encoded += static_cast<char>(c);
    } else {
      encoded += '%';
      encoded += "0123456789ABCDEF"[c >> 4];
      encoded += "0123456789ABCDEF"[c & 15];
    }
  }
  return encoded;
}

std::string PercentDecode(std::string_view text) {
  std::string decoded;
  for (size_t i = 0; i < text.size(); ++i) {
    int value = 0;
    if (text[i] == '%' && i + 2 < text.size() &&
        std::from_chars(text.data() + i + 1, text.data() + i + 3, value, 16).ec == std::errc()) {
      decoded += static_cast<char>(value);
      i += 2;
    } else {
      decoded += text[i] == '+' ? ' ' : text[i];
    }
  }
  return decoded;
}

// The text of the first <name> in `xml`; "" without.
std::string_view Element(std::string_view xml, const std::string& name) {
  const std::string open = "<" + name + ">", close = "</" + name + ">";
  const size_t begin = xml.find(open);
  const size_t end = begin == std::string_view::npos ? begin : xml.find(close, begin);
  if (end == std::string_view::npos) return "";
  return xml.substr(begin + open.size(), end - begin - open.size());
}

std::string EscapeXml(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    escaped += c == '&'   ? "&amp;"
               : c == '<' ? "&lt;"
               : c == '>' ? "&gt;"
               : c == '"' ? "&quot;"
                          : std::string(1, c);
  }
  return escaped;
}

using Query = std::map<std::string, std::string>;  // Sorted, as the signature wants it.

bool IsTransient(const HttpAnswer& answer) {
  return answer.code == 0 || answer.code == 429 || answer.code >= 500;
}

struct OpenFile {
  explicit OpenFile(const std::string& path) : fd(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
  ~OpenFile() {
    if (fd >= 0) close(fd);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  const int fd;
};

class S3Store final : public Store {
 public:
  explicit S3Store(const S3Options& options)
      : options_(options),
        http_({.access_key = options.access_key,
               .secret_key = options.secret_key,
               .session_token = options.session_token,
               .region = options.region}) {}

  std::string Uri() const override {
    return std::string(kScheme) + options_.bucket +
           (options_.prefix.empty() ? "" : "/" + options_.prefix) +
           "?endpoint=" + PercentEncode(options_.endpoint, true) + "&region=" + options_.region +
           "&path_style=" + (options_.path_style ? "1" : "0");
  }

  absl::Status Put(std::string_view path, std::string_view bytes) override {
    RETURN_IF_ERROR(CheckStorePath(path));
    return PutKey(KeyOf(path), {.bytes = bytes}, Sha256Hex(bytes));
  }

  absl::Status PutFile(std::string_view path, const std::string& local_path, const StoreFile& facts,
                       bool) override {
    RETURN_IF_ERROR(CheckStorePath(path));
    ASSIGN_OR_RETURN(const HttpAnswer there, Ask({.method = "HEAD"}, KeyOf(path), {}, {404}));
    const auto hash = there.headers.find(kHashHeader);
    if (there.code == 200 && hash != there.headers.end() && hash->second == facts.sha256) {
      return absl::OkStatus();
    }
    // Read as it is sent: a worker has many files under way, and better use for its memory.
    const OpenFile file(local_path);
    if (file.fd < 0) return ErrnoError(errno, "open " + local_path);
    struct stat status {};
    if (fstat(file.fd, &status) != 0) return ErrnoError(errno, "look at " + local_path);
    const HttpBody body{.fd = file.fd, .file_bytes = status.st_size};
    ASSIGN_OR_RETURN(const std::string sha256, body.Sha256Hex());
    if (body.size() != facts.size || sha256 != facts.sha256) {
      return DataLoss("{}: its content is not what its manifest says", local_path);
    }
    return PutKey(KeyOf(path), body, sha256);
  }

  absl::StatusOr<std::string> Get(std::string_view path) const override {
    RETURN_IF_ERROR(CheckStorePath(path));
    ASSIGN_OR_RETURN(HttpAnswer answer, Ask({.method = "GET"}, KeyOf(path), {}, {}));
    return std::move(answer.body);
  }

  absl::StatusOr<std::string> GetPiece(std::string_view path, int64_t offset,
                                       size_t max_bytes) const override {
    RETURN_IF_ERROR(CheckStorePath(path));
    if (max_bytes == 0) return std::string();
    const std::string range =
        fmt::format("bytes={}-{}", offset, offset + static_cast<int64_t>(max_bytes) - 1);
    // 416: there is nothing from there on.
    ASSIGN_OR_RETURN(HttpAnswer answer,
                     Ask({.method = "GET", .headers = {{"Range", range}}}, KeyOf(path), {}, {416}));
    return answer.code == 416 ? std::string() : std::move(answer.body);
  }

  absl::StatusOr<std::vector<StoreEntry>> List(std::string_view prefix) const override {
    if (!prefix.empty()) RETURN_IF_ERROR(CheckStorePath(prefix));
    ASSIGN_OR_RETURN(std::vector<StoreEntry> entries,
                     ListKeys(prefix.empty() ? FolderKey() : KeyOf(prefix) + "/"));
    std::sort(entries.begin(), entries.end(),
              [](const StoreEntry& a, const StoreEntry& b) { return a.path < b.path; });
    return entries;
  }

  absl::Status RemoveTree(std::string_view path) override {
    ASSIGN_OR_RETURN(const std::vector<StoreEntry> entries, List(path));
    RETURN_IF_ERROR(CheckStorePath(path));
    RETURN_IF_ERROR(RemoveKey(KeyOf(path)));
    for (const StoreEntry& entry : entries) RETURN_IF_ERROR(RemoveKey(KeyOf(entry.path)));
    return absl::OkStatus();
  }

  absl::StatusOr<std::string> LocalPath(std::string_view path) const override {
    RETURN_IF_ERROR(CheckStorePath(path));
    return FailedPrecondition("store {} is no folder of this machine", Uri());
  }

  // Checks that we may read and, unless `read_only`, write here.
  absl::Status Probe(bool read_only) {
    if (read_only) {
      return Ask({.method = "GET"}, "", {{"list-type", "2"}, {"max-keys", "1"}}, {}).status();
    }
    const std::string key = FolderKey() + std::string(kTemporaryPrefix) + "probe";
    RETURN_IF_ERROR(PutKey(key, {.bytes = "probe"}, Sha256Hex("probe")));
    return RemoveKey(key);
  }

 private:
  std::string FolderKey() const { return options_.prefix.empty() ? "" : options_.prefix + "/"; }
  std::string KeyOf(std::string_view path) const { return FolderKey() + std::string(path); }

  std::string UrlOf(const std::string& key, const Query& query) const {
    std::string url;
    const size_t host = options_.endpoint.find("://") + 3;
    if (options_.path_style) {
      url = options_.endpoint + "/" + PercentEncode(options_.bucket, false);
    } else {
      url = options_.endpoint.substr(0, host) + options_.bucket + "." +
            options_.endpoint.substr(host);
    }
    url += "/" + PercentEncode(key, true);
    char mark = '?';
    for (const auto& [name, value] : query) {
      url += mark + PercentEncode(name, false) + "=" + PercentEncode(value, false);
      mark = '&';
    }
    return url;
  }

  // 2xx and `expected` codes are answers, all others errors.
  absl::StatusOr<HttpAnswer> Ask(HttpRequest request, const std::string& key, const Query& query,
                                 const std::set<int>& expected) const {
    request.url = UrlOf(key, query);
    const std::string what = "s3 " + request.method + " " + options_.bucket + "/" + key;
    HttpAnswer answer;
    auto pause = options_.first_pause;
    for (int i = 1;; ++i) {
      answer = http_.Send(request);
      if (!IsTransient(answer) || i >= options_.tries) break;
      LogDebug("s3 request to be tried again", {{"request", what}, {"code", answer.code}});
      Pause(pause);
      pause = std::min(pause * 2, options_.longest_pause);
    }
    if ((answer.code >= 200 && answer.code < 300) || expected.count(answer.code) > 0) {
      return answer;
    }
    return ErrorOf(answer, what);
  }

  static absl::Status ErrorOf(const HttpAnswer& answer, const std::string& what) {
    std::string why(Element(answer.body, "Code"));
    if (const auto message = Element(answer.body, "Message"); !message.empty()) {
      why += fmt::format(": {}", message);
    }
    if (answer.code == 0) return Unavailable("{}: {}", what, answer.error);
    return MakeError(CodeOfHttp(answer.code),
                     fmt::format("{}: HTTP {} {}", what, answer.code, why));
  }

  static absl::StatusCode CodeOfHttp(long http_code) {
    switch (http_code) {
      case 404:
        return absl::StatusCode::kNotFound;
      case 401:
      case 403:
        return absl::StatusCode::kPermissionDenied;
      case 400:
        return absl::StatusCode::kFailedPrecondition;
      case 507:
        return absl::StatusCode::kResourceExhausted;
      default:
        return absl::StatusCode::kUnavailable;
    }
  }

  static void Pause(std::chrono::milliseconds pause) {
    std::mutex mu;
    std::condition_variable never;
    std::unique_lock lock(mu);
    never.wait_for(lock, pause, [] { return false; });
  }

  absl::Status PutKey(const std::string& key, const HttpBody& body, const std::string& sha256) {
    if (body.size() > options_.part_bytes) return PutInParts(key, body, sha256);
    return Ask({.method = "PUT",
                .headers = {{kHashHeader, sha256}},
                .body = body,
                .sha256 = sha256},
               key, {}, {})
        .status();
  }

  // Sends a file in parts. The object becomes visible with the last request.
  absl::Status PutInParts(const std::string& key, const HttpBody& body, const std::string& sha256) {
    ASSIGN_OR_RETURN(
        const HttpAnswer begun,
        Ask({.method = "POST", .headers = {{kHashHeader, sha256}}}, key, {{"uploads", ""}}, {}));
    const std::string upload(Element(begun.body, "UploadId"));
    if (upload.empty()) return Unavailable("s3: no id for an upload in parts");
    const absl::Status status = PutParts(key, body, upload);
    if (!status.ok()) {
      Ask({.method = "DELETE"}, key, {{"uploadId", upload}}, {}).status().IgnoreError();
    }
    return status;
  }

  absl::Status PutParts(const std::string& key, const HttpBody& body, const std::string& upload) {
    std::string done = "<CompleteMultipartUpload>";
    int number = 1;
    for (int64_t at = 0; at < body.size(); at += options_.part_bytes, ++number) {
      const HttpBody part = body.Piece(at, options_.part_bytes);
      ASSIGN_OR_RETURN(const std::string sha256, part.Sha256Hex());
      ASSIGN_OR_RETURN(const HttpAnswer answer,
                       Ask({.method = "PUT", .body = part, .sha256 = sha256}, key,
                           {{"partNumber", std::to_string(number)}, {"uploadId", upload}}, {}));
      const auto tag = answer.headers.find("etag");
      if (tag == answer.headers.end()) return Unavailable("s3: a part without ETag");
      done += fmt::format("<Part><PartNumber>{}</PartNumber><ETag>{}</ETag></Part>", number,
                          EscapeXml(tag->second));
    }
    done += "</CompleteMultipartUpload>";
    ASSIGN_OR_RETURN(const HttpAnswer answer, Ask({.method = "POST", .body = {.bytes = done}}, key,
                                                  {{"uploadId", upload}}, {}));
    // The call may fail with 200, because the server answers before it knows.   Source: S3's API.
    if (answer.body.find("<Error>") != std::string::npos) return ErrorOf(answer, "s3 parts");
    return absl::OkStatus();
  }

  absl::StatusOr<std::vector<StoreEntry>> ListKeys(const std::string& prefix) const {
    std::vector<StoreEntry> entries;
    Query query = {{"list-type", "2"}, {"encoding-type", "url"}, {"prefix", prefix}};
    while (true) {
      ASSIGN_OR_RETURN(const HttpAnswer answer, Ask({.method = "GET"}, "", query, {}));
      std::string_view rest = answer.body;
      for (std::string_view item; !(item = Element(rest, "Contents")).empty();) {
        rest = std::string_view(
            item.data() + item.size(),
            static_cast<size_t>(rest.data() + rest.size() - (item.data() + item.size())));
        const std::string key = PercentDecode(Element(item, "Key"));
        const std::string_view size = Element(item, "Size");
        StoreEntry entry;
        entry.path = key.substr(FolderKey().size());
        std::from_chars(size.data(), size.data() + size.size(), entry.size);
        const size_t name = entry.path.rfind('/') + 1;  // 0 without.
        if (entry.path.compare(name, kTemporaryPrefix.size(), kTemporaryPrefix) == 0) continue;
        entries.push_back(std::move(entry));
      }
      const std::string next(Element(answer.body, "NextContinuationToken"));
      if (Element(answer.body, "IsTruncated") != "true" || next.empty()) return entries;
      query["continuation-token"] = next;
    }
  }

  absl::Status RemoveKey(const std::string& key) {
    return Ask({.method = "DELETE"}, key, {}, {404}).status();
  }

  const S3Options options_;
  const HttpClient http_;
};

absl::Status BadUri(std::string_view uri, const std::string& why) {
  return InvalidArgument(
      "store {}: {} (wanted s3://BUCKET[/PREFIX][?endpoint=URL&region=NAME&path_style=1])", uri,
      why);
}

}  // namespace

absl::StatusOr<S3Options> ParseS3Uri(std::string_view uri) {
  S3Options options;
  options.endpoint = Environment({"AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL"});
  options.region = Environment({"AWS_REGION", "AWS_DEFAULT_REGION"});
  options.access_key = Environment({"AWS_ACCESS_KEY_ID"});
  options.secret_key = Environment({"AWS_SECRET_ACCESS_KEY"});
  options.session_token = Environment({"AWS_SESSION_TOKEN"});
  std::optional<bool> path_style;
  const size_t mark = uri.find('?');
  const std::string_view place = uri.substr(0, mark).substr(kScheme.size());
  std::string_view rest = mark == std::string_view::npos ? "" : uri.substr(mark + 1);
  while (!rest.empty()) {
    const std::string_view pair = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(rest.size(), pair.size() + 1));
    const std::string name(pair.substr(0, pair.find('=')));
    const std::string value = PercentDecode(pair.substr(std::min(pair.size(), name.size() + 1)));
    if (name == "endpoint") {
      options.endpoint = value;
    } else if (name == "region") {
      options.region = value;
    } else if (name == "path_style" && (value == "0" || value == "1")) {
      path_style = value == "1";
    } else {
      return BadUri(uri, "unknown setting '" + std::string(pair) + "'");
    }
  }
  options.bucket = place.substr(0, place.find('/'));
  if (place.size() > options.bucket.size())
    options.prefix = place.substr(options.bucket.size() + 1);
  while (!options.prefix.empty() && options.prefix.back() == '/') options.prefix.pop_back();
  if (options.bucket.empty()) return BadUri(uri, "no bucket");
  if (!options.prefix.empty()) {
    const absl::Status prefix = CheckStorePath(options.prefix);
    if (!prefix.ok()) return BadUri(uri, std::string(ToStd(prefix.message())));
  }
  if (options.region.empty()) options.region = "us-east-1";
  options.path_style = path_style.value_or(!options.endpoint.empty());
  if (options.endpoint.empty())
    options.endpoint = "https://s3." + options.region + ".amazonaws.com";
  while (options.endpoint.back() == '/') options.endpoint.pop_back();
  if (options.endpoint.rfind("http://", 0) != 0 && options.endpoint.rfind("https://", 0) != 0) {
    return BadUri(uri, "endpoint '" + options.endpoint + "' is neither http:// nor https://");
  }
  if (options.access_key.empty() || options.secret_key.empty()) {
    return FailedPrecondition(
        "store {}: no credentials; set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY", uri);
  }
  return options;
}

absl::StatusOr<std::unique_ptr<Store>> OpenS3Store(const S3Options& options,
                                                   const StoreOptions& store) {
  auto opened = std::make_unique<S3Store>(options);
  RETURN_IF_ERROR(WithContext(opened->Probe(store.read_only), "store"));
  return std::unique_ptr<Store>(std::move(opened));
}

}  // namespace parallax
