#include "coordinator/client/content/predictor_choice.h"

#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>

#include "common/base/edit_distance.h"
#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/base/system/installation.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;

absl::StatusOr<std::string> FindTrainerProgram(const std::string& given) {
  if (given.empty()) return FindProgram("trainer");
  if (access(given.c_str(), X_OK) == 0) return fs::absolute(given).string();
  return ErrnoError(errno, "the trainer program " + given);
}

// The built-in trainer's checkpoints are archives of torch, which are ZIP files.
absl::Status CheckIsCheckpoint(const std::string& path) {
  constexpr std::string_view kZip = "PK\x03\x04";
  std::ifstream file(path, std::ios::binary);
  std::string begin(kZip.size(), '\0');
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  if (!file.is_open() || begin == kZip) return absl::OkStatus();
  return InvalidArgument(
      "{}: no checkpoint of the built-in trainer, wanted a .pt file that it wrote, or sgbm; other "
      "networks predict by --command, TorchScript and ONNX by \"trainer predict --format onnx "
      "--checkpoint FILE --list {{list}}\"",
      path);
}

// Returns what a checkpoint was trained on by the place where it lies: the set of
// training/<set>/<trainer>/seed-<n>/final.pt, else the name of the file, or of its folder if the
// file has the name that all trainings give.
std::string VariantOf(const fs::path& checkpoint) {
  const std::string stem = checkpoint.stem();
  if (stem != "final" && stem.rfind("checkpoint-", 0) != 0) return stem;
  const fs::path folder = checkpoint.parent_path(), trainer = folder.parent_path();
  const fs::path set = trainer.parent_path();
  if (set.parent_path().filename() == "training" &&
      folder.filename().string().rfind("seed-", 0) == 0) {
    return set.filename();
  }
  return folder.filename().empty() ? stem : folder.filename().string();
}

// Returns the seed in the card that a study or the trainer left beside a checkpoint; 0 without one.
int64_t SeedOf(const fs::path& checkpoint) {
  using Json = nlohmann::json;
  const struct {
    const char* file;
    Json::json_pointer place;
  } cards[] = {{"training.json", Json::json_pointer("/seed")},
               {"train.json", Json::json_pointer("/settings/seed")}};
  for (const auto& card : cards) {
    const absl::StatusOr<std::string> text = ReadFile(checkpoint.parent_path() / card.file);
    if (!text.ok()) continue;
    const Json json = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
    if (!json.is_object() || !json.contains(card.place)) continue;
    if (json[card.place].is_number_integer()) return json[card.place].get<int64_t>();
  }
  return 0;
}

absl::StatusOr<ChosenPredictor> FromCheckpoint(const PredictorChoice& choice) {
  ChosenPredictor chosen;
  const std::string checkpoint = fs::absolute(choice.what).lexically_normal();
  // A program that is named may have a format of its own.
  if (choice.trainer_program.empty()) RETURN_IF_ERROR(CheckIsCheckpoint(choice.what));
  ASSIGN_OR_RETURN(const std::string program, FindTrainerProgram(choice.trainer_program));
  ASSIGN_OR_RETURN(chosen.run.checkpoint, Sha256HexOfFile(checkpoint));
  chosen.run.variant = VariantOf(checkpoint);
  chosen.run.seed = SeedOf(checkpoint);
  chosen.run.trainer = "builtin";
  chosen.run.looks = choice.looks;
  chosen.predictor = MakeCommandPredictor(
      {.command = TrainerPredictCommand(program, checkpoint, choice.threads, choice.looks),
       .pair_s = choice.pair_s,
       .name = choice.what});
  return chosen;
}

absl::StatusOr<ChosenPredictor> FromShippedNetwork(PredictorChoice choice) {
  ASSIGN_OR_RETURN(choice.what, FindNetwork());
  ASSIGN_OR_RETURN(ChosenPredictor chosen, FromCheckpoint(choice));
  chosen.run.variant = kShippedNetwork;
  chosen.run.seed.reset();  // As it is, one network.
  return chosen;
}

}  // namespace

absl::StatusOr<ChosenPredictor> ChoosePredictor(const PredictorChoice& choice) {
  std::error_code error;
  if (choice.what.empty() == choice.command.empty()) {
    return InvalidArgument(
        "{}", choice.what.empty()
                  ? "what predicts? Give network, sgbm, a checkpoint, a folder, or --command"
                  : "PREDICTOR and --command exclude each other");
  }
  const bool is_network = choice.what == kShippedNetwork;
  if (choice.looks > 0 && !is_network && !fs::is_regular_file(choice.what, error)) {
    return InvalidArgument("--looks has no effect on {}, allowed is a checkpoint, or network",
                           choice.command.empty() ? choice.what : "--command");
  }
  if (!choice.command.empty()) {
    return ChosenPredictor{
        MakeCommandPredictor({.command = choice.command, .pair_s = choice.pair_s}),
        {.variant = "command", .trainer = "command"}};
  }
  if (choice.what == "sgbm") {
    return ChosenPredictor{MakeSgbmPredictor(), {.variant = "sgbm", .trainer = "opencv"}};
  }
  if (is_network) return FromShippedNetwork(choice);
  if (fs::is_directory(choice.what, error)) {
    const fs::path dir = fs::absolute(choice.what / fs::path()).lexically_normal();
    return ChosenPredictor{MakeFolderPredictor(dir.parent_path()),
                           {.variant = dir.parent_path().filename(), .trainer = "files"}};
  }
  if (fs::is_regular_file(choice.what, error)) return FromCheckpoint(choice);
  return NotFound("{}: neither `network`, `sgbm`, nor a checkpoint, nor a folder of predictions{}",
                  choice.what, NearestHint(choice.what, {"sgbm", kShippedNetwork}));
}

}  // namespace parallax::client
