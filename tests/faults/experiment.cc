#include "tests/faults/experiment.h"

#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

namespace parallax::faults {
namespace {

constexpr size_t kComplaints = 50;

void Complain(Tally& tally, const std::string& what) {
  std::fprintf(stderr, "%s\n", what.c_str());
  if (tally.complaints.size() < kComplaints) tally.complaints.push_back(what);
}

// Removes the folders of processes that are gone. Their names are `prefix`, then the process's id.
void RemoveStale(const std::filesystem::path& prefix) {
  const std::string name = prefix.filename();
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(prefix.parent_path(), ignored)) {
    const std::string other = entry.path().filename();
    if (!other.starts_with(name)) continue;
    const pid_t pid = std::atoi(other.c_str() + name.size());
    if (pid > 0 && kill(pid, 0) != 0 && errno == ESRCH) {
      std::filesystem::remove_all(entry.path(), ignored);
    }
  }
}

}  // namespace

void Tally::Lost(const std::string& what) {
  ++lost;
  Complain(*this, "lost: " + what);
}

void Tally::Doubled(const std::string& what) {
  ++doubled;
  Complain(*this, "doubled: " + what);
}

void Tally::Found(const std::vector<std::string>& violations, const std::string& where) {
  findings += static_cast<int64_t>(violations.size());
  for (const std::string& violation : violations) Complain(*this, where + ": " + violation);
}

TempFolder::TempFolder(bool memory) {
  std::string name = memory && access("/dev/shm", W_OK) == 0
                         ? "/dev/shm"
                         : std::filesystem::temp_directory_path().string();
  name += "/parallax-faults-";
  static const bool removed = (RemoveStale(name), true);
  (void)removed;
  name += std::to_string(getpid()) + "-XXXXXX";
  if (mkdtemp(name.data()) == nullptr) {
    std::perror(name.c_str());
    std::exit(1);
  }
  path_ = name;
}

TempFolder::~TempFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

Rng RoundRng(const ExperimentOptions& options, const std::string& experiment, int round) {
  return Rng(SceneSeed{options.seed}, "faults/" + experiment)
      .Child("round", static_cast<uint64_t>(round));
}

}  // namespace parallax::faults
