// Materials of a .glb. Not thread-safe.   Source: Khronos, "glTF 2.0 specification", 3.8 and 3.9;
// KHR_texture_transform, KHR_materials_pbrSpecularGlossiness.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "worker/assets/files/gltf_data.h"
#include "worker/assets/files/mesh_parts.h"

namespace parallax {

class GltfMaterials {
 public:
  // `data` must outlive it; pictures lie in `folder`.
  GltfMaterials(const GltfData& data, std::string folder)
      : data_(data), folder_(std::move(folder)) {}

  // The set of texture coordinates on which a part's material lies: "TEXCOORD_0"; "" for one that
  // shows no maps. Errors: kInvalidArgument for a material that is not there, or with maps on
  // different sets.
  absl::StatusOr<std::string> CoordinatesOf(const GltfEntry& part);
  // The place in `out.materials` of a part's material, added if need be. Says in `out.left_out`
  // what of it is not used. Errors: kInvalidArgument naming the material and what is wrong.
  absl::StatusOr<size_t> PlaceOf(const GltfEntry& part, bool has_uv, MeshParts& out);

 private:
  struct Map {
    const char* name;  // "colour"
    GltfEntry info;    // glTF's textureInfo.
  };
  absl::StatusOr<std::vector<GltfEntry>> MaterialOf(const GltfEntry& part) const;
  absl::StatusOr<std::vector<Map>> MapsOf(const GltfEntry& material) const;
  absl::StatusOr<uint64_t> SetOf(const Map& map) const;
  absl::StatusOr<FileMaterial> Read(const GltfEntry& material, bool has_uv, MeshParts& out);
  absl::Status ReadMaps(const GltfEntry& material, FileMaterial& read, MeshParts& out);
  absl::StatusOr<PbrPicture> ReadMap(const Map& map, std::string* source) const;
  absl::StatusOr<ImageRgb8> ReadImage(const GltfEntry& image, std::string* source) const;
  absl::Status Lay(const GltfEntry& info, PbrPicture& picture) const;

  const GltfData& data_;
  const std::string folder_;
  std::map<std::pair<int64_t, bool>, size_t> places_;  // By number (-1: none) and whether with uv.
};

}  // namespace parallax
