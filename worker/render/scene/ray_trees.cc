#include "worker/render/scene/ray_trees.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>
#include <map>
#include <tuple>

namespace parallax {
namespace {

constexpr float kDark = 1e-3f;  // Relative strength below which light is dropped.

// Embree passes a pointer to the first member to the filter.
struct ShadowContext {
  RTCIntersectContext base;
  const ShadowFilter* filter;
  uint32_t rest;  // RayTrees::rest_.
  // World frame; the filter of an instance gets the ray in the object's frame.
  Vec3f origin, direction;
  Vec3f transmittance;
};

bool Meets(RTCScene scene, const Vec3f& origin, const Vec3f& direction, float t_min,
           RTCRayHit* query) {
  query->ray = MakeRay(origin, direction, t_min, std::numeric_limits<float>::infinity());
  query->hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, query);
  return query->hit.geomID != RTC_INVALID_GEOMETRY_ID;
}

// Shadow rays filter only geometry that may transmit light; the rest is opaque at no cost.
void FilterOcclusion(const RTCFilterFunctionNArguments* args) {
  auto* context = reinterpret_cast<ShadowContext*>(args->context);
  RawHit hit;
  const uint32_t instance = RTCHitN_instID(args->hit, args->N, 0, 0);
  hit.placed = instance != context->rest ? instance : RTCHitN_geomID(args->hit, args->N, 0);
  hit.triangle = RTCHitN_primID(args->hit, args->N, 0);
  hit.u = RTCHitN_u(args->hit, args->N, 0);
  hit.v = RTCHitN_v(args->hit, args->N, 0);
  hit.position = context->origin + RTCRayN_tfar(args->ray, args->N, 0) * context->direction;
  hit.edge_cross = Vec3f(RTCHitN_Ng_x(args->hit, args->N, 0), RTCHitN_Ng_y(args->hit, args->N, 0),
                         RTCHitN_Ng_z(args->hit, args->N, 0));
  const Vec3f passes = context->filter->Passes(hit, context->direction);
  context->transmittance = context->transmittance.cwiseProduct(passes);
  if (context->transmittance.maxCoeff() > kDark) args->valid[0] = 0;
}

}  // namespace

struct RayTrees::MemoryWatch {
  std::atomic<int64_t> used{0};
  int64_t limit = 0;

  static bool Callback(void* self, ssize_t bytes, bool /*post*/) {
    auto* watch = static_cast<MemoryWatch*>(self);
    const int64_t used = watch->used.fetch_add(bytes) + bytes;
    return bytes <= 0 || used <= watch->limit;
  }
};

class RayTrees::Builder {
 public:
  Builder(RayTrees* trees, const TreeOptions& options)
      : trees_(*trees), device_(trees->device_.get()), options_(options) {}

  EmbreeScene Build(const std::vector<TreeBody>& bodies, Tree tree) {
    EmbreeScene scene = NewScene(tree), rest;
    if (trees_.rest_ != RTC_INVALID_GEOMETRY_ID) rest = NewScene(tree);
    for (uint32_t i = 0; i < bodies.size(); ++i) {
      const TreeBody& body = bodies[i];
      if (body.mesh->triangles.empty()) continue;
      if (body.instanced) {
        Attach(scene.get(), Shared(body, tree), body.world_from_object, i);
      } else {
        rtcAttachGeometryByID(rest.get() ? rest.get() : scene.get(), Triangles(body).get(), i);
      }
    }
    if (rest.get()) {
      rtcCommitScene(rest.get());
      Attach(scene.get(), rest.get(), Eigen::Affine3f::Identity(), trees_.rest_);
      trees_.shared_.push_back(std::move(rest));
    }
    rtcCommitScene(scene.get());
    return scene;
  }

  static void Place(RTCGeometry instance, const Eigen::Affine3f& world_from_object) {
    const Eigen::Matrix<float, 3, 4> matrix = world_from_object.matrix().topRows<3>();
    rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, matrix.data());
    rtcCommitGeometry(instance);
  }

 private:
  void Attach(RTCScene scene, RTCScene child, const Eigen::Affine3f& place, uint32_t id) const {
    EmbreeGeometry instance(rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE));
    rtcSetGeometryInstancedScene(instance.get(), child);
    Place(instance.get(), place);
    rtcAttachGeometryByID(scene, instance.get(), id);
  }

  EmbreeScene NewScene(Tree tree) const {
    EmbreeScene scene(rtcNewScene(device_));
    rtcSetSceneFlags(scene.get(),
                     tree == Tree::kRobust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    if (options_.one_tree) rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_HIGH);
    return scene;
  }

  EmbreeGeometry Triangles(const TreeBody& body) const {
    EmbreeGeometry geometry(rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE));
    const Mesh& mesh = *body.mesh;
    rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               body.positions, 0, sizeof(Vec3f), mesh.positions.size());
    rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               mesh.triangles.data(), 0, sizeof(Triangle), mesh.triangles.size());
    if (options_.one_tree) rtcSetGeometryBuildQuality(geometry.get(), RTC_BUILD_QUALITY_HIGH);
    if (body.filtered) rtcSetGeometryOccludedFilterFunction(geometry.get(), &FilterOcclusion);
    rtcCommitGeometry(geometry.get());
    return geometry;
  }

  // If the uses of a shared mesh differ in what transmits light, one of its two trees needs the
  // filter.
  RTCScene Shared(const TreeBody& body, Tree tree) {
    RTCScene& scene = shared_[{body.mesh, body.filtered, tree}];
    if (scene) return scene;
    EmbreeScene child = NewScene(tree);
    rtcAttachGeometryByID(child.get(), Triangles(body).get(), 0);
    rtcCommitScene(child.get());
    scene = child.get();
    trees_.shared_.push_back(std::move(child));
    return scene;
  }

  RayTrees& trees_;
  const RTCDevice device_;
  const TreeOptions options_;
  std::map<std::tuple<const Mesh*, bool, Tree>, RTCScene> shared_;
};

RayTrees::RayTrees() = default;
RayTrees::~RayTrees() = default;

absl::StatusOr<std::unique_ptr<RayTrees>> RayTrees::Build(const std::vector<TreeBody>& bodies,
                                                          const TreeOptions& options) {
  std::unique_ptr<RayTrees> trees(new RayTrees);
  trees->device_ = MakeEmbreeDevice();
  if (!trees->device_.get()) {
    return ResourceExhausted("render: Embree gives no device");
  }
  trees->memory_ = std::make_unique<MemoryWatch>();
  trees->memory_->limit = options.memory_limit_bytes;
  rtcSetDeviceMemoryMonitorFunction(trees->device_.get(), &MemoryWatch::Callback,
                                    trees->memory_.get());
  for (uint32_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].moves && !bodies[i].mesh->triangles.empty()) trees->movers_.push_back(i);
  }
  const bool rests =
      std::any_of(bodies.begin(), bodies.end(), [](const TreeBody& b) { return !b.instanced; });
  if (!trees->movers_.empty() && rests) trees->rest_ = static_cast<uint32_t>(bodies.size());
  Builder builder(trees.get(), options);
  trees->robust_ = builder.Build(bodies, Tree::kRobust);
  if (options.twins) trees->fast_ = builder.Build(bodies, Tree::kFast);
  RETURN_IF_ERROR(trees->Error());
  return trees;
}

absl::Status RayTrees::Error() const {
  const RTCError error = rtcGetDeviceError(device_.get());
  if (error == RTC_ERROR_NONE) return absl::OkStatus();
  if (error == RTC_ERROR_OUT_OF_MEMORY) {
    return ResourceExhausted("render: the acceleration structure needs more than {} MB",
                             memory_->limit >> 20);
  }
  return Internal("render: Embree error {}", static_cast<int>(error));
}

absl::Status RayTrees::Move(const std::vector<Eigen::Affine3f>& world_from_object) {
  for (const EmbreeScene* scene : {&robust_, &fast_}) {
    if (!scene->get()) continue;
    for (const uint32_t i : movers_) {
      Builder::Place(rtcGetGeometry(scene->get(), i), world_from_object[i]);
    }
    rtcCommitScene(scene->get());
  }
  return Error();
}

absl::Status RayTrees::ShowMovers(bool shown) {
  for (const EmbreeScene* scene : {&robust_, &fast_}) {
    if (!scene->get()) continue;
    for (const uint32_t i : movers_) {
      const RTCGeometry mover = rtcGetGeometry(scene->get(), i);
      shown ? rtcEnableGeometry(mover) : rtcDisableGeometry(mover);
    }
    rtcCommitScene(scene->get());
  }
  return Error();
}

RTCScene RayTrees::scene(Tree tree) const {
  return tree == Tree::kFast && fast_.get() ? fast_.get() : robust_.get();
}

bool RayTrees::Intersect(Tree tree, const Ray& ray, float t_min, RawHit* hit) const {
  RTCRayHit query;
  if (!Meets(scene(tree), ray.origin, ray.direction, t_min, &query)) return false;
  hit->distance = query.ray.tfar;
  hit->placed = BodyOf(query.hit);
  hit->triangle = query.hit.primID;
  hit->u = query.hit.u;
  hit->v = query.hit.v;
  hit->position = ray.origin + query.ray.tfar * ray.direction;
  hit->edge_cross = Vec3f(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z);
  return true;
}

void RayTrees::Intersect(Tree tree, const Rays8& rays, Mask8 lanes, bool coherent,
                         Hits8* hits) const {
  coherent ? IntersectPacket(tree, rays, lanes, hits) : IntersectEach(tree, rays, lanes, hits);
  hits->position = rays.origin + rays.direction * hits->distance;
}

// Sets everything but the position.
void RayTrees::IntersectPacket(Tree tree, const Rays8& rays, Mask8 lanes, Hits8* hits) const {
  alignas(32) RTCRayHit8 query;
  const auto put = [](auto* to, auto from) { std::memcpy(to, &from, sizeof(from)); };
  put(query.ray.org_x, rays.origin.x);
  put(query.ray.org_y, rays.origin.y);
  put(query.ray.org_z, rays.origin.z);
  put(query.ray.dir_x, rays.direction.x);
  put(query.ray.dir_y, rays.direction.y);
  put(query.ray.dir_z, rays.direction.z);
  put(query.ray.tnear, Splat(0));
  put(query.ray.tfar, Splat(std::numeric_limits<float>::infinity()));
  put(query.ray.time, Splat(0));
  put(query.ray.mask, ~Int8{});
  put(query.ray.id, Int8{});
  put(query.ray.flags, Int8{});
  put(query.hit.geomID, ~Int8{});  // RTC_INVALID_GEOMETRY_ID.
  put(query.hit.instID[0], ~Int8{});
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(reinterpret_cast<const int*>(&lanes), scene(tree), &context, &query);

  const auto get = [](auto* to, const auto* from) { std::memcpy(to, from, sizeof(*to)); };
  Int8 geometry, instance;
  get(&geometry, query.hit.geomID);
  get(&instance, query.hit.instID[0]);
  hits->met = lanes & (geometry != -1);
  hits->placed = instance != static_cast<int32_t>(rest_) ? instance : geometry;
  get(&hits->distance, query.ray.tfar);
  get(&hits->triangle, query.hit.primID);
  get(&hits->u, query.hit.u);
  get(&hits->v, query.hit.v);
  get(&hits->edge_cross.x, query.hit.Ng_x);
  get(&hits->edge_cross.y, query.hit.Ng_y);
  get(&hits->edge_cross.z, query.hit.Ng_z);
}

void RayTrees::IntersectEach(Tree tree, const Rays8& rays, Mask8 lanes, Hits8* hits) const {
  hits->met = Mask8{};
  for (uint32_t left = BitsOf(lanes); left != 0; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    RTCRayHit query;
    if (!Meets(scene(tree), rays.origin.Get(lane), rays.direction.Get(lane), 0, &query)) continue;
    hits->met[lane] = -1;
    hits->distance[lane] = query.ray.tfar;
    hits->placed[lane] = static_cast<int32_t>(BodyOf(query.hit));
    hits->triangle[lane] = static_cast<int32_t>(query.hit.primID);
    hits->u[lane] = query.hit.u;
    hits->v[lane] = query.hit.v;
    hits->edge_cross.Set(lane, {query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z});
  }
}

Vec3f RayTrees::Transmittance(const ShadowFilter& filter, const Vec3f& origin,
                              const Vec3f& direction, float distance) const {
  RTCRay ray = MakeRay(origin, direction, 0, distance);
  ShadowContext context;
  rtcInitIntersectContext(&context.base);
  context.filter = &filter;
  context.rest = rest_;
  context.origin = origin;
  context.direction = direction;
  context.transmittance = Vec3f::Ones();
  rtcOccluded1(scene(Tree::kFast), &context.base, &ray);
  return ray.tfar < 0.0f ? Vec3f::Zero() : context.transmittance;
}

}  // namespace parallax
