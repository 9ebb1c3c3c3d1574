#include <algorithm>
#include <cstring>
#include <fstream>
#include <set>
#include <utility>

#include "worker/assets/files/gltf_data.h"

namespace parallax {
namespace {

using Json = nlohmann::json;

constexpr size_t kHeaderBytes = 12, kChunkHeaderBytes = 8;
constexpr size_t kMostJsonBytes = 64 << 20;
constexpr size_t kDeepestJson = 64;

uint32_t NumberAt(std::string_view bytes, size_t at) {
  uint32_t number = 0;
  std::memcpy(&number, bytes.data() + at, sizeof(number));
  return number;
}

// Watches the parser: how deep the JSON is, and whether a key stands twice in one object, which
// readers take for different values.
class JsonWatch final : public nlohmann::json_sax<Json> {
 public:
  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(number_integer_t) override { return true; }
  bool number_unsigned(number_unsigned_t) override { return true; }
  bool number_float(number_float_t, const string_t&) override { return true; }
  bool string(string_t&) override { return true; }
  bool binary(binary_t&) override { return true; }
  bool start_object(size_t) override { return Begin(); }
  bool start_array(size_t) override { return Begin(); }
  bool end_object() override { return End(); }
  bool end_array() override { return End(); }
  bool key(string_t& name) override {
    if (keys_.back().insert(name).second) return true;
    status_ = InvalidArgument("its JSON has \"{}\" twice in one object", name);
    return false;
  }
  bool parse_error(size_t at, const std::string&, const Json::exception&) override {
    status_ = InvalidArgument("its JSON is damaged or not UTF-8 (at byte {})", at);
    return false;
  }

  const absl::Status& status() const { return status_; }

 private:
  bool Begin() {
    keys_.emplace_back();
    if (keys_.size() <= kDeepestJson) return true;
    status_ = InvalidArgument("its JSON has more than {} levels", kDeepestJson);
    return false;
  }
  bool End() {
    keys_.pop_back();
    return true;
  }

  std::vector<std::set<std::string>> keys_;  // By level, of the object that is open.
  absl::Status status_;
};

absl::StatusOr<Json> ParseJson(std::string_view text) {
  text = text.substr(0, text.find('\0'));  // Some writers pad with zeros.
  JsonWatch watch;
  Json::sax_parse(text, &watch);
  RETURN_IF_ERROR(watch.status());
  Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return InvalidArgument("its JSON is no object");
  return json;
}

// Returns the text of the JSON chunk, which may be cut where `bytes` are only the file's first.
absl::StatusOr<std::string_view> JsonChunk(std::string_view bytes, uint64_t file_bytes) {
  if (bytes.size() < kHeaderBytes + kChunkHeaderBytes || bytes.substr(0, 4) != "glTF") {
    return InvalidArgument("does not begin as a .glb does");
  }
  if (const uint32_t version = NumberAt(bytes, 4); version != 2) {
    return InvalidArgument("glTF of version {}, wanted 2", version);
  }
  if (const uint32_t length = NumberAt(bytes, 8); length > file_bytes) {
    return InvalidArgument("is cut: it has {} of its {} bytes", file_bytes, length);
  }
  const uint64_t length = NumberAt(bytes, kHeaderBytes);
  if (bytes.substr(kHeaderBytes + 4, 4) != "JSON") {
    return InvalidArgument("its first chunk is not its JSON");
  }
  if (length > file_bytes - kHeaderBytes - kChunkHeaderBytes || length > kMostJsonBytes) {
    return InvalidArgument("its JSON has {} bytes, wanted at most {} and all of them in the file",
                           length, kMostJsonBytes);
  }
  return bytes.substr(kHeaderBytes + kChunkHeaderBytes, length);
}

// Returns the binary chunk, which follows the JSON; empty where none exists.
absl::StatusOr<std::string_view> BinaryChunk(std::string_view bytes, size_t json_bytes) {
  const size_t begin = (kHeaderBytes + kChunkHeaderBytes + json_bytes + 3) / 4 * 4;
  const std::string_view rest = bytes.substr(std::min(begin, bytes.size()));
  if (rest.size() < kChunkHeaderBytes) return std::string_view();
  const uint64_t length = NumberAt(rest, 0);
  if (rest.substr(4, 4) != std::string_view("BIN\0", 4)) {
    return InvalidArgument("its second chunk is not binary");
  }
  if (length > rest.size() - kChunkHeaderBytes) {
    return InvalidArgument("is cut: its binary chunk has {} of {} bytes",
                           rest.size() - kChunkHeaderBytes, length);
  }
  return rest.substr(kChunkHeaderBytes, length);
}

}  // namespace

absl::StatusOr<GlbChunks> ReadGlbChunks(std::string_view bytes) {
  ASSIGN_OR_RETURN(const std::string_view text, JsonChunk(bytes, bytes.size()));
  GlbChunks chunks;
  ASSIGN_OR_RETURN(chunks.json, ParseJson(text));
  ASSIGN_OR_RETURN(chunks.body, BinaryChunk(bytes, text.size()));
  return chunks;
}

std::vector<std::string> PicturesBesideGlb(const std::string& path) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  const auto file_bytes = static_cast<uint64_t>(std::max<std::streamoff>(in.tellg(), 0));
  std::string bytes(kHeaderBytes + kChunkHeaderBytes, '\0');
  if (!in.seekg(0) || !in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) return {};
  if (!JsonChunk(bytes, file_bytes).ok()) return {};
  std::string text(NumberAt(bytes, kHeaderBytes), '\0');
  if (!in.read(text.data(), static_cast<std::streamsize>(text.size()))) return {};
  const absl::StatusOr<Json> json = ParseJson(text);
  if (!json.ok() || !json->contains("images") || !(*json)["images"].is_array()) return {};
  std::vector<std::string> names;
  for (const Json& image : (*json)["images"]) {
    if (!image.is_object() || !image.contains("uri") || !image["uri"].is_string()) continue;
    std::string uri = image["uri"];
    if (!uri.starts_with("data:")) names.push_back(std::move(uri));
  }
  return names;
}

}  // namespace parallax
