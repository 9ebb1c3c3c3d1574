// Shrubs: several stems from one root that colonise a low dome; leaves, blossoms or bare twigs.
#include <algorithm>
#include <cmath>

#include "worker/assets/nature/ground_cover.h"
#include "worker/assets/nature/plant_detail.h"
#include "worker/assets/nature/skeleton.h"
#include "worker/assets/nature/tree_wood.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

constexpr int kPoints = 420, kLeavesATwig = 9;

// A bush of forked stems with leaves.
struct ShrubParams {
  float height_m = 1.2f;
  float width = 1.1f;  // In heights.
  LeafForm leaf;
  float leaf_m = 0.045f;
  int leaves = 2200;
  float blossoms = 0;  // Share of twigs that end in flowers.
  bool bare = false;   // Dry: no leaves.
  Season season = Season::kSummer;
  uint64_t seed = 0;
};

class ShrubGrower {
 public:
  explicit ShrubGrower(const ShrubParams& p)
      : p_(p), rng_(SceneSeed{p.seed}, "shrub"), detail_(CurrentDetail()) {}

  Asset Grow() {
    GrowStems();
    WoodMaker wood({.detail = detail_,
                    .has_trunk = false,
                    .bark = Slot("bark", {"SmoothBark"}),
                    .twig_bark = Slot("twigs", {p_.bare ? "DeadWood" : "SmoothBark"})},
                   rng_.Child("wood"));
    wood.AddTree(tree_);
    SheetGrower leaves(SheetSlot("leaves", LeafMaterials(p_.season)), rng_.Child("leaves"));
    SheetGrower petals(SheetSlot("petals", {p_.seed % 2 == 0 ? "Petal" : "WhitePetal"}),
                       rng_.Child("petals"));
    GrowTwigs(wood, leaves, petals);
    AssetBuilder b(p_.seed);
    wood.MoveTo(b);
    for (const Mesh* part : {&leaves.mesh(), &petals.mesh()}) {
      if (!part->triangles.empty()) b.AddMesh(*part, Eigen::Affine3f::Identity());
    }
    return b.Finish(Anchor::kGround);
  }

 private:
  // A dome that noise breaks; nothing grows near the ground in its middle.
  std::vector<Vec3f> Points(Rng& rng) const {
    const Noise noise(rng);
    const float radius = 0.5f * p_.width * p_.height_m;
    std::vector<Vec3f> points;
    for (int tries = 0; tries < 40 * kPoints && points.size() < kPoints; ++tries) {
      const float a = Draw(rng, 0, 2 * kPi), up = Draw(rng, 0.0, 1.0),
                  out = std::pow(Draw(rng, 0, 1), 0.4f);
      const float side = std::sqrt(1 - up * up);
      const Vec3f way(side * std::cos(a), side * std::sin(a), up);
      const float broken = 1 + 0.32f * noise.At(2.0f * way) + 0.18f * noise.At(5.0f * way);
      const Vec3f p = out * broken * way.cwiseProduct(Vec3f(radius, radius, p_.height_m));
      if (p.z() < 0.12f * p_.height_m || noise.At(p / (0.3f * radius)) > 0.28f) continue;
      points.push_back(p);
    }
    return points;
  }

  void GrowStems() {
    Rng rng = rng_.Child("stems");
    const int root = tree_.Add(Vec3f::Zero(), -1);
    const int stems = rng.UniformInt(6, 11);
    for (int k = 0; k < stems; ++k) {
      const float a = 2.39996f * static_cast<float>(k) + Draw(rng, -0.4, 0.4);
      const float open = Draw(rng, 0.15, 0.75);
      const Vec3f out(std::cos(a), std::sin(a), 0);
      int last = tree_.Add(0.02f * p_.height_m * out + Vec3f(0, 0, 0.015f), root);
      for (int i = 1; i <= 3; ++i) {
        const Vec3f way = (Vec3f::UnitZ() + open * out).normalized();
        const Vec3f from = tree_.nodes()[static_cast<size_t>(last)].at;
        last = tree_.Add(from + 0.07f * p_.height_m * way, last);
      }
    }
    ColoniseOptions options;
    options.step_m = 0.055f * p_.height_m;
    options.kill_m = 0.075f * p_.height_m;
    options.tropism = Vec3f(0, 0, 0.15f);
    options.jitter = 0.3f;
    options.first_node = 1;
    options.max_nodes = 2500;
    tree_.Colonise(Points(rng), options, rng);
    tree_.Thicken(0.016f * p_.height_m + 0.004f, 0.0012f + 0.0008f * p_.height_m);
    tree_.Smooth(2, 1);
  }

  std::vector<SheetTemplate> Templates() const {
    std::vector<SheetTemplate> sheets;
    for (const float droop : {-0.3f, 0.6f, 1.5f}) {
      LeafForm form = p_.leaf;
      form.droop *= droop;
      if (detail_ != PlantDetail::kNear) form.stations = detail_ == PlantDetail::kMid ? 2 : 1;
      if (detail_ != PlantDetail::kNear) form.shape = LeafShape::kElliptic;
      sheets.push_back(MakeLeafTemplate(form));
    }
    return sheets;
  }

  std::vector<int> Bearers() const {
    std::vector<int> bearers;
    for (int i = 1; i < static_cast<int>(tree_.nodes().size()); ++i) {
      const TreeNode& node = tree_.nodes()[static_cast<size_t>(i)];
      if (node.tips <= 4 && node.at.z() > 0.1f * p_.height_m) bearers.push_back(i);
    }
    return bearers;
  }

  void GrowTwigs(WoodMaker& wood, SheetGrower& leaves, SheetGrower& petals) {
    Rng rng = rng_.Child("twigs");
    const std::vector<int> bearers = Bearers();
    const int twigs = p_.leaves / kLeavesATwig;
    if (bearers.empty()) return;
    const std::vector<SheetTemplate> sheets = Templates();
    stride_ = LeafStride(detail_, static_cast<size_t>(p_.leaves), 3 * sheets[1].triangles.size());
    const SheetTemplate petal = MakeLeafTemplate({LeafShape::kPetal, 0.75f, 0.4f, 0.0f, 2, 0});
    int number = 0;
    for (int t = 0; t < twigs; ++t) {
      const size_t pick = static_cast<size_t>(t) * bearers.size() / static_cast<size_t>(twigs);
      const Vec3f from = tree_.nodes()[static_cast<size_t>(bearers[pick])].at;
      const Vec3f side{Draw(rng, -1, 1), Draw(rng, -1, 1), Draw(rng, -0.3, 1)};
      const Vec3f way = (tree_.Heading(bearers[pick]) + 0.9f * side).stableNormalized();
      const float length = p_.height_m * Draw(rng, 0.06, 0.15);
      const Vec3f shake{Draw(rng, -0.3, 0.3), Draw(rng, -0.3, 0.3), Draw(rng, -0.1, 0.3)};
      const Vec3f middle = from + 0.5f * length * way, end = middle + 0.5f * length * (way + shake);
      if (detail_ == PlantDetail::kNear)
        wood.AddTwig({from, middle, end}, 0.0009f + 0.0007f * p_.height_m);
      if (p_.bare || p_.season == Season::kWinter) continue;
      for (int k = 0; k < kLeavesATwig; ++k, ++number) {
        AddLeaf(leaves, sheets, from, end, k, number, rng);
      }
      if (rng.Bernoulli(static_cast<double>(p_.blossoms)) && t % stride_ == 0) {
        AddCluster(petals, petal, end, rng);
      }
    }
  }

  void AddLeaf(SheetGrower& leaves, const std::vector<SheetTemplate>& sheets, const Vec3f& from,
               const Vec3f& end, int k, int number, Rng& rng) const {
    const Vec3f along = (end - from).normalized();
    const float s = (static_cast<float>(k) + Draw(rng, 0.2, 1.0)) / kLeavesATwig;
    const float turn = 2.39996f * static_cast<float>(k) + Draw(rng, -0.5, 0.5);
    Vec3f x = along.cross(std::abs(along.z()) < 0.9f ? Vec3f::UnitZ() : Vec3f::UnitX());
    x.normalize();
    const Vec3f out = std::cos(turn) * x + std::sin(turn) * along.cross(x);
    const Vec3f shake{Draw(rng, -1, 1), Draw(rng, -1, 1), Draw(rng, -1, 1)};
    SheetPlace place;
    place.at = from + s * (end - from);
    place.along = 0.7f * along + 0.75f * out + 0.25f * shake;
    place.up = Vec3f(0, 0, 0.8f) + 0.4f * out + 0.45f * shake;
    place.length_m = p_.leaf_m * Draw(rng, 0.6, 1.2) * std::sqrt(static_cast<float>(stride_));
    const auto form = static_cast<size_t>(rng.UniformInt(0, 2));
    if (number % stride_ == 0) leaves.Add(sheets[form], place);
  }

  // A head of small flowers.
  void AddCluster(SheetGrower& petals, const SheetTemplate& petal, const Vec3f& at,
                  Rng& rng) const {
    for (int f = 0; f < 4; ++f) {
      const Vec3f axis =
          Vec3f{Draw(rng, -1, 1), Draw(rng, -1, 1), Draw(rng, 0, 1.2)}.stableNormalized();
      const Vec3f middle = at + 0.45f * p_.leaf_m * axis;
      const Vec3f x = axis.cross(std::abs(axis.z()) < 0.9f ? Vec3f::UnitZ() : Vec3f::UnitX());
      const Vec3f u = x.normalized(), v = axis.cross(u);
      for (int k = 0; k < 5; ++k) {
        const float a = 2 * kPi * static_cast<float>(k) / 5 + Draw(rng, -0.1, 0.1);
        const Vec3f out = std::cos(a) * u + std::sin(a) * v;
        petals.Add(petal, {middle, out + 0.35f * axis, axis,
                           0.42f * p_.leaf_m * Draw(rng, 0.8, 1.1) *
                               std::sqrt(static_cast<float>(stride_))});
      }
    }
  }

  const ShrubParams& p_;
  Rng rng_;
  PlantDetail detail_;
  Skeleton tree_;
  int stride_ = 1;  // Keeps every stride-th leaf.
};

ShrubParams DrawShrub(Rng& rng) {
  ShrubParams p{.height_m = Draw(rng, 0.6, 1.7), .width = Draw(rng, 0.8, 1.4)};
  const LeafShape shapes[] = {LeafShape::kElliptic, LeafShape::kOvate, LeafShape::kOblong};
  p.leaf = {shapes[rng.UniformInt(0, 2)], Draw(rng, 0.35, 0.65), 0.5f, 0.0f, 3, 0.3f};
  p.leaf_m = (0.03f + 0.026f * p.height_m) * Draw(rng, 0.85, 1.25);
  p.leaves = rng.UniformInt(2300, 3400);
  p.season = rng.Bernoulli(0.2)   ? Season::kSpring
             : rng.Bernoulli(0.2) ? Season::kAutumn
                                  : Season::kSummer;
  p.seed = rng.Seed();
  return p;
}

Asset MakeShrub(const ShrubParams& p) { return ShrubGrower(p).Grow(); }

}  // namespace

Asset SampleShrub(Rng& rng) { return MakeShrub(DrawShrub(rng)); }

Asset SampleFlowerBush(Rng& rng) {
  ShrubParams p = DrawShrub(rng);
  p.season = Season::kSummer;
  p.blossoms = Draw(rng, 0.35, 0.8);
  p.leaves = static_cast<int>(0.7f * static_cast<float>(p.leaves));
  return MakeShrub(p);
}

Asset SampleDryBush(Rng& rng) {
  ShrubParams p = DrawShrub(rng);
  p.bare = true;
  return MakeShrub(p);
}

}  // namespace parallax
