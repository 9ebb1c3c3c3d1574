// YAML of scene configs and studies, as users write and submit them, and of lands, kinds of rooms,
// batch systems, trainers and samplers: any text ends in a message or an error, and a study that
// was accepted survives being written out and read again.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "common/base/system/file.h"
#include "common/config/config.h"
#include "common/config/files/engine_files.h"
#include "common/config/files/land_files.h"
#include "common/config/files/room_files.h"
#include "coordinator/search/samplers.h"
#include "tests/fuzz/fuzz_folder.h"
#include "worker/train/contract/contract.h"

namespace {

void ReadOtherFiles(std::string_view text) {
  (void)parallax::ParseBiome(text, "fuzz.yaml");
  (void)parallax::ParseRoomKind(text, "fuzz.yaml");
  (void)parallax::ParseTrainerContract(text, "fuzz.yaml");
  if (const auto engine = parallax::ParseEngine(text, "fuzz.yaml"); engine.ok()) {
    if (engine->submit().command().empty() || engine->cancel().empty()) std::abort();
  }
  if (text.find("sampler") == text.npos) return;
  const std::string folder = parallax::FuzzFolder() + "/samplers";
  std::filesystem::create_directories(folder);
  if (!parallax::WriteFile(folder + "/optuna.yaml", std::string(text)).ok()) return;
  const auto samplers = parallax::LoadSamplers(folder);
  if (samplers.ok() && samplers->at("optuna").command.empty()) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto config = parallax::ParseSceneConfig(text, "fuzz.yaml");
  const auto study = parallax::ParseStudy(text, "fuzz.yaml");
  (void)config;
  ReadOtherFiles(text);
  if (!study.ok()) return 0;
  if (const absl::Status valid = parallax::ValidateStudy(*study); !valid.ok()) {
    std::fprintf(stderr, "accepted, then not: %s\n", valid.ToString().c_str());
    std::abort();
  }
  const auto again = parallax::ParseStudy(parallax::StudyToYaml(*study), "again.yaml");
  if (!again.ok()) {
    std::fprintf(stderr, "its lock file: %s\n", again.status().ToString().c_str());
    std::abort();
  }
  return 0;
}
