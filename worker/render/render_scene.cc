#include "worker/render/render_scene.h"

#include <atomic>
#include <map>
#include <set>

#include "common/base/memory_budget.h"
#include "worker/render/bsdf.h"
#include "worker/render/sampling.h"

namespace parallax {
namespace {

// Embree reads 16 bytes at a float3: the last vertex needs one more float behind it.
using Positions = std::vector<Vec3f>;

// Relief is a few millimetres high: a wider footprint than this averages it away.
constexpr float kWidestRelief_m = 0.1f;

// Of the state of a shadow ray; Embree hands the first member to the filter.
struct ShadowContext {
  RTCIntersectContext base;
  const RenderScene* scene;
  Vec3f origin,
      direction;  // World; the filter of an instance is given the ray in the object's frame.
  Vec3f transmittance;
};

// What Build adds for each triangle and vertex, its peak included (bench_scale measures it).
constexpr int64_t kBytesPerTriangle = 130;
constexpr int64_t kBytesPerVertex = 32;  // For shading; copies of a mesh share it.
constexpr int64_t kBytesPerPosition = 12;

// One tree over everything, with triangles split where that helps, is traced a good deal faster
// than a tree of trees; it costs build time and memory for every copy of a mesh.
bool OneTree(const SceneGeometry& geometry, bool movable) {
  constexpr size_t kOneTree = 3'000'000;
  size_t placed_triangles = 0;
  for (const PlacedMesh& placed : geometry.meshes) {
    placed_triangles += placed.mesh->triangles.size();
  }
  return placed_triangles <= kOneTree && !movable;
}

// In one tree every copy of a mesh counts; instances share theirs.
absl::Status CheckBuildMemory(const SceneGeometry& geometry, bool one_tree) {
  std::set<const Mesh*> seen;
  int64_t triangles = 0, vertices = 0, positions = 0;
  for (const PlacedMesh& placed : geometry.meshes) {
    const bool first = seen.insert(placed.mesh.get()).second;
    const auto count = static_cast<int64_t>(placed.mesh->positions.size());
    if (first) vertices += count;
    if (!first && !one_tree) continue;
    positions += count;
    triangles += static_cast<int64_t>(placed.mesh->triangles.size());
  }
  return CheckMemory(
      "render: acceleration structure of " + std::to_string(triangles) + " triangles",
      triangles * kBytesPerTriangle + vertices * kBytesPerVertex + positions * kBytesPerPosition);
}

}  // namespace

struct RenderScene::MemoryWatch {
  std::atomic<int64_t> used{0};
  int64_t limit = 0;

  static bool Callback(void* self, ssize_t bytes, bool /*post*/) {
    auto* watch = static_cast<MemoryWatch*>(self);
    const int64_t used = watch->used.fetch_add(bytes) + bytes;
    return bytes <= 0 || used <= watch->limit;
  }
};

struct alignas(32) RenderScene::Vertex {
  Vec3f normal;
  Vec3f texture;
  Vec2f uv;
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
    RETURN_IF_ERROR(CheckBuildMemory(scene->geometry_, OneTree(scene->geometry_, movable)));
    scene->ProbeMaterials();
    RETURN_IF_ERROR(scene->BuildEmbree(memory_limit_bytes, movable));
    return scene;
  } catch (const std::bad_alloc&) {
    return MakeError(absl::StatusCode::kResourceExhausted,
                     "render: geometry does not fit in memory");
  }
}

// Shadow rays ask only geometry that may let light through; all else stays opaque at no cost.
static void FilterOcclusion(const RTCFilterFunctionNArguments* args) {
  auto* context = reinterpret_cast<ShadowContext*>(args->context);
  RawHit hit;
  const uint32_t instance = RTCHitN_instID(args->hit, args->N, 0, 0);
  hit.placed =
      instance != RTC_INVALID_GEOMETRY_ID ? instance : RTCHitN_geomID(args->hit, args->N, 0);
  hit.triangle = RTCHitN_primID(args->hit, args->N, 0);
  hit.u = RTCHitN_u(args->hit, args->N, 0);
  hit.v = RTCHitN_v(args->hit, args->N, 0);
  hit.position = context->origin + RTCRayN_tfar(args->ray, args->N, 0) * context->direction;
  hit.edge_cross = Vec3f(RTCHitN_Ng_x(args->hit, args->N, 0), RTCHitN_Ng_y(args->hit, args->N, 0),
                         RTCHitN_Ng_z(args->hit, args->N, 0));
  const SurfaceHit surface_hit = context->scene->Resolve(hit);
  const MaterialTraits& traits = context->scene->traits(surface_hit.material);
  if (!traits.may_be_open && !traits.may_be_thin) return;
  const SurfaceSample surface = context->scene->Evaluate(surface_hit, 0.001f);
  const float cosine =
      std::min(1.0f, std::abs(context->direction.dot(surface_hit.geometric_normal)));
  const float opacity = std::clamp(surface.opacity, 0.0f, 1.0f);
  Vec3f passes = Vec3f::Constant(1.0f - opacity);
  if (traits.may_be_thin && surface.thin_walled) {
    const Vec3f out = DirectionAt(std::max(cosine, 1e-3f), 0.0f);
    passes += opacity * Bsdf(surface, out, true).Straight();
  }
  context->transmittance = context->transmittance.cwiseProduct(passes);
  if (context->transmittance.maxCoeff() > 1e-3f) args->valid[0] = 0;
}

absl::Status RenderScene::BuildEmbree(int64_t memory_limit_bytes, bool movable) {
  movable_ = movable;
  device_ = EmbreeDevice(rtcNewDevice(nullptr));
  if (!device_.get()) {
    return MakeError(absl::StatusCode::kResourceExhausted, "render: Embree gives no device");
  }
  memory_ = std::make_unique<MemoryWatch>();
  memory_->limit = memory_limit_bytes > 0 ? memory_limit_bytes : MemoryLimit();
  rtcSetDeviceMemoryMonitorFunction(device_.get(), &MemoryWatch::Callback, memory_.get());

  std::map<const Mesh*, int> uses;
  for (const PlacedMesh& placed : geometry_.meshes) ++uses[placed.mesh.get()];
  const bool one_tree = OneTree(geometry_, movable);

  const auto new_triangles = [&](const Mesh& mesh, const Positions& positions, bool filtered) {
    EmbreeGeometry geometry(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
    rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               positions.data(), 0, sizeof(Vec3f), mesh.positions.size());
    rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               mesh.triangles.data(), 0, sizeof(Triangle), mesh.triangles.size());
    if (one_tree) rtcSetGeometryBuildQuality(geometry.get(), RTC_BUILD_QUALITY_HIGH);
    if (filtered) rtcSetGeometryOccludedFilterFunction(geometry.get(), &FilterOcclusion);
    rtcCommitGeometry(geometry.get());
    return geometry;
  };
  const auto lets_light_through = [&](const PlacedMesh& placed) {
    for (const uint32_t material : placed.material_of_slot) {
      if (traits_[material].may_be_open || traits_[material].may_be_thin) return true;
    }
    return false;
  };

  scene_ = EmbreeScene(rtcNewScene(device_.get()));
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
  if (one_tree) rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_HIGH);
  // A shared mesh whose uses differ in what lets light through needs the filter in one of its two
  // child scenes.
  struct Shared {
    std::shared_ptr<const Positions> positions;
    RTCScene scene = nullptr;
  };
  std::map<std::pair<const Mesh*, bool>, Shared> shared;
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
    if (mesh.triangles.empty()) continue;
    auto& vertices = packed[&mesh];
    if (!vertices) {
      auto all = std::make_shared<std::vector<Vertex>>(mesh.positions.size());
      for (size_t k = 0; k < all->size(); ++k) {
        (*all)[k] = {mesh.normals[k], mesh.texture[k], mesh.uv[k]};
      }
      vertices = all;
    }
    body.owned_vertices = vertices;
    body.vertices = vertices->data();
    const bool filtered = lets_light_through(placed);
    body.instanced = movable || (uses[&mesh] > 1 && !one_tree);
    if (!body.instanced) {
      auto positions = std::make_shared<Positions>();
      positions->reserve(mesh.positions.size() + 1);
      for (const Vec3f& p : mesh.positions) positions->push_back(placed.world_from_object * p);
      positions->push_back(Vec3f::Zero());
      body.owned_positions = positions;
      body.positions = positions->data();
      for (size_t k = 0; k < mesh.positions.size(); ++k) bounds_.extend((*positions)[k]);
      const EmbreeGeometry geometry = new_triangles(mesh, *positions, filtered);
      rtcAttachGeometryByID(scene_.get(), geometry.get(), i);
      continue;
    }
    Shared& entry = shared[{&mesh, filtered}];
    if (!entry.scene) {
      auto& positions = shared_positions[&mesh];
      if (!positions) {
        auto copy = std::make_shared<Positions>(mesh.positions);
        copy->push_back(Vec3f::Zero());
        positions = copy;
      }
      entry.positions = positions;
      EmbreeScene child(rtcNewScene(device_.get()));
      rtcSetSceneFlags(child.get(), RTC_SCENE_FLAG_ROBUST);
      const EmbreeGeometry geometry = new_triangles(mesh, *positions, filtered);
      rtcAttachGeometryByID(child.get(), geometry.get(), 0);
      rtcCommitScene(child.get());
      entry.scene = child.get();
      shared_scenes_.push_back(std::move(child));
    }
    body.owned_positions = entry.positions;
    body.positions = entry.positions->data();
    for (const Vec3f& p : mesh.positions) bounds_.extend(placed.world_from_object * p);
    EmbreeGeometry instance(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE));
    rtcSetGeometryInstancedScene(instance.get(), entry.scene);
    const Eigen::Matrix<float, 3, 4> matrix = placed.world_from_object.matrix().topRows<3>();
    rtcSetGeometryTransform(instance.get(), 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, matrix.data());
    rtcCommitGeometry(instance.get());
    rtcAttachGeometryByID(scene_.get(), instance.get(), i);
  }
  rtcCommitScene(scene_.get());
  const RTCError error = rtcGetDeviceError(device_.get());
  if (error == RTC_ERROR_OUT_OF_MEMORY) {
    return MakeError(absl::StatusCode::kResourceExhausted,
                     "render: the acceleration structure needs more than " +
                         std::to_string(memory_->limit >> 20) + " MB");
  }
  if (error != RTC_ERROR_NONE) {
    return MakeError(absl::StatusCode::kInternal,
                     "render: Embree error " + std::to_string(static_cast<int>(error)));
  }
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
    const RTCGeometry instance = rtcGetGeometry(scene_.get(), i);
    const Eigen::Matrix<float, 3, 4> matrix = place.matrix().topRows<3>();
    rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, matrix.data());
    rtcCommitGeometry(instance);
  }
  rtcCommitScene(scene_.get());
  const RTCError error = rtcGetDeviceError(device_.get());
  if (error == RTC_ERROR_NONE) return absl::OkStatus();
  return MakeError(absl::StatusCode::kInternal,
                   "render: Embree error " + std::to_string(static_cast<int>(error)));
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

bool RenderScene::Intersect(const Ray& ray, float t_min, RawHit* hit) const {
  RTCRayHit query;
  query.ray.org_x = ray.origin.x();
  query.ray.org_y = ray.origin.y();
  query.ray.org_z = ray.origin.z();
  query.ray.dir_x = ray.direction.x();
  query.ray.dir_y = ray.direction.y();
  query.ray.dir_z = ray.direction.z();
  query.ray.tnear = t_min;
  query.ray.tfar = std::numeric_limits<float>::infinity();
  query.ray.time = 0;
  query.ray.mask = ~0u;
  query.ray.id = 0;
  query.ray.flags = 0;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene_.get(), &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  hit->distance = query.ray.tfar;
  hit->placed =
      query.hit.instID[0] != RTC_INVALID_GEOMETRY_ID ? query.hit.instID[0] : query.hit.geomID;
  hit->triangle = query.hit.primID;
  hit->u = query.hit.u;
  hit->v = query.hit.v;
  hit->position = ray.origin + query.ray.tfar * ray.direction;
  hit->edge_cross = Vec3f(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z);
  return true;
}

Vec3f RenderScene::Transmittance(const Vec3f& origin, const Vec3f& direction,
                                 float distance) const {
  RTCRay ray;
  ray.org_x = origin.x();
  ray.org_y = origin.y();
  ray.org_z = origin.z();
  ray.dir_x = direction.x();
  ray.dir_y = direction.y();
  ray.dir_z = direction.z();
  ray.tnear = 0;
  ray.tfar = distance;
  ray.time = 0;
  ray.mask = ~0u;
  ray.id = 0;
  ray.flags = 0;
  ShadowContext context;
  rtcInitIntersectContext(&context.base);
  context.scene = this;
  context.origin = origin;
  context.direction = direction;
  context.transmittance = Vec3f::Ones();
  rtcOccluded1(scene_.get(), &context.base, &ray);
  return ray.tfar < 0.0f ? Vec3f::Zero() : context.transmittance;
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
  return id;
}

SurfaceHit RenderScene::Resolve(const RawHit& raw) const {
  const Body& body = bodies_[raw.placed];
  const Triangle& t = body.triangles[raw.triangle];
  const Vertex& a = body.vertices[t.a];
  const Vertex& b = body.vertices[t.b];
  const Vertex& c = body.vertices[t.c];
  const float w = 1.0f - raw.u - raw.v;

  SurfaceHit hit;
  hit.placed = raw.placed;
  hit.triangle = raw.triangle;
  hit.slot = t.slot;
  hit.material = body.MaterialOf(t);
  hit.position = raw.position;
  const float doubled_area = raw.edge_cross.norm() * (body.instanced ? Square(body.scale) : 1.0f);
  const Vec3f cross =
      body.instanced ? Vec3f(body.normal_from_object * raw.edge_cross) : raw.edge_cross;
  const float cross_length = cross.norm();
  if (cross_length > 0.0f) hit.geometric_normal = cross / cross_length;
  const Vec3f n = w * a.normal + raw.u * b.normal + raw.v * c.normal;
  const float n_length = n.norm();
  hit.point.normal = n_length > 1e-6f ? Vec3f(n / n_length) : a.normal;
  const Vec3f bent = body.normal_from_object * n;
  const float length = bent.norm();
  hit.shading_normal = length > 1e-12f ? Vec3f(bent / length) : hit.geometric_normal;
  if (hit.shading_normal.dot(hit.geometric_normal) < 0.0f) hit.shading_normal = -hit.shading_normal;
  hit.point.texture_m = body.scale * (w * a.texture + raw.u * b.texture + raw.v * c.texture);
  hit.point.uv = w * a.uv + raw.u * b.uv + raw.v * c.uv;
  const Vec3f texture_cross = (b.texture - a.texture).cross(c.texture - a.texture);
  const float texture_area = texture_cross.norm();
  if (texture_area > 1e-20f) hit.point.texture_normal = texture_cross / texture_area;
  const Vec2f q1 = b.uv - a.uv;
  const Vec2f q2 = c.uv - a.uv;
  const float uv_area = std::abs(q1.x() * q2.y() - q1.y() * q2.x());
  if (uv_area > 0.0f && doubled_area > 0.0f) hit.uv_per_metre = std::sqrt(uv_area / doubled_area);
  return hit;
}

SurfaceSample RenderScene::Evaluate(const SurfaceHit& hit, float footprint_m) const {
  const Material* material = geometry_.materials[hit.material].get();
  if (!material) return {};
  SurfacePoint point = hit.point;
  point.footprint_m = footprint_m;
  point.footprint_uv = footprint_m * hit.uv_per_metre;
  return material->Evaluate(point);
}

Vec3f RenderScene::BumpedNormal(const SurfaceHit& hit, float footprint_m) const {
  const Material* material = geometry_.materials[hit.material].get();
  if (!material || !traits_[hit.material].has_relief || footprint_m > kWidestRelief_m) {
    return hit.shading_normal;
  }
  const PlacedMesh& placed = geometry_.meshes[hit.placed];
  const Mesh& mesh = *placed.mesh;
  const Triangle& t = mesh.triangles[hit.triangle];
  Vec3f corners[3];
  Corners(hit.placed, hit.triangle, corners);
  const Vec3f e1 = corners[1] - corners[0];
  const Vec3f e2 = corners[2] - corners[0];
  const float g11 = e1.squaredNorm(), g12 = e1.dot(e2), g22 = e2.squaredNorm();
  const float determinant = g11 * g22 - g12 * g12;
  if (!(determinant > 1e-10f * g11 * g22)) return hit.shading_normal;  // A sliver has no plane.
  const float scale = bodies_[hit.placed].scale;
  const Vec3f d1 = scale * (mesh.texture[t.b] - mesh.texture[t.a]);
  const Vec3f d2 = scale * (mesh.texture[t.c] - mesh.texture[t.a]);
  const Vec2f q1 = mesh.uv[t.b] - mesh.uv[t.a];
  const Vec2f q2 = mesh.uv[t.c] - mesh.uv[t.a];

  const float step = std::clamp(0.5f * footprint_m, 5e-5f, 0.02f);
  const ShadingFrame frame(hit.shading_normal);
  SurfacePoint point = hit.point;
  point.footprint_m = footprint_m;
  point.footprint_uv = footprint_m * hit.uv_per_metre;
  const float height = material->Height(point);
  const auto slope = [&](const Vec3f& tangent) {
    // The tangent in terms of the triangle's edges, then the same step in texture space.
    const float b1 = tangent.dot(e1), b2 = tangent.dot(e2);
    const float s = (g22 * b1 - g12 * b2) / determinant * step;
    const float r = (g11 * b2 - g12 * b1) / determinant * step;
    SurfacePoint moved = point;
    moved.texture_m += s * d1 + r * d2;
    moved.uv += s * q1 + r * q2;
    return (material->Height(moved) - height) / step;
  };
  const float dx = std::clamp(slope(frame.x), -4.0f, 4.0f);
  const float dy = std::clamp(slope(frame.y), -4.0f, 4.0f);
  if (dx == 0.0f && dy == 0.0f) return hit.shading_normal;
  return (frame.z - dx * frame.x - dy * frame.y).normalized();
}

}  // namespace parallax
