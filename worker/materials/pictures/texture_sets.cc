#include "worker/materials/pictures/texture_sets.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <utility>

#include "common/base/hash.h"
#include "common/image/io.h"
#include "common/image/jpeg.h"
#include "worker/materials/pictures/pbr_material.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSetPictures[] = {".png", ".jpg", ".jpeg", ".exr"};

// kPacked: occlusion, roughness and metal in red, green and blue. kUnused: a map that nothing here
// reads. Numbers count for seeds: the newest comes last.
enum class PictureRole { kAlbedo, kRoughness, kMetallic, kNormal, kNormalDown, kPacked, kUnused };

struct RoleWords {
  PictureRole role;
  const char* name;   // For people.
  const char* words;  // One or two words of a name, joined; in blanks.
};

// Maps of the usual libraries and programs. Unused ones: occlusion, relief, shine, transparency,
// light, and several in one that others order differently.
constexpr RoleWords kRoles[] = {
    {PictureRole::kAlbedo, "colour",
     " albedo basecolor basecolour color colour col diffuse diff basemap "},
    {PictureRole::kRoughness, "roughness", " roughness rough "},
    {PictureRole::kMetallic, "metal", " metallic metalness metal "},
    {PictureRole::kNormal, "normal",
     " normal nor nrm norm normalmap normalgl norgl nrmgl normgl normalogl normalopengl "},
    {PictureRole::kNormalDown, "normal, y down",
     " normaldx nordx nrmdx normdx normaldirectx normald3d "},
    {PictureRole::kPacked, "occlusion, roughness and metal",
     " arm orm aorm occlusionroughnessmetallic "},
    {PictureRole::kUnused, "",
     " ao ambientocclusion mixedao occlusion occ cavity curvature disp displacement height bump "
     "spec specular gloss glossiness reflection opacity alpha mask emissive emission translucency "
     "thickness subsurface sss rma mra ior sheen "}};

// One letter or two behind the last "_" of names that begin with "T_", as Unreal's do, whose
// normals have y down.
constexpr RoleWords kUnrealRoles[] = {{PictureRole::kAlbedo, "colour", " d c bc a "},
                                      {PictureRole::kRoughness, "roughness", " r "},
                                      {PictureRole::kMetallic, "metal", " m "},
                                      {PictureRole::kNormalDown, "normal, y down", " n "},
                                      {PictureRole::kUnused, "", " e h s o "}};

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

const RoleWords* RoleOf(std::span<const RoleWords> roles, const std::string& word) {
  for (const RoleWords& role : roles) {
    if (std::string_view(role.words).find(" " + word + " ") != std::string_view::npos) return &role;
  }
  return nullptr;
}

// Whether the word may follow the one that tells a picture's content: a size or number ("1k",
// "02"), a format.
bool MayFollowRole(const std::string& word) {
  constexpr std::string_view kWords = " gl dx opengl directx png jpg jpeg exr map tex texture ";
  return kWords.find(" " + word + " ") != kWords.npos ||
         std::any_of(word.begin(), word.end(),
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
  const RoleWords* role;
};
// Nothing for a name that says no role. Only the last words say it: a set's own name may have such
// a word, as "rough_block_wall" has.
std::optional<NamedPicture> ParseSetName(const std::string& name) {
  std::vector<std::string> words = WordsOfName(fs::path(name).stem().string());
  const bool is_unreal = words.size() > 2 && words[0] == "t";
  for (size_t i = words.size(); i-- > 0;) {
    size_t first = i;
    const RoleWords* role = i > 0 ? RoleOf(kRoles, words[i - 1] + words[i]) : nullptr;
    if (role != nullptr) {
      --first;
    } else {
      role = RoleOf(kRoles, words[i]);
    }
    if (role == nullptr && is_unreal && i > 1) role = RoleOf(kUnrealRoles, words[i]);
    if (role == nullptr && MayFollowRole(words[i])) continue;
    if (role == nullptr) return std::nullopt;
    words.erase(words.begin() + static_cast<std::ptrdiff_t>(first),
                words.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    std::string set;
    for (const std::string& word : words) set += (set.empty() ? "" : "_") + word;
    const std::string folder = fs::path(name).parent_path().string();
    if (set.empty()) set = fs::path(folder).filename().string();
    return NamedPicture{folder + "/" + set, role};
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

bool IsExr(const std::string& name) { return Lower(fs::path(name).extension().string()) == ".exr"; }

// The pictures of one name.
struct FoundSet {
  std::map<PictureRole, FolderFile> pictures;
  std::map<PictureRole, std::string> names;  // The roles' names.
  std::vector<std::string> left_out;

  // Takes a picture. The first of a role stays, but for an EXR where there is another picture.
  void Add(const RoleWords& role, const FolderFile& file) {
    if (role.role == PictureRole::kUnused) {
      left_out.push_back(file.name + " (a map that is not read)");
      return;
    }
    names[role.role] = role.name;
    const auto [entry, is_new] = pictures.try_emplace(role.role, file);
    if (is_new) return;
    const bool replaces = IsExr(entry->second.name) && !IsExr(file.name);
    LeaveOut(replaces ? entry->second : file);
    if (replaces) entry->second = file;
  }

  // Leaves out what another picture of the set has.
  void Choose() {
    for (const auto& [first, second] : {std::pair(PictureRole::kNormal, PictureRole::kNormalDown),
                                        {PictureRole::kRoughness, PictureRole::kPacked}}) {
      const auto twin = pictures.find(second);
      if (!pictures.contains(first) || twin == pictures.end()) continue;
      LeaveOut(twin->second);
      pictures.erase(twin);
    }
  }

  void LeaveOut(const FolderFile& file) {
    left_out.push_back(file.name + " (another picture shows the same)");
  }
};

TextureSet SetOf(const std::string& path, const std::map<PictureRole, FolderFile>& pictures) {
  Sha256 hash;
  for (const auto& [role, file] : pictures) {
    hash.Update(std::to_string(static_cast<int>(role))).Update(":").Update(file.sha256);
  }
  return {std::string(kOwnPrefix) + fs::path(path).filename().string(),
          ContentSeed(HexOf(hash.Finish())),
          {},
          {}};
}

uint8_t ByteOf(float number) {
  return static_cast<uint8_t>(std::lround(255 * std::clamp(number, 0.0f, 1.0f)));
}

// Reads a picture as 8-bit numbers. An EXR, which holds linear ones, may be grey where a map is one
// number or a colour.
absl::StatusOr<ImageRgb8> ReadMap(const std::string& path, PictureRole role) {
  if (!IsExr(path)) return ReadPictureRgb8(path);
  absl::StatusOr<ImageF3> color = ReadExrRgb(path);
  if (!color.ok()) {
    if (role >= PictureRole::kNormal) return color.status();
    const absl::StatusOr<ImageF> grey = ReadExrY(path);
    if (!grey.ok()) return color.status();
    color = ImageF3(grey->width(), grey->height());
    for (size_t i = 0; i < color->values().size(); ++i) color->values()[i] = grey->values()[i / 3];
  }
  ImageRgb8 image(color->width(), color->height());
  for (size_t i = 0; i < image.values().size(); ++i) {
    float number = color->values()[i];
    if (std::isnan(number)) {
      const size_t pixel = i / 3, width = static_cast<size_t>(image.width());
      return InvalidArgument("{}: a value that is no number (NaN) at column {}, row {}", path,
                             pixel % width, pixel / width);
    }
    if (role == PictureRole::kAlbedo) {  // sRGB's curve.
      number =
          number <= 0.0031308f ? 12.92f * number : 1.055f * std::pow(number, 1 / 2.4f) - 0.055f;
    }
    image.values()[i] = ByteOf(number);
  }
  return image;
}

absl::StatusOr<PbrPictures> ReadSet(const SetPlace& place) {
  PbrPictures pictures;
  for (const auto& [role, file] : place.pictures) {
    ASSIGN_OR_RETURN(const std::string path, FindPicture(place.dir, file.name, file.sha256));
    ASSIGN_OR_RETURN(ImageRgb8 image, ReadMap(path, role));
    if (role == PictureRole::kNormalDown) {
      for (size_t i = 1; i < image.values().size(); i += 3) {
        image.values()[i] = static_cast<uint8_t>(255 - image.values()[i]);
      }
    }
    PbrPicture picture;
    picture.image = std::move(image);
    switch (role) {
      case PictureRole::kAlbedo:
        pictures.albedo = std::move(picture);
        break;
      case PictureRole::kRoughness:
        pictures.roughness = {1, std::move(picture), 0};
        break;
      case PictureRole::kMetallic:
        pictures.metallic = {1, std::move(picture), 0};
        break;
      case PictureRole::kNormal:
      case PictureRole::kNormalDown:
        pictures.normal = std::move(picture);
        break;
      case PictureRole::kPacked:
        pictures.roughness = {1, picture, 1};
        if (!pictures.metallic.picture) pictures.metallic = {1, std::move(picture), 2};
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
  std::map<std::string, FoundSet> sets;
  TextureFolder folder;
  for (const FolderFile& file : files) {
    const std::optional<NamedPicture> named = ParseSetName(file.name);
    if (named) {
      sets[named->set].Add(*named->role, file);
    } else {
      folder.left_out.push_back(file.name + " (its name tells no map)");
    }
  }
  std::vector<FolderFile> used;
  for (auto& [path, found] : sets) {
    found.Choose();
    if (found.pictures.empty()) {  // Nothing but maps that are not read.
      folder.left_out.insert(folder.left_out.end(), found.left_out.begin(), found.left_out.end());
      continue;
    }
    if (!found.pictures.contains(PictureRole::kAlbedo)) {
      return InvalidArgument(
          "texture_dir: the set of {}/{} has no albedo, wanted a picture named like it with "
          "albedo, basecolor, color or diffuse",
          dir, found.pictures.begin()->second.name);
    }
    TextureSet set = SetOf(path, found.pictures);
    for (const auto& [role, file] : found.pictures) {
      used.push_back(file);
      set.maps.push_back(found.names[role] + " " + fs::path(file.name).filename().string());
    }
    set.left_out = std::move(found.left_out);
    KnownSets().Set(set, {dir, found.pictures});
    folder.sets.push_back(std::move(set));
  }
  if (folder.sets.empty()) {
    return NotFound(
        "texture_dir: no texture set in {}, wanted pictures named like brick_albedo.png, "
        "brick_roughness.png",
        dir);
  }
  std::sort(used.begin(), used.end(),
            [](const FolderFile& a, const FolderFile& b) { return a.name < b.name; });
  folder.sha256 = ContentHashOf(used);
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
