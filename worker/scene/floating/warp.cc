#include "worker/scene/floating/warp.h"

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "common/base/rng.h"
#include "worker/assets/asset.h"

namespace parallax {
namespace {

constexpr int kWaves = 4;

// Over the unit cube around the mesh: displacement and its derivative.
class WarpField {
 public:
  WarpField(uint64_t seed, double amount) {
    Rng rng(SceneSeed{seed}, "warp");
    // Shares of the whole displacement; waves shorter than the object bend it, longer ones lean it.
    double sum = 0;
    for (Wave& wave : waves_) {
      for (int c = 0; c < 3; ++c) wave.toward[c] = static_cast<float>(rng.Normal());
      Vec3d along(rng.Normal(), rng.Normal(), rng.Normal());
      along *= 2 * std::numbers::pi / (rng.Uniform(0.9, 2.2) * std::max(along.norm(), 1e-9));
      wave.along = along.cast<float>();
      wave.phase = static_cast<float>(rng.Uniform(0, 2 * std::numbers::pi));
      wave.toward /= std::max(wave.toward.norm(), 1e-6f);
      const double size = rng.Uniform(0.3, 1.0);
      wave.toward *= static_cast<float>(size);
      sum += size;
    }
    twist_ = static_cast<float>(rng.Uniform(-1, 1));
    taper_ = static_cast<float>(rng.Uniform(-1, 1));
    axis_ = rng.UniformInt(0, 2);
    // Twist and taper move a corner of the cube, 0.71 from the axis, by at most 0.36 each way.
    const double scale = amount / (sum + kTurn + kTurn);
    for (Wave& wave : waves_) wave.toward *= static_cast<float>(scale);
    twist_ *= static_cast<float>(scale * kTurn / 0.36);
    taper_ *= static_cast<float>(scale * kTurn / 0.36);
  }

  // `p` in [-0.5, 0.5]^3.
  Vec3f Displacement(const Vec3f& p, Mat3f& jacobian) const {
    Vec3f moved = Vec3f::Zero();
    jacobian.setZero();
    for (const Wave& wave : waves_) {
      const float angle = wave.along.dot(p) + wave.phase;
      moved += wave.toward * std::sin(angle);
      jacobian += wave.toward * (std::cos(angle) * wave.along).transpose();
    }
    const int a = axis_, b = (axis_ + 1) % 3, c = (axis_ + 2) % 3;
    moved[b] += p[a] * (taper_ * p[b] - twist_ * p[c]);
    moved[c] += p[a] * (taper_ * p[c] + twist_ * p[b]);
    jacobian(b, a) += taper_ * p[b] - twist_ * p[c];
    jacobian(b, b) += p[a] * taper_;
    jacobian(b, c) -= p[a] * twist_;
    jacobian(c, a) += taper_ * p[c] + twist_ * p[b];
    jacobian(c, c) += p[a] * taper_;
    jacobian(c, b) += p[a] * twist_;
    return moved;
  }

 private:
  static constexpr double kTurn = 0.8;
  struct Wave {
    Vec3f toward = Vec3f::Zero(), along = Vec3f::Zero();
    float phase = 0;
  };
  std::array<Wave, kWaves> waves_;
  float twist_ = 0, taper_ = 0;
  int axis_ = 2;
};

}  // namespace

void WarpMesh(uint64_t seed, double amount, Mesh& mesh) {
  const Box3f bounds = mesh.Bounds();
  if (!(amount > 0) || bounds.isEmpty()) return;
  const WarpField field(seed, amount);
  const Vec3f middle = bounds.center();
  const float side = std::max(bounds.diagonal().maxCoeff(), 1e-6f);
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    Mat3f jacobian;
    const Vec3f at = (mesh.positions[i] - middle) / side;
    mesh.positions[i] += side * field.Displacement(at, jacobian);
    // Normals go with the inverse transpose; the cofactors spare the division.
    const Mat3f deformation = Mat3f::Identity() + jacobian;
    Mat3f cofactor;
    cofactor.col(0) = deformation.col(1).cross(deformation.col(2));
    cofactor.col(1) = deformation.col(2).cross(deformation.col(0));
    cofactor.col(2) = deformation.col(0).cross(deformation.col(1));
    const Vec3f normal = cofactor * mesh.normals[i];
    const float length = normal.norm();
    if (length > 1e-9f) mesh.normals[i] = normal / length;
  }
}

absl::StatusOr<Mesh> MakeObjectMesh(const v1::SceneObject& object) {
  ASSIGN_OR_RETURN(Asset asset, MakeAsset(object.asset_class(), object.seed()));
  WarpMesh(object.warp_seed(), object.warp(), asset.mesh);
  return std::move(asset.mesh);
}

}  // namespace parallax
