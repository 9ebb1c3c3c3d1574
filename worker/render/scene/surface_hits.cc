// Surfaces of hits: material, position on it, normals, and the properties that the material gives
// there.
#include <algorithm>

#include "worker/render/scene/render_scene_bodies.h"
#include "worker/render/surface/bsdf.h"
#include "worker/render/surface/sampling.h"

namespace parallax {
namespace {

// The lane itself, or the last valid lane of the batch.
int Filled(const HitBatch8& batch, int lane) { return std::min(lane, batch.count - 1); }

// Copies `x` of the last valid lane into the lanes behind it.
Float8 Filled(const HitBatch8& batch, Float8 x) {
  return FirstLanes(batch.count) ? x : Splat(x[batch.count - 1]);
}

// Multiplies eight vectors by their bodies' matrices; neighbours are mostly on one body.
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

// Eight packed vertices, or an interpolation of them.
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

Eigen::Affine3f RenderScene::PlaceOf(uint32_t placed) const {
  const size_t meshes = geometry_.meshes.size();
  return placed < meshes ? geometry_.meshes[placed].world_from_object
                         : geometry_.instances[placed - meshes].Affine();
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

PARALLAX_LANE_CLONES void RenderScene::HitTriangles(const Rays8& rays, Hits8* hits) const {
  Vec3x8 a = Vec3x8::Zero(), to_b = Vec3x8::Zero(), to_c = Vec3x8::Zero();
  hits->edge_cross = Vec3x8::Zero();
  for (uint32_t left = BitsOf(hits->met); left != 0; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    const auto placed = static_cast<uint32_t>(hits->placed[lane]);
    const Body& body = bodies_[placed];
    const Triangle& t = body.triangles[static_cast<uint32_t>(hits->triangle[lane])];
    Vec3f corner = body.positions[t.a];
    Vec3f edges[2] = {body.positions[t.b] - corner, body.positions[t.c] - corner};
    hits->edge_cross.Set(lane, edges[0].cross(edges[1]));
    if (body.instanced) {
      const Eigen::Affine3f place = PlaceOf(placed);
      corner = place * corner;
      for (Vec3f& edge : edges) edge = place.linear() * edge;
    }
    a.Set(lane, corner);
    to_b.Set(lane, edges[0]);
    to_c.Set(lane, edges[1]);
  }
  // Source: Moeller and Trumbore, "Fast, minimum storage ray/triangle intersection", 1997.
  const Vec3x8 from_a = rays.origin - a;
  const Vec3x8 across = Cross(rays.direction, to_c);
  const Float8 scale = 1.0f / Inner(to_b, across);
  hits->u = Clamp(Inner(from_a, across) * scale, 0.0f, 1.0f);
  hits->v = Min(Max(Inner(rays.direction, Cross(from_a, to_b)) * scale, 0.0f), 1.0f - hits->u);
  hits->distance = Inner(to_b * hits->u + to_c * hits->v - from_a, rays.direction);
  hits->position = rays.origin + rays.direction * hits->distance;
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
  Float8 area_scale = Splat(1);  // Scales the length of the cross product.
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
  // Normals that cancel leave the rounding error of barycentric coordinates, which differs between
  // processors.
  const Mask8 none = ~(length > 1e-5f);
  for (int lane = 0; Any(none) && lane < kLanes; ++lane) {
    const int from = Filled(batch, lane);
    if (none[lane] == 0) continue;
    points.normal.Set(lane, FirstNormal(static_cast<uint32_t>(batch.placed[from]),
                                        static_cast<uint32_t>(batch.triangle[from])));
  }
  const Float8 bent_length = Norm(bent);
  const Mask8 bends = (bent_length > 1e-12f) & ~none;
  const Vec3x8 normal = Select(bends, bent * (1.0f / bent_length), geometric);
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

// Computes two edges of each triangle, world frame.
PARALLAX_LANE_CLONES void RenderScene::FindEdges(const HitBatch8& batch, Vec3x8 edges[2]) const {
  Float8 rows[kLanes];
  bool instanced = false;
  for (int lane = 0; lane < kLanes; ++lane) {
    const int from = Filled(batch, lane);
    const Body& body = bodies_[static_cast<uint32_t>(batch.placed[from])];
    const Triangle& t = body.triangles[static_cast<uint32_t>(batch.triangle[from])];
    // Loads four numbers, as Embree does: one more position is behind the last.
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
