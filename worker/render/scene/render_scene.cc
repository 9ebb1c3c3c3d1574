#include "worker/render/scene/render_scene.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <set>

#include "common/base/system/memory_budget.h"
#include "worker/render/scene/render_scene_bodies.h"

namespace parallax {
namespace {

// Memory that Build takes for each triangle of a tree, each vertex and each position, its peak
// included (bench_scale measures it).
constexpr int64_t kBytesPerTriangle = 130;
constexpr int64_t kBytesPerVertex = 32;  // For shading; copies of a mesh share it.
constexpr int64_t kBytesPerPosition = 12;
constexpr int64_t kBytesPerInstance = 470;

// The layout of a scene in memory.
struct Plan {
  // One tree over everything, with triangles split where that helps, traces a good deal faster than
  // a tree of trees, but costs build time and memory for every copy of a mesh.
  bool one_tree = false;
  bool twins = false;
  int64_t triangles = 0, vertices = 0, positions = 0;  // Copies that are stored apart count.
  int64_t instances = 0;                               // Instances of all prototypes.

  Plan(const SceneGeometry& geometry, bool all_move) {
    constexpr int64_t kMost = 3'000'000;
    int64_t placed_triangles = 0;
    for (const PlacedMesh& placed : geometry.meshes) {
      placed_triangles += static_cast<int64_t>(placed.mesh->triangles.size());
    }
    one_tree = placed_triangles <= kMost && !all_move && geometry.instances.empty();
    std::set<const Mesh*> seen;
    for (const PlacedMesh& placed : geometry.meshes) {
      const bool first = seen.insert(placed.mesh.get()).second;
      const auto count = static_cast<int64_t>(placed.mesh->positions.size());
      if (first) vertices += count;
      if (!first && !one_tree) continue;
      positions += count;
      triangles += static_cast<int64_t>(placed.mesh->triangles.size());
    }
    for (const Prototype& prototype : geometry.prototypes) {
      const auto count = static_cast<int64_t>(prototype.mesh->positions.size());
      vertices += count;
      positions += count;
      triangles += static_cast<int64_t>(prototype.mesh->triangles.size());
    }
    instances = static_cast<int64_t>(geometry.instances.size());
    twins = triangles <= kMost;
  }

  absl::Status CheckMemory() const {
    return parallax::CheckMemory(
        fmt::format("render: acceleration structure of {} triangles", triangles),
        triangles * kBytesPerTriangle * (twins ? 2 : 1) + vertices * kBytesPerVertex +
            positions * kBytesPerPosition + instances * kBytesPerInstance * (twins ? 2 : 1));
  }
};

std::shared_ptr<const Positions> Placed(const Mesh& mesh, const Eigen::Affine3f& place) {
  auto positions = std::make_shared<Positions>();
  positions->reserve(mesh.positions.size() + 1);
  for (const Vec3f& p : mesh.positions) positions->push_back(place * p);
  positions->push_back(Vec3f::Zero());
  return positions;
}

}  // namespace

std::shared_ptr<const std::vector<RenderScene::Vertex>> RenderScene::Pack(const Mesh& mesh) {
  auto all = std::make_shared<std::vector<Vertex>>(mesh.positions.size());
  for (size_t k = 0; k < all->size(); ++k) {
    (*all)[k] = Vertex(mesh.normals[k], mesh.texture[k], mesh.uv[k]);
  }
  return all;
}

RenderScene::RenderScene() = default;
RenderScene::~RenderScene() = default;

absl::StatusOr<std::unique_ptr<RenderScene>> RenderScene::Build(SceneGeometry geometry,
                                                                int64_t memory_limit_bytes,
                                                                std::vector<bool> movers) {
  try {
    std::unique_ptr<RenderScene> scene(new RenderScene);
    scene->geometry_ = std::move(geometry);
    if (scene->geometry_.materials.empty()) scene->geometry_.materials.resize(1);
    RETURN_IF_ERROR(scene->CheckReferences());
    scene->movers_ = std::move(movers);
    RETURN_IF_ERROR(Plan(scene->geometry_, scene->AllMove()).CheckMemory());
    scene->ProbeMaterials();
    RETURN_IF_ERROR(scene->BuildTrees(memory_limit_bytes));
    return scene;
  } catch (const std::bad_alloc&) {
    return ResourceExhausted("render: geometry does not fit in memory");
  }
}

absl::Status RenderScene::CheckReferences() const {
  const auto check = [&](const std::string& what, const Mesh* mesh,
                         const std::vector<uint32_t>& bound) -> absl::Status {
    if (!mesh) return InvalidArgument("{}: no mesh", what);
    for (const uint32_t material : bound) {
      if (material < geometry_.materials.size()) continue;
      return InvalidArgument("{}: material {} of {}", what, material, geometry_.materials.size());
    }
    return absl::OkStatus();
  };
  for (const PlacedMesh& placed : geometry_.meshes) {
    RETURN_IF_ERROR(check(fmt::format("object {}", placed.object_index), placed.mesh.get(),
                          placed.material_of_slot));
  }
  for (size_t i = 0; i < geometry_.prototypes.size(); ++i) {
    RETURN_IF_ERROR(check(fmt::format("prototype {}", i), geometry_.prototypes[i].mesh.get(),
                          geometry_.prototypes[i].material_of_slot));
  }
  for (const Instance& instance : geometry_.instances) {
    if (instance.prototype < geometry_.prototypes.size()) continue;
    return InvalidArgument("object {}: prototype {} of {}", instance.object_index,
                           instance.prototype, geometry_.prototypes.size());
  }
  return absl::OkStatus();
}

bool RenderScene::LetsLightThrough(const std::vector<uint32_t>& materials) const {
  return std::any_of(materials.begin(), materials.end(),
                     [&](uint32_t m) { return traits_[m].may_be_open || traits_[m].may_be_thin; });
}

void RenderScene::StoreBodies(bool one_tree) {
  std::map<const Mesh*, int> uses;
  for (const PlacedMesh& placed : geometry_.meshes) ++uses[placed.mesh.get()];
  std::map<const Mesh*, std::shared_ptr<const Positions>> shared_positions;
  std::map<const Mesh*, std::shared_ptr<const std::vector<Vertex>>> packed;
  static_assert(sizeof(Body) == 32);
  const size_t meshes = geometry_.meshes.size();
  bodies_.resize(meshes + geometry_.instances.size());
  places_.resize(bodies_.size());
  stored_.resize(meshes + geometry_.prototypes.size());
  for (uint32_t i = 0; i < meshes; ++i) {
    const PlacedMesh& placed = geometry_.meshes[i];
    const Mesh& mesh = *placed.mesh;
    Body& body = bodies_[i];
    SetPlace(i, placed.world_from_object);
    body = BodyOf(mesh, placed.material_of_slot);
    body.instanced = Moves(i) || (uses[&mesh] > 1 && !one_tree);
    if (mesh.triangles.empty()) continue;
    for (const Vec3f& p : mesh.positions) {
      bounds_.extend(placed.world_from_object * p);
      if (!Moves(i)) rest_bounds_.extend(placed.world_from_object * p);
    }
    auto& vertices = packed[&mesh];
    if (!vertices) vertices = Pack(mesh);
    stored_[i].owned_vertices = vertices;
    body.vertices = vertices->data();
    if (body.instanced) {
      auto& positions = shared_positions[&mesh];
      if (!positions) positions = Placed(mesh, Eigen::Affine3f::Identity());
      stored_[i].owned_positions = positions;
    } else {
      stored_[i].owned_positions = Placed(mesh, placed.world_from_object);
    }
    body.positions = stored_[i].owned_positions->data();
  }
  StoreInstances();
}

RenderScene::Body RenderScene::BodyOf(const Mesh& mesh, const std::vector<uint32_t>& materials) {
  Body body;
  body.triangles = mesh.triangles.data();
  body.first_material = static_cast<uint32_t>(materials_.size());
  body.slots = static_cast<uint16_t>(std::min<size_t>(materials.size(), UINT16_MAX));
  materials_.insert(materials_.end(), materials.begin(), materials.end());
  return body;
}

void RenderScene::StoreInstances() {
  const size_t meshes = geometry_.meshes.size();
  std::vector<Body> prototypes;
  std::vector<Box3f> boxes;
  for (size_t k = 0; k < geometry_.prototypes.size(); ++k) {
    const Mesh& mesh = *geometry_.prototypes[k].mesh;
    Stored& stored = stored_[meshes + k];
    stored.owned_vertices = Pack(mesh);
    stored.owned_positions = Placed(mesh, Eigen::Affine3f::Identity());
    Body body = BodyOf(mesh, geometry_.prototypes[k].material_of_slot);
    body.vertices = stored.owned_vertices->data();
    body.positions = stored.owned_positions->data();
    body.instanced = true;
    prototypes.push_back(body);
    boxes.push_back(mesh.Bounds());
  }
  for (size_t i = 0; i < geometry_.instances.size(); ++i) {
    const Instance& instance = geometry_.instances[i];
    const Eigen::Affine3f place = instance.Affine();
    bodies_[meshes + i] = prototypes[instance.prototype];
    SetPlace(meshes + i, place);
    const Box3f& box = boxes[instance.prototype];
    if (box.isEmpty()) continue;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3f at = place * box.corner(static_cast<Box3f::CornerType>(corner));
      bounds_.extend(at);
      rest_bounds_.extend(at);
    }
  }
}

void RenderScene::FindCacheGroups() {
  constexpr int kMany = 32;  // More of one mesh than stand in a room.
  std::map<const Mesh*, int> uses;
  std::map<const Mesh*, uint32_t> first;
  for (uint32_t i = 0; i < geometry_.meshes.size(); ++i) {
    const Mesh* mesh = geometry_.meshes[i].mesh.get();
    ++uses[mesh];
    first.emplace(mesh, i);
  }
  const auto sheets_of = [](const Mesh& mesh) {
    uint32_t sheets = 0;
    for (size_t slot = 0; slot < std::min<size_t>(mesh.slots.size(), 32); ++slot) {
      if (mesh.slots[slot].sheet) sheets |= 1u << slot;
    }
    return sheets;
  };
  for (uint32_t i = 0; i < geometry_.meshes.size(); ++i) {
    const Mesh& mesh = *geometry_.meshes[i].mesh;
    CacheGroup& group = cache_groups_.emplace_back();
    group.sheets = sheets_of(mesh);
    group.id = group.sheets != 0 || uses[&mesh] >= kMany ? first[&mesh] : i;
  }
  for (const Prototype& prototype : geometry_.prototypes) {
    const auto id = static_cast<uint32_t>(cache_groups_.size());
    cache_groups_.push_back({id, sheets_of(*prototype.mesh)});
  }
}

void RenderScene::SetPlace(size_t i, const Eigen::Affine3f& place) {
  places_[i].scale = std::cbrt(std::abs(place.linear().determinant()));
  places_[i].normal_from_object = place.linear().inverse().transpose();
}

bool RenderScene::AllMove() const {
  return !movers_.empty() && std::all_of(movers_.begin(), movers_.end(), [](bool m) { return m; });
}

absl::Status RenderScene::BuildTrees(int64_t memory_limit_bytes) {
  const Plan plan(geometry_, AllMove());
  StoreBodies(plan.one_tree);
  FindCacheGroups();
  std::vector<TreeBody> bodies;
  bodies.reserve(bodies_.size());
  for (size_t i = 0; i < geometry_.meshes.size(); ++i) {
    const PlacedMesh& placed = geometry_.meshes[i];
    bodies.push_back({placed.mesh.get(), bodies_[i].positions, bodies_[i].instanced,
                      LetsLightThrough(placed.material_of_slot), Moves(i),
                      placed.world_from_object});
  }
  std::vector<bool> open;
  for (const Prototype& prototype : geometry_.prototypes) {
    open.push_back(LetsLightThrough(prototype.material_of_slot));
  }
  for (const Instance& instance : geometry_.instances) {
    bodies.push_back({geometry_.prototypes[instance.prototype].mesh.get(),
                      bodies_[bodies.size()].positions, true, open[instance.prototype], false,
                      instance.Affine()});
  }
  TreeOptions options;
  options.one_tree = plan.one_tree;
  options.twins = plan.twins;
  options.memory_limit_bytes = memory_limit_bytes > 0 ? memory_limit_bytes : MemoryLimit();
  ASSIGN_OR_RETURN(trees_, RayTrees::Build(bodies, options));
  return absl::OkStatus();
}

absl::Status RenderScene::Move(const std::vector<Eigen::Affine3f>& world_from_object) {
  const size_t meshes = geometry_.meshes.size();
  if (movers_.empty() || world_from_object.size() != meshes) {
    return InvalidArgument("render: {} placements for {}{}", world_from_object.size(), meshes,
                           movers_.empty() ? " meshes that can't move" : " meshes");
  }
  bounds_ = rest_bounds_;
  for (uint32_t i = 0; i < meshes; ++i) {
    if (!Moves(i)) continue;
    const Eigen::Affine3f& place = world_from_object[i];
    geometry_.meshes[i].world_from_object = place;
    SetPlace(i, place);
    const Mesh& mesh = *geometry_.meshes[i].mesh;
    if (mesh.triangles.empty()) continue;
    for (const Vec3f& p : mesh.positions) bounds_.extend(place * p);
  }
  return trees_->Move(world_from_object);
}

// Materials declare no traits, so each is sampled at points of a cube, seen from six
// sides, and at corners of pictures. A trait that no sample shows will not show in shadows
// either.
void RenderScene::ProbeMaterials() {
  traits_.resize(geometry_.materials.size());
  const Vec3f sides[] = {Vec3f::UnitX(),  Vec3f::UnitY(),  Vec3f::UnitZ(),
                         -Vec3f::UnitX(), -Vec3f::UnitY(), -Vec3f::UnitZ()};
  for (size_t m = 1; m < geometry_.materials.size(); ++m) {
    if (!geometry_.materials[m]) continue;
    MaterialTraits& traits = traits_[m];
    float first_height = 0;
    for (uint32_t k = 0; k < 512; ++k) {
      SurfacePoint point;
      // Additive recurrence of the plastic constant in three dimensions: covers a cube of 0.7 m
      // evenly.
      const auto n = static_cast<float>(k);
      point.texture_m = Vec3f(std::fmod(n * 0.8191725f, 1.0f), std::fmod(n * 0.6710436f, 1.0f),
                              std::fmod(n * 0.5497005f, 1.0f)) *
                        0.7f;
      point.uv = point.texture_m.head<2>() / 0.7f;
      point.normal = sides[k % 6];
      point.footprint_m = 5e-4f;
      const SurfaceSample s = geometry_.materials[m]->Evaluate(point);
      traits.may_be_open |= s.opacity < 0.999f;
      traits.may_be_transmissive |= s.transmission > 0.0f;
      traits.may_be_thin |= s.thin_walled && s.transmission > 0.0f;
      traits.may_be_translucent |= !s.transmitted_color.isZero();
      traits.may_be_mirror |= s.metallic >= 0.4f && s.roughness <= 0.15f;
      traits.needs_tracing |= s.opacity < 0.999f || s.transmission > 0.0f || !s.emission.isZero();
      const float height = geometry_.materials[m]->Height(point);
      if (k == 0) first_height = height;
      traits.has_relief |= height != first_height;
    }
  }
}

}  // namespace parallax
