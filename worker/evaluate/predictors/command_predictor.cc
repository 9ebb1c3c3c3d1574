#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "worker/evaluate/predictors/predictor.h"
#include "worker/evaluate/predictors/predictor_command.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPlaceholder = "{list}";

// In single quotes for the shell.
std::string Quoted(const std::string& word) {
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

bool HasBlank(const std::string& path) {
  return path.find_first_of(" \t\r\n\v\f") != std::string::npos;
}

// Names without blanks for paths that have some, because blanks separate the fields of a list. They
// lie in a temporary folder of links, made when the first one is needed and removed with this.
class BlanklessPaths {
 public:
  BlanklessPaths() = default;
  ~BlanklessPaths() {
    std::error_code error;
    if (!folder_.empty()) fs::remove_all(folder_, error);
  }
  BlanklessPaths(const BlanklessPaths&) = delete;
  BlanklessPaths& operator=(const BlanklessPaths&) = delete;

  // Returns `path`, or another path of the same file, which need not exist yet unless its own name
  // has a blank.
  absl::StatusOr<std::string> Of(const std::string& path) {
    if (!HasBlank(path)) return path;
    const fs::path full(path);
    if (HasBlank(full.filename())) {
      return LinkTo(path, fmt::format("{}{}", links_.size(), full.extension().string()));
    }
    ASSIGN_OR_RETURN(const std::string folder,
                     LinkTo(full.parent_path(), std::to_string(links_.size())));
    return folder + "/" + full.filename().string();
  }

 private:
  absl::StatusOr<std::string> LinkTo(const std::string& path, const std::string& name) {
    const auto known = links_.find(path);
    if (known != links_.end()) return known->second;
    if (folder_.empty()) {
      RETURN_IF_ERROR(MakeFolder());
    }
    std::string link = folder_ + "/" + name;
    if (HasBlank(link)) link = folder_ + "/" + std::to_string(links_.size());
    std::error_code error;
    fs::create_symlink(path, link, error);
    if (error) return ErrnoError(error.value(), "link " + link);
    return links_[path] = link;
  }

  absl::Status MakeFolder() {
    const char* const candidates[] = {std::getenv("TMPDIR"), "/tmp", "/var/tmp", "/dev/shm"};
    for (const char* candidate : candidates) {
      if (candidate == nullptr || candidate[0] != '/' || HasBlank(candidate)) continue;
      std::string folder = std::string(candidate) + "/parallax-links-XXXXXX";
      if (mkdtemp(folder.data()) == nullptr) continue;
      folder_ = folder;
      return absl::OkStatus();
    }
    return FailedPrecondition(
        "no folder for links: a path of this prediction has a blank, and none of $TMPDIR, /tmp, "
        "/var/tmp and /dev/shm is both writable and without blanks");
  }

  std::string folder_;
  std::map<std::string, std::string> links_;  // By the path that they lead to.
};

class CommandPredictor : public Predictor {
 public:
  explicit CommandPredictor(CommandPredictorOptions options) : options_(std::move(options)) {}
  std::string name() const override {
    return options_.name.empty() ? options_.command : options_.name;
  }

  absl::Status Predict(const std::vector<PredictionTask>& tasks,
                       const PredictionContext& context) override {
    const size_t at = options_.command.find(kPlaceholder);
    if (at == std::string::npos) {
      return InvalidArgument("`{}`: has no {{list}} to put the list of pairs at", options_.command);
    }
    BlanklessPaths paths;
    ASSIGN_OR_RETURN(const std::string list, WriteList(tasks, context.work_dir, paths));
    CommandOptions run;
    run.command = options_.command;
    const std::string quoted = Quoted(list);
    for (size_t place = at; place != std::string::npos;
         place = run.command.find(kPlaceholder, place + quoted.size())) {
      run.command.replace(place, kPlaceholder.size(), quoted);
    }
    run.name = options_.name;
    run.directory = options_.directory;
    run.log = context.work_dir + "/predictor.log";
    run.limit_s = options_.start_s + options_.pair_s * static_cast<double>(tasks.size());
    run.cancel = context.cancel;
    run.clock = context.clock;
    size_t done = 0;
    run.poll = [&] {
      std::error_code error;
      const size_t before = done;
      while (done < tasks.size() && fs::exists(tasks[done].output, error)) ++done;
      if (done != before) context.progress(static_cast<int>(done));
    };
    return RunCommand(run);
  }

 private:
  // Returns the list's path, without blanks as all that it names.
  static absl::StatusOr<std::string> WriteList(const std::vector<PredictionTask>& tasks,
                                               const std::string& work_dir, BlanklessPaths& paths) {
    std::string text;
    for (const PredictionTask& task : tasks) {
      ASSIGN_OR_RETURN(const std::string left, paths.Of(task.left));
      ASSIGN_OR_RETURN(const std::string right, paths.Of(task.right));
      ASSIGN_OR_RETURN(const std::string output, paths.Of(task.output));
      text += left + " " + right + " " + output + "\n";
    }
    const std::string list = work_dir + "/pairs.txt";
    RETURN_IF_ERROR(WriteFile(list, text));
    return paths.Of(list);
  }

  CommandPredictorOptions options_;
};

}  // namespace

std::unique_ptr<Predictor> MakeCommandPredictor(CommandPredictorOptions options) {
  return std::make_unique<CommandPredictor>(std::move(options));
}

std::string CommandOfWords(const std::vector<std::string>& words) {
  std::string command;
  for (const std::string& word : words) {
    command += (command.empty() ? "" : " ") + (word == kPlaceholder ? word : Quoted(word));
  }
  return command;
}

std::string TrainerPredictCommand(const std::string& trainer_program, const std::string& checkpoint,
                                  int threads, int looks) {
  std::vector<std::string> words = {trainer_program, "predict", "--checkpoint",
                                    checkpoint,      "--list",  std::string(kPlaceholder)};
  if (threads > 0) words.insert(words.end(), {"--threads", std::to_string(threads)});
  if (looks > 0) words.insert(words.end(), {"--looks", std::to_string(looks)});
  return CommandOfWords(words);
}

}  // namespace parallax
