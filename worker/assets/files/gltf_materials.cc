#include "worker/assets/files/gltf_materials.h"

#include <absl/strings/escaping.h>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/base/names.h"

namespace parallax {
namespace {

constexpr char kSpecularGlossiness[] = "KHR_materials_pbrSpecularGlossiness";

std::string NameOf(const GltfEntry& entry) { return entry.TextOr("name", entry.name); }

// A texture's wrapping mode by glTF's number.
absl::StatusOr<MipPicture::Edge> EdgeOf(const GltfEntry& sampler, const char* key) {
  ASSIGN_OR_RETURN(const uint64_t mode, sampler.WholeOr(key, 10497));
  if (mode == 10497) return MipPicture::Edge::kRepeat;
  if (mode == 33648) return MipPicture::Edge::kMirror;
  if (mode == 33071) return MipPicture::Edge::kClamp;
  return InvalidArgument("{}: {} is {}, wanted 10497, 33071 or 33648", sampler.name, key, mode);
}

}  // namespace

// The material, or nothing.
absl::StatusOr<std::vector<GltfEntry>> GltfMaterials::MaterialOf(const GltfEntry& part) const {
  std::vector<GltfEntry> found;
  if (!part.Has("material")) return found;
  ASSIGN_OR_RETURN(const std::vector<GltfEntry> all, data_.root().List("materials", "material"));
  ASSIGN_OR_RETURN(const uint64_t place, part.Whole("material"));
  if (place >= all.size()) {
    return InvalidArgument("{}: material {} of {}", part.name, place, all.size());
  }
  found.push_back({all[place].json, NameOf(all[place])});
  return found;
}

// The maps that are shown.
absl::StatusOr<std::vector<GltfMaterials::Map>> GltfMaterials::MapsOf(
    const GltfEntry& material) const {
  std::vector<Map> maps;
  const auto add = [&maps](const char* name, const GltfEntry& of, const char* key) -> absl::Status {
    if (!of.Has(key)) return absl::OkStatus();
    ASSIGN_OR_RETURN(const GltfEntry info, of.Object(key));
    maps.push_back({name, info});
    return absl::OkStatus();
  };
  ASSIGN_OR_RETURN(const GltfEntry extensions, material.Object("extensions"));
  if (extensions.Has(kSpecularGlossiness)) {
    ASSIGN_OR_RETURN(const GltfEntry old, extensions.Object(kSpecularGlossiness));
    RETURN_IF_ERROR(add("colour", old, "diffuseTexture"));
  } else {
    ASSIGN_OR_RETURN(const GltfEntry pbr, material.Object("pbrMetallicRoughness"));
    RETURN_IF_ERROR(add("colour", pbr, "baseColorTexture"));
    RETURN_IF_ERROR(add("roughness and metal", pbr, "metallicRoughnessTexture"));
  }
  RETURN_IF_ERROR(add("normal", material, "normalTexture"));
  return maps;
}

absl::StatusOr<uint64_t> GltfMaterials::SetOf(const Map& map) const {
  ASSIGN_OR_RETURN(const uint64_t set, map.info.WholeOr("texCoord", 0));
  ASSIGN_OR_RETURN(const GltfEntry extensions, map.info.Object("extensions"));
  ASSIGN_OR_RETURN(const GltfEntry transform, extensions.Object("KHR_texture_transform"));
  return transform.WholeOr("texCoord", set);
}

absl::StatusOr<std::string> GltfMaterials::CoordinatesOf(const GltfEntry& part) {
  ASSIGN_OR_RETURN(const std::vector<GltfEntry> material, MaterialOf(part));
  if (material.empty()) return std::string();
  ASSIGN_OR_RETURN(const std::vector<Map> maps, MapsOf(material[0]));
  if (maps.empty()) return std::string();
  ASSIGN_OR_RETURN(const uint64_t first, SetOf(maps[0]));
  for (const Map& map : maps) {
    ASSIGN_OR_RETURN(const uint64_t set, SetOf(map));
    if (set == first) continue;
    return InvalidArgument(
        "material {}: its {} map lies on texture coordinates {}, its {} map on {}; wanted one set "
        "for all: bake them onto it",
        material[0].name, maps[0].name, first, map.name, set);
  }
  return fmt::format("TEXCOORD_{}", first);
}

absl::StatusOr<size_t> GltfMaterials::PlaceOf(const GltfEntry& part, bool has_uv, MeshParts& out) {
  ASSIGN_OR_RETURN(const std::vector<GltfEntry> material, MaterialOf(part));
  int64_t number = -1;
  if (!material.empty()) number = part.json["material"].get<int64_t>();
  const auto [entry, is_new] = places_.try_emplace({number, has_uv}, out.materials.size());
  if (!is_new) return entry->second;
  FileMaterial read;
  if (!material.empty()) {
    ASSIGN_OR_RETURN(read, Read(material[0], has_uv, out));
  }
  out.materials.push_back(std::move(read));
  return entry->second;
}

absl::StatusOr<FileMaterial> GltfMaterials::Read(const GltfEntry& material, bool has_uv,
                                                 MeshParts& out) {
  FileMaterial read;
  read.name = material.name;
  PbrPictures& looks = read.looks.emplace();
  ASSIGN_OR_RETURN(const GltfEntry extensions, material.Object("extensions"));
  ASSIGN_OR_RETURN(const GltfEntry old, extensions.Object(kSpecularGlossiness));
  ASSIGN_OR_RETURN(const GltfEntry pbr, material.Object("pbrMetallicRoughness"));
  const bool is_old = extensions.Has(kSpecularGlossiness);
  const std::vector<double> white = {1, 1, 1, 1};
  ASSIGN_OR_RETURN(const std::vector<double> color, is_old
                                                        ? old.NumbersOr("diffuseFactor", white)
                                                        : pbr.NumbersOr("baseColorFactor", white));
  for (int c = 0; c < 3; ++c) {
    looks.color[c] = std::clamp(static_cast<float>(color[static_cast<size_t>(c)]), 0.0f, 1.0f);
  }
  ASSIGN_OR_RETURN(const double metallic, pbr.NumberOr("metallicFactor", 1));
  ASSIGN_OR_RETURN(const double roughness, pbr.NumberOr("roughnessFactor", 1));
  ASSIGN_OR_RETURN(const double glossiness, old.NumberOr("glossinessFactor", 1));
  looks.metallic.factor = is_old ? 0 : static_cast<float>(metallic);
  looks.roughness.factor = static_cast<float>(is_old ? 1 - glossiness : roughness);
  const auto leave_out = [&](const std::string& what) {
    out.left_out.push_back(fmt::format("{} of material {}", what, read.name));
  };
  if (material.TextOr("alphaMode", "OPAQUE") != "OPAQUE") leave_out("transparency");
  for (const char* map : {"occlusionTexture", "emissiveTexture"}) {
    if (material.Has(map)) leave_out(map);
  }
  ASSIGN_OR_RETURN(const std::vector<double> glow, material.NumbersOr("emissiveFactor", {0, 0, 0}));
  const bool glows = std::any_of(glow.begin(), glow.end(), [](double g) { return g > 0; });
  if (glows && !material.Has("emissiveTexture")) leave_out("emissiveFactor");
  if (is_old && old.Has("specularGlossinessTexture")) leave_out("specularGlossinessTexture");
  for (const auto& [name, value] : extensions.json.items()) {
    if (name != kSpecularGlossiness && name != "KHR_materials_unlit") leave_out(name);
  }
  if (has_uv) {
    RETURN_IF_ERROR(ReadMaps(material, read, out));
    return read;
  }
  ASSIGN_OR_RETURN(const std::vector<Map> maps, MapsOf(material));
  if (!maps.empty()) leave_out("the maps, on parts without their texture coordinates,");
  return read;
}

absl::Status GltfMaterials::ReadMaps(const GltfEntry& material, FileMaterial& read,
                                     MeshParts& out) {
  ASSIGN_OR_RETURN(const std::vector<Map> maps, MapsOf(material));
  for (const Map& map : maps) {
    std::string source;
    absl::StatusOr<PbrPicture> picture = ReadMap(map, &source);
    if (!picture.ok()) {
      return InvalidArgument("material {}, its {} map: {}", read.name, map.name,
                             ToStd(picture.status().message()));
    }
    read.maps.push_back(std::string(map.name) + " " + source);
    ASSIGN_OR_RETURN(const GltfEntry extensions, map.info.Object("extensions"));
    for (const auto& [name, value] : extensions.json.items()) {
      if (name != "KHR_texture_transform") {
        out.left_out.push_back(fmt::format("{} of material {}", name, read.name));
      }
    }
    const std::string_view kind = map.name;
    if (kind == "colour") {
      read.looks->albedo = *std::move(picture);
    } else if (kind == "normal") {
      ASSIGN_OR_RETURN(const double scale, map.info.NumberOr("scale", 1));
      read.looks->normal_scale = static_cast<float>(scale);
      read.looks->normal = *std::move(picture);
    } else {  // Roughness is its green, metal its blue.
      read.looks->roughness.picture = *picture;
      read.looks->roughness.channel = 1;
      read.looks->metallic.picture = *std::move(picture);
      read.looks->metallic.channel = 2;
    }
  }
  return absl::OkStatus();
}

// Reads a map's picture and where it lies. `source`: the picture's name for people.
absl::StatusOr<PbrPicture> GltfMaterials::ReadMap(const Map& map, std::string* source) const {
  ASSIGN_OR_RETURN(const std::vector<GltfEntry> textures, data_.root().List("textures", "texture"));
  ASSIGN_OR_RETURN(const std::vector<GltfEntry> images, data_.root().List("images", "image"));
  ASSIGN_OR_RETURN(const std::vector<GltfEntry> samplers, data_.root().List("samplers", "sampler"));
  ASSIGN_OR_RETURN(const uint64_t place, map.info.Whole("index"));
  if (place >= textures.size()) {
    return InvalidArgument("texture {} of {}", place, textures.size());
  }
  const GltfEntry& texture = textures[place];
  if (!texture.Has("source")) {
    ASSIGN_OR_RETURN(const GltfEntry extensions, texture.Object("extensions"));
    std::string others;
    for (const auto& [name, value] : extensions.json.items()) others += " " + name;
    return InvalidArgument("{} has no PNG or JPEG{}{}, wanted one", texture.name,
                           others.empty() ? "" : ", only what needs", others);
  }
  ASSIGN_OR_RETURN(const uint64_t image, texture.Whole("source"));
  if (image >= images.size()) return InvalidArgument("image {} of {}", image, images.size());
  PbrPicture picture;
  ASSIGN_OR_RETURN(picture.image, ReadImage(images[image], source));
  if (texture.Has("sampler")) {
    ASSIGN_OR_RETURN(const uint64_t sampler, texture.Whole("sampler"));
    if (sampler >= samplers.size()) {
      return InvalidArgument("sampler {} of {}", sampler, samplers.size());
    }
    ASSIGN_OR_RETURN(picture.edges.u, EdgeOf(samplers[sampler], "wrapS"));
    ASSIGN_OR_RETURN(picture.edges.v, EdgeOf(samplers[sampler], "wrapT"));
  }
  RETURN_IF_ERROR(Lay(map.info, picture));
  return picture;
}

absl::StatusOr<ImageRgb8> GltfMaterials::ReadImage(const GltfEntry& image,
                                                   std::string* source) const {
  if (image.Has("bufferView")) {
    ASSIGN_OR_RETURN(const uint64_t view, image.Whole("bufferView"));
    ASSIGN_OR_RETURN(const std::string_view bytes, data_.BytesOfView(view));
    *source = image.TextOr("name", "inside");
    return DecodeShrunk(bytes, *source);
  }
  const std::string uri = image.TextOr("uri", "");
  if (!uri.starts_with("data:")) {
    *source = uri;
    return ReadBeside(folder_, uri);
  }
  *source = image.TextOr("name", "inside");
  const size_t comma = uri.find(";base64,");
  std::string bytes;
  if (comma == uri.npos || !absl::Base64Unescape(uri.substr(comma + 8), &bytes)) {
    return InvalidArgument("{}: its data are no base64", image.name);
  }
  return DecodeShrunk(bytes, *source);
}

// Applies KHR_texture_transform, whose v goes down.
absl::Status GltfMaterials::Lay(const GltfEntry& info, PbrPicture& picture) const {
  ASSIGN_OR_RETURN(const GltfEntry extensions, info.Object("extensions"));
  if (!extensions.Has("KHR_texture_transform")) return absl::OkStatus();
  ASSIGN_OR_RETURN(const GltfEntry transform, extensions.Object("KHR_texture_transform"));
  ASSIGN_OR_RETURN(const std::vector<double> offset, transform.NumbersOr("offset", {0, 0}));
  ASSIGN_OR_RETURN(const std::vector<double> scale, transform.NumbersOr("scale", {1, 1}));
  ASSIGN_OR_RETURN(const double rotation, transform.NumberOr("rotation", 0));
  const double c = std::cos(rotation), s = std::sin(rotation);
  picture.turn = (Eigen::Matrix2d() << c * scale[0], -s * scale[1], s * scale[0], c * scale[1])
                     .finished()
                     .cast<float>();
  picture.offset = Vec2d(offset[0] + s * scale[1], 1 - offset[1] - c * scale[1]).cast<float>();
  return absl::OkStatus();
}

}  // namespace parallax
