#include "common/rpc/revocation.h"

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <set>
#include <sstream>
#include <utility>

#include "common/base/seconds.h"
#include "common/base/system/file.h"
#include "common/base/system/log.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr double kLookEvery_s = 1;
constexpr size_t kMostBytes = 16 << 20;

using Fingerprints = std::set<std::string, std::less<>>;

bool IsFingerprint(const std::string& word) {
  return word.size() == 64 && std::all_of(word.begin(), word.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

absl::StatusOr<Fingerprints> ReadFingerprints(const std::string& path) {
  Fingerprints found;
  const absl::StatusOr<std::string> read = ReadFile(path, kMostBytes);
  if (!read.ok() && !absl::IsNotFound(read.status())) return read.status();
  const std::string text = read.ok() ? *read : "";
  if (text.find_first_not_of(" \t\r\n") == std::string::npos) {
    return FailedPrecondition(
        "{}: {}; if no certificate is revoked, let it have a line that begins with '#'", path,
        read.ok() ? "the list of revoked certificates is empty"
                  : "there is no list of revoked certificates");
  }
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::string word = line.substr(0, line.find('#'));
    word.erase(std::remove_if(word.begin(), word.end(), ::isspace), word.end());
    if (word.empty()) continue;
    if (!IsFingerprint(word)) {
      return InvalidArgument("{}:{}: '{}' is no SHA-256 fingerprint of 64 lower-case hex digits",
                             path, number, word);
    }
    found.insert(std::move(word));
  }
  return found;
}

// Time and size of the file: one of them changes when it is written again.
std::pair<fs::file_time_type, uintmax_t> StampOf(const std::string& path) {
  std::error_code error;
  const auto time = fs::last_write_time(path, error);
  if (error) return {};
  return {time, fs::file_size(path, error)};
}

class RevokedCertificatesImpl final : public RevokedCertificates {
 public:
  RevokedCertificatesImpl(std::string path, Clock& clock) : path_(std::move(path)), clock_(clock) {}

  absl::Status Read() {
    std::lock_guard lock(mu_);
    return ReadLocked();
  }

  bool Contains(std::string_view sha256) override {
    std::lock_guard lock(mu_);
    if (SecondsBetween(looked_, clock_.Steady()) >= kLookEvery_s) LookAgain();
    return fingerprints_.find(sha256) != fingerprints_.end();
  }

 private:
  absl::Status ReadLocked() {
    looked_ = clock_.Steady();
    stamp_ = StampOf(path_);
    ASSIGN_OR_RETURN(const Fingerprints found, ReadFingerprints(path_));
    const size_t before = fingerprints_.size();
    fingerprints_.insert(found.begin(), found.end());
    if (const size_t gone = fingerprints_.size() - found.size(); before > 0 && gone > 0) {
      LogWarning("revoked certificates are missing in the list; they stay revoked until a restart",
                 {{"file", path_}, {"count", gone}});
    }
    return absl::OkStatus();
  }

  void LookAgain() {
    looked_ = clock_.Steady();
    if (StampOf(path_) == stamp_) return;
    if (const absl::Status status = ReadLocked(); !status.ok()) {
      LogError("revoked certificates: the list is left as it was read before",
               {{"error", ToStd(status.message())}});
      return;
    }
    LogInfo("revoked certificates read", {{"file", path_}, {"count", fingerprints_.size()}});
  }

  const std::string path_;
  Clock& clock_;
  std::mutex mu_;
  // Guarded by mu_.
  SteadyTime looked_{};
  std::pair<fs::file_time_type, uintmax_t> stamp_;
  Fingerprints fingerprints_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<RevokedCertificates>> RevokedCertificates::Open(
    const std::string& path, Clock& clock) {
  auto revoked = std::make_unique<RevokedCertificatesImpl>(path, clock);
  RETURN_IF_ERROR(revoked->Read());
  return revoked;
}

}  // namespace parallax
