#include "worker/train/contract/installed_trainers.h"

#include <filesystem>
#include <string_view>

#include "common/base/system/installation.h"
#include "common/config/config.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr char kOwnProgram[] = "trainer";
constexpr char kBuiltin[] = "builtin";

absl::StatusOr<TrainerContract> ContractOf(const std::string& name, const std::string& dir) {
  std::error_code error;
  const std::string path = dir + "/" + name + ".yaml";
  if (!dir.empty() && fs::exists(path, error)) return ReadTrainerContract(path);
  if (name == kBuiltin) {
    ASSIGN_OR_RETURN(const std::string text, BuiltinConfigText("trainers/builtin.yaml"));
    return ParseTrainerContract(text, "builtin.yaml");
  }
  return NotFound("trainer {} is allowed, but there is no {}", name,
                  dir.empty() ? name + ".yaml: name its folder by --trainers" : path);
}

// Checks that files of the repository that the commands name are there.
absl::Status CheckFilesOfRepository(const InstalledTrainer& trainer, const std::string& dir) {
  constexpr std::string_view kRepository = "{repository}/";
  const TrainerContract& contract = trainer.contract;
  const std::string repository = fs::absolute(dir + "/" + contract.name);
  for (const auto* command : {&contract.train, &contract.resume, &contract.predict}) {
    for (const std::string& argument : *command) {
      if (argument.rfind(kRepository, 0) != 0) continue;
      const std::string file = argument.substr(kRepository.size());
      std::error_code error;
      if (file.find('{') != std::string::npos || fs::exists(repository + "/" + file, error)) {
        continue;
      }
      return NotFound(
          "trainer {}: {} is missing, which {}/{}.yaml names; link the trainer's own "
          "code to {}",
          contract.name, repository + "/" + file, dir, contract.name, repository);
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<InstalledTrainers> InstalledTrainers::Load(const std::vector<std::string>& allowed,
                                                          const std::string& dir) {
  InstalledTrainers installed;
  std::error_code error;
  for (const std::string& name : allowed) {
    InstalledTrainer& trainer = installed.trainers_[name];
    ASSIGN_OR_RETURN(trainer.contract, ContractOf(name, dir));
    if (trainer.contract.name != name) {
      return InvalidArgument("{}/{}.yaml: its trainer is \"{}\", not \"{}\"", dir, name,
                             trainer.contract.name, name);
    }
    const fs::path repository = fs::absolute(dir + "/" + name);
    if (!dir.empty() && fs::is_directory(repository, error)) trainer.repository = repository;
    RETURN_IF_ERROR(CheckFilesOfRepository(trainer, dir));
  }
  return installed;
}

absl::StatusOr<InstalledTrainer> InstalledTrainers::Find(const std::string& name) const {
  const auto found = trainers_.find(name);
  if (found != trainers_.end()) return found->second;
  std::string known;
  for (const std::string& one : Names()) known += (known.empty() ? "" : ", ") + one;
  return Unimplemented("trainer '{}' is not allowed on this worker (--allow-trainers: {})", name,
                       known.empty() ? "none" : known);
}

std::vector<std::string> InstalledTrainers::Names() const {
  std::vector<std::string> names;
  for (const auto& [name, trainer] : trainers_) names.push_back(name);
  return names;
}

absl::Status CheckOwnProgram(const TrainerContract& contract) {
  for (const auto* command : {&contract.train, &contract.predict}) {
    if (command->empty() || command->front() != kOwnProgram) continue;
    RETURN_IF_ERROR(FindProgram(kOwnProgram).status());
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::string>> CommandToRun(const std::vector<std::string>& command,
                                                      const CommandValues& values) {
  ASSIGN_OR_RETURN(std::vector<std::string> words, ExpandCommand(command, values));
  if (!words.empty() && words[0] == kOwnProgram) {
    ASSIGN_OR_RETURN(words[0], FindProgram(kOwnProgram));
  }
  return words;
}

}  // namespace parallax
