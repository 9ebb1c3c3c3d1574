#include "worker/render/raster/rasteriser.h"

#include <fmt/core.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "common/base/system/memory_budget.h"
#include "worker/render/raster/strip.h"
#include "worker/render/surface/sampler.h"

namespace parallax {
namespace {

using ImageFromMesh = Eigen::Matrix<float, 3, 4>;

// A pinhole eye: its pose, frustum and projection.
class PinholeView {
 public:
  explicit PinholeView(const PinholeCamera& camera)
      : camera_from_world_(camera.world_from_camera.transpose()),
        origin_(camera.origin),
        size_(camera.width_px, camera.height_px),
        fx_(static_cast<float>(camera.fx_px)),
        fy_(static_cast<float>(camera.fy_px)),
        cx_(static_cast<float>(camera.cx_px)),
        cy_(static_cast<float>(camera.cy_px)) {
    image_from_camera_ << camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1;
    const float left = -cx_ / fx_, right = (static_cast<float>(camera.width_px) - cx_) / fx_;
    const float top = -cy_ / fy_, bottom = (static_cast<float>(camera.height_px) - cy_) / fy_;
    sides_[0] = Vec3f(1, 0, -left).normalized();
    sides_[1] = Vec3f(-1, 0, right).normalized();
    sides_[2] = Vec3f(0, 1, -top).normalized();
    sides_[3] = Vec3f(0, -1, bottom).normalized();
  }

  // Returns the way from a body's mesh to the camera's frame.
  Eigen::Affine3d CameraFromMesh(const Eigen::Affine3f& world_from_mesh) const {
    Eigen::Affine3d way = world_from_mesh.cast<double>();
    way.translation() -= origin_;
    way.matrix().topRows<3>() = camera_from_world_ * way.matrix().topRows<3>();
    return way;
  }
  ImageFromMesh ToImage(const Eigen::Affine3d& camera_from_mesh) const {
    return (image_from_camera_ * camera_from_mesh.matrix().topRows<3>()).cast<float>();
  }
  // Whether a ball, camera frame, may be seen.
  bool MaySee(const BoundingSphere& ball) const {
    if (ball.center.z() + ball.radius < Rasteriser::kNearM) return false;
    return std::all_of(std::begin(sides_), std::end(sides_),
                       [&](const Vec3f& side) { return side.dot(ball.center) >= -ball.radius; });
  }
  // Sets `nearest` and `tiles` of a cluster that is inside of the ball, camera frame.
  void Bound(const BoundingSphere& ball, PlacedCluster* placed) const {
    constexpr int kTile = Strip::kTile;
    constexpr float kNear = Rasteriser::kNearM;
    const float closest = ball.center.z() - ball.radius;
    if (closest <= 1.01f * kNear) {
      placed->nearest = std::numeric_limits<float>::infinity();
      placed->tiles = {0, 0, (size_.x() - 1) / kTile, (size_.y() - 1) / kTile};
      return;
    }
    placed->nearest = 1.0001f / closest;
    const float x = ball.center.x() / ball.center.z(), y = ball.center.y() / ball.center.z();
    // |p.x / p.z - x| <= radius |(1, x)| / closest, by Cauchy and Schwarz. A pixel more for
    // rounding.
    const float across = fx_ * ball.radius * std::hypot(1.0f, x) / closest + 1;
    const float down = fy_ * ball.radius * std::hypot(1.0f, y) / closest + 1;
    const auto tile = [](float at, int size) {
      return static_cast<int>(std::clamp(at, 0.0f, static_cast<float>(size - 1))) / kTile;
    };
    placed->tiles = {tile(fx_ * x + cx_ - across, size_.x()), tile(fy_ * y + cy_ - down, size_.y()),
                     tile(fx_ * x + cx_ + across, size_.x()),
                     tile(fy_ * y + cy_ + down, size_.y())};
  }

 private:
  const Eigen::Matrix3d camera_from_world_;
  const Vec3d origin_;
  const Eigen::Vector2i size_;
  const float fx_, fy_, cx_, cy_;
  Eigen::Matrix3d image_from_camera_;
  Vec3f sides_[4];  // Inward normals of the frustum.
};

BoundingSphere Moved(const BoundingSphere& ball, const Eigen::Affine3f& place, float scale) {
  return {place * ball.center, ball.radius * scale};
}

// Greatest stretch of a placement.
float ScaleOf(const Eigen::Affine3f& place) {
  // Columns suffice for turns with a scale for each axis; the sum of squares bounds all others.
  const Mat3f& m = place.linear();
  const Mat3f square = m.transpose() * m;
  const bool turns = square.isDiagonal(1e-4f);
  return 1.0001f * std::sqrt(turns ? square.diagonal().maxCoeff() : square.trace());
}

}  // namespace

SamplePoints::SamplePoints(uint32_t stream_hash) {
  for (uint32_t y = 0; y < kTile; ++y) {
    for (uint32_t x = 0; x < kTile; ++x) {
      for (uint32_t k = 0; k < kSamples; ++k) {
        const Vec2f at = Sampler::OfImage(stream_hash, x, y, kLog2Samples, k).Pair();
        const size_t index = Index(static_cast<int>(x), static_cast<int>(y)) + k;
        x_[index] = at.x();
        y_[index] = at.y();
      }
    }
  }
}

absl::StatusOr<Rasteriser> Rasteriser::Create(const RenderScene& scene) {
  constexpr int64_t kBytesPerTriangle = 20;
  const SceneGeometry& geometry = scene.geometry();
  std::vector<const Mesh*> meshes;
  for (const PlacedMesh& placed : geometry.meshes) meshes.push_back(placed.mesh.get());
  for (const Prototype& prototype : geometry.prototypes) meshes.push_back(prototype.mesh.get());

  std::map<const Mesh*, ClusteredMeshes::Range> ranges;
  int64_t triangles = 0;
  for (const Mesh* mesh : meshes) {
    if (!ranges.try_emplace(mesh).second) continue;
    triangles += static_cast<int64_t>(mesh->triangles.size());
  }
  RETURN_IF_ERROR(CheckMemory(fmt::format("render: clusters of {} triangles", triangles),
                              triangles * kBytesPerTriangle));
  Rasteriser rasteriser(scene);
  for (const Mesh* mesh : meshes) {
    ClusteredMeshes::Range& range = ranges[mesh];
    if (range.begin == range.end) range = rasteriser.meshes_.Add(*mesh);
    rasteriser.ranges_.push_back(range);
  }
  return rasteriser;
}

VisibilityBuffer Rasteriser::Draw(const PinholeCamera& camera, uint32_t stream_hash,
                                  const CancelToken& cancel) const {
  VisibilityBuffer buffer(camera.width_px, camera.height_px,
                          std::make_unique<const SamplePoints>(stream_hash));
  const PinholeView view(camera);
  const SceneGeometry& geometry = scene_->geometry();

  // Clusters that may be seen, body by body.
  std::vector<std::unique_ptr<ImageFromMesh>> ways;
  std::vector<PlacedCluster> clusters;
  for (uint32_t body = 0; body < scene_->body_count(); ++body) {
    const size_t meshes = geometry.meshes.size();
    const ClusteredMeshes::Range& range =
        ranges_[body < meshes ? body : meshes + geometry.instances[body - meshes].prototype];
    if (range.begin == range.end) continue;
    const Eigen::Affine3d place = view.CameraFromMesh(scene_->PlaceOf(body));
    const Eigen::Affine3f camera_from_mesh = place.cast<float>();
    const float scale = ScaleOf(camera_from_mesh);
    if (!view.MaySee(Moved(range.bounds, camera_from_mesh, scale))) continue;
    ways.push_back(std::make_unique<ImageFromMesh>(view.ToImage(place)));
    for (uint32_t c = range.begin; c < range.end; ++c) {
      const Cluster& cluster = meshes_.clusters[c];
      const BoundingSphere ball = Moved(cluster.bounds, camera_from_mesh, scale);
      if (!view.MaySee(ball)) continue;
      PlacedCluster placed{ways.back().get(), c};
      view.Bound(ball, &placed);
      clusters.push_back(placed);
      buffer.draws_.push_back({body, cluster.mesh_triangle});
    }
  }

  tbb::enumerable_thread_specific<Strip> strips(camera.width_px);
  const int count = (camera.height_px + Strip::kRows - 1) / Strip::kRows;
  tbb::parallel_for(0, count, [&](int strip) {
    constexpr int kTiles = Strip::kRows / Strip::kTile;
    if (cancel.cancelled()) return;
    std::vector<uint32_t> order;
    for (uint32_t draw = 0; draw < clusters.size(); ++draw) {
      const TileRect& tiles = clusters[draw].tiles;
      if (tiles.y0 < (strip + 1) * kTiles && tiles.y1 >= strip * kTiles) order.push_back(draw);
    }
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
      return clusters[a].nearest != clusters[b].nearest ? clusters[a].nearest > clusters[b].nearest
                                                        : a < b;
    });
    strips.local().Draw(meshes_, clusters, order, strip * Strip::kRows, &buffer);
  });
  return buffer;
}

}  // namespace parallax
