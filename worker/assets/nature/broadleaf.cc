// Broadleaf trees: a trunk that wanders, limbs that colonise the crown's envelope, twigs and leaves
// at their ends.
#include <algorithm>
#include <cmath>

#include "worker/assets/nature/plant_detail.h"
#include "worker/assets/nature/skeleton.h"
#include "worker/assets/nature/tree_wood.h"
#include "worker/assets/nature/trees.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

constexpr int kLimbPoints = 46, kTwigPoints = 1300;

// Where limbs grow to: a body of revolution whose outline noise breaks, with holes.
class Crown {
 public:
  Crown(const BroadleafSpecies& species, float height_m, const Vec3f& axis_top, Rng& rng)
      : species_(species), height_m_(height_m), axis_top_(axis_top), noise_(rng) {
    lobes_ = Draw(rng, 0.7, 1.3);
    phase_ = Draw(rng, 0, 2 * kPi);
    lopsided_ = Draw(rng, 0.0, 0.22);
  }

  float radius_m() const { return species_.crown_radius * height_m_; }

  // `count` points, denser towards the outside.
  std::vector<Vec3f> Points(int count, Rng& rng) const {
    std::vector<Vec3f> points;
    for (int tries = 0; tries < 60 * count && static_cast<int>(points.size()) < count; ++tries) {
      const float h = Draw(rng, 0, 1), a = Draw(rng, 0, 2 * kPi);
      const float out = std::pow(Draw(rng, 0, 1), 0.42f), keep = Draw(rng, 0, 1);
      const float widest = OutlineAt(h, a);
      if (keep > 0.15f + 0.85f * widest) continue;  // As many a volume at each height.
      const float z = height_m_ * Lerp(species_.crown_base, 1.0f, h);
      const Vec3f axis = axis_top_ * (z / height_m_);
      const float r = out * widest * radius_m();
      const Vec3f p(axis.x() + r * std::cos(a), axis.y() + r * std::sin(a), z);
      if (InGap(p)) continue;
      points.push_back(p);
    }
    return points;
  }

 private:
  float OutlineAt(float h, float a) const {
    const float f = 4 * h;
    const size_t k = std::min<size_t>(3, static_cast<size_t>(f));
    const float smooth =
        Lerp(species_.profile[k], species_.profile[k + 1], f - static_cast<float>(k));
    const Vec3f on(std::cos(a), std::sin(a), 1.6f * h);
    const float broken = 0.3f * noise_.At(1.7f * lobes_ * on) + 0.14f * noise_.At(4.1f * on);
    return smooth * std::max(0.3f, 1 + broken + lopsided_ * std::cos(a - phase_));
  }
  bool InGap(const Vec3f& p) const {
    const float n = noise_.At(p / (0.34f * radius_m()) + Vec3f::Constant(7.3f));
    return n > 0.62f - 1.5f * species_.gaps;
  }

  const BroadleafSpecies& species_;
  float height_m_;
  Vec3f axis_top_;
  Noise noise_;
  float lobes_, phase_, lopsided_;
};

class BroadleafGrower {
 public:
  explicit BroadleafGrower(const BroadleafParams& p)
      : p_(p),
        species_(BroadleafTable()[p.species]),
        root_(SceneSeed{p.seed}, "broadleaf"),
        detail_(CurrentDetail()),
        trunk_m_(species_.trunk_radius * p.height_m),
        tip_m_(0.0028f + 0.0002f * p.height_m) {}

  Asset Grow() {
    GrowTrunk();
    GrowCrown();
    ShapeLimbs();
    AssetBuilder b(p_.seed);
    const WoodStyle style{.detail = detail_,
                          .flare = Draw(shape_, 0.7, 1.3),
                          .bark = Slot("bark", species_.bark),
                          .twig_bark = Slot("twigs", species_.twig_bark)};
    WoodMaker wood(style, root_.Child("wood"));
    wood.AddTree(tree_);
    SheetGrower leaves(SheetSlot("leaves", LeafMaterials(p_.season)), root_.Child("own"));
    GrowTwigs(wood, leaves);
    wood.MoveTo(b);
    if (leaves.count() > 0) b.AddMesh(leaves.mesh(), Eigen::Affine3f::Identity());
    return b.Finish(Anchor::kGround);
  }

 private:
  // A leader that leans, recovers and bends at old wounds.
  void GrowTrunk() {
    Rng rng = root_.Child("trunk");
    const float end = species_.leader * p_.height_m * Draw(rng, 0.9, 1.1);
    const int pieces = std::max(5, static_cast<int>(end / 0.3f));
    const float lean = Draw(rng, 0.0, 0.09), toward = Draw(rng, 0, 2 * kPi);
    Vec3f way = Vec3f(lean * std::cos(toward), lean * std::sin(toward), 1).normalized();
    Vec3f at = Vec3f::Zero();
    int last = tree_.Add(at, -1);
    for (int k = 0; k < pieces; ++k) {
      const Vec3f push{Draw(rng, -1, 1), Draw(rng, -1, 1), 0};
      way = (way + 4.0f * species_.wander * push + Vec3f(0, 0, 0.12f)).normalized();
      at += way * (end / static_cast<float>(pieces));
      last = tree_.Add(at, last);
    }
    trunk_nodes_ = last + 1;
    trunk_top_ = at;
  }

  // Few far points first, for limbs; then many, for branches.
  void GrowCrown() {
    Rng rng = root_.Child("crown");
    const float h = p_.height_m;
    const Vec3f axis = trunk_top_ * (h / std::max(0.1f, trunk_top_.z()));
    const Crown crown(species_, h, 0.6f * axis, rng);
    ColoniseOptions limbs;
    limbs.step_m = 0.04f * h;
    limbs.kill_m = 0.09f * h;
    limbs.tropism = Vec3f(0, 0, species_.up);
    limbs.jitter = 0.22f;
    limbs.first_node = FirstFork();
    tree_.Colonise(crown.Points(kLimbPoints, rng), limbs, rng);
    ColoniseOptions branches;
    branches.step_m = 0.021f * h;
    branches.kill_m = 0.03f * h;
    branches.reach_m = 0.16f * h;
    branches.tropism = Vec3f(0, 0, 0.4f * species_.up);
    branches.jitter = 0.3f;
    branches.first_node = FirstFork();
    tree_.Colonise(crown.Points(kTwigPoints, rng), branches, rng);
  }

  // No limb leaves the trunk below.
  int FirstFork() const {
    const float low = std::min(0.75f * species_.crown_base + 0.02f, 0.8f * species_.leader);
    int first = 1;
    while (first + 2 < trunk_nodes_ &&
           tree_.nodes()[static_cast<size_t>(first)].at.z() < low * p_.height_m) {
      ++first;
    }
    return first;
  }

  void ShapeLimbs() {
    tree_.Thicken(trunk_m_, tip_m_);
    tree_.Smooth(3, 2);
    const Noise noise(shape_);
    const float h = p_.height_m, amount = species_.wander * h;
    tree_.Displace(
        [&](const Vec3f& q) {
          const float rise = Smooth01(q.z() / (0.25f * h));
          return Vec3f(rise * (amount * noise.Vector(q / (0.16f * h)) +
                               0.3f * amount * noise.Vector(q / (0.05f * h))));
        },
        1);
  }

  // Nodes that bear twigs: the thin ends, in order.
  std::vector<int> Bearers() const {
    std::vector<int> bearers;
    for (int i = trunk_nodes_; i < static_cast<int>(tree_.nodes().size()); ++i) {
      if (tree_.nodes()[static_cast<size_t>(i)].tips <= 5) bearers.push_back(i);
    }
    return bearers;
  }

  // Leaves as large as the crown's cover needs, within what the species has.
  float LeafLength(const SheetTemplate& sheet) const {
    const float radius = species_.crown_radius * p_.height_m;
    const float wanted =
        species_.cover * kPi * radius * radius / (static_cast<float>(species_.leaves) * sheet.area);
    const float length = std::clamp(std::sqrt(wanted), species_.leaf_m, 2.0f * species_.leaf_m);
    return p_.season == Season::kSpring ? 0.72f * length : length;
  }

  std::vector<SheetTemplate> Templates() const {
    std::vector<SheetTemplate> sheets;
    for (const float droop : {0.3f, 0.9f, 1.5f}) {
      LeafForm form = species_.leaf;
      form.droop *= droop;
      form.twist *= droop - 0.6f;
      if (detail_ != PlantDetail::kNear) {
        form.shape = LeafShape::kElliptic;
        form.stations = detail_ == PlantDetail::kMid ? 2 : 1;
        form.fold = detail_ == PlantDetail::kMid ? 0.0f : 0.35f;
        form.width = std::max(form.width, 0.3f);
      }
      sheets.push_back(MakeLeafTemplate(form));
    }
    return sheets;
  }

  void GrowTwigs(WoodMaker& wood, SheetGrower& leaves) {
    Rng rng = root_.Child("twigs");
    const std::vector<int> bearers = Bearers();
    if (bearers.empty()) return;
    LeafForm whole = species_.leaf;
    const float usual = LeafLength(MakeLeafTemplate(whole));
    const std::vector<SheetTemplate> sheets = Templates();
    const int stride =
        LeafStride(detail_, static_cast<size_t>(species_.leaves), sheets[1].triangles.size());
    // The same area of leaves at each level.
    const float scale =
        std::sqrt(MakeLeafTemplate(whole).area / sheets[1].area * static_cast<float>(stride));
    // Leaves hide half of the twigs; bare crowns show them all.
    const int bare = p_.season == Season::kWinter ? 2 : 1;
    const int twigs = bare * species_.leaves / species_.leaves_per_twig;
    const double fallen = p_.season == Season::kAutumn ? rng.Uniform(0.0, 0.5) : 0.0;
    int number = 0;
    for (int t = 0; t < twigs; ++t) {
      const size_t pick = static_cast<size_t>(t) * bearers.size() / static_cast<size_t>(twigs);
      const std::vector<Vec3f> path = TwigPath(bearers[pick], rng);
      if (detail_ == PlantDetail::kNear) wood.AddTwig(path, tip_m_);
      for (int k = 0; k < species_.leaves_per_twig; ++k) {
        SheetPlace place = LeafPlace(path, k, rng);
        const bool there = rng.Uniform() >= fallen && p_.season != Season::kWinter;
        const size_t form = static_cast<size_t>(rng.UniformInt(0, 2));
        place.length_m *= usual * scale;
        if (there && number % stride == 0) leaves.Add(sheets[form], place);
        ++number;
      }
    }
  }

  std::vector<Vec3f> TwigPath(int node, Rng& rng) const {
    const TreeNode& from = tree_.nodes()[static_cast<size_t>(node)];
    const Vec3f heading = tree_.Heading(node);
    Vec3f side{Draw(rng, -1, 1), Draw(rng, -1, 1), Draw(rng, -0.6, 1)};
    Vec3f way = (heading + (tree_.IsTip(node) ? 0.5f : 1.3f) * side).stableNormalized();
    const float length = species_.twig_m * Draw(rng, 0.55, 1.2);
    constexpr int kPieces = 4;
    std::vector<Vec3f> path{from.at};
    for (int k = 0; k < kPieces; ++k) {
      const Vec3f shake{Draw(rng, -1, 1), Draw(rng, -1, 1), Draw(rng, -1, 1)};
      way = (way + species_.twig_hang * Vec3f(0, 0, -0.9f) + 0.16f * shake).stableNormalized();
      path.push_back(path.back() + way * (length / kPieces));
      if (path.back().z() < 0.25f) path.back().z() = 0.25f;
    }
    return path;
  }

  SheetPlace LeafPlace(const std::vector<Vec3f>& path, int k, Rng& rng) const {
    const auto n = static_cast<float>(species_.leaves_per_twig);
    const float s = (static_cast<float>(k) + Draw(rng, 0.35, 0.98)) / n;
    const float f = s * static_cast<float>(path.size() - 1);
    const size_t i = std::min(path.size() - 2, static_cast<size_t>(f));
    const Vec3f along = (path[i + 1] - path[i]).stableNormalized();
    const float turn = 2.39996f * static_cast<float>(k) + Draw(rng, -0.6, 0.6);
    Vec3f x = along.cross(std::abs(along.z()) < 0.9f ? Vec3f::UnitZ() : Vec3f::UnitX());
    x.normalize();
    const Vec3f out = std::cos(turn) * x + std::sin(turn) * along.cross(x);
    const Vec3f shake{Draw(rng, -1, 1), Draw(rng, -1, 1), Draw(rng, -1, 1)};
    SheetPlace place;
    place.at = path[i] + (f - static_cast<float>(i)) * (path[i + 1] - path[i]);
    place.along = 0.6f * along + 0.8f * out + 0.25f * shake - Vec3f(0, 0, species_.leaf_hang);
    place.up = Vec3f(0, 0, 0.75f) + 0.45f * out + 0.5f * shake;
    place.length_m = Draw(rng, 0.62, 1.2);
    return place;
  }

  const BroadleafParams& p_;
  const BroadleafSpecies& species_;
  Rng root_;
  Rng shape_ = root_.Child("shape");
  PlantDetail detail_;
  float trunk_m_, tip_m_;
  Skeleton tree_;
  int trunk_nodes_ = 0;
  Vec3f trunk_top_ = Vec3f::Zero();
};

}  // namespace

Asset MakeBroadleafTree(const BroadleafParams& p) { return BroadleafGrower(p).Grow(); }

Asset SampleBroadleafTree(Rng& rng) {
  BroadleafParams p;
  p.species = static_cast<size_t>(rng.UniformInt(0, static_cast<int>(BroadleafTable().size()) - 1));
  const BroadleafSpecies& species = BroadleafTable()[p.species];
  p.height_m = Draw(rng, static_cast<double>(species.height_low_m),
                    static_cast<double>(species.height_high_m));
  const double season = rng.Uniform();
  p.season = season < 0.2    ? Season::kSpring
             : season < 0.62 ? Season::kSummer
             : season < 0.87 ? Season::kAutumn
                             : Season::kWinter;
  p.seed = rng.Seed();
  return MakeBroadleafTree(p);
}

}  // namespace parallax
