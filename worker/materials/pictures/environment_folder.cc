#include "worker/materials/pictures/environment_folder.h"

#include <map>
#include <mutex>
#include <optional>

#include "worker/materials/pictures/picture_folder.h"

namespace parallax {
namespace {

constexpr std::string_view kEnvironments[] = {".hdr", ".exr"};

struct EnvironmentPlace {
  std::string dir;
  FolderFile file;
};

std::mutex& EnvironmentsMutex() {
  static auto* mutex = new std::mutex;
  return *mutex;
}
std::map<uint64_t, EnvironmentPlace>& EnvironmentPlaces() {  // Under EnvironmentsMutex.
  static auto* places = new std::map<uint64_t, EnvironmentPlace>;
  return *places;
}

}  // namespace

absl::StatusOr<EnvironmentFolder> ReadEnvironmentFolder(const std::string& dir) {
  ASSIGN_OR_RETURN(const std::vector<FolderFile> files, ReadContentFolder(dir, kEnvironments));
  EnvironmentFolder folder;
  folder.sha256 = ContentHashOf(files);
  std::lock_guard<std::mutex> lock(EnvironmentsMutex());
  for (const FolderFile& file : files) {
    folder.names.push_back(file.name);
    folder.seeds.push_back(ContentSeed(file.sha256));
    EnvironmentPlaces()[folder.seeds.back()] = {dir, file};
  }
  return folder;
}

absl::StatusOr<std::string> FindEnvironment(uint64_t seed) {
  std::optional<EnvironmentPlace> place;
  {
    std::lock_guard<std::mutex> lock(EnvironmentsMutex());
    if (const auto found = EnvironmentPlaces().find(seed); found != EnvironmentPlaces().end())
      place = found->second;
  }
  if (!place) {
    return NotFound(
        "the scene's surroundings are in no folder that this job names (lighting.hdri_dir)");
  }
  return FindPicture(place->dir, place->file.name, place->file.sha256);
}

}  // namespace parallax
