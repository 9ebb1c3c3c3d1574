#include "worker/assets/files/mesh_file.h"

#include <assimp/DefaultIOSystem.h>
#include <assimp/GltfMaterial.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "common/base/system/file.h"
#include "common/image/jpeg.h"
#include "worker/assets/files/glb_check.h"
#include "worker/assets/files/ply_check.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr unsigned kSteps = aiProcess_Triangulate | aiProcess_PreTransformVertices |
                            aiProcess_JoinIdenticalVertices | aiProcess_GenSmoothNormals |
                            aiProcess_FindDegenerates | aiProcess_SortByPType |
                            aiProcess_ValidateDataStructure;

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

absl::Status Bad(const std::string& path, const std::string& what) {
  return InvalidArgument("mesh {}: {}", path, what);
}

// Converts from a file's axes to the asset frame's.
Vec3f Turned(const aiVector3D& v, bool z_up) {
  return z_up ? Vec3f(-v.x, -v.y, v.z) : Vec3f(-v.x, v.z, v.y);
}

// Files outside of the mesh's folder are not there.
class FolderIo final : public Assimp::DefaultIOSystem {
 public:
  explicit FolderIo(const std::string& path) : folder_(Canonical(fs::path(path).parent_path())) {}
  bool Exists(const char* file) const override {
    return IsInside(file) && Assimp::DefaultIOSystem::Exists(file);
  }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    return IsInside(file) ? Assimp::DefaultIOSystem::Open(file, mode) : nullptr;
  }

 private:
  static fs::path Canonical(const fs::path& path) {
    std::error_code error;
    return fs::weakly_canonical(path.empty() ? fs::path(".") : path, error);
  }
  bool IsInside(const char* file) const {
    const fs::path full = Canonical(file);
    return std::mismatch(folder_.begin(), folder_.end(), full.begin(), full.end()).first ==
           folder_.end();
  }
  const fs::path folder_;
};

// Halved until no side is longer than materials show.
ImageRgb8 Shrunk(ImageRgb8 image) {
  constexpr int kMost = 1024;
  while (std::max(image.width(), image.height()) > kMost) {
    ImageRgb8 half(std::max(1, image.width() / 2), std::max(1, image.height() / 2));
    for (int y = 0; y < half.height(); ++y) {
      for (int x = 0; x < half.width(); ++x) {
        const int x1 = std::min(2 * x + 1, image.width() - 1);
        const int y1 = std::min(2 * y + 1, image.height() - 1);
        for (int c = 0; c < 3; ++c) {
          half(x, y, c) = static_cast<uint8_t>((image(2 * x, 2 * y, c) + image(x1, 2 * y, c) +
                                                image(2 * x, y1, c) + image(x1, y1, c) + 2) /
                                               4);
        }
      }
    }
    image = std::move(half);
  }
  return image;
}

class FileReader {
 public:
  explicit FileReader(const std::string& path)
      : path_(path), z_up_(Lower(fs::path(path).extension().string()) == ".ply") {}

  absl::StatusOr<MeshFile> Read() {
    RETURN_IF_ERROR(CheckFormat());
    Assimp::Importer importer;
    importer.SetIOHandler(new FolderIo(path_));  // The importer deletes it.
    importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                                aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    importer.SetPropertyBool(AI_CONFIG_PP_FD_REMOVE, true);
    scene_ = importer.ReadFile(path_, kSteps);
    if (scene_ == nullptr) {
      return Bad(path_, std::string("not a .glb, .obj or .ply that can be read (") +
                            importer.GetErrorString() + ")");
    }
    RETURN_IF_ERROR(Count());
    for (unsigned i = 0; i < scene_->mNumMeshes; ++i) RETURN_IF_ERROR(Add(*scene_->mMeshes[i]));
    RETURN_IF_ERROR(Place());
    if (!IsClosed()) MakeSheets();
    const absl::Status valid = ValidateMesh(file_.mesh);
    if (!valid.ok()) return Bad(path_, std::string(ToStd(valid.message())));
    return std::move(file_);
  }

 private:
  // Checks what the importer trusts. Errors: also what the disk says.
  absl::Status CheckFormat() const {
    ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path_));
    const std::string ending = Lower(fs::path(path_).extension().string());
    const absl::Status status = ending == ".glb"   ? CheckGlb(bytes)
                                : ending == ".ply" ? CheckPly(bytes)
                                                   : absl::OkStatus();
    return status.ok() ? status : Bad(path_, std::string(ToStd(status.message())));
  }

  absl::Status Count() const {
    int64_t triangles = 0;
    for (unsigned i = 0; i < scene_->mNumMeshes; ++i) triangles += scene_->mMeshes[i]->mNumFaces;
    if (triangles >= 1 && triangles <= kMostTrianglesOfAFile) return absl::OkStatus();
    return Bad(path_,
               fmt::format("{} triangles, wanted 1 to {}", triangles, kMostTrianglesOfAFile));
  }

  absl::Status Add(const aiMesh& part) {
    Mesh& mesh = file_.mesh;
    const auto base = static_cast<uint32_t>(mesh.positions.size());
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      const Vec3f at = Turned(part.mVertices[i], z_up_);
      if (!at.allFinite()) {
        return Bad(path_, fmt::format("corner {} of part {} is not finite", i, part.mName.C_Str()));
      }
      Vec3f normal = part.HasNormals() ? Turned(part.mNormals[i], z_up_) : Vec3f::UnitZ();
      const float length = normal.norm();
      normal = length > 1e-6f && std::isfinite(length) ? Vec3f(normal / length) : Vec3f::UnitZ();
      const Vec2f uv = part.HasTextureCoords(0)
                           ? Vec2f(part.mTextureCoords[0][i].x, part.mTextureCoords[0][i].y)
                           : Vec2f::Zero();
      mesh.positions.push_back(at);
      mesh.normals.push_back(normal);
      mesh.uv.push_back(uv.allFinite() ? uv : Vec2f::Zero());
    }
    ASSIGN_OR_RETURN(const uint16_t slot, SlotOf(part.mMaterialIndex, part.HasTextureCoords(0)));
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
      const aiFace& face = part.mFaces[i];
      if (face.mNumIndices != 3) continue;
      mesh.triangles.push_back(
          {base + face.mIndices[0], base + face.mIndices[1], base + face.mIndices[2], slot});
    }
    return absl::OkStatus();
  }

  absl::StatusOr<uint16_t> SlotOf(unsigned material, bool has_uv) {
    const auto [entry, is_new] =
        slots_.try_emplace(material, static_cast<uint16_t>(file_.mesh.slots.size()));
    if (!is_new) return entry->second;
    MaterialSlot slot;
    slot.name = std::to_string(file_.mesh.slots.size());
    slot.families = {"plastic", "ceramic", "wood", "metal"};
    file_.mesh.slots.push_back(slot);
    ASSIGN_OR_RETURN(std::optional<PbrPictures> looks,
                     LooksOf(*scene_->mMaterials[material], has_uv));
    file_.materials.push_back(std::move(looks));
    return entry->second;
  }

  // Nothing for the material that the reader itself makes up.
  absl::StatusOr<std::optional<PbrPictures>> LooksOf(const aiMaterial& material, bool has_uv) {
    if (Lower(material.GetName().C_Str()) == "defaultmaterial") {
      return std::optional<PbrPictures>();
    }
    PbrPictures looks;
    aiColor4D color(1, 1, 1, 1);
    if (material.Get(AI_MATKEY_BASE_COLOR, color) != AI_SUCCESS) {
      material.Get(AI_MATKEY_COLOR_DIFFUSE, color);
    }
    looks.color = Vec3f(color.r, color.g, color.b).cwiseMax(0.0f).cwiseMin(1.0f);
    material.Get(AI_MATKEY_METALLIC_FACTOR, looks.metallic.factor);
    material.Get(AI_MATKEY_ROUGHNESS_FACTOR, looks.roughness.factor);
    if (!has_uv) return std::optional(std::move(looks));
    ASSIGN_OR_RETURN(looks.albedo,
                     Picture(material, {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}));
    ASSIGN_OR_RETURN(looks.normal, Picture(material, {aiTextureType_NORMALS}));
    // glTF packs both into one picture: roughness is its green, metal its blue.
    ASSIGN_OR_RETURN(looks.roughness.picture,
                     Picture(material, {aiTextureType_DIFFUSE_ROUGHNESS, aiTextureType_UNKNOWN}));
    ASSIGN_OR_RETURN(looks.metallic.picture,
                     Picture(material, {aiTextureType_METALNESS, aiTextureType_UNKNOWN}));
    looks.roughness.channel = 1;
    looks.metallic.channel = 2;
    return std::optional(std::move(looks));
  }

  // The first that there is.
  absl::StatusOr<std::optional<ImageRgb8>> Picture(const aiMaterial& material,
                                                   std::initializer_list<aiTextureType> types) {
    for (const aiTextureType type : types) {
      aiString name;
      if (material.GetTexture(type, 0, &name) != AI_SUCCESS) continue;
      ASSIGN_OR_RETURN(const std::string bytes, BytesOf(name.C_Str()));
      absl::StatusOr<ImageRgb8> image = DecodePictureRgb8(bytes);
      if (!image.ok()) {
        return Bad(path_, std::string("its picture ") + name.C_Str() + " is " +
                              std::string(ToStd(image.status().message())));
      }
      return std::optional(Shrunk(*std::move(image)));
    }
    return std::optional<ImageRgb8>();
  }

  absl::StatusOr<std::string> BytesOf(const std::string& name) const {
    if (const aiTexture* inside = scene_->GetEmbeddedTexture(name.c_str())) {
      if (inside->mHeight != 0) return Bad(path_, "a picture inside of it is not packed");
      return std::string(reinterpret_cast<const char*>(inside->pcData), inside->mWidth);
    }
    const fs::path relative(name);
    if (relative.is_absolute() ||
        std::find(relative.begin(), relative.end(), "..") != relative.end()) {
      return Bad(path_, "its picture " + name + " lies elsewhere, wanted one beside it");
    }
    // Only these count for the mesh's hash and are brought along.
    const std::string ending = Lower(relative.extension().string());
    if (ending != ".png" && ending != ".jpg" && ending != ".jpeg") {
      return Bad(path_, "its picture " + name + " is named like none, wanted .png, .jpg or .jpeg");
    }
    absl::StatusOr<std::string> bytes =
        ReadFile((fs::path(path_).parent_path() / relative).string());
    if (!bytes.ok()) {
      return Bad(path_,
                 "its picture " + name + ": " + std::string(ToStd(bytes.status().message())));
    }
    return bytes;
  }

  // Onto the floor, about the origin.
  absl::Status Place() {
    Mesh& mesh = file_.mesh;
    const Box3f box = mesh.Bounds();
    const float side = box.diagonal().maxCoeff();
    if (!(side > 1e-6f) || !std::isfinite(side)) {
      return Bad(path_, fmt::format("its longest side is {:f}, wanted more than 0", side));
    }
    const Vec3f origin(box.center().x(), box.center().y(), box.min().z());
    for (Vec3f& at : mesh.positions) at = (at - origin) + Vec3f::Zero();  // -0 becomes 0.
    mesh.texture = mesh.positions;
    return absl::OkStatus();
  }

  // A number for each vertex, the same for those at the same place.
  std::vector<uint32_t> PlacesOfVertices() const {
    const std::vector<Vec3f>& at = file_.mesh.positions;
    const auto key = [&at](uint32_t v) { return std::tuple(at[v].x(), at[v].y(), at[v].z()); };
    std::vector<uint32_t> order(at.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
    std::vector<uint32_t> places(at.size());
    uint32_t place = 0;
    for (size_t i = 0; i < order.size(); ++i) {
      if (i > 0 && key(order[i]) != key(order[i - 1])) ++place;
      places[order[i]] = place;
    }
    return places;
  }

  // Every edge is passed as often in one direction as in the other: a surface without a rim.
  bool IsClosed() const {
    const std::vector<uint32_t> places = PlacesOfVertices();
    std::vector<std::pair<std::pair<uint32_t, uint32_t>, int>> edges;
    for (const Triangle& t : file_.mesh.triangles) {
      const uint32_t corners[3] = {places[t.a], places[t.b], places[t.c]};
      for (int k = 0; k < 3; ++k) {
        const uint32_t from = corners[k], to = corners[(k + 1) % 3];
        edges.push_back({std::minmax(from, to), from < to ? 1 : from > to ? -1 : 0});
      }
    }
    std::sort(edges.begin(), edges.end());
    int open = 0;
    for (size_t i = 0; i < edges.size(); ++i) {
      open = (i > 0 && edges[i].first == edges[i - 1].first ? open : 0) + edges[i].second;
      const bool last = i + 1 == edges.size() || edges[i + 1].first != edges[i].first;
      if (last && open != 0) return false;
    }
    return true;
  }

  // Drops all but one of the triangles with the same corners: rays must meet one only.
  void MakeSheets() {
    Mesh& mesh = file_.mesh;
    for (MaterialSlot& slot : mesh.slots) slot.sheet = true;
    const std::vector<uint32_t> places = PlacesOfVertices();
    std::set<std::array<uint32_t, 3>> seen;
    std::erase_if(mesh.triangles, [&](const Triangle& t) {
      std::array<uint32_t, 3> corners = {places[t.a], places[t.b], places[t.c]};
      std::sort(corners.begin(), corners.end());
      return !seen.insert(corners).second;
    });
  }

  const std::string& path_;
  const bool z_up_;
  const aiScene* scene_ = nullptr;
  MeshFile file_;
  std::map<unsigned, uint16_t> slots_;  // By the file's materials.
};

}  // namespace

absl::StatusOr<MeshFile> ReadMeshFile(const std::string& path) { return FileReader(path).Read(); }

}  // namespace parallax
