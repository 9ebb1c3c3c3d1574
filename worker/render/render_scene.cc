#include "worker/render/render_scene.h"

#include <algorithm>
#include <map>
#include <set>

#include "common/base/memory_budget.h"
#include "common/math/lanes.h"
#include "worker/render/bsdf.h"
#include "worker/render/sampling.h"

namespace parallax {
namespace {

// Embree reads 16 bytes at a float3: the last vertex needs one more float behind it.
using Positions = std::vector<Vec3f>;

// What Build adds for each triangle of a tree, each vertex and each position, its peak included
// (bench_scale measures it).
constexpr int64_t kBytesPerTriangle = 130;
constexpr int64_t kBytesPerVertex = 32;  // For shading; copies of a mesh share it.
constexpr int64_t kBytesPerPosition = 12;

// How a scene is stored.
struct Plan {
  // One tree over everything, with triangles split where that helps, is traced a good deal faster
  // than a tree of trees; it costs build time and memory for every copy of a mesh.
  bool one_tree = false;
  bool twins = false;
  int64_t triangles = 0, vertices = 0, positions = 0;  // Copies that are stored apart count.

  Plan(const SceneGeometry& geometry, bool movable) {
    constexpr int64_t kMost = 3'000'000;
    int64_t placed_triangles = 0;
    for (const PlacedMesh& placed : geometry.meshes) {
      placed_triangles += static_cast<int64_t>(placed.mesh->triangles.size());
    }
    one_tree = placed_triangles <= kMost && !movable;
    std::set<const Mesh*> seen;
    for (const PlacedMesh& placed : geometry.meshes) {
      const bool first = seen.insert(placed.mesh.get()).second;
      const auto count = static_cast<int64_t>(placed.mesh->positions.size());
      if (first) vertices += count;
      if (!first && !one_tree) continue;
      positions += count;
      triangles += static_cast<int64_t>(placed.mesh->triangles.size());
    }
    twins = triangles <= kMost;
  }

  absl::Status CheckMemory() const {
    return parallax::CheckMemory(
        "render: acceleration structure of " + std::to_string(triangles) + " triangles",
        triangles * kBytesPerTriangle * (twins ? 2 : 1) + vertices * kBytesPerVertex +
            positions * kBytesPerPosition);
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

struct alignas(32) RenderScene::Vertex {
  Vec3f normal;
  Vec3f texture;
  Vec2f uv;

  Vertex() = default;
  Vertex(const Vec3f& n, const Vec3f& t, const Vec2f& at) : normal(n), texture(t), uv(at) {}
  explicit Vertex(Float8 all) { _mm256_store_ps(normal.data(), all); }
  Float8 Load() const { return _mm256_load_ps(normal.data()); }
};

// What a hit reads stands first and is one step away: shading waits for memory more than it
// computes.
struct RenderScene::Body {
  const Triangle* triangles = nullptr;
  const Vertex* vertices = nullptr;     // Object frame.
  const Vec3f* positions = nullptr;     // World frame, or object frame when instanced.
  const uint32_t* materials = nullptr;  // By slot.
  uint32_t slots = 0;
  bool instanced = false;
  float scale = 1;
  Mat3f normal_from_object = Mat3f::Identity();
  Eigen::Affine3f world_from_object = Eigen::Affine3f::Identity();
  std::shared_ptr<const Positions> owned_positions;
  std::shared_ptr<const std::vector<Vertex>> owned_vertices;

  uint32_t MaterialOf(const Triangle& t) const { return t.slot < slots ? materials[t.slot] : 0; }

  void SetPlace(const Eigen::Affine3f& place) {
    world_from_object = place;
    scale = std::cbrt(std::abs(place.linear().determinant()));
    normal_from_object = place.linear().inverse().transpose();
  }
};

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
                                                                bool movable) {
  try {
    std::unique_ptr<RenderScene> scene(new RenderScene);
    scene->geometry_ = std::move(geometry);
    if (scene->geometry_.materials.empty()) scene->geometry_.materials.resize(1);
    for (const PlacedMesh& placed : scene->geometry_.meshes) {
      if (!placed.mesh) {
        return MakeError(absl::StatusCode::kInvalidArgument,
                         "object " + std::to_string(placed.object_index) + ": no mesh");
      }
      for (const uint32_t material : placed.material_of_slot) {
        if (material >= scene->geometry_.materials.size()) {
          return MakeError(absl::StatusCode::kInvalidArgument,
                           "object " + std::to_string(placed.object_index) + ": material " +
                               std::to_string(material) + " of " +
                               std::to_string(scene->geometry_.materials.size()));
        }
      }
    }
    RETURN_IF_ERROR(Plan(scene->geometry_, movable).CheckMemory());
    scene->ProbeMaterials();
    scene->movable_ = movable;
    RETURN_IF_ERROR(scene->BuildTrees(memory_limit_bytes));
    return scene;
  } catch (const std::bad_alloc&) {
    return MakeError(absl::StatusCode::kResourceExhausted,
                     "render: geometry does not fit in memory");
  }
}

Vec3f RenderScene::Passes(const RawHit& raw, const Vec3f& direction) const {
  const SurfaceHit hit = Resolve(raw);
  const MaterialTraits& traits = traits_[hit.material];
  if (!traits.may_be_open && !traits.may_be_thin) return Vec3f::Zero();
  const SurfaceSample surface = Evaluate(hit, 0.001f);
  const float cosine = std::min(1.0f, std::abs(direction.dot(hit.geometric_normal)));
  const float opacity = std::clamp(surface.opacity, 0.0f, 1.0f);
  Vec3f passes = Vec3f::Constant(1.0f - opacity);
  if (traits.may_be_thin && surface.thin_walled) {
    const Vec3f out = DirectionAt(std::max(cosine, 1e-3f), 0.0f);
    passes += opacity * Bsdf(surface, out, true).Straight();
  }
  return passes;
}

bool RenderScene::LetsLightThrough(const PlacedMesh& placed) const {
  return std::any_of(placed.material_of_slot.begin(), placed.material_of_slot.end(),
                     [&](uint32_t m) { return traits_[m].may_be_open || traits_[m].may_be_thin; });
}

void RenderScene::StoreBodies(bool one_tree) {
  std::map<const Mesh*, int> uses;
  for (const PlacedMesh& placed : geometry_.meshes) ++uses[placed.mesh.get()];
  std::map<const Mesh*, std::shared_ptr<const Positions>> shared_positions;
  std::map<const Mesh*, std::shared_ptr<const std::vector<Vertex>>> packed;
  bodies_.resize(geometry_.meshes.size());
  for (uint32_t i = 0; i < geometry_.meshes.size(); ++i) {
    const PlacedMesh& placed = geometry_.meshes[i];
    const Mesh& mesh = *placed.mesh;
    Body& body = bodies_[i];
    body.SetPlace(placed.world_from_object);
    body.triangles = mesh.triangles.data();
    body.materials = placed.material_of_slot.data();
    body.slots = static_cast<uint32_t>(placed.material_of_slot.size());
    body.instanced = movable_ || (uses[&mesh] > 1 && !one_tree);
    if (mesh.triangles.empty()) continue;
    for (const Vec3f& p : mesh.positions) bounds_.extend(placed.world_from_object * p);
    auto& vertices = packed[&mesh];
    if (!vertices) vertices = Pack(mesh);
    body.owned_vertices = vertices;
    body.vertices = vertices->data();
    if (body.instanced) {
      auto& positions = shared_positions[&mesh];
      if (!positions) positions = Placed(mesh, Eigen::Affine3f::Identity());
      body.owned_positions = positions;
    } else {
      body.owned_positions = Placed(mesh, placed.world_from_object);
    }
    body.positions = body.owned_positions->data();
  }
}

absl::Status RenderScene::BuildTrees(int64_t memory_limit_bytes) {
  const Plan plan(geometry_, movable_);
  StoreBodies(plan.one_tree);
  std::vector<TreeBody> bodies;
  for (size_t i = 0; i < bodies_.size(); ++i) {
    const PlacedMesh& placed = geometry_.meshes[i];
    bodies.push_back({placed.mesh.get(), bodies_[i].positions, bodies_[i].instanced,
                      LetsLightThrough(placed), placed.world_from_object});
  }
  TreeOptions options;
  options.one_tree = plan.one_tree;
  options.twins = plan.twins;
  options.memory_limit_bytes = memory_limit_bytes > 0 ? memory_limit_bytes : MemoryLimit();
  ASSIGN_OR_RETURN(trees_, RayTrees::Build(bodies, options));
  return absl::OkStatus();
}

absl::Status RenderScene::Move(const std::vector<Eigen::Affine3f>& world_from_object) {
  if (!movable_ || world_from_object.size() != bodies_.size()) {
    return MakeError(absl::StatusCode::kInvalidArgument,
                     "render: " + std::to_string(world_from_object.size()) + " placements for " +
                         std::to_string(bodies_.size()) +
                         (movable_ ? " meshes" : " meshes that can't move"));
  }
  bounds_.setEmpty();
  for (uint32_t i = 0; i < bodies_.size(); ++i) {
    const Eigen::Affine3f& place = world_from_object[i];
    geometry_.meshes[i].world_from_object = place;
    bodies_[i].SetPlace(place);
    const Mesh& mesh = *geometry_.meshes[i].mesh;
    if (mesh.triangles.empty()) continue;
    for (const Vec3f& p : mesh.positions) bounds_.extend(place * p);
  }
  return trees_->Move(world_from_object);
}

// Materials have no flags of their own: each is asked at points of a cube, seen from six sides and
// at corners of pictures. A trait that shows at none of these points does not show in shadows
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
      // Additive recurrence of the plastic constant in three dimensions: even cover of a cube of
      // 0.7 m.
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
      traits.may_be_mirror |= s.metallic >= 0.4f && s.roughness <= 0.15f;
      traits.needs_tracing |= s.opacity < 0.999f || s.transmission > 0.0f || !s.emission.isZero();
      const float height = geometry_.materials[m]->Height(point);
      if (k == 0) first_height = height;
      traits.has_relief |= height != first_height;
    }
  }
}

void RenderScene::Corners(uint32_t placed, uint32_t triangle, Vec3f corners[3]) const {
  const Body& body = bodies_[placed];
  const Triangle& t = body.triangles[triangle];
  corners[0] = body.positions[t.a];
  corners[1] = body.positions[t.b];
  corners[2] = body.positions[t.c];
  if (body.instanced) {
    for (int k = 0; k < 3; ++k) corners[k] = body.world_from_object * corners[k];
  }
}

void RenderScene::Prefetch(const RawHit& raw) const {
  __builtin_prefetch(bodies_[raw.placed].triangles + raw.triangle);
}

void RenderScene::PrefetchVertices(const RawHit& raw) const {
  const Body& body = bodies_[raw.placed];
  const Triangle& t = body.triangles[raw.triangle];
  __builtin_prefetch(body.vertices + t.a);
  __builtin_prefetch(body.vertices + t.b);
  __builtin_prefetch(body.vertices + t.c);
  if (!traits_[body.MaterialOf(t)].has_relief) return;
  __builtin_prefetch(body.positions + t.a);
  __builtin_prefetch(body.positions + t.b);
  __builtin_prefetch(body.positions + t.c);
}

SurfaceId RenderScene::Identify(const RawHit& raw) const {
  const Body& body = bodies_[raw.placed];
  const Triangle& t = body.triangles[raw.triangle];
  SurfaceId id;
  id.slot = t.slot;
  id.material = body.MaterialOf(t);
  const Vec3f cross =
      body.instanced ? Vec3f(body.normal_from_object * raw.edge_cross) : raw.edge_cross;
  const float length = cross.norm();
  if (length > 0.0f) id.geometric_normal = cross / length;
  id.doubled_area = body.instanced ? raw.edge_cross.norm() * Square(body.scale) : length;
  return id;
}

SurfaceHit RenderScene::Resolve(const RawHit& raw) const {
  SurfaceHit hit;
  Resolve(raw, Identify(raw), &hit);
  return hit;
}

void RenderScene::Resolve(const RawHit& raw, const SurfaceId& id, SurfaceHit* resolved) const {
  const Body& body = bodies_[raw.placed];
  const Triangle& t = body.triangles[raw.triangle];
  const Float8 corner = body.vertices[t.a].Load();
  const Float8 to_b = body.vertices[t.b].Load() - corner, to_c = body.vertices[t.c].Load() - corner;
  const Vertex here(corner + raw.u * to_b + raw.v * to_c), b(to_b), c(to_c);

  SurfaceHit& hit = *resolved;
  hit.placed = raw.placed;
  hit.triangle = raw.triangle;
  hit.slot = id.slot;
  hit.material = id.material;
  hit.position = raw.position;
  hit.geometric_normal = id.geometric_normal;
  hit.point.texture_m = body.scale * here.texture;
  hit.point.uv = here.uv;

  const Vec3f& n = here.normal;
  const Vec3f bent = body.normal_from_object * n;
  const Vec3f texture_cross = b.texture.cross(c.texture);
  const float uv_area = std::abs(b.uv.x() * c.uv.y() - b.uv.y() * c.uv.x());
  const Eigen::Array4f squares(n.squaredNorm(), bent.squaredNorm(), texture_cross.squaredNorm(),
                               id.doubled_area > 0.0f ? uv_area / id.doubled_area : 0.0f);
  const Eigen::Array4f lengths = squares.sqrt(), inverse = lengths.inverse();
  hit.point.normal = lengths[0] > 1e-6f ? Vec3f(n * inverse[0]) : body.vertices[t.a].normal;
  hit.shading_normal = lengths[1] > 1e-12f ? Vec3f(bent * inverse[1]) : hit.geometric_normal;
  if (hit.shading_normal.dot(hit.geometric_normal) < 0.0f) hit.shading_normal = -hit.shading_normal;
  hit.point.texture_normal =
      lengths[2] > 1e-20f ? Vec3f(texture_cross * inverse[2]) : Vec3f(Vec3f::Zero());
  hit.uv_per_metre = lengths[3];
}

SurfaceSample RenderScene::Evaluate(const SurfaceHit& hit, float footprint_m) const {
  const Material* material = geometry_.materials[hit.material].get();
  if (!material) return {};
  SurfacePoint point = hit.point;
  point.footprint_m = footprint_m;
  point.footprint_uv = footprint_m * hit.uv_per_metre;
  return material->Evaluate(point);
}

Faces8 RenderScene::FacesOf(std::span<const SurfaceHit* const> hits) const {
  Faces8 faces;
  for (int lane = 0; lane < kLanes; ++lane) {
    const SurfaceHit& hit = *hits[std::min(static_cast<size_t>(lane), hits.size() - 1)];
    const Body& body = bodies_[hit.placed];
    const Triangle& t = body.triangles[hit.triangle];
    Vec3f corners[3];
    Corners(hit.placed, hit.triangle, corners);
    const Vertex& corner = body.vertices[t.a];
    for (int k = 0; k < 2; ++k) {
      const Vertex& other = body.vertices[k == 0 ? t.b : t.c];
      faces.edge[k].Set(lane, corners[k + 1] - corners[0]);
      faces.texture_edge[k].Set(lane, body.scale * (other.texture - corner.texture));
      faces.u_edge[k][lane] = other.uv.x() - corner.uv.x();
      faces.v_edge[k][lane] = other.uv.y() - corner.uv.y();
    }
  }
  return faces;
}

Look8 RenderScene::Look(std::span<const SurfaceHit* const> hits, const float* footprints_m) const {
  const uint32_t index = hits[0]->material;
  Look8 look;
  SurfacePoint point[kLanes];
  for (int lane = 0; lane < kLanes; ++lane) {
    const size_t k = std::min(static_cast<size_t>(lane), hits.size() - 1);
    look.shading_normal.Set(lane, hits[k]->shading_normal);
    point[lane] = hits[k]->point;
    point[lane].footprint_m = footprints_m[k];
    point[lane].footprint_uv = footprints_m[k] * hits[k]->uv_per_metre;
  }
  const Material* material = geometry_.materials[index].get();
  if (!material) return look;
  const SurfacePoint8 points({point, hits.size()});
  look.surface = material->Evaluate(points);
  if (traits_[index].has_relief) {
    look.shading_normal = BendNormals(*material, points, FacesOf(hits), look.shading_normal);
  }
  return look;
}

}  // namespace parallax
