#include "worker/materials/pictures/texture_sets.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <set>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/image/jpeg.h"
#include "worker/materials/pictures/pbr_material.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSetPictures[] = {".png", ".jpg", ".jpeg"};

// kUnused: a map that nothing here reads. Its number comes last, for seeds count the others'.
enum class PictureRole { kAlbedo, kRoughness, kMetallic, kNormal, kNormalDown, kUnused };

std::optional<PictureRole> PictureRoleOf(std::string_view word) {
  static const auto& roles = *new std::map<std::string_view, PictureRole>{
      {"albedo", PictureRole::kAlbedo},      {"basecolor", PictureRole::kAlbedo},
      {"color", PictureRole::kAlbedo},       {"colour", PictureRole::kAlbedo},
      {"col", PictureRole::kAlbedo},         {"diffuse", PictureRole::kAlbedo},
      {"diff", PictureRole::kAlbedo},        {"roughness", PictureRole::kRoughness},
      {"rough", PictureRole::kRoughness},    {"metallic", PictureRole::kMetallic},
      {"metalness", PictureRole::kMetallic}, {"metal", PictureRole::kMetallic},
      {"normal", PictureRole::kNormal},      {"normalgl", PictureRole::kNormal},
      {"nor", PictureRole::kNormal},         {"nrm", PictureRole::kNormal},
      {"norm", PictureRole::kNormal},        {"normaldx", PictureRole::kNormalDown}};
  // Maps of the usual libraries: occlusion, relief, shine, transparency, light, several in one.
  static const auto& unused = *new std::set<std::string_view>{"ao",           "ambientocclusion",
                                                              "occlusion",    "occ",
                                                              "cavity",       "curvature",
                                                              "disp",         "displacement",
                                                              "height",       "bump",
                                                              "spec",         "specular",
                                                              "gloss",        "glossiness",
                                                              "reflection",   "opacity",
                                                              "alpha",        "mask",
                                                              "emissive",     "emission",
                                                              "translucency", "thickness",
                                                              "subsurface",   "sss",
                                                              "arm",          "orm",
                                                              "rma",          "mra",
                                                              "ior",          "sheen"};
  const auto found = roles.find(word);
  if (found != roles.end()) return found->second;
  if (unused.contains(word)) return PictureRole::kUnused;
  return std::nullopt;
}

// Whether the word may follow the one that tells a picture's content: a size or number ("1k",
// "02"), the direction of a normal's y, a format.
bool MayFollowRole(const std::string& word) {
  static const auto& words = *new std::set<std::string_view>{
      "gl", "dx", "opengl", "directx", "png", "jpg", "jpeg", "map", "tex", "texture"};
  return words.contains(word) || std::any_of(word.begin(), word.end(),
                                             [](unsigned char c) { return std::isdigit(c) != 0; });
}

// "Brick_Wall-1k" -> brick, wall, 1k.
std::vector<std::string> WordsOfName(const std::string& stem) {
  std::vector<std::string> words(1);
  for (const char c : stem) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
      words.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  return words;
}

struct NamedPicture {
  std::string set;  // With its folder.
  PictureRole role;
};
// Nothing for a name that says no role, or one that is not used. Only the last words say it: a
// set's own name may have such a word, as "rough_block_wall" has.
std::optional<NamedPicture> ParseSetName(const std::string& name) {
  std::vector<std::string> words = WordsOfName(fs::path(name).stem().string());
  for (size_t i = words.size(); i-- > 0;) {
    std::optional<PictureRole> role = PictureRoleOf(words[i]);
    if (!role && MayFollowRole(words[i])) continue;
    if (!role || role == PictureRole::kUnused) return std::nullopt;
    words.erase(words.begin() + static_cast<std::ptrdiff_t>(i));
    // The direction of a normal's y: "nor_gl", "nor_dx".
    if (*role == PictureRole::kNormal && i < words.size() &&
        (words[i] == "gl" || words[i] == "dx")) {
      if (words[i] == "dx") role = PictureRole::kNormalDown;
      words.erase(words.begin() + static_cast<std::ptrdiff_t>(i));
    }
    std::string set;
    for (const std::string& word : words) set += (set.empty() ? "" : "_") + word;
    const std::string folder = fs::path(name).parent_path().string();
    if (set.empty()) set = fs::path(folder).filename().string();
    return NamedPicture{folder + "/" + set, *role};
  }
  return std::nullopt;
}

struct SetPlace {
  std::string dir;
  std::map<PictureRole, FolderFile> pictures;
};

// The places that this process knows, by name and seed.
class SetPlaces {
 public:
  void Set(const TextureSet& set, const SetPlace& place) {
    std::lock_guard<std::mutex> lock(mutex_);
    places_[{set.name, set.seed}] = place;
  }
  std::optional<SetPlace> Find(std::string_view name, uint64_t seed) {
    std::lock_guard<std::mutex> lock(mutex_);
    const auto found = places_.find({std::string(name), seed});
    if (found == places_.end()) return std::nullopt;
    return found->second;
  }

 private:
  std::mutex mutex_;
  std::map<std::pair<std::string, uint64_t>, SetPlace> places_;
};

SetPlaces& KnownSets() {
  static auto* places = new SetPlaces;
  return *places;
}

TextureSet SetOf(const std::string& path, const std::map<PictureRole, FolderFile>& pictures) {
  Sha256 hash;
  for (const auto& [role, file] : pictures) {
    hash.Update(std::to_string(static_cast<int>(role))).Update(":").Update(file.sha256);
  }
  return {std::string(kOwnPrefix) + fs::path(path).filename().string(),
          ContentSeed(HexOf(hash.Finish()))};
}

absl::StatusOr<PbrPictures> ReadSet(const SetPlace& place) {
  PbrPictures pictures;
  for (const auto& [role, file] : place.pictures) {
    ASSIGN_OR_RETURN(const std::string path, FindPicture(place.dir, file.name, file.sha256));
    ASSIGN_OR_RETURN(ImageRgb8 image, ReadPictureRgb8(path));
    switch (role) {
      case PictureRole::kAlbedo:
        pictures.albedo = std::move(image);
        break;
      case PictureRole::kRoughness:
        pictures.roughness = {1, std::move(image), 0};
        break;
      case PictureRole::kMetallic:
        pictures.metallic = {1, std::move(image), 0};
        break;
      case PictureRole::kNormalDown:
        if (pictures.normal) break;  // The other way round is there too.
        for (size_t i = 1; i < image.values().size(); i += 3) {
          image.values()[i] = static_cast<uint8_t>(255 - image.values()[i]);
        }
        pictures.normal = std::move(image);
        break;
      case PictureRole::kNormal:
        pictures.normal = std::move(image);
        break;
      case PictureRole::kUnused:
        break;
    }
  }
  return pictures;
}

}  // namespace

absl::StatusOr<TextureFolder> ReadTextureFolder(const std::string& dir) {
  ASSIGN_OR_RETURN(const std::vector<FolderFile> files, ReadContentFolder(dir, kSetPictures));
  std::map<std::string, std::map<PictureRole, FolderFile>> sets;
  std::vector<FolderFile> used;
  for (const FolderFile& file : files) {
    const std::optional<NamedPicture> named = ParseSetName(file.name);
    if (!named) continue;
    sets[named->set].emplace(named->role, file);
    used.push_back(file);
  }
  TextureFolder folder;
  folder.sha256 = ContentHashOf(used);
  for (const auto& [path, pictures] : sets) {
    if (!pictures.contains(PictureRole::kAlbedo)) {
      return InvalidArgument(
          "texture_dir: the set of {}/{} has no albedo, wanted a picture named like it with "
          "albedo, basecolor, color or diffuse",
          dir, pictures.begin()->second.name);
    }
    folder.sets.push_back(SetOf(path, pictures));
    KnownSets().Set(folder.sets.back(), {dir, pictures});
  }
  if (folder.sets.empty()) {
    return NotFound(
        "texture_dir: no texture set in {}, wanted pictures named like brick_albedo.png, "
        "brick_roughness.png",
        dir);
  }
  return folder;
}

absl::Status CheckTextureSet(const TextureSet& set) {
  return MakeOwnTexture(set.name, set.seed).status();
}

absl::StatusOr<std::unique_ptr<const Material>> MakeOwnTexture(std::string_view name,
                                                               uint64_t seed) {
  const std::optional<SetPlace> place = KnownSets().Find(name, seed);
  if (!place) {
    return NotFound("texture set {} is in no folder that this job names (materials.texture_dir)",
                    name);
  }
  ASSIGN_OR_RETURN(const PbrPictures pictures, ReadSet(*place));
  return MakePbrMaterial(pictures, PbrMapping::kPlane);
}

}  // namespace parallax
