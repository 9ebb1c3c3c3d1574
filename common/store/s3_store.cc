#include "common/store/s3_store.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>

#include "common/base/hash.h"
#include "common/base/status.h"
#include "common/base/system/secret.h"
#include "common/store/local_store.h"
#include "common/store/s3_requests.h"
#include "common/store/s3_text.h"

namespace parallax {
namespace {

constexpr char kHashHeader[] = "x-amz-meta-sha256";

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
  explicit S3Store(const S3Options& options) : options_(options), requests_(options) {}

  std::string Uri() const override { return S3Uri(options_); }
  std::string Id() const override { return id_; }
  absl::Status CheckMarker() const override {
    ASSIGN_OR_RETURN(const std::string id, ReadMarker());
    return CheckStoreId(Uri(), id, id_);
  }
  absl::StatusOr<std::string> Owner() const override {
    ASSIGN_OR_RETURN(const std::string text, ReadOwn(kStoreOwner));
    return text.substr(0, text.find('\n'));
  }
  absl::Status SetOwner(const std::string& database_id) override {
    return PutOwn(kStoreOwner, database_id + "\n");
  }

  // Reads the marker's id, or makes a marker. Errors: those of OpenStore.
  absl::Status TakeMarker(const StoreOptions& options) {
    ASSIGN_OR_RETURN(id_, ReadMarker());
    if (id_.empty() && options.create) {
      ASSIGN_OR_RETURN(id_, NewSecret());
      RETURN_IF_ERROR(PutOwn(kStoreMarker, StoreMarkerText(id_)));
    }
    // An older coordinator made a store without a marker.
    if (id_.empty() && options.id.empty()) return absl::OkStatus();
    return CheckStoreId(Uri(), id_, options.id);
  }

  absl::Status Put(std::string_view path, std::string_view bytes) override {
    RETURN_IF_ERROR(CheckStorePath(path));
    return PutKey(KeyOf(path), {.bytes = bytes}, Sha256Hex(bytes));
  }

  absl::Status PutFile(std::string_view path, const std::string& local_path, const StoreFile& facts,
                       bool) override {
    RETURN_IF_ERROR(CheckStorePath(path));
    ASSIGN_OR_RETURN(const bool is_there, HasHash(KeyOf(path), facts.sha256));
    if (is_there) return absl::OkStatus();
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
    ASSIGN_OR_RETURN(HttpAnswer answer, requests_.Ask({.method = "GET"}, KeyOf(path)));
    return std::move(answer.body);
  }

  absl::StatusOr<std::string> GetPiece(std::string_view path, int64_t offset,
                                       size_t max_bytes) const override {
    RETURN_IF_ERROR(CheckStorePath(path));
    if (max_bytes == 0) return std::string();
    const std::string range =
        fmt::format("bytes={}-{}", offset, offset + static_cast<int64_t>(max_bytes) - 1);
    // 416: there is nothing from there on.
    ASSIGN_OR_RETURN(
        HttpAnswer answer,
        requests_.Ask({.method = "GET", .headers = {{"Range", range}}}, KeyOf(path), {}, {416}));
    if (answer.code == 416) return std::string();
    if (answer.code == 206) return std::move(answer.body);
    // A server or proxy may send the whole file all the same.   Source: RFC 9110, 14.2.
    const size_t from = std::min(answer.body.size(), static_cast<size_t>(offset));
    return answer.body.substr(from, max_bytes);
  }

  absl::StatusOr<bool> Has(std::string_view path) const override {
    RETURN_IF_ERROR(CheckStorePath(path));
    ASSIGN_OR_RETURN(const HttpAnswer answer,
                     requests_.Ask({.method = "HEAD"}, KeyOf(path), {}, {404}));
    return answer.code != 404;
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
      return requests_.Ask({.method = "GET"}, "", {{"list-type", "2"}, {"max-keys", "1"}}).status();
    }
    const std::string key = FolderKey() + std::string(kTemporaryPrefix) + "probe";
    RETURN_IF_ERROR(PutKey(key, {.bytes = "probe"}, Sha256Hex("probe")));
    return RemoveKey(key);
  }

 private:
  // The store's own objects; "" without.
  absl::StatusOr<std::string> ReadOwn(std::string_view name) const {
    ASSIGN_OR_RETURN(HttpAnswer answer,
                     requests_.Ask({.method = "GET"}, FolderKey() + std::string(name), {}, {404}));
    return answer.code == 404 ? std::string() : std::move(answer.body);
  }
  absl::Status PutOwn(std::string_view name, const std::string& text) {
    return PutKey(FolderKey() + std::string(name), {.bytes = text}, Sha256Hex(text));
  }
  absl::StatusOr<std::string> ReadMarker() const {
    ASSIGN_OR_RETURN(const std::string text, ReadOwn(kStoreMarker));
    if (text.empty()) return text;
    return ParseStoreMarker(text, Uri());
  }

  std::string FolderKey() const { return options_.prefix.empty() ? "" : options_.prefix + "/"; }
  std::string KeyOf(std::string_view path) const { return FolderKey() + std::string(path); }

  absl::Status PutKey(const std::string& key, const HttpBody& body, const std::string& sha256) {
    if (body.size() > options_.part_bytes) return PutInParts(key, body, sha256);
    return requests_
        .Ask({.method = "PUT", .headers = {{kHashHeader, sha256}}, .body = body, .sha256 = sha256},
             key)
        .status();
  }

  // Returns whether the object is there and was put with this hash.
  absl::StatusOr<bool> HasHash(const std::string& key, const std::string& sha256) const {
    ASSIGN_OR_RETURN(const HttpAnswer there, requests_.Ask({.method = "HEAD"}, key, {}, {404}));
    const auto hash = there.headers.find(kHashHeader);
    return there.code == 200 && hash != there.headers.end() && hash->second == sha256;
  }

  // Sends a file in parts. The object becomes visible with the last request.
  absl::Status PutInParts(const std::string& key, const HttpBody& body, const std::string& sha256) {
    ASSIGN_OR_RETURN(const HttpAnswer begun,
                     requests_.Ask({.method = "POST", .headers = {{kHashHeader, sha256}}}, key,
                                   {{"uploads", ""}}));
    const std::string upload(Element(begun.body, "UploadId"));
    if (upload.empty()) return Unavailable("s3: no id for an upload in parts");
    const absl::Status status = PutParts(key, body, upload, sha256);
    if (!status.ok()) {
      requests_.Ask({.method = "DELETE"}, key, {{"uploadId", upload}}).status().IgnoreError();
    }
    return status;
  }

  absl::Status PutParts(const std::string& key, const HttpBody& body, const std::string& upload,
                        const std::string& whole_sha256) {
    std::string done = "<CompleteMultipartUpload>";
    int number = 1;
    for (int64_t at = 0; at < body.size(); at += options_.part_bytes, ++number) {
      const HttpBody part = body.Piece(at, options_.part_bytes);
      ASSIGN_OR_RETURN(const std::string sha256, part.Sha256Hex());
      ASSIGN_OR_RETURN(
          const HttpAnswer answer,
          requests_.Ask({.method = "PUT", .body = part, .sha256 = sha256}, key,
                        {{"partNumber", std::to_string(number)}, {"uploadId", upload}}));
      const auto tag = answer.headers.find("etag");
      if (tag == answer.headers.end()) return Unavailable("s3: a part without ETag");
      done += fmt::format("<Part><PartNumber>{}</PartNumber><ETag>{}</ETag></Part>", number,
                          EscapeXml(tag->second));
    }
    done += "</CompleteMultipartUpload>";
    ASSIGN_OR_RETURN(const HttpAnswer answer,
                     requests_.Ask({.method = "POST", .body = {.bytes = done}}, key,
                                   {{"uploadId", upload}}, {404}));
    if (answer.code == 404) {  // A first try, whose answer was lost, may have completed it.
      ASSIGN_OR_RETURN(const bool is_complete, HasHash(key, whole_sha256));
      return is_complete ? absl::OkStatus() : S3Error(answer, "s3 parts of " + key);
    }
    // The call may fail with 200, because the server answers before it knows.   Source: S3's API.
    if (answer.body.find("<Error>") != std::string::npos) return S3Error(answer, "s3 parts");
    return absl::OkStatus();
  }

  absl::StatusOr<std::vector<StoreEntry>> ListKeys(const std::string& prefix) const {
    std::vector<StoreEntry> entries;
    S3Query query = {{"list-type", "2"}, {"encoding-type", "url"}, {"prefix", prefix}};
    while (true) {
      ASSIGN_OR_RETURN(const HttpAnswer answer, requests_.Ask({.method = "GET"}, "", query));
      const bool is_encoded = Element(answer.body, "EncodingType") == "url";
      std::string_view rest = answer.body;
      for (std::string_view item; !(item = Element(rest, "Contents")).empty();) {
        rest = std::string_view(
            item.data() + item.size(),
            static_cast<size_t>(rest.data() + rest.size() - (item.data() + item.size())));
        const std::string text = UnescapeXml(Element(item, "Key"));
        const std::string key = is_encoded ? PercentDecode(text) : text;
        if (key.ends_with('/')) continue;  // The mark of a folder that somebody made by hand.
        if (!key.starts_with(FolderKey())) {
          return DataLoss("s3: the server listed \"{}\", which does not begin with \"{}\"", key,
                          FolderKey());
        }
        const std::string_view size = Element(item, "Size");
        StoreEntry entry;
        entry.path = key.substr(FolderKey().size());
        std::from_chars(size.data(), size.data() + size.size(), entry.size);
        const size_t name = entry.path.rfind('/') + 1;  // 0 without.
        if (entry.path.compare(name, kTemporaryPrefix.size(), kTemporaryPrefix) == 0 ||
            entry.path == kStoreMarker || entry.path == kStoreOwner) {
          continue;
        }
        entry.modified_unix_s = UnixSecondsOf(Element(item, "LastModified"));
        entries.push_back(std::move(entry));
      }
      // Ceph's is a key, as XML writes it.
      const std::string next = UnescapeXml(Element(answer.body, "NextContinuationToken"));
      if (Element(answer.body, "IsTruncated") != "true") return entries;
      if (next.empty()) {
        return Unimplemented(
            "s3: the list of {}/{} goes on, and the server does not say where; wanted is a server "
            "that knows ListObjectsV2",
            options_.bucket, prefix);
      }
      query["continuation-token"] = next;
    }
  }

  absl::Status RemoveKey(const std::string& key) {
    return requests_.Ask({.method = "DELETE"}, key, {}, {404}).status();
  }

  const S3Options options_;
  const S3Requests requests_;
  std::string id_;  // Constant after TakeMarker.
};

}  // namespace

absl::StatusOr<std::unique_ptr<Store>> OpenS3Store(const S3Options& options,
                                                   const StoreOptions& store) {
  auto opened = std::make_unique<S3Store>(options);
  RETURN_IF_ERROR(WithContext(opened->Probe(store.read_only), "store"));
  StoreOptions marker = store;
  marker.create = store.create && !store.read_only;
  RETURN_IF_ERROR(opened->TakeMarker(marker));
  return std::unique_ptr<Store>(std::move(opened));
}

}  // namespace parallax
