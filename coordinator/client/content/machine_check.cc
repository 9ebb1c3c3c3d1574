#include "coordinator/client/content/machine_check.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "common/base/edit_distance.h"
#include "common/base/names.h"
#include "common/base/system/installation.h"
#include "common/config/check/field_rules.h"
#include "common/config/config.h"
#include "coordinator/client/views/text.h"
#include "worker/evaluate/benchmark.h"
#include "worker/train/contract/installed_trainers.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;

constexpr char kBuiltinTrainer[] = "builtin";
constexpr char kOwnProgram[] = "trainer";

std::vector<std::string> AllowedTrainers(const std::string& names) {
  std::vector<std::string> allowed;
  std::istringstream in(names.empty() ? kBuiltinTrainer : names);
  for (std::string name; std::getline(in, name, ',');) allowed.push_back(name);
  return allowed;
}

// Names that a study may have meant: trainers that are allowed, have a file, or come with Parallax.
std::vector<std::string> KnownTrainers(const MachineOptions& options) {
  std::vector<std::string> names = AllowedTrainers(options.allow_trainers);
  for (const std::string& name : BuiltinTrainers()) names.push_back(name);
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(options.trainers_dir, error)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem());
  }
  return names;
}

// Returns whether a command's first word can be run.
bool IsProgram(const std::string& word) {
  if (word.find('/') != std::string::npos) return access(word.c_str(), X_OK) == 0;
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (access((folder + "/" + word).c_str(), X_OK) == 0) return true;
  }
  return false;
}

// Returns why the trainer can't run here; "" if it can.
std::string WhyNotTrainer(const std::string& trainer, const MachineOptions& options) {
  const std::vector<std::string> allowed = AllowedTrainers(options.allow_trainers);
  if (std::find(allowed.begin(), allowed.end(), trainer) == allowed.end()) {
    const std::vector<std::string> known = KnownTrainers(options);
    const bool is_known = std::find(known.begin(), known.end(), trainer) != known.end();
    const std::string hint = is_known ? "" : NearestHint(trainer, known);
    return fmt::format("{} may not run here{} by --allow-trainers: {}", Quoted(trainer),
                       hint.empty() ? ", allowed" : hint + " Allowed",
                       config_internal::JoinNames(allowed));
  }
  std::error_code error;
  const std::string contract = options.trainers_dir + "/" + trainer + ".yaml";
  if (trainer != kBuiltinTrainer && !fs::is_regular_file(contract, error)) {
    return Quoted(trainer) + ": " +
           (options.trainers_dir.empty() ? "name the folder with " + trainer + ".yaml by --trainers"
                                         : "no such file " + contract);
  }
  const absl::StatusOr<InstalledTrainers> installed =
      InstalledTrainers::Load({trainer}, options.trainers_dir);
  if (!installed.ok()) return std::string(ToStd(installed.status().message()));
  const TrainerContract commands = installed->Find(trainer)->contract;
  for (const auto* command : {&commands.train, &commands.predict}) {
    if (command->empty()) continue;
    const std::string& program = command->front();
    if (program == kOwnProgram) {
      const absl::Status found = FindProgram(kOwnProgram).status();
      if (!found.ok()) return std::string(ToStd(found.message()));
    } else if (program.find('{') == std::string::npos && !IsProgram(program)) {
      return fmt::format("{}: its program {} is not there, or not on $PATH; {} names it",
                         Quoted(trainer), Quoted(program), contract);
    }
  }
  return "";
}

// Returns why trainings of the study can't begin with the trained network here; "" if they can.
std::string WhyNotStart(const v1::TrainSpec& train, const MachineOptions& options) {
  const auto installed = InstalledTrainers::Load({train.trainer()}, options.trainers_dir);
  if (train.start() != "network" || !installed.ok()) return "";
  if (installed->Find(train.trainer())->contract.start.empty()) {
    return fmt::format("network, but trainer {} can't start from one: its file has no list `start`",
                       Quoted(train.trainer()));
  }
  return std::string(ToStd(FindNetwork().status().message()));
}

// Returns why the trainer can't take the study's number of looks; "" if it can.
std::string WhyNotLooks(const v1::StudySpec& study, const MachineOptions& options) {
  const std::string& trainer = study.train().trainer();
  const auto installed = InstalledTrainers::Load({trainer}, options.trainers_dir);
  if (study.evaluate().looks() != 1 || !installed.ok()) return "";
  if (!installed->Find(trainer)->contract.looks.empty()) return "";
  return fmt::format("1, but trainer {} has no option for it: its file has no list `looks`",
                     Quoted(trainer));
}

std::string WhyNotBenchmark(const std::string& name, const std::string& dir) {
  const absl::Status opened = OpenBenchmark(name, dir).status();
  if (opened.ok()) return "";
  const std::string why = Quoted(name) + ": " + FirstLine(ToStd(opened.message()));
  if (name == kShippedBenchmark || dir.empty()) return why;
  return why + "; `parallax evaluate --list` lists the expected files";
}

}  // namespace

void AddMachineOptions(CLI::App& command, MachineOptions& options) {
  command
      .add_option("--benchmarks", options.benchmarks_dir,
                  "Folder of the real sets that evaluations name (default: $PARALLAX_BENCHMARKS)")
      ->envname("PARALLAX_BENCHMARKS")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
  command
      .add_option("--allow-trainers", options.allow_trainers,
                  "Trainers that may run here (default: builtin)")
      ->type_name("NAMES");
  command
      .add_option("--trainers", options.trainers_dir,
                  "Folder with NAME.yaml of each trainer beside the built-in one")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
}

std::vector<std::string> WhatIsMissing(const v1::StudySpec& study, const std::string& file,
                                       const MachineOptions& options, const std::string& gpu) {
  std::vector<std::string> missing;
  const auto tell = [&](const std::string& field, const std::string& why) {
    if (!why.empty()) missing.push_back(PlaceOfField(file, field) + ": " + field + ": " + why);
  };
  if (study.has_train()) {
    tell("train.trainer", WhyNotTrainer(study.train().trainer(), options));
    tell("train.start", WhyNotStart(study.train(), options));
    tell("evaluate.looks", WhyNotLooks(study, options));
  }
  const struct {
    const char* field;
    int gpus;
  } needs[] = {{"train.needs.gpus", study.train().needs().gpus()},
               {"evaluate.needs.gpus", study.evaluate().needs().gpus()}};
  std::error_code error;
  for (const auto& need : needs) {
    if (need.gpus == 0 || fs::exists(gpu, error)) continue;
    tell(need.field,
         fmt::format("{}, but this machine has no GPU ({} is missing)", need.gpus, gpu));
  }
  for (const std::string& name : study.evaluate().benchmarks()) {
    tell("evaluate.benchmarks", WhyNotBenchmark(name, options.benchmarks_dir));
  }
  if (const absl::Status worker = FindProgram("worker").status(); !worker.ok()) {
    missing.emplace_back(ToStd(worker.message()));
  }
  return missing;
}

absl::Status CheckMachine(const v1::StudySpec& study, const std::string& file,
                          const MachineOptions& options) {
  std::string lines;
  for (const std::string& line : WhatIsMissing(study, file, options)) {
    lines += (lines.empty() ? "" : "\n") + line;
  }
  return lines.empty() ? absl::OkStatus() : InvalidArgument("{}", lines);
}

void PrintMissing(const v1::StudySpec& study, const std::vector<std::string>& missing,
                  const Session& session) {
  const bool is_for_run = !study.has_search() && !study.has_stream();
  for (const std::string& text : missing) {
    session.PrintNote((is_for_run ? "`parallax run` would refuse this here: "
                                  : "workers need what this machine lacks: ") +
                      text);
  }
}

}  // namespace parallax::client
