// Reads .glb: its nodes, and the meshes that they place.
#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "common/base/names.h"
#include "worker/assets/files/draco_mesh.h"
#include "worker/assets/files/gltf_data.h"
#include "worker/assets/files/gltf_materials.h"
#include "worker/assets/files/mesh_parts.h"

namespace parallax {
namespace {

constexpr int kDeepestNode = 256;
constexpr uint64_t kMostTriangles = kMostTrianglesOfAFile, kMostCorners = 3 * kMostTriangles;
constexpr char kDraco[] = "KHR_draco_mesh_compression";

// A file may need these; lights are left out like others' cameras.
constexpr std::string_view kKnownExtensions[] = {kDraco,
                                                 "KHR_lights_punctual",
                                                 "KHR_materials_pbrSpecularGlossiness",
                                                 "KHR_materials_unlit",
                                                 "KHR_mesh_quantization",
                                                 "KHR_texture_transform",
                                                 "KHR_xmp_json_ld"};

bool IsKnown(const std::string& extension) {
  return std::find(std::begin(kKnownExtensions), std::end(kKnownExtensions), extension) !=
         std::end(kKnownExtensions);
}

struct Node {
  Eigen::Affine3d to_world = Eigen::Affine3d::Identity();
  int depth = 0;  // 0: not in the scene.
};

absl::StatusOr<Eigen::Affine3d> PlacementOf(const GltfEntry& node) {
  Eigen::Affine3d placement = Eigen::Affine3d::Identity();
  if (node.Has("matrix")) {
    ASSIGN_OR_RETURN(const std::vector<double> m,
                     node.NumbersOr("matrix", std::vector<double>(16)));
    placement.matrix().topRows<3>() = Eigen::Map<const Eigen::Matrix4d>(m.data()).topRows<3>();
    return placement;
  }
  ASSIGN_OR_RETURN(const std::vector<double> t, node.NumbersOr("translation", {0, 0, 0}));
  ASSIGN_OR_RETURN(const std::vector<double> r, node.NumbersOr("rotation", {0, 0, 0, 1}));
  ASSIGN_OR_RETURN(const std::vector<double> s, node.NumbersOr("scale", {1, 1, 1}));
  Eigen::Quaterniond turn(r[3], r[0], r[1], r[2]);
  if (!(turn.norm() > 0)) return InvalidArgument("{}: its rotation is 0", node.name);
  placement =
      Eigen::Translation3d(t[0], t[1], t[2]) * turn.normalized() * Eigen::Scaling(s[0], s[1], s[2]);
  return placement;
}

class GlbReader {
 public:
  GlbReader(const GltfData& data, const std::string& folder)
      : data_(data), materials_(data, folder) {
    out_.crease_deg = -1;
  }

  absl::StatusOr<MeshParts> Read() {
    RETURN_IF_ERROR(CheckExtensions());
    ASSIGN_OR_RETURN(node_entries_, List("nodes", "node"));
    ASSIGN_OR_RETURN(meshes_, List("meshes", "mesh"));
    ASSIGN_OR_RETURN(skins_, List("skins", "skin"));
    RETURN_IF_ERROR(PlaceNodes());
    for (size_t i = 0; i < nodes_.size(); ++i) {
      if (nodes_[i].depth > 0) RETURN_IF_ERROR(AddNode(i));
    }
    for (const char* what : {"animations", "cameras"}) {
      if (data_.root().Has(what)) out_.left_out.push_back(what);
    }
    // Parts of one kind say the same.
    std::sort(out_.left_out.begin(), out_.left_out.end());
    out_.left_out.erase(std::unique(out_.left_out.begin(), out_.left_out.end()),
                        out_.left_out.end());
    return std::move(out_);
  }

 private:
  // By pointer, for entries can't be assigned.
  using Entries = std::shared_ptr<const std::vector<GltfEntry>>;

  absl::StatusOr<Entries> List(const char* key, const std::string& name) const {
    ASSIGN_OR_RETURN(std::vector<GltfEntry> entries, data_.root().List(key, name));
    return std::make_shared<const std::vector<GltfEntry>>(std::move(entries));
  }

  absl::Status CheckExtensions() {
    const auto names = [&](const char* key) {
      std::vector<std::string> found;
      for (const nlohmann::json& name : data_.root().json.value(key, nlohmann::json::array())) {
        if (name.is_string()) found.push_back(name);
      }
      return found;
    };
    const std::vector<std::string> required = names("extensionsRequired");
    for (const std::string& name : required) {
      if (IsKnown(name)) continue;
      return InvalidArgument(
          "it needs the extension {}, which is not known here; wanted a file without it "
          "(extensionsRequired)",
          Quoted(name));
    }
    for (const std::string& name : names("extensionsUsed")) {
      // Materials and their maps tell of theirs.
      const bool told =
          name.find("_materials_") != name.npos || name.find("_texture_") != name.npos;
      if (name == "KHR_lights_punctual" || (!IsKnown(name) && !told)) out_.left_out.push_back(name);
    }
    return absl::OkStatus();
  }

  // Places the nodes of the scene, which form trees.
  absl::Status PlaceNodes() {
    const std::vector<GltfEntry>& entries = *node_entries_;
    ASSIGN_OR_RETURN(const std::vector<GltfEntry> scenes, data_.root().List("scenes", "scene"));
    ASSIGN_OR_RETURN(const uint64_t shown, data_.root().WholeOr("scene", 0));
    if (shown >= scenes.size()) return InvalidArgument("scene {} of {}", shown, scenes.size());
    if (scenes.size() > 1) {
      out_.left_out.push_back(fmt::format("{} other scenes", scenes.size() - 1));
    }
    nodes_.resize(entries.size());
    std::vector<size_t> reached;
    const auto reach = [&](const std::vector<size_t>& places, const Node& parent) -> absl::Status {
      for (const size_t place : places) {
        if (nodes_[place].depth != 0) {
          return InvalidArgument("node {} stands in two places", place);
        }
        ASSIGN_OR_RETURN(const Eigen::Affine3d placement, PlacementOf(entries[place]));
        nodes_[place] = {parent.to_world * placement, parent.depth + 1};
        if (parent.depth >= kDeepestNode) {
          return InvalidArgument("{} is too deep", entries[place].name);
        }
        reached.push_back(place);
      }
      return absl::OkStatus();
    };
    ASSIGN_OR_RETURN(const std::vector<size_t> roots, scenes[shown].Places("nodes", nodes_.size()));
    RETURN_IF_ERROR(reach(roots, Node()));
    for (size_t i = 0; i < reached.size(); ++i) {
      ASSIGN_OR_RETURN(const std::vector<size_t> children,
                       entries[reached[i]].Places("children", nodes_.size()));
      const Node parent = nodes_[reached[i]];
      RETURN_IF_ERROR(reach(children, parent));
    }
    return absl::OkStatus();
  }

  absl::Status AddNode(size_t place) {
    const GltfEntry& node = (*node_entries_)[place];
    if (!node.Has("mesh")) return absl::OkStatus();
    ASSIGN_OR_RETURN(const uint64_t mesh, node.Whole("mesh"));
    if (mesh >= meshes_->size()) {
      return InvalidArgument("{}: mesh {} of {}", node.name, mesh, meshes_->size());
    }
    const GltfEntry& entry = (*meshes_)[mesh];
    ASSIGN_OR_RETURN(const std::vector<GltfEntry> parts, entry.List("primitives", "part"));
    for (const GltfEntry& part : parts) {
      const GltfEntry& weighted = node.Has("weights") ? node : entry;
      RETURN_IF_ERROR(AddPart(part, weighted, place));
    }
    return absl::OkStatus();
  }

  // Adds a part, with the weights of its morph targets as `weighted` has them.
  absl::Status AddPart(const GltfEntry& part, const GltfEntry& weighted, size_t node) {
    ASSIGN_OR_RETURN(const uint64_t mode, part.WholeOr("mode", 4));
    if (mode > 6) return InvalidArgument("{}: mode {}, wanted 0 to 6", part.name, mode);
    ASSIGN_OR_RETURN(const GltfEntry found, part.Object("attributes"));
    const GltfEntry attributes{found.json, part.name};
    if (!attributes.Has("POSITION")) {
      return InvalidArgument("{} has no attribute POSITION", part.name);
    }
    ASSIGN_OR_RETURN(const uint64_t position, data_.AccessorOf(attributes, "POSITION"));
    RETURN_IF_ERROR(CheckCounts(attributes, part.name, data_.CountOf(position)));
    if (mode < 4) {
      out_.left_out.push_back("points and lines");
      return absl::OkStatus();
    }
    Source source{part, attributes, std::nullopt, part};
    ASSIGN_OR_RETURN(const GltfEntry extensions, part.Object("extensions"));
    ASSIGN_OR_RETURN(const GltfEntry draco, extensions.Object(kDraco));
    ASSIGN_OR_RETURN(const GltfEntry ids, draco.Object("attributes"));
    Source packed{part, attributes, std::nullopt, ids};
    if (extensions.Has(kDraco)) {
      ASSIGN_OR_RETURN(const uint64_t view, draco.Whole("bufferView"));
      ASSIGN_OR_RETURN(const std::string_view bytes, data_.BytesOfView(view));
      ASSIGN_OR_RETURN(packed.draco, DracoMesh::Decode(bytes));
      RETURN_IF_ERROR(Count(packed.draco->Triangles().size(), packed.draco->vertices(), part.name));
    }
    if (!packed.draco) RETURN_IF_ERROR(CountPart(part, mode, data_.CountOf(position)));
    return AddSource(packed.draco ? packed : source, mode, weighted, node);
  }

  // Where a part's numbers are.
  struct Source {
    const GltfEntry& part;
    const GltfEntry& attributes;
    std::optional<DracoMesh> draco;
    const GltfEntry& ids;  // Names Draco's attributes.
  };

  // An attribute's numbers; none where the part has no such attribute.
  absl::StatusOr<std::vector<double>> Numbers(const Source& source, const std::string& name,
                                              uint64_t components) const {
    if (source.draco && source.ids.Has(name.c_str())) {
      ASSIGN_OR_RETURN(const uint64_t id, source.ids.Whole(name.c_str()));
      return source.draco->Numbers(id, components);
    }
    if (!source.attributes.Has(name.c_str())) return std::vector<double>();
    ASSIGN_OR_RETURN(const uint64_t place, data_.AccessorOf(source.attributes, name.c_str()));
    ASSIGN_OR_RETURN(std::vector<double> numbers, data_.Numbers(place, components));
    if (!source.draco || numbers.size() == components * source.draco->vertices()) return numbers;
    return InvalidArgument("{}: {} has {} elements, wanted {}, as its Draco data", source.part.name,
                           name, numbers.size() / components, source.draco->vertices());
  }

  absl::Status AddSource(const Source& source, uint64_t mode, const GltfEntry& weighted,
                         size_t node) {
    MeshPart part;
    ASSIGN_OR_RETURN(std::vector<double> positions, Numbers(source, "POSITION", 3));
    ASSIGN_OR_RETURN(std::vector<double> normals, Numbers(source, "NORMAL", 3));
    RETURN_IF_ERROR(Morph(source, weighted, positions, normals));
    for (size_t i = 0; i + 2 < positions.size(); i += 3) {
      part.positions.emplace_back(positions[i], positions[i + 1], positions[i + 2]);
    }
    for (size_t i = 0; i + 2 < normals.size(); i += 3) {
      part.normals.push_back(Vec3d(normals[i], normals[i + 1], normals[i + 2]).cast<float>());
    }
    ASSIGN_OR_RETURN(const std::string coordinates, materials_.CoordinatesOf(source.part));
    if (!coordinates.empty()) {
      ASSIGN_OR_RETURN(const std::vector<double> uv, Numbers(source, coordinates, 2));
      for (size_t i = 0; i + 1 < uv.size(); i += 2) {
        part.uv.push_back(Vec2d(uv[i], 1 - uv[i + 1]).cast<float>());
      }
    }
    if (source.attributes.Has("COLOR_0")) out_.left_out.push_back("vertex colours");
    if ((*node_entries_)[node].Has("skin") && source.attributes.Has("JOINTS_1")) {
      out_.left_out.push_back("joints beyond four a corner");
    }
    RETURN_IF_ERROR(AddTriangles(source, mode, part));
    ASSIGN_OR_RETURN(part.material, materials_.PlaceOf(source.part, !part.uv.empty(), out_));
    part.step = FloatStep(part.positions) *
                std::cbrt(std::abs(nodes_[node].to_world.linear().determinant()));
    RETURN_IF_ERROR(MoveToWorld(source, node, part));
    out_.parts.push_back(std::move(part));
    return absl::OkStatus();
  }

  absl::Status AddTriangles(const Source& source, uint64_t mode, MeshPart& part) const {
    if (source.draco) {
      part.triangles = source.draco->Triangles();
      return absl::OkStatus();
    }
    std::vector<uint32_t> corners;
    if (source.part.Has("indices")) {
      ASSIGN_OR_RETURN(const uint64_t indices, data_.AccessorOf(source.part, "indices"));
      ASSIGN_OR_RETURN(corners, data_.Indices(indices, part.positions.size(), source.part.name));
    } else {
      for (uint32_t i = 0; i < part.positions.size(); ++i) corners.push_back(i);
    }
    const size_t step = mode == 4 ? 3 : 1;
    for (size_t i = 0; i + 2 < corners.size(); i += step) {
      std::array<uint32_t, 3> t = {corners[i], corners[i + 1], corners[i + 2]};
      if (mode == 5 && i % 2 == 1) std::swap(t[0], t[1]);  // A strip.
      if (mode == 6) t[0] = corners[0];                    // A fan.
      part.triangles.push_back(t);
    }
    return absl::OkStatus();
  }

  // Adds the morph targets.
  absl::Status Morph(const Source& source, const GltfEntry& weighted,
                     std::vector<double>& positions, std::vector<double>& normals) {
    ASSIGN_OR_RETURN(const std::vector<GltfEntry> targets, source.part.List("targets", "target"));
    if (targets.empty()) return absl::OkStatus();
    ASSIGN_OR_RETURN(const std::vector<double> weights,
                     weighted.NumbersOr("weights", std::vector<double>(targets.size(), 0.0)));
    for (size_t i = 0; i < targets.size(); ++i) {
      RETURN_IF_ERROR(CheckCounts(targets[i], targets[i].name, positions.size() / 3));
      if (weights[i] == 0) continue;
      RETURN_IF_ERROR(Count(0, positions.size() / 3, source.part.name));
      for (auto& [name, numbers] : {std::pair("POSITION", &positions), {"NORMAL", &normals}}) {
        if (!targets[i].Has(name) || numbers->empty()) continue;
        ASSIGN_OR_RETURN(const uint64_t place, data_.AccessorOf(targets[i], name));
        ASSIGN_OR_RETURN(const std::vector<double> more, data_.Numbers(place, 3));
        for (size_t k = 0; k < more.size(); ++k) (*numbers)[k] += weights[i] * more[k];
      }
    }
    return absl::OkStatus();
  }

  // Places a part as its node, or the joints of its skin, stand.
  absl::Status MoveToWorld(const Source& source, size_t node, MeshPart& part) const {
    std::vector<Eigen::Affine3d> joints;
    std::vector<double> numbers, weights;
    if ((*node_entries_)[node].Has("skin") && source.attributes.Has("JOINTS_0")) {
      ASSIGN_OR_RETURN(joints, JointsOf((*node_entries_)[node]));
      ASSIGN_OR_RETURN(numbers, Numbers(source, "JOINTS_0", 4));
      ASSIGN_OR_RETURN(weights, Numbers(source, "WEIGHTS_0", 4));
      if (numbers.size() != weights.size()) {
        return InvalidArgument("{}: it has joints without weights", source.part.name);
      }
    }
    for (size_t i = 0; i < part.positions.size(); ++i) {
      Eigen::Affine3d to_world = nodes_[node].to_world;
      if (!joints.empty()) {
        Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
        double total = 0;
        for (size_t k = 4 * i; k < 4 * i + 4; ++k) {
          const double joint = numbers[k];
          if (!(weights[k] > 0)) continue;
          if (!(joint >= 0 && joint < static_cast<double>(joints.size()))) {
            return InvalidArgument("{}: joint {} of {}", source.part.name, joint, joints.size());
          }
          sum += weights[k] * joints[static_cast<size_t>(joint)].matrix();
          total += weights[k];
        }
        if (total > 0) to_world.matrix() = sum / total;
      }
      part.positions[i] = to_world * part.positions[i];
      if (part.normals.empty()) continue;
      // The matrix of cofactors is the inverse transposed, but for a factor.
      const Eigen::Matrix3d& m = to_world.linear();
      const Eigen::Vector3d n = part.normals[i].cast<double>();
      Vec3d turned = m.col(1).cross(m.col(2)) * n.x() + m.col(2).cross(m.col(0)) * n.y() +
                     m.col(0).cross(m.col(1)) * n.z();
      if (m.determinant() < 0) turned = -turned;
      part.normals[i] = turned.normalized().cast<float>();
    }
    if (joints.empty() && nodes_[node].to_world.linear().determinant() < 0) {
      for (auto& t : part.triangles) std::swap(t[1], t[2]);
    }
    return absl::OkStatus();
  }

  // From a mesh to the world by each joint of the node's skin.
  absl::StatusOr<std::vector<Eigen::Affine3d>> JointsOf(const GltfEntry& node) const {
    ASSIGN_OR_RETURN(const uint64_t place, node.Whole("skin"));
    if (place >= skins_->size()) {
      return InvalidArgument("{}: skin {} of {}", node.name, place, skins_->size());
    }
    const GltfEntry& skin = (*skins_)[place];
    ASSIGN_OR_RETURN(const std::vector<size_t> places, skin.Places("joints", nodes_.size()));
    std::vector<double> inverse;
    if (skin.Has("inverseBindMatrices")) {
      ASSIGN_OR_RETURN(const uint64_t accessor, data_.AccessorOf(skin, "inverseBindMatrices"));
      ASSIGN_OR_RETURN(inverse, data_.Numbers(accessor, 16));
      if (inverse.size() < 16 * places.size()) {
        return InvalidArgument("{}: {} matrices, wanted {}, as joints", skin.name,
                               inverse.size() / 16, places.size());
      }
    }
    std::vector<Eigen::Affine3d> joints;
    for (size_t i = 0; i < places.size(); ++i) {
      if (nodes_[places[i]].depth == 0) {
        return InvalidArgument("{}: its joint {} is not in the scene", skin.name, places[i]);
      }
      joints.push_back(nodes_[places[i]].to_world);
      if (inverse.empty()) continue;
      Eigen::Affine3d bind = Eigen::Affine3d::Identity();
      bind.matrix().topRows<3>() = Eigen::Map<const Eigen::Matrix4d>(&inverse[16 * i]).topRows<3>();
      joints.back() = joints.back() * bind;
    }
    return joints;
  }

  // All attributes have as many elements as there are corners.
  absl::Status CheckCounts(const GltfEntry& attributes, const std::string& name,
                           uint64_t corners) const {
    for (const auto& [key, value] : attributes.json.items()) {
      ASSIGN_OR_RETURN(const uint64_t place,
                       data_.AccessorOf({attributes.json, name}, key.c_str()));
      if (data_.CountOf(place) != corners) {
        return InvalidArgument("{}: {} has {} elements, wanted {}, as POSITION", name, key,
                               data_.CountOf(place), corners);
      }
    }
    return absl::OkStatus();
  }

  absl::Status CountPart(const GltfEntry& part, uint64_t mode, uint64_t vertices) {
    uint64_t corners = vertices;
    if (part.Has("indices")) {
      ASSIGN_OR_RETURN(const uint64_t indices, data_.AccessorOf(part, "indices"));
      corners = data_.CountOf(indices);
    }
    return Count(mode == 4 ? corners / 3 : corners > 2 ? corners - 2 : 0, vertices, part.name);
  }

  // Counts what is read, each time that it is.
  absl::Status Count(uint64_t triangles, uint64_t corners, const std::string& name) {
    triangles_ += triangles;
    corners_ += corners;
    if (triangles_ <= kMostTriangles && corners_ <= kMostCorners) return absl::OkStatus();
    return InvalidArgument("{}: {} triangles with {} corners or more, wanted at most {} with {}",
                           name, triangles_, corners_, kMostTriangles, kMostCorners);
  }

  const GltfData& data_;
  GltfMaterials materials_;
  Entries node_entries_, meshes_, skins_;
  std::vector<Node> nodes_;
  uint64_t triangles_ = 0, corners_ = 0;
  MeshParts out_;
};

}  // namespace

absl::StatusOr<MeshParts> ReadGlb(std::string_view bytes, const std::string& path) {
  ASSIGN_OR_RETURN(const GlbChunks chunks, ReadGlbChunks(bytes));
  ASSIGN_OR_RETURN(const GltfData data, GltfData::Open(chunks.json, chunks.body));
  return GlbReader(data, std::filesystem::path(path).parent_path().string()).Read();
}

}  // namespace parallax
