#include "worker/assets/files/own_meshes.h"

#include <algorithm>
#include <charconv>
#include <deque>
#include <filesystem>
#include <iterator>
#include <map>
#include <mutex>
#include <optional>
#include <set>

#include "common/base/hash.h"
#include "common/base/names.h"
#include "common/base/system/memory_budget.h"
#include "worker/assets/files/gltf_data.h"
#include "worker/materials/pictures/picture_folder.h"
#include "worker/materials/pictures/texture_sets.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMeshEndings[] = {".glb", ".obj", ".ply"};
constexpr std::string_view kContentEndings[] = {".glb", ".obj", ".ply", ".mtl",
                                                ".png", ".jpg", ".jpeg"};
constexpr char kMaterialPrefix[] = "mesh:";
constexpr size_t kMeshesKept = 16;
constexpr int64_t kMemoryShare = 16;  // Meshes take this part of the process's memory at most.

// Counts in all seeds and hashes: raised when the readers give other meshes or looks for the same
// files, so that no result of before is taken for one of now.
constexpr std::string_view kReaders = "mesh readers 2";

std::string EndingOf(const std::string& name) {
  std::string ending = fs::path(name).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

bool IsMeshFile(const std::string& name) {
  const std::string ending = EndingOf(name);
  return std::find(std::begin(kMeshEndings), std::end(kMeshEndings), ending) !=
         std::end(kMeshEndings);
}

// The files that a mesh was made of when its folder was read.
struct MeshPlace {
  std::string dir;
  std::vector<FolderFile> files;  // The mesh first.
};

int64_t BytesOf(const MeshFile& file) {
  const Mesh& mesh = file.mesh;
  size_t bytes = mesh.positions.size() * (3 * sizeof(Vec3f) + sizeof(Vec2f)) +
                 mesh.triangles.size() * sizeof(Triangle);
  for (const FileMaterial& material : file.materials) {
    if (!material.looks) continue;
    const PbrPictures& looks = *material.looks;
    for (const std::optional<PbrPicture>* picture :
         {&looks.albedo, &looks.normal, &looks.roughness.picture, &looks.metallic.picture}) {
      if (*picture) bytes += 3 * (*picture)->image.pixels();
    }
  }
  return static_cast<int64_t>(bytes);
}

class Shelf {
 public:
  void Set(const OwnMesh& mesh, MeshPlace place) {
    std::lock_guard<std::mutex> lock(mutex_);
    places_[mesh.seed] = std::move(place);
  }

  absl::StatusOr<std::shared_ptr<const MeshFile>> Open(uint64_t seed) {
    std::optional<MeshPlace> place;
    {
      std::lock_guard<std::mutex> lock(mutex_);
      for (const auto& [of, file] : open_) {
        if (of == seed) return file;
      }
      if (const auto found = places_.find(seed); found != places_.end()) place = found->second;
    }
    if (!place) {
      return NotFound("it is in no folder that this job names (assets.include)");
    }
    std::string path;
    for (const FolderFile& file : place->files) {
      ASSIGN_OR_RETURN(const std::string found, FindPicture(place->dir, file.name, file.sha256));
      if (path.empty()) path = found;
    }
    ASSIGN_OR_RETURN(MeshFile read, ReadMeshFile(path));
    auto file = std::make_shared<const MeshFile>(std::move(read));
    std::lock_guard<std::mutex> lock(mutex_);
    open_.emplace_front(seed, file);
    CloseOldest();
    return file;
  }

 private:
  // The newest stays, however large it is.
  void CloseOldest() {
    const int64_t most_bytes = MemoryLimit() / kMemoryShare;
    int64_t bytes = BytesOf(*open_.front().second);
    size_t kept = 1;
    for (; kept < std::min(open_.size(), kMeshesKept); ++kept) {
      bytes += BytesOf(*open_[kept].second);
      if (bytes > most_bytes) break;
    }
    open_.erase(open_.begin() + static_cast<std::ptrdiff_t>(kept), open_.end());
  }

  std::mutex mutex_;
  std::map<uint64_t, MeshPlace> places_;
  std::deque<std::pair<uint64_t, std::shared_ptr<const MeshFile>>> open_;  // The newest first.
};

Shelf& TheShelf() {
  static auto* shelf = new Shelf;
  return *shelf;
}

// PicturesBesideGlb of a file with this hash, remembered.
std::vector<std::string> PicturesOfGlb(const std::string& path, const std::string& sha256) {
  static std::mutex mutex;
  static auto& known = *new std::map<std::string, std::vector<std::string>>;
  std::lock_guard<std::mutex> lock(mutex);
  const auto [entry, is_new] = known.try_emplace(sha256);
  if (is_new) entry->second = PicturesBesideGlb(path);
  return entry->second;
}

// The mesh's files: itself and the pictures that a .glb names; for others all files in its folder
// or below.
std::vector<FolderFile> FilesOfMesh(const std::string& dir, const FolderFile& mesh,
                                    const std::vector<FolderFile>& all) {
  std::vector<FolderFile> parts = {mesh};
  const fs::path folder = fs::path(mesh.name).parent_path();
  if (EndingOf(mesh.name) == ".glb") {
    std::set<std::string> named;
    for (const std::string& name : PicturesOfGlb(dir + "/" + mesh.name, mesh.sha256)) {
      const auto found = FindBeside((fs::path(dir) / folder).string(), name);
      if (found.ok()) named.insert((folder / *found).string());
    }
    std::copy_if(all.begin(), all.end(), std::back_inserter(parts), [&](const FolderFile& file) {
      return !IsMeshFile(file.name) && named.contains(file.name);
    });
    return parts;
  }
  const std::string below = folder.empty() ? "" : folder.string() + "/";
  for (const FolderFile& file : all) {
    if (!IsMeshFile(file.name) && file.name.rfind(below, 0) == 0) parts.push_back(file);
  }
  return parts;
}

// A mesh's name with its class, for the hash of the folder's content: the last folder, which may
// be the one that was named.
std::string NameWithClass(const OwnMesh& mesh, const std::string& name) {
  if (name.find('/') != std::string::npos) return name;
  return mesh.asset_class.substr(kOwnPrefix.size()) + "/" + name;
}

absl::StatusOr<std::string> OwnClassOf(const std::string& dir, const std::string& name) {
  const std::string folder = fs::path(dir + "/" + name).parent_path().filename().string();
  if (IsName(folder)) return std::string(kOwnPrefix) + folder;
  return InvalidArgument(
      "include: {}/{} lies in the folder {}, which would be the name of its class: {}", dir, name,
      Quoted(folder), WhyNotName(folder));
}

absl::Status AddMeshFolder(const std::string& dir, OwnMeshes& out,
                           std::vector<FolderFile>& content) {
  ASSIGN_OR_RETURN(const std::vector<FolderFile> files, ReadContentFolder(dir, kContentEndings));
  bool any = false;
  for (const FolderFile& file : files) {
    content.push_back(file);
    if (!IsMeshFile(file.name)) continue;
    any = true;
    OwnMesh mesh;
    ASSIGN_OR_RETURN(mesh.asset_class, OwnClassOf(dir, file.name));
    content.back().name = NameWithClass(mesh, file.name);
    const std::vector<FolderFile> parts = FilesOfMesh(dir, file, files);
    std::vector<FolderFile> nameless = parts;
    nameless[0].name = kReaders;
    mesh.seed = ContentSeed(ContentHashOf(nameless));
    mesh.path = dir + "/" + file.name;
    TheShelf().Set(mesh, {dir, parts});
    out.meshes.push_back(std::move(mesh));
  }
  if (any) return absl::OkStatus();
  return NotFound("include: no .glb, .obj or .ply in {}", dir);
}

}  // namespace

absl::StatusOr<OwnMeshes> ReadMeshFolders(const std::vector<std::string>& dirs) {
  OwnMeshes out;
  std::vector<FolderFile> content;
  for (const std::string& dir : dirs) RETURN_IF_ERROR(AddMeshFolder(dir, out, content));
  content.push_back({std::string(kReaders), ""});
  out.sha256 = ContentHashOf(content);
  return out;
}

bool IsOwnClass(std::string_view asset_class) { return asset_class.starts_with(kOwnPrefix); }

absl::StatusOr<std::shared_ptr<const MeshFile>> OpenOwnMesh(std::string_view asset_class,
                                                            uint64_t seed) {
  auto file = TheShelf().Open(seed);
  if (!file.ok())
    return WithContext(file.status(), "own mesh of class " + std::string(asset_class));
  return file;
}

std::string OwnMeshMaterial(std::string_view slot) { return kMaterialPrefix + std::string(slot); }

bool IsOwnMeshMaterial(std::string_view material_class) {
  return material_class.starts_with(kMaterialPrefix);
}

absl::StatusOr<std::unique_ptr<const Material>> MakeOwnMeshMaterial(std::string_view name,
                                                                    uint64_t seed) {
  ASSIGN_OR_RETURN(const std::shared_ptr<const MeshFile> file, OpenOwnMesh(name, seed));
  size_t slot = 0;
  const std::string_view number = name.substr(std::min(sizeof(kMaterialPrefix) - 1, name.size()));
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), slot);
  if (error != std::errc() || end != number.data() + number.size() ||
      slot >= file->materials.size() || !file->materials[slot].looks) {
    return InvalidArgument("material {}: the mesh has none of this number", name);
  }
  return MakePbrMaterial(*file->materials[slot].looks, PbrMapping::kUv);
}

}  // namespace parallax
