#include "worker/dataset/verify/verify_files.h"

#include <sys/stat.h>

#include <filesystem>

#include "common/base/hash.h"
#include "common/base/status.h"

namespace parallax {

namespace fs = std::filesystem;

void CheckFiles(const DatasetFrame& frame, bool hashes, std::vector<Finding>& findings,
                int64_t& bytes) {
  const auto find = [&](const char* check, const std::string& file, const std::string& message) {
    findings.push_back({check, frame.dir + "/" + file, message});
  };
  for (const char* name : {"left.png", "right.png", "frame.json"}) {
    if (!frame.files.contains(name)) find("missing", name, "not in the index");
  }
  for (const auto& [name, hash] : frame.files) {
    struct stat info {};
    if (::stat((frame.dir + "/" + name).c_str(), &info) != 0) {
      find("missing", name, "the index has it, the disk has not");
      continue;
    }
    bytes += info.st_size;
    if (!hashes) continue;
    const absl::StatusOr<std::string> seen = Sha256HexOfFile(frame.dir + "/" + name);
    if (!seen.ok()) {
      find("hash", name, std::string(ToStd(seen.status().message())));
    } else if (*seen != hash) {
      find("hash", name,
           "SHA-256 is " + seen->substr(0, 12) + "..., the index says " + hash.substr(0, 12) +
               "...");
    }
  }
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(frame.dir, error)) {
    const std::string name = entry.path().filename();
    if (!frame.files.contains(name)) find("stray", name, "not in the index");
  }
}

}  // namespace parallax
