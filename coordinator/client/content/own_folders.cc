#include "coordinator/client/content/own_folders.h"

#include <fmt/core.h>

#include <algorithm>
#include <span>
#include <string_view>
#include <utility>

#include "common/base/system/log.h"
#include "common/base/system/memory_budget.h"
#include "common/image/picture_pair.h"
#include "worker/assets/files/own_meshes.h"
#include "worker/materials/pictures/environment_folder.h"
#include "worker/materials/pictures/picture_folder.h"
#include "worker/materials/pictures/texture_sets.h"
#include "worker/render/lights/environment.h"

namespace parallax::client {
namespace {

absl::StatusOr<ContentReport> CheckPictures(const std::string& dir) {
  ASSIGN_OR_RETURN(const std::vector<FolderFile> pictures, ReadPictureFolder(dir));
  ContentReport report{ContentHashOf(pictures), {}, {}, {}};
  for (const FolderFile& picture : pictures) {
    const MemoryRequests memory;
    // A header says neither what inks a picture has nor whether its data is sound.
    ASSIGN_OR_RETURN(std::vector<std::string> notes, CheckPicture(dir + "/" + picture.name));
    for (const std::string& note : notes) LogWarning("picture", {{"note", note}});
    report.items.push_back({picture.name, "a picture", std::move(notes), memory.bytes()});
  }
  return report;
}

std::string Joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

// A mesh in its file's unit: width, depth and height, and its materials with their maps.
std::string TextOf(const MeshFile& file) {
  const Vec3f size = file.mesh.Bounds().sizes();
  std::string text = fmt::format("{} triangles, {:.4g} x {:.4g} x {:.4g}",
                                 file.mesh.triangles.size(), size.x(), size.y(), size.z());
  for (const FileMaterial& material : file.materials) {
    if (!material.looks) {
      text += "; no material";
      continue;
    }
    text += fmt::format("; material {} ({})", material.name,
                        material.maps.empty() ? "no maps" : Joined(material.maps));
  }
  return text;
}

absl::StatusOr<ContentReport> CheckMeshes(const std::vector<std::string>& dirs) {
  ASSIGN_OR_RETURN(const OwnMeshes meshes, ReadMeshFolders(dirs));
  ContentReport report{meshes.sha256, {}, {}, {}};
  for (const OwnMesh& mesh : meshes.meshes) {
    if (std::count(report.classes.begin(), report.classes.end(), mesh.asset_class) == 0) {
      report.classes.push_back(mesh.asset_class);
    }
    const MemoryRequests memory;
    const auto file = OpenOwnMesh(mesh.asset_class, mesh.seed);
    if (!file.ok()) return WithContext(file.status(), mesh.path);
    report.items.push_back({mesh.path, TextOf(**file), (*file)->left_out, memory.bytes()});
  }
  return report;
}

absl::StatusOr<ContentReport> CheckTextures(const std::string& dir) {
  ASSIGN_OR_RETURN(const TextureFolder folder, ReadTextureFolder(dir));
  ContentReport report{folder.sha256, {}, folder.left_out, {}};
  for (const TextureSet& set : folder.sets) {
    const MemoryRequests memory;
    RETURN_IF_ERROR(CheckTextureSet(set));
    report.items.push_back({set.name, Joined(set.maps), set.left_out, memory.bytes()});
  }
  return report;
}

absl::StatusOr<ContentReport> CheckHdris(const std::string& dir) {
  ASSIGN_OR_RETURN(const EnvironmentFolder folder, ReadEnvironmentFolder(dir));
  ContentReport report{folder.sha256, {}, {}, {}};
  for (size_t i = 0; i < folder.seeds.size(); ++i) {
    const MemoryRequests memory;
    ASSIGN_OR_RETURN(const auto environment, OpenEnvironment(folder.seeds[i]));
    const std::string& note = environment->note();
    report.items.push_back(
        {folder.names[i],
         fmt::format("surroundings, mean luminance {:.3g}{}{}", environment->mean_luminance(),
                     note.empty() ? "" : "; ", note),
         {},
         memory.bytes()});
  }
  return report;
}

absl::StatusOr<ContentReport> CheckFolders(ContentKind kind, const std::vector<std::string>& dirs) {
  switch (kind) {
    case ContentKind::kMeshes:
      return CheckMeshes(dirs);
    case ContentKind::kTextures:
      return CheckTextures(dirs.front());
    case ContentKind::kHdris:
      return CheckHdris(dirs.front());
    case ContentKind::kPictures:
      break;
  }
  return CheckPictures(dirs.front());
}

std::span<const std::string_view> EndingsOf(ContentKind kind) {
  static constexpr std::string_view kPictures[] = {".png", ".jpg", ".jpeg"};
  static constexpr std::string_view kTextures[] = {".png", ".jpg", ".jpeg", ".exr"};
  static constexpr std::string_view kHdris[] = {".hdr", ".exr"};
  static constexpr std::string_view kMeshes[] = {".glb", ".obj", ".ply", ".mtl",
                                                 ".png", ".jpg", ".jpeg"};
  switch (kind) {
    case ContentKind::kMeshes:
      return kMeshes;
    case ContentKind::kTextures:
      return kTextures;
    case ContentKind::kHdris:
      return kHdris;
    case ContentKind::kPictures:
      break;
  }
  return kPictures;
}

}  // namespace

void AddFollowLinksOption(CLI::App& command) {
  command.add_flag_callback(
      "--follow-links", [] { SetFollowLinks(true); },
      "Follow links in folders of your own content that lead out of them, too");
}

absl::StatusOr<ContentReport> CheckContent(ContentKind kind, const std::vector<std::string>& dirs) {
  ASSIGN_OR_RETURN(ContentReport report, CheckFolders(kind, dirs));
  for (const std::string& dir : dirs) {
    ASSIGN_OR_RETURN(const ContentNames names, NamesOfContent(dir, EndingsOf(kind)));
    for (const std::string& name : names.left_out) {
      report.left_out.push_back(dirs.size() == 1 ? name : dir + "/" + name);
    }
  }
  return report;
}

absl::StatusOr<const ContentReport*> ContentReports::Of(ContentKind kind,
                                                        const std::vector<std::string>& dirs) {
  if (const auto known = known_.find({kind, dirs}); known != known_.end()) return &known->second;
  ASSIGN_OR_RETURN(ContentReport report, CheckFolders(kind, dirs));
  for (const ContentItem& item : report.items) {
    if (!largest_ || item.memory_bytes > largest_->memory_bytes) largest_ = item;
  }
  return &(known_[{kind, dirs}] = std::move(report));
}

}  // namespace parallax::client
