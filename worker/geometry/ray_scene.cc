#include "worker/geometry/ray_scene.h"

#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <utility>

#include "worker/geometry/embree_handles.h"

namespace parallax {

// A body of a RayScene. It has a name outside of this file, because RayScene::State does.
struct RayBody {
  std::shared_ptr<const TriangleTree> tree;
  Eigen::Affine3f world_from_object;
  Box3f bounds;  // World.
  EmbreeGeometry instance;
  bool enabled = true;
};

namespace {

constexpr float kEndGap_m = 1e-5f;

std::array<Vec3f, 3> WorldCorners(const RayBody& body, uint32_t triangle) {
  const auto& t = body.tree->triangles()[triangle];
  const auto& p = body.tree->positions();
  return {body.world_from_object * p[t[0]], body.world_from_object * p[t[1]],
          body.world_from_object * p[t[2]]};
}

Vec3f GeometricNormal(const std::array<Vec3f, 3>& t) {
  return (t[1] - t[0]).cross(t[2] - t[0]).stableNormalized();
}

struct NearestQuery {
  const std::vector<RayBody>* bodies;
  Vec3f point;
  float best;
};

bool VisitNearest(RTCPointQueryFunctionArguments* args) {
  NearestQuery& query = *static_cast<NearestQuery*>(args->userPtr);
  const uint32_t body = args->context->instID[args->context->instStackSize - 1];
  const float distance =
      PointTriangleDistance(query.point, WorldCorners((*query.bodies)[body], args->primID));
  if (distance >= query.best) return false;
  query.best = distance;
  args->query->radius = distance;
  return true;
}

}  // namespace

struct RayScene::State {
  // One thread, because a solve is one of many jobs of a worker.
  EmbreeDevice device = MakeEmbreeDevice("threads=1,set_affinity=0");
  EmbreeScene top;
  // One scene for each tree, however many bodies use it.
  std::map<std::shared_ptr<const TriangleTree>, EmbreeScene> scenes;
  std::vector<RayBody> bodies;

  RTCScene SceneOf(const std::shared_ptr<const TriangleTree>& tree);
};

RTCScene RayScene::State::SceneOf(const std::shared_ptr<const TriangleTree>& tree) {
  EmbreeScene& scene = scenes[tree];
  if (scene.get()) return scene.get();
  scene = EmbreeScene(rtcNewScene(device.get()));
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  EmbreeGeometry triangles(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
  rtcSetSharedGeometryBuffer(triangles.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                             tree->positions().data(), 0, sizeof(Vec3f),
                             tree->positions().empty() ? 0 : tree->positions().size() - 1);
  rtcSetSharedGeometryBuffer(triangles.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             tree->triangles().data(), 0, sizeof(tree->triangles()[0]),
                             tree->triangles().size());
  rtcCommitGeometry(triangles.get());
  rtcAttachGeometryByID(scene.get(), triangles.get(), 0);
  rtcCommitScene(scene.get());
  return scene.get();
}

RayScene::RayScene() : state_(std::make_unique<State>()) {}
RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

uint32_t RayScene::Add(const Mesh& mesh, const Eigen::Affine3f& world_from_object) {
  return Add(std::make_shared<TriangleTree>(mesh), world_from_object);
}

uint32_t RayScene::Add(std::shared_ptr<const TriangleTree> tree,
                       const Eigen::Affine3f& world_from_object) {
  const RTCDevice device = state_->device.get();
  RayBody body;
  body.world_from_object = world_from_object;
  body.bounds = TransformBox(world_from_object, tree->bounds());

  body.instance = EmbreeGeometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE));
  rtcSetGeometryInstancedScene(body.instance.get(), state_->SceneOf(tree));
  rtcSetGeometryTimeStepCount(body.instance.get(), 1);
  const Eigen::Matrix<float, 3, 4> matrix = world_from_object.affine();  // Column-major.
  rtcSetGeometryTransform(body.instance.get(), 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, matrix.data());
  rtcCommitGeometry(body.instance.get());
  body.tree = std::move(tree);
  state_->bodies.push_back(std::move(body));
  return static_cast<uint32_t>(state_->bodies.size() - 1);
}

void RayScene::SetEnabled(uint32_t body, bool enabled) { state_->bodies[body].enabled = enabled; }

void RayScene::Commit() {
  state_->top = EmbreeScene(rtcNewScene(state_->device.get()));
  rtcSetSceneFlags(state_->top.get(), RTC_SCENE_FLAG_ROBUST);
  for (uint32_t i = 0; i < state_->bodies.size(); ++i) {
    if (!state_->bodies[i].enabled) continue;
    rtcAttachGeometryByID(state_->top.get(), state_->bodies[i].instance.get(), i);
  }
  rtcCommitScene(state_->top.get());
}

std::optional<RayHit> RayScene::Intersect(const Vec3f& origin, const Vec3f& direction,
                                          float max_distance) const {
  RTCRayHit ray{};
  ray.ray = MakeRay(origin, direction, 0.0f, max_distance);
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(state_->top.get(), &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  RayHit hit;
  hit.distance = ray.ray.tfar;
  hit.body = ray.hit.instID[0];
  hit.triangle = ray.hit.primID;
  hit.normal = GeometricNormal(WorldCorners(state_->bodies[hit.body], hit.triangle));
  return hit;
}

bool RayScene::Occluded(const Vec3f& from, const Vec3f& to) const {
  const Vec3f direction = to - from;
  const float length = direction.norm();
  if (length <= 2 * kEndGap_m) return false;
  RTCRay ray = MakeRay(from, direction / length, kEndGap_m, length - kEndGap_m);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(state_->top.get(), &context, &ray);
  return ray.tfar < 0;
}

float RayScene::NearestDistance(const Vec3f& point, float max_distance) const {
  NearestQuery mine{&state_->bodies, point, max_distance};
  RTCPointQuery query{point.x(), point.y(), point.z(), 0.0f, max_distance};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(state_->top.get(), &query, &context, VisitNearest, &mine);
  return mine.best;
}

bool RayScene::Inside(const Vec3f& point) const {
  for (const RayBody& body : state_->bodies) {
    if (!body.enabled || !body.bounds.contains(point)) continue;
    if (body.tree->Inside(body.world_from_object.inverse() * point)) return true;
  }
  return false;
}

bool RayScene::Overlaps(const Mesh& mesh, const Eigen::Affine3f& world_from_object,
                        float tolerance_m) const {
  return Overlaps(TriangleTree(mesh), world_from_object, tolerance_m);
}

bool RayScene::Overlaps(const TriangleTree& tree, const Eigen::Affine3f& world_from_object,
                        float tolerance_m) const {
  const Box3f bounds = TransformBox(world_from_object, tree.bounds());
  for (const RayBody& body : state_->bodies) {
    if (!body.enabled || !body.bounds.intersects(bounds)) continue;
    if (Overlap(*body.tree, body.world_from_object, tree, world_from_object, tolerance_m)) {
      return true;
    }
  }
  return false;
}

}  // namespace parallax
