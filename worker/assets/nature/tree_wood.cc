#include "worker/assets/nature/tree_wood.h"

#include <algorithm>
#include <cmath>

#include "worker/assets/parts.h"

namespace parallax {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

namespace {

constexpr float kThinBranch_m = 0.011f;  // Thinner ones wear the twigs' bark.

}  // namespace

WoodMaker::WoodMaker(const WoodStyle& style, Rng rng) : style_(style), rng_(std::move(rng)) {
  bark_.slots.push_back(style.bark);
  twigs_.slots.push_back(style.twig_bark);
}

int WoodMaker::SidesFor(float radius_m) const {
  const int fine = radius_m > 0.05f ? 12 : radius_m > 0.025f ? 8 : radius_m > 0.01f ? 5 : 4;
  switch (style_.detail) {
    case PlantDetail::kNear:
      return fine;
    case PlantDetail::kMid:
      return std::max(3, fine * 2 / 3);
    default:
      return radius_m > 0.05f ? 5 : 3;
  }
}

// Limbs thinner at their beginning are left out.
float WoodMaker::ThinnestShown() const {
  constexpr float kStems_m[] = {0.0f, 0.0f, 0.002f, 0.004f};
  if (!style_.has_trunk) return kStems_m[static_cast<int>(style_.detail)];
  constexpr float kThinnest_m[] = {0.0f, 0.007f, 0.016f, 1e9f};
  return kThinnest_m[static_cast<int>(style_.detail)];
}

Vec3f WoodMaker::Offset() {
  return Vec3f{Draw(rng_, -20, 20), Draw(rng_, -20, 20), Draw(rng_, -20, 20)};
}

void WoodMaker::AddTree(const Skeleton& tree) {
  const auto& nodes = tree.nodes();
  bool trunk = style_.has_trunk;
  for (const std::vector<int>& limb : tree.Limbs()) {
    std::vector<LimbRing> rings;
    for (const int k : limb) {
      rings.push_back({nodes[static_cast<size_t>(k)].at, nodes[static_cast<size_t>(k)].radius});
    }
    if (trunk) {
      AddTrunk(rings);
      trunk = false;
      continue;
    }
    // Wider where it leaves its parent, but never as wide as that.
    if (rings[1].radius < ThinnestShown()) continue;
    if (!style_.has_trunk && limb.front() == 0 && rings.size() > 2) {
      rings.erase(rings.begin());  // A stem of its own, not a fork of the root's point.
    } else {
      rings[0].radius = std::min(0.9f * rings[0].radius, 1.45f * rings[1].radius);
    }
    AddBranch(rings);
  }
}

void WoodMaker::AddTrunk(const std::vector<LimbRing>& rings) {
  const bool near = style_.detail == PlantDetail::kNear;
  const bool shell = style_.detail == PlantDetail::kShell;
  const float radius = rings.front().radius;
  const Noise noise(rng_);
  const int roots = rng_.UniformInt(4, 7);
  const float phase = Draw(rng_, 0, 2 * kPi), uneven = Draw(rng_, 0, 2 * kPi);
  const float flare = style_.flare, lumps = style_.lumps;
  LimbOptions options;
  options.sides = near ? 22 : style_.detail == PlantDetail::kMid ? 10 : shell ? 4 : 6;
  options.modulate = [=](float a, float along) {
    const float low = std::exp(-along / (2.6f * radius)), foot = std::exp(-along / (0.9f * radius));
    const float wave = static_cast<float>(roots) * a + phase + 0.9f * std::sin(a + uneven);
    const float root = std::pow(0.5f + 0.5f * std::cos(wave), 1.5f);
    const Vec3f on(std::cos(a), std::sin(a), along / (4 * radius));
    return (1 + flare * (0.28f * low + foot * (0.15f + 0.75f * root))) *
           (1 + lumps * (noise.At(1.4f * on) + 0.6f * noise.At(3.3f * on)));
  };
  options.texture_offset_m = Offset();
  std::vector<LimbRing> all;
  if (near) {
    // Close rings at the foot, where the roots leave.
    const Vec3f up = rings[1].at - rings[0].at;
    all.push_back(rings[0]);
    for (const float s : {0.1f, 0.22f, 0.36f, 0.55f, 0.78f}) {
      all.push_back({rings[0].at + s * up, Lerp(rings[0].radius, rings[1].radius, s)});
    }
    const std::vector<LimbRing> rest =
        SmoothRings(std::vector<LimbRing>(rings.begin() + 1, rings.end()), 2);
    all.insert(all.end(), rest.begin(), rest.end());
  } else {
    const size_t stride = shell ? std::max<size_t>(1, rings.size() / 4) : 2;
    for (size_t i = 0; i < rings.size(); i += stride) all.push_back(rings[i]);
    if ((rings.size() - 1) % stride != 0) all.push_back(rings.back());
  }
  AddLimb(bark_, all, options);
}

void WoodMaker::AddBranch(const std::vector<LimbRing>& rings) {
  const float radius = rings[1].radius;
  const LimbOptions options{.sides = SidesFor(radius), .texture_offset_m = Offset()};
  std::vector<LimbRing> all;
  const bool fine = style_.detail == PlantDetail::kNear && radius > 0.015f;
  const size_t stride = fine ? 1 : style_.detail == PlantDetail::kFar ? 4 : 2;
  for (size_t i = 0; i < rings.size(); ++i) {
    const bool wanted = i <= 1 || i % stride == 0;
    // Rings nearer to each other than they are wide would fold over at a bend.
    const bool apart =
        all.empty() || (rings[i].at - all.back().at).norm() > 0.9f * all.back().radius;
    if ((wanted && apart) || i + 1 == rings.size()) all.push_back(rings[i]);
  }
  AddLimb(radius < kThinBranch_m ? twigs_ : bark_, all, options);
}

void WoodMaker::AddTwig(const std::vector<Vec3f>& path, float radius_m) {
  std::vector<LimbRing> rings;
  for (size_t i = 0; i < path.size(); i += 2) {
    const float t = static_cast<float>(i) / static_cast<float>(path.size() - 1);
    rings.push_back({path[i], radius_m * (1 - 0.7f * t)});
  }
  AddLimb(twigs_, rings, {.sides = 3, .texture_offset_m = Offset()});
}

void WoodMaker::MoveTo(AssetBuilder& b) const {
  if (!bark_.triangles.empty()) b.AddMesh(bark_, Eigen::Affine3f::Identity());
  if (!twigs_.triangles.empty()) b.AddMesh(twigs_, Eigen::Affine3f::Identity());
}

}  // namespace parallax
