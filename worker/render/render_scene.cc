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
constexpr int64_t kBytesPerInstance = 470;

// How a scene is stored.
struct Plan {
  // One tree over everything, with triangles split where that helps, is traced a good deal faster
  // than a tree of trees; it costs build time and memory for every copy of a mesh.
  bool one_tree = false;
  bool twins = false;
  int64_t triangles = 0, vertices = 0, positions = 0;  // Copies that are stored apart count.
  int64_t instances = 0;                               // Of prototypes.

  Plan(const SceneGeometry& geometry, bool movable) {
    constexpr int64_t kMost = 3'000'000;
    int64_t placed_triangles = 0;
    for (const PlacedMesh& placed : geometry.meshes) {
      placed_triangles += static_cast<int64_t>(placed.mesh->triangles.size());
    }
    one_tree = placed_triangles <= kMost && !movable && geometry.instances.empty();
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
        "render: acceleration structure of " + std::to_string(triangles) + " triangles",
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

struct alignas(32) RenderScene::Vertex {
  Vec3f normal;
  Vec3f texture;
  Vec2f uv;

  Vertex() = default;
  Vertex(const Vec3f& n, const Vec3f& t, const Vec2f& at) : normal(n), texture(t), uv(at) {}
  Float8 Load() const { return _mm256_load_ps(normal.data()); }
};

namespace {

// Of a lane, or of the last that counts.
int Filled(const HitBatch8& batch, int lane) { return std::min(lane, batch.count - 1); }

// Likewise, of a number of theirs.
Float8 Filled(const HitBatch8& batch, Float8 x) {
  return FirstLanes(batch.count) ? x : Splat(x[batch.count - 1]);
}

// Eight vectors, each by its body's matrix; neighbours are mostly on one body.
template <typename MatrixOf>
Vec3x8 Turned(const HitBatch8& batch, const Vec3x8& vectors, MatrixOf matrix_of) {
  const auto placed = [&](int lane) {
    return static_cast<uint32_t>(batch.placed[Filled(batch, lane)]);
  };
  if (!Any(FirstLanes(batch.count) & (batch.placed != batch.placed[0]))) {
    const Mat3f m = matrix_of(placed(0));
    return {Inner(Vec3x8(Vec3f(m.row(0))), vectors), Inner(Vec3x8(Vec3f(m.row(1))), vectors),
            Inner(Vec3x8(Vec3f(m.row(2))), vectors)};
  }
  Vec3x8 turned;
  for (int lane = 0; lane < kLanes; ++lane) {
    turned.Set(lane, matrix_of(placed(lane)) * vectors.Get(lane));
  }
  return turned;
}

// Eight vertices as they are loaded, or what is between them.
struct Vertices8 {
  Vec3x8 normal, texture;
  Float8 u, v;

  explicit Vertices8(Float8 rows[kLanes]) {
    Transpose(rows);
    normal = {rows[0], rows[1], rows[2]};
    texture = {rows[3], rows[4], rows[5]};
    u = rows[6];
    v = rows[7];
  }
};

}  // namespace

// What every hit reads, half a line of the cache: shading waits for memory more than it computes.
struct alignas(32) RenderScene::Body {
  const Triangle* triangles = nullptr;
  const Vertex* vertices = nullptr;  // Object frame.
  const Vec3f* positions = nullptr;  // World frame, or object frame when instanced.
  uint32_t first_material = 0;       // In materials_, by slot.
  uint16_t slots = 0;
  bool instanced = false;
};

// How it stands.
struct alignas(64) RenderScene::Place {
  Mat3f normal_from_object = Mat3f::Identity();
  float scale = 1;
};

// What else is kept of it.
struct RenderScene::Stored {
  std::shared_ptr<const Positions> owned_positions;
  std::shared_ptr<const std::vector<Vertex>> owned_vertices;
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
    RETURN_IF_ERROR(scene->CheckReferences());
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

absl::Status RenderScene::CheckReferences() const {
  const auto check = [&](const std::string& what, const Mesh* mesh,
                         const std::vector<uint32_t>& bound) -> absl::Status {
    if (!mesh) return MakeError(absl::StatusCode::kInvalidArgument, what + ": no mesh");
    for (const uint32_t material : bound) {
      if (material < geometry_.materials.size()) continue;
      return MakeError(absl::StatusCode::kInvalidArgument,
                       what + ": material " + std::to_string(material) + " of " +
                           std::to_string(geometry_.materials.size()));
    }
    return absl::OkStatus();
  };
  for (const PlacedMesh& placed : geometry_.meshes) {
    RETURN_IF_ERROR(check("object " + std::to_string(placed.object_index), placed.mesh.get(),
                          placed.material_of_slot));
  }
  for (size_t i = 0; i < geometry_.prototypes.size(); ++i) {
    RETURN_IF_ERROR(check("prototype " + std::to_string(i), geometry_.prototypes[i].mesh.get(),
                          geometry_.prototypes[i].material_of_slot));
  }
  for (const Instance& instance : geometry_.instances) {
    if (instance.prototype < geometry_.prototypes.size()) continue;
    return MakeError(absl::StatusCode::kInvalidArgument,
                     "object " + std::to_string(instance.object_index) + ": prototype " +
                         std::to_string(instance.prototype) + " of " +
                         std::to_string(geometry_.prototypes.size()));
  }
  return absl::OkStatus();
}

Vec3f RenderScene::Passes(const RawHit& raw, const Vec3f& direction) const {
  const SurfaceId id = Identify(raw);
  const MaterialTraits& traits = traits_[id.material];
  if (!traits.may_be_open && !traits.may_be_thin) return Vec3f::Zero();
  const SurfaceSample surface = Evaluate(raw, id, 0.001f);
  const float cosine = std::min(1.0f, std::abs(direction.dot(id.geometric_normal)));
  const float opacity = std::clamp(surface.opacity, 0.0f, 1.0f);
  Vec3f passes = Vec3f::Constant(1.0f - opacity);
  if (traits.may_be_thin && surface.thin_walled) {
    const Vec3f out = DirectionAt(std::max(cosine, 1e-3f), 0.0f);
    passes += opacity * Bsdf(surface, out, true).Straight();
  }
  return passes;
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
    body.instanced = movable_ || (uses[&mesh] > 1 && !one_tree);
    if (mesh.triangles.empty()) continue;
    for (const Vec3f& p : mesh.positions) bounds_.extend(placed.world_from_object * p);
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
      bounds_.extend(place * box.corner(static_cast<Box3f::CornerType>(corner)));
    }
  }
}

Eigen::Affine3f RenderScene::PlaceOf(uint32_t placed) const {
  const size_t meshes = geometry_.meshes.size();
  return placed < meshes ? geometry_.meshes[placed].world_from_object
                         : geometry_.instances[placed - meshes].Affine();
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

uint32_t RenderScene::MaterialOf(const Body& body, uint16_t slot) const {
  return slot < body.slots ? materials_[body.first_material + slot] : 0;
}

Mask8 RenderScene::OnSheets(const HitBatch8& batch) const {
  Mask8 on{};
  for (int lane = 0; lane < batch.count; ++lane) {
    const auto placed = static_cast<uint32_t>(batch.placed[lane]);
    const uint16_t slot = bodies_[placed].triangles[batch.triangle[lane]].slot;
    on[lane] = cache_group(placed).Sheet(slot) ? -1 : 0;
  }
  return on;
}

absl::Status RenderScene::BuildTrees(int64_t memory_limit_bytes) {
  const Plan plan(geometry_, movable_);
  StoreBodies(plan.one_tree);
  FindCacheGroups();
  std::vector<TreeBody> bodies;
  bodies.reserve(bodies_.size());
  for (size_t i = 0; i < geometry_.meshes.size(); ++i) {
    const PlacedMesh& placed = geometry_.meshes[i];
    bodies.push_back({placed.mesh.get(), bodies_[i].positions, bodies_[i].instanced,
                      LetsLightThrough(placed.material_of_slot), placed.world_from_object});
  }
  std::vector<bool> open;
  for (const Prototype& prototype : geometry_.prototypes) {
    open.push_back(LetsLightThrough(prototype.material_of_slot));
  }
  for (const Instance& instance : geometry_.instances) {
    bodies.push_back({geometry_.prototypes[instance.prototype].mesh.get(),
                      bodies_[bodies.size()].positions, true, open[instance.prototype],
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
  if (!movable_ || !geometry_.instances.empty() || world_from_object.size() != bodies_.size()) {
    return MakeError(absl::StatusCode::kInvalidArgument,
                     "render: " + std::to_string(world_from_object.size()) + " placements for " +
                         std::to_string(bodies_.size()) +
                         (movable_ ? " meshes" : " meshes that can't move"));
  }
  bounds_.setEmpty();
  for (uint32_t i = 0; i < bodies_.size(); ++i) {
    const Eigen::Affine3f& place = world_from_object[i];
    geometry_.meshes[i].world_from_object = place;
    SetPlace(i, place);
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
      traits.may_be_translucent |= !s.transmitted_color.isZero();
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
    const Eigen::Affine3f place = PlaceOf(placed);
    for (int k = 0; k < 3; ++k) corners[k] = place * corners[k];
  }
}

void RenderScene::Prefetch(const Hits8& hits) const {
  for (uint32_t left = BitsOf(hits.met); left != 0; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    __builtin_prefetch(bodies_[static_cast<uint32_t>(hits.placed[lane])].triangles +
                       static_cast<uint32_t>(hits.triangle[lane]));
  }
}

void RenderScene::PrefetchVertices(uint32_t placed, uint32_t triangle) const {
  const Body& body = bodies_[placed];
  const Triangle& t = body.triangles[triangle];
  __builtin_prefetch(body.vertices + t.a);
  __builtin_prefetch(body.vertices + t.b);
  __builtin_prefetch(body.vertices + t.c);
  if (!traits_[MaterialOf(body, t.slot)].has_relief) return;
  const Vec3f* positions = body.positions;
  __builtin_prefetch(positions + t.a);
  __builtin_prefetch(positions + t.b);
  __builtin_prefetch(positions + t.c);
}

SurfaceId RenderScene::Identify(const RawHit& raw) const {
  const Body& body = bodies_[raw.placed];
  const Triangle& t = body.triangles[raw.triangle];
  SurfaceId id;
  id.slot = t.slot;
  id.material = MaterialOf(body, t.slot);
  const Vec3f cross = body.instanced
                          ? Vec3f(places_[raw.placed].normal_from_object * raw.edge_cross)
                          : raw.edge_cross;
  const float length = cross.norm();
  if (length > 0.0f) id.geometric_normal = cross / length;
  id.doubled_area =
      body.instanced ? raw.edge_cross.norm() * Square(places_[raw.placed].scale) : length;
  return id;
}

SurfaceIds8 RenderScene::Identify(const Hits8& hits) const {
  SurfaceIds8 ids{};
  Vec3x8 cross = hits.edge_cross;
  Float8 area_scale = Splat(1);  // Of the square of the cross product's length.
  for (int lane = 0; lane < kLanes; ++lane) {
    if (hits.met[lane] == 0) continue;
    const Body& body = bodies_[static_cast<uint32_t>(hits.placed[lane])];
    const uint16_t slot = body.triangles[static_cast<uint32_t>(hits.triangle[lane])].slot;
    ids.slot[lane] = slot;
    ids.material[lane] = static_cast<int32_t>(MaterialOf(body, slot));
    if (!body.instanced) continue;
    const Place& place = places_[static_cast<uint32_t>(hits.placed[lane])];
    cross.Set(lane, place.normal_from_object * cross.Get(lane));
    area_scale[lane] = Square(place.scale);
  }
  const Float8 length = Norm(cross);
  ids.geometric_normal = Select(length > 0.0f, cross / length, Vec3x8(Vec3f::UnitZ()));
  ids.doubled_area = Norm(hits.edge_cross) * area_scale;
  return ids;
}

PARALLAX_LANE_CLONES Interpolated8 RenderScene::Interpolate(const HitBatch8& batch) const {
  Float8 here[kLanes], to_b[kLanes], to_c[kLanes];
  Float8 scale;
  for (int lane = 0; lane < kLanes; ++lane) {
    const int from = Filled(batch, lane);
    const Body& body = bodies_[static_cast<uint32_t>(batch.placed[from])];
    const Triangle& t = body.triangles[static_cast<uint32_t>(batch.triangle[from])];
    const Float8 a = body.vertices[t.a].Load();
    to_b[lane] = body.vertices[t.b].Load() - a;
    to_c[lane] = body.vertices[t.c].Load() - a;
    here[lane] = a + batch.u[from] * to_b[lane] + batch.v[from] * to_c[lane];
    scale[lane] = places_[static_cast<uint32_t>(batch.placed[from])].scale;
  }
  const Vec3x8 geometric(Filled(batch, batch.geometric_normal.x),
                         Filled(batch, batch.geometric_normal.y),
                         Filled(batch, batch.geometric_normal.z));
  const Float8 doubled_area = Filled(batch, batch.doubled_area);
  const Float8 footprint_m = Filled(batch, batch.footprint_m);
  const Vertices8 at(here), b(to_b), c(to_c);
  const Vec3x8 bent = Turned(
      batch, at.normal, [&](uint32_t k) -> const Mat3f& { return places_[k].normal_from_object; });
  Interpolated8 out;
  SurfacePoint8& points = out.points;
  points.count = batch.count;
  points.texture_m = at.texture * scale;
  points.u = at.u;
  points.v = at.v;

  const Float8 length = Norm(at.normal);
  points.normal = at.normal * (1.0f / length);
  const Mask8 none = ~(length > 1e-6f);
  for (int lane = 0; Any(none) && lane < kLanes; ++lane) {
    const int from = Filled(batch, lane);
    if (none[lane] == 0) continue;
    points.normal.Set(lane, FirstNormal(static_cast<uint32_t>(batch.placed[from]),
                                        static_cast<uint32_t>(batch.triangle[from])));
  }
  const Float8 bent_length = Norm(bent);
  const Vec3x8 normal = Select(bent_length > 1e-12f, bent * (1.0f / bent_length), geometric);
  out.shading_normal = Select(Inner(normal, geometric) < 0.0f, -normal, normal);

  const Vec3x8 cross = Cross(b.texture, c.texture);
  const Float8 cross_length = Norm(cross);
  points.texture_normal =
      Select(cross_length > 1e-20f, cross * (1.0f / cross_length), Vec3x8::Zero());
  const Float8 uv_area = Abs(b.u * c.v - b.v * c.u);
  points.footprint_m = footprint_m;
  points.footprint_uv = footprint_m * Sqrt(doubled_area > 0.0f ? uv_area / doubled_area : Splat(0));
  out.faces.texture_edge[0] = b.texture * scale;
  out.faces.texture_edge[1] = c.texture * scale;
  out.faces.u_edge[0] = b.u;
  out.faces.u_edge[1] = c.u;
  out.faces.v_edge[0] = b.v;
  out.faces.v_edge[1] = c.v;
  return out;
}

Vec3f RenderScene::FirstNormal(uint32_t placed, uint32_t triangle) const {
  const Body& body = bodies_[placed];
  return body.vertices[body.triangles[triangle].a].normal;
}

SurfaceSample RenderScene::Evaluate(const RawHit& hit, const SurfaceId& id,
                                    float footprint_m) const {
  const Material* material = geometry_.materials[id.material].get();
  if (!material) return {};
  HitBatch8 batch{};
  batch.Add(hit, id, footprint_m);
  SurfaceSample surface = material->Evaluate(Interpolate(batch).points).Get(0);
  if (OnSheets(batch)[0] == 0) surface.transmitted_color.setZero();
  return surface;
}

// Two edges of each triangle, in the world.
PARALLAX_LANE_CLONES void RenderScene::FindEdges(const HitBatch8& batch, Vec3x8 edges[2]) const {
  Float8 rows[kLanes];
  bool instanced = false;
  for (int lane = 0; lane < kLanes; ++lane) {
    const int from = Filled(batch, lane);
    const Body& body = bodies_[static_cast<uint32_t>(batch.placed[from])];
    const Triangle& t = body.triangles[static_cast<uint32_t>(batch.triangle[from])];
    // Of four numbers, as Embree loads them: one more position is behind the last.
    const auto position = [&](uint32_t k) { return _mm_loadu_ps(body.positions[k].data()); };
    const Float4 a = position(t.a), to_b = position(t.b) - a, to_c = position(t.c) - a;
    rows[lane] = _mm256_set_m128(to_c, to_b);
    instanced |= body.instanced;
  }
  Transpose(rows);
  for (int k = 0; k < 2; ++k) edges[k] = {rows[4 * k], rows[4 * k + 1], rows[4 * k + 2]};
  if (!instanced) return;
  const auto world_from_positions = [&](uint32_t placed) -> Mat3f {
    if (!bodies_[placed].instanced) return Mat3f::Identity();
    return PlaceOf(placed).linear();
  };
  for (int k = 0; k < 2; ++k) edges[k] = Turned(batch, edges[k], world_from_positions);
}

MaterialSample8 RenderScene::EvaluateMaterial(const HitBatch8& batch, uint32_t index) const {
  Interpolated8 at = Interpolate(batch);
  const Material* material = geometry_.materials[index].get();
  if (!material) return {.surface = {}, .shading_normal = at.shading_normal};
  MaterialSample8 look{material->Evaluate(at.points), at.shading_normal};
  if (traits_[index].may_be_translucent) {
    Vec3x8& through = look.surface.transmitted_color;
    through = Select(OnSheets(batch), through, Vec3x8::Zero());
  }
  if (!traits_[index].has_relief) return look;

  FindEdges(batch, at.faces.edge);
  look.shading_normal = BendNormals(*material, at.points, at.faces, at.shading_normal);
  return look;
}

}  // namespace parallax
