#include "worker/jobs/training/network_predictor.h"

#include <filesystem>
#include <vector>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "worker/jobs/files/store_files.h"

namespace parallax {
namespace {

absl::StatusOr<std::string> BringNetwork(const StoredNetwork& network, const Store& store,
                                         const std::string& dir) {
  ASSIGN_OR_RETURN(const std::string bytes, GetWhole(store, network.path, network.file.size()));
  if (Sha256Hex(bytes) != network.file.sha256()) {
    return DataLoss("{}: is not the network that was trained", network.path);
  }
  const std::string path = dir + "/" + std::filesystem::path(network.path).filename().string();
  RETURN_IF_ERROR(WriteFile(path, bytes));
  return path;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Predictor>> OpenStoredNetwork(const StoredNetwork& network,
                                                             const InstalledTrainers& trainers,
                                                             const Store& store,
                                                             const std::string& given_dir,
                                                             int threads) {
  const std::string dir = std::filesystem::absolute(given_dir).lexically_normal();
  ASSIGN_OR_RETURN(const InstalledTrainer trainer, trainers.Find(network.trainer));
  const TrainerContract& contract = trainer.contract;
  ASSIGN_OR_RETURN(const std::string checkpoint, BringNetwork(network, store, dir));
  CommandValues values;
  values.values = {{"checkpoint", checkpoint},
                   {"list", "{list}"},
                   {"device", contract.gpus > 0 ? "cuda" : "cpu"},
                   {"threads", std::to_string(threads)},
                   {"out", dir},
                   {"repository", trainer.repository},
                   {"looks", std::to_string(network.looks)}};
  std::vector<std::string> command = contract.predict;
  if (network.looks > 0) {
    if (contract.looks.empty()) {
      return Unimplemented("trainer {} has no option for the number of looks", network.trainer);
    }
    command.insert(command.end(), contract.looks.begin(), contract.looks.end());
  }
  ASSIGN_OR_RETURN(std::vector<std::string> words, CommandToRun(command, values));
  if (!contract.environment.empty()) {
    words.insert(words.begin(), contract.environment.begin(), contract.environment.end());
    words.insert(words.begin(), "env");
  }
  ASSIGN_OR_RETURN(const auto directory, ExpandCommand({contract.directory}, values));
  return MakeCommandPredictor({.command = CommandOfWords(words),
                               .name = network.trainer,
                               .directory = contract.directory.empty() ? dir : directory.at(0)});
}

}  // namespace parallax
