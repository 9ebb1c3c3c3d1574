#include <algorithm>
#include <filesystem>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "worker/evaluate/predictors/predictor.h"
#include "worker/evaluate/predictors/predictor_command.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPlaceholder = "{list}";

bool HasSpace(const std::string& path) {
  return path.find_first_of(" \t\r\n") != std::string::npos;
}

// In single quotes for the shell.
std::string Quoted(const std::string& word) {
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

// The list separates its fields by spaces: a picture whose path has one is reached by a link.
absl::StatusOr<std::string> SpacelessPath(const std::string& path, const std::string& link) {
  if (!HasSpace(path)) return path;
  std::error_code error;
  fs::remove(link, error);
  fs::create_symlink(path, link, error);
  if (error) return ErrnoError(error.value(), "link " + link);
  return link;
}

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
    ASSIGN_OR_RETURN(const std::string list, WriteList(tasks, context.work_dir));
    CommandOptions run;
    run.command = options_.command;
    run.command.replace(at, kPlaceholder.size(), Quoted(list));
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
  static absl::StatusOr<std::string> WriteList(const std::vector<PredictionTask>& tasks,
                                               const std::string& work_dir) {
    if (HasSpace(work_dir)) {
      return InvalidArgument("{}: a command's working folder can't have a space in its path",
                             work_dir);
    }
    std::string text;
    for (const PredictionTask& task : tasks) {
      const std::string link = work_dir + "/" + task.name;
      const auto extension = [](const std::string& path) {
        return fs::path(path).extension().string();
      };
      ASSIGN_OR_RETURN(const std::string left,
                       SpacelessPath(task.left, link + "_left" + extension(task.left)));
      ASSIGN_OR_RETURN(const std::string right,
                       SpacelessPath(task.right, link + "_right" + extension(task.right)));
      text += left + " " + right + " " + task.output + "\n";
    }
    const std::string list = work_dir + "/pairs.txt";
    RETURN_IF_ERROR(WriteFile(list, text));
    return list;
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
                                  int threads) {
  std::vector<std::string> words = {trainer_program, "predict", "--checkpoint",
                                    checkpoint,      "--list",  std::string(kPlaceholder)};
  if (threads > 0) words.insert(words.end(), {"--threads", std::to_string(threads)});
  return CommandOfWords(words);
}

}  // namespace parallax
