#include "coordinator/client/content/own_folders.h"

#include <cstdint>
#include <string_view>

#include "common/base/system/file.h"
#include "worker/assets/files/own_meshes.h"
#include "worker/materials/pictures/environment_folder.h"
#include "worker/materials/pictures/picture_folder.h"
#include "worker/materials/pictures/texture_sets.h"
#include "worker/render/lights/environment.h"

namespace parallax::client {
namespace {

uint32_t BigEndian(std::string_view bytes) {
  uint32_t number = 0;
  for (const char byte : bytes) number = number << 8 | static_cast<uint8_t>(byte);
  return number;
}

// Says what is wrong with a PNG; "" if its header gives a size and all its chunks are there.
// Source: PNG (third edition), 5.3 and 11.2.1.
std::string WhyNotPng(std::string_view bytes) {
  constexpr size_t kAround = 12;  // Size, type and checksum of a chunk.
  for (size_t at = 8; bytes.size() >= at + kAround;) {
    const size_t size = BigEndian(bytes.substr(at, 4));
    const std::string_view type = bytes.substr(at + 4, 4), data = bytes.substr(at + 8);
    if (size > bytes.size() - at - kAround) break;
    if (at == 8 && (type != "IHDR" || size != 13 || BigEndian(data.substr(0, 4)) == 0 ||
                    BigEndian(data.substr(4, 4)) == 0)) {
      return "broken PNG: its header gives no size";
    }
    if (type == "IEND") return "";
    at += kAround + size;
  }
  return "broken PNG: it ends early";
}

bool IsJpegFrame(uint8_t marker) {
  return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

// Says what is wrong with a JPEG; "" if its header gives a size and its end is there.
// Source: ITU-T T.81, B.1.1 and B.2.2.
std::string WhyNotJpeg(std::string_view bytes) {
  bool has_size = false;
  for (size_t at = 2; at + 4 <= bytes.size();) {
    const auto marker = static_cast<uint8_t>(bytes[at + 1]);
    if (bytes[at] != '\xff') return "broken JPEG: no marker after the one before";
    if (marker == 0xff) {  // Fills.
      ++at;
      continue;
    }
    const std::string_view data = bytes.substr(at + 4);
    if (IsJpegFrame(marker) && data.size() >= 5) {
      has_size = BigEndian(data.substr(1, 2)) > 0 && BigEndian(data.substr(3, 2)) > 0;
    }
    if (marker == 0xda) {  // The picture itself begins.
      if (!has_size) return "broken JPEG: its header gives no size";
      if (bytes.find("\xff\xd9", at) != bytes.npos) return "";
      break;
    }
    at += 2 + BigEndian(bytes.substr(at + 2, 2));
  }
  return "broken JPEG: it ends early";
}

// Looks at the header and for the end, without decoding: folders have thousands of pictures.
absl::Status CheckPicture(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  const std::string why = bytes.starts_with("\x89PNG\r\n\x1a\n") ? WhyNotPng(bytes)
                          : bytes.starts_with("\xff\xd8")
                              ? WhyNotJpeg(bytes)
                              : "neither a PNG nor a JPEG: convert it to one of them";
  return why.empty() ? absl::OkStatus() : InvalidArgument("{}: {}", path, why);
}

absl::StatusOr<std::string> CheckPictures(const std::string& dir) {
  ASSIGN_OR_RETURN(const std::vector<FolderFile> pictures, ReadPictureFolder(dir));
  for (const FolderFile& picture : pictures) {
    RETURN_IF_ERROR(CheckPicture(dir + "/" + picture.name));
  }
  return ContentHashOf(pictures);
}

absl::StatusOr<std::string> CheckMeshes(const std::vector<std::string>& dirs) {
  ASSIGN_OR_RETURN(const OwnMeshes meshes, ReadMeshFolders(dirs));
  for (const OwnMesh& mesh : meshes.meshes) {
    const auto file = OpenOwnMesh(mesh.asset_class, mesh.seed);
    if (!file.ok()) return WithContext(file.status(), mesh.path);
  }
  return meshes.sha256;
}

absl::StatusOr<std::string> CheckTextures(const std::string& dir) {
  ASSIGN_OR_RETURN(const TextureFolder folder, ReadTextureFolder(dir));
  for (const TextureSet& set : folder.sets) RETURN_IF_ERROR(CheckTextureSet(set));
  return folder.sha256;
}

absl::StatusOr<std::string> CheckHdris(const std::string& dir) {
  ASSIGN_OR_RETURN(const EnvironmentFolder folder, ReadEnvironmentFolder(dir));
  for (const uint64_t seed : folder.seeds) RETURN_IF_ERROR(OpenEnvironment(seed).status());
  return folder.sha256;
}

absl::StatusOr<std::string> CheckFolders(ContentKind kind, const std::vector<std::string>& dirs) {
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

}  // namespace

absl::StatusOr<std::string> ContentHashes::Of(ContentKind kind,
                                              const std::vector<std::string>& dirs) {
  auto [entry, is_new] = known_.try_emplace({kind, dirs});
  if (!is_new) return entry->second;
  absl::StatusOr<std::string> sha256 = CheckFolders(kind, dirs);
  if (sha256.ok()) {
    entry->second = *sha256;
  } else {
    known_.erase(entry);
  }
  return sha256;
}

}  // namespace parallax::client
