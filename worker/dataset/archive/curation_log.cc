#include "worker/dataset/archive/curation_log.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <sstream>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/base/version.h"
#include "common/store/store.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

// Scores of another version of the network's program or of the metrics are not today's.
std::string Versions() { return std::string(kTrainVersion) + "/" + kEvaluateVersion; }

// Identifies the files on which a score depends.
std::string ContentOf(const DatasetFrame& frame) {
  Sha256 hash;
  for (const char* name : {"left.png", "right.png", "disparity_left.exr", "masks_left.png"}) {
    const auto file = frame.files.find(name);
    hash.Update(name).Update(" ");
    if (file != frame.files.end()) hash.Update(file->second);
    hash.Update("\n");
  }
  return HexOf(hash.Finish());
}

absl::Status AppendAndSync(const std::string& path, const std::string& text) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file < 0) return ErrnoError(errno, "open " + path);
  absl::Status status;
  for (size_t done = 0; status.ok() && done < text.size();) {
    const ssize_t wrote = ::write(file, text.data() + done, text.size() - done);
    if (wrote > 0) done += static_cast<size_t>(wrote);
    if (wrote < 0 && errno != EINTR) status = ErrnoError(errno, "write " + path);
  }
  if (status.ok() && ::fdatasync(file) != 0) status = ErrnoError(errno, "write " + path);
  ::close(file);
  return status;
}

bool IsText(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_string();
}
bool IsCount(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_number_unsigned();
}

}  // namespace

absl::StatusOr<CurationLog> CurationLog::Open(const std::string& variant_dir) {
  CurationLog log(variant_dir + "/curation.jsonl");
  const absl::StatusOr<std::string> text = ReadFile(log.path_);
  if (absl::IsNotFound(text.status())) return log;
  RETURN_IF_ERROR(text.status());
  std::string whole;
  std::istringstream in(*text);
  for (std::string row; std::getline(in, row);) {
    const Json json = Json::parse(row, nullptr, /*allow_exceptions=*/false);
    if (!json.is_object() || !IsText(json, "frame") || !IsText(json, "network") ||
        !IsText(json, "versions") || !IsCount(json, "pixels") || !IsCount(json, "bad")) {
      continue;
    }
    whole += row + "\n";
    if (json["versions"] != Versions()) continue;
    log.scores_[{json["frame"], json["network"]}] = {json["pixels"], json["bad"]};
  }
  if (whole != *text) RETURN_IF_ERROR(WriteFileAtomically(log.path_, whole));
  return log;
}

std::optional<CurationScore> CurationLog::Find(const DatasetFrame& frame,
                                               const std::string& network) const {
  const auto found = scores_.find({ContentOf(frame), network});
  if (found == scores_.end()) return std::nullopt;
  return found->second;
}

absl::Status CurationLog::Add(const std::string& network, const std::vector<Entry>& entries) {
  std::string text;
  for (const Entry& entry : entries) {
    const std::string content = ContentOf(*entry.frame);
    const Json json = {
        {"scene", entry.frame->scene}, {"rig", entry.frame->rig}, {"frame", content},
        {"network", network},          {"versions", Versions()},  {"pixels", entry.score.pixels},
        {"bad", entry.score.bad}};
    text += json.dump() + "\n";
    scores_[{content, network}] = entry.score;
  }
  return AppendAndSync(path_, text);
}

}  // namespace parallax
