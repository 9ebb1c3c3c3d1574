#include "coordinator/client/farm/slurm.h"

#include <fmt/core.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "common/base/names.h"
#include "common/base/system/child_process.h"
#include "coordinator/client/views/text.h"

namespace parallax::client {
namespace {

// A name for a file that is gone with the object.
class TemporaryFile {
 public:
  TemporaryFile() : path_(std::filesystem::temp_directory_path() / "parallax_slurm_XXXXXX") {
    if (const int file = mkstemp(path_.data()); file >= 0) close(file);
  }
  ~TemporaryFile() { unlink(path_.c_str()); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::string& path() const { return path_; }
  std::string Read() const {
    std::ostringstream text;
    text << std::ifstream(path_).rdbuf();
    return text.str();
  }

 private:
  std::string path_;
};

// Output and errors of a program that ended well.
absl::StatusOr<std::string> OutputOf(const std::vector<std::string>& command,
                                     const std::vector<std::string>& environment = {}) {
  constexpr std::chrono::seconds kLimit(60);
  const TemporaryFile output;
  ASSIGN_OR_RETURN(
      const auto child,
      ChildProcess::Start(
          {.command = command, .directory = "", .log = output.path(), .environment = environment}));
  const auto deadline = std::chrono::steady_clock::now() + kLimit;
  std::optional<int> ended;
  while (!(ended = child->Poll())) {
    if (std::chrono::steady_clock::now() > deadline) {
      child->Kill();
      return DeadlineExceeded("{} did not end within a minute", command[0]);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const std::string text = output.Read();
  if (WIFEXITED(*ended) && WEXITSTATUS(*ended) == 0) return text;
  return Unavailable("{}: {}: {}", command[0], DescribeExit(*ended), FirstLine(text));
}

Pilot::State StateOf(const std::string& state) {
  if (state == "RUNNING") return Pilot::State::kRunning;
  // A requeued or suspended pilot comes back by itself.
  for (const char* waiting : {"PENDING", "CONFIGURING", "REQUEUED", "REQUEUE_FED", "REQUEUE_HOLD",
                              "RESIZING", "SUSPENDED"}) {
    if (state == waiting) return Pilot::State::kPending;
  }
  return Pilot::State::kEnding;
}

}  // namespace

absl::StatusOr<std::vector<Pilot>> ParsePilots(const std::string& text) {
  std::vector<Pilot> pilots;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty()) continue;
    const size_t bar = line.find('|');
    if (bar == std::string::npos || bar == 0 || !isdigit(static_cast<unsigned char>(line[0]))) {
      return InvalidArgument("squeue: expected ID|STATE, got '{}'", line);
    }
    pilots.push_back({line.substr(0, bar), StateOf(line.substr(bar + 1))});
  }
  return pilots;
}

absl::StatusOr<std::vector<Pilot>> Slurm::Pilots() const {
  ASSIGN_OR_RETURN(const std::string text,
                   OutputOf({"squeue", "--me", "--array", "--noheader", "--sort=i",
                             "--name=" + options_.job_name, "--format=%i|%T"}));
  return ParsePilots(text);
}

std::vector<std::string> Slurm::SubmitWords(int pilots) const {
  std::vector<std::string> words = {"sbatch", "--parsable", "--job-name=" + options_.job_name,
                                    fmt::format("--array=1-{}", pilots)};
  words.insert(words.end(), options_.sbatch_options.begin(), options_.sbatch_options.end());
  words.push_back(options_.script);
  words.insert(words.end(), options_.worker_arguments.begin(), options_.worker_arguments.end());
  return words;
}

std::string Slurm::SubmitCommand(int pilots) const {
  std::string line;
  for (const std::string& variable : options_.environment) line += variable + " ";
  for (const std::string& word : SubmitWords(pilots)) line += word + " ";
  line.pop_back();
  return line;
}

absl::StatusOr<std::string> Slurm::Submit(int pilots) const {
  ASSIGN_OR_RETURN(const std::string text, OutputOf(SubmitWords(pilots), options_.environment));
  // "17" or "17;cluster", after warnings of the site's plugins.
  std::istringstream lines(text);
  std::string id;
  for (std::string line; std::getline(lines, line);) {
    const std::string first = line.substr(0, line.find(';'));
    if (!first.empty() &&
        std::all_of(first.begin(), first.end(), [](unsigned char c) { return isdigit(c) != 0; })) {
      id = first;
    }
  }
  if (id.empty()) {
    return Unavailable("sbatch named no job: {}", FirstLine(text));
  }
  return id;
}

absl::Status Slurm::Cancel(const std::vector<std::string>& ids) const {
  if (ids.empty()) return absl::OkStatus();
  std::vector<std::string> command = {"scancel"};
  command.insert(command.end(), ids.begin(), ids.end());
  return OutputOf(command).status();
}

}  // namespace parallax::client
