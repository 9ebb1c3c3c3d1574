// Conifers: a straight leader, whorls of boughs that shorten towards the top, side twigs clothed in
// needles.
#include <algorithm>
#include <cmath>

#include "worker/assets/nature/plant_detail.h"
#include "worker/assets/nature/tree_wood.h"
#include "worker/assets/nature/trees.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

using Path = std::vector<Vec3f>;

Vec3f PointOn(const Path& path, float s) {
  const float f = std::clamp(s, 0.0f, 1.0f) * static_cast<float>(path.size() - 1);
  const size_t i = std::min(path.size() - 2, static_cast<size_t>(f));
  return path[i] + (f - static_cast<float>(i)) * (path[i + 1] - path[i]);
}
Vec3f AlongPath(const Path& path, float s) {
  return (PointOn(path, s + 0.06f) - PointOn(path, s - 0.06f)).stableNormalized();
}
float LengthOf(const Path& path) {
  float length = 0;
  for (size_t i = 1; i < path.size(); ++i) length += (path[i] - path[i - 1]).norm();
  return length;
}

class ConiferGrower {
 public:
  explicit ConiferGrower(const ConiferParams& p)
      : p_(p),
        species_(ConiferTable()[p.species]),
        root_(SceneSeed{p.seed}, "conifer"),
        rng_(root_.Child("boughs")),
        detail_(CurrentDetail()),
        scale_(p.height_m / 10),
        wood_({.detail = detail_,
               .flare = 0.7f,
               .bark = Slot("bark", species_.bark),
               .twig_bark = Slot("twigs", {"ConiferBark"})},
              root_.Child("wood")),
        needles_(SheetSlot("needles", NeedleMaterials()), root_.Child("own")) {
    MakeTemplates();
  }

  Asset Grow() {
    GrowTrunk();
    GrowWhorls();
    AddSheets();
    AssetBuilder b(p_.seed);
    wood_.MoveTo(b);
    if (needles_.count() > 0) b.AddMesh(needles_.mesh(), Eigen::Affine3f::Identity());
    return b.Finish(Anchor::kGround);
  }

 private:
  bool Bare() const { return species_.sheds && p_.season == Season::kWinter; }

  std::vector<std::string> NeedleMaterials() const {
    if (!species_.sheds) return {"Needle"};
    return p_.season == Season::kAutumn ? std::vector<std::string>{"GoldenNeedle"}
                                        : std::vector<std::string>{"FreshNeedle"};
  }

  void MakeTemplates() {
    Rng rng = root_.Child("templates");
    const int level = static_cast<int>(detail_);
    constexpr int kTeeth[] = {5, 4, 3, 3}, kTuft[] = {18, 10, 8, 6}, kRosette[] = {10, 7, 6, 5};
    for (int k = 0; k < 4; ++k) {
      switch (species_.needles) {
        case NeedleKind::kSpray:
          templates_.push_back(MakeSprayTemplate(kTeeth[level] + (level == 0 ? k % 2 : 0), 0.34f,
                                                 Draw(rng, 0.1, 0.7)));
          break;
        case NeedleKind::kTuft:
          templates_.push_back(MakeTuftTemplate(kTuft[level], Draw(rng, 1.0, 1.3),
                                                level == 0 ? 0.075f : 0.14f, rng));
          break;
        default:
          templates_.push_back(
              MakeTuftTemplate(kRosette[level], 1.35f, level == 0 ? 0.13f : 0.24f, rng));
      }
    }
  }

  void GrowTrunk() {
    Rng rng = root_.Child("trunk");
    const float h = p_.height_m, radius = species_.trunk_radius * h;
    const bool pine = species_.needles == NeedleKind::kTuft;
    const float wander = pine ? 0.05f : 0.012f;
    Vec3f way = Vec3f{wander * Draw(rng, -1, 1), wander * Draw(rng, -1, 1), 1}.normalized();
    const int pieces = std::max(8, static_cast<int>(h / 0.5f));
    std::vector<LimbRing> rings{{Vec3f::Zero(), radius}};
    for (int k = 1; k <= pieces; ++k) {
      const Vec3f push{Draw(rng, -1, 1), Draw(rng, -1, 1), 0};
      way = (way + wander * push + Vec3f(0, 0, 0.1f)).normalized();
      const float t = static_cast<float>(k) / static_cast<float>(pieces);
      rings.push_back({rings.back().at + way * (h / static_cast<float>(pieces)),
                       radius * (1 - 0.96f * std::pow(t, 0.9f))});
    }
    for (const LimbRing& ring : rings) trunk_.push_back(ring.at);
    wood_.AddTrunk(rings);
  }

  void GrowWhorls() {
    const float h = p_.height_m, top = trunk_.back().z();
    float z = species_.crown_base * h * Draw(rng_, 0.8, 1.3);
    DeadStubs(z);
    const float low = z;
    float turn = 0;
    while (z < top - 0.12f) {
      const float rise = (z - low) / (top - low);
      const int boughs = std::max(3, species_.boughs + rng_.UniformInt(-1, 1));
      turn += Draw(rng_, 0.3, 1.1);
      for (int k = 0; k < boughs; ++k) {
        const float a = turn + 2 * kPi * static_cast<float>(k) / static_cast<float>(boughs) +
                        Draw(rng_, -0.3, 0.3);
        const bool lost =
            rng_.Bernoulli(static_cast<double>(species_.lost) * (rise < 0.25f ? 2 : 1));
        const float up = z + scale_ * species_.whorl_m * Draw(rng_, -0.3, 0.3);
        if (!lost) GrowBough(std::min(up, top - 0.05f), a, rise);
      }
      z += scale_ * species_.whorl_m * Lerp(1.0f, 0.5f, rise) * Draw(rng_, 0.75, 1.25);
    }
    // The leader's own end.
    Clothe({PointOn(trunk_, 0.965f), trunk_.back() + Vec3f(0, 0, 0.08f)}, 0.0f);
  }

  // Broken dry branches on the bare part of the trunk.
  void DeadStubs(float below_z) {
    const int count = static_cast<int>(below_z / 0.5f);
    for (int k = 0; k < count; ++k) {
      const float z = Draw(rng_, 0.35, 1.0) * below_z, a = Draw(rng_, 0, 2 * kPi),
                  length = Draw(rng_, 0.08, 0.5);
      const Vec3f at = PointOn(trunk_, z / p_.height_m);
      const Vec3f out(std::cos(a), std::sin(a), Draw(rng_, -0.3, 0.1));
      if (detail_ == PlantDetail::kFar || detail_ == PlantDetail::kShell) continue;
      wood_.AddBranch(
          {{at, 0.016f}, {at + 0.5f * length * out, 0.011f}, {at + length * out, 0.006f}});
    }
  }

  // Grows a bough at height z towards azimuth a; `rise` is its place in the crown, 0 to 1.
  void GrowBough(float z, float a, float rise) {
    const float shape = std::pow(1 - rise, species_.roundness);
    // The oldest, shaded boughs are a little shorter than those above them.
    const float shaded = 0.7f + 0.3f * Smooth01(rise / 0.18f);
    const float length = std::max(0.16f, species_.crown_radius * p_.height_m * shape * shaded *
                                             Draw(rng_, 1 - 3.2 * species_.lost, 1.12));
    const float loose = species_.needles == NeedleKind::kTuft ? 2.4f : 1.0f;
    const float lift =
        Lerp(species_.rise_low, species_.rise_high, rise) + loose * Draw(rng_, -0.12, 0.12);
    const float sag = species_.sag * Draw(rng_, 0.6, 1.4) * (1 - 0.7f * rise);
    const float bend = loose * Draw(rng_, -0.25, 0.25);
    const Vec3f from = PointOn(trunk_, z / trunk_.back().z());
    Path path;
    constexpr int kPieces = 6;
    for (int k = 0; k <= kPieces; ++k) {
      const float s = static_cast<float>(k) / kPieces;
      const float turn = a + bend * s * s;
      const Vec3f out(std::cos(turn), std::sin(turn), 0);
      const float drop = -sag * std::sin(0.8f * kPi * s) + 0.5f * sag * s * s * s;
      path.push_back(from +
                     length * (s * std::cos(lift) * out + Vec3f(0, 0, s * std::sin(lift) + drop)));
      path.back().z() = std::max(path.back().z(), 0.12f + 0.02f * static_cast<float>(k));
    }
    std::vector<LimbRing> rings;
    const float radius = 0.006f + 0.0115f * length;
    for (int k = 0; k <= kPieces; ++k) {
      const float s = static_cast<float>(k) / kPieces;
      rings.push_back({path[static_cast<size_t>(k)], radius * (1 - 0.85f * s)});
    }
    if (detail_ == PlantDetail::kNear || (detail_ != PlantDetail::kShell && length > 0.8f)) {
      wood_.AddBranch(rings);
    }
    SideTwigs(path, length);
    Clothe(path, species_.needles == NeedleKind::kSpray ? 0.25f : 0.6f);
  }

  // Twigs leave a bough by turns to both sides, longest a third out, and hang.
  void SideTwigs(const Path& bough, float length) {
    const bool tufts = species_.needles == NeedleKind::kTuft;
    const float apart = scale_ * (tufts ? 0.12f : 0.1f);
    const int count = static_cast<int>(length / apart);
    for (int k = 0; k < count; ++k) {
      for (const float side : {-1.0f, 1.0f}) {
        const float s = (tufts ? 0.3f : 0.12f) +
                        (tufts ? 0.7f : 0.86f) * (static_cast<float>(k) + Draw(rng_, 0.1, 0.9)) /
                            static_cast<float>(count);
        const float reach = length * (tufts ? 0.3f : 0.42f) * (1.05f - s) * Smooth01(s / 0.22f) *
                                Draw(rng_, 0.6, 1.15) +
                            0.08f;
        const Vec3f ahead = AlongPath(bough, s), at = PointOn(bough, s);
        const Vec3f across = ahead.cross(Vec3f::UnitZ()).stableNormalized();
        const Vec3f shake{Draw(rng_, -1, 1), Draw(rng_, -1, 1), Draw(rng_, -1, 1)};
        const float lift = tufts ? 0.35f : 0.0f;
        const Vec3f way =
            (0.75f * ahead + 0.8f * side * across + lift * Vec3f::UnitZ() + 0.2f * shake)
                .stableNormalized();
        const Vec3f hang(0, 0, -species_.hang * reach);
        const Path twig{at, at + 0.5f * reach * way + 0.25f * hang, at + reach * way + hang};
        if (detail_ == PlantDetail::kNear && reach > 0.25f * scale_) wood_.AddTwig(twig, 0.0045f);
        Clothe(twig, tufts ? 0.45f : 0.05f);
      }
    }
  }

  // Needles along a path from `start` of it on.
  void Clothe(const Path& path, float start) {
    if (Bare()) return;
    const float length = LengthOf(path);
    const float apart = scale_ * species_.needle_m *
                        (species_.needles == NeedleKind::kSpray  ? 0.44f
                         : species_.needles == NeedleKind::kTuft ? 0.34f
                                                                 : 0.72f);
    const int count = std::max(1, static_cast<int>((1 - start) * length / apart + 0.5f));
    for (int k = 0; k < count; ++k) {
      const float s = start + (1 - start) * (static_cast<float>(k) + Draw(rng_, 0.5, 1.0)) /
                                  static_cast<float>(count);
      AddNeedles(PointOn(path, s), AlongPath(path, s));
    }
  }

  void AddNeedles(const Vec3f& at, const Vec3f& along) {
    const Vec3f shake{Draw(rng_, -1, 1), Draw(rng_, -1, 1), Draw(rng_, -1, 1)};
    const int form = rng_.UniformInt(0, 3);
    const float size = scale_ * species_.needle_m * Draw(rng_, 0.75, 1.2);
    SheetPlace place{.at = at, .along = along + 0.3f * shake, .length_m = size};
    if (species_.needles != NeedleKind::kSpray) place.along += Vec3f(0, 0, 0.35f) + 0.5f * shake;
    place.up = Vec3f(0, 0, 1) + 0.45f * shake;
    places_.push_back({static_cast<size_t>(form), along, place});
  }

  // Adds as many sheets as the level of detail shows.
  void AddSheets() {
    const auto stride =
        static_cast<size_t>(LeafStride(detail_, places_.size(), templates_[0].triangles.size()));
    for (size_t i = 0; i < places_.size(); i += stride) {
      SheetPlace place = places_[i].place;
      place.length_m *= std::sqrt(static_cast<float>(stride));
      // A spray lies about its place, a tuft opens from it.
      if (species_.needles == NeedleKind::kSpray)
        place.at -= 0.55f * place.length_m * places_[i].along;
      needles_.Add(templates_[places_[i].form], place);
    }
  }

  const ConiferParams& p_;
  const ConiferSpecies& species_;
  Rng root_, rng_;
  PlantDetail detail_;
  float scale_;  // Boughs and needles of larger trees are larger, not more.
  WoodMaker wood_;
  SheetGrower needles_;
  std::vector<SheetTemplate> templates_;
  Path trunk_;
  struct Needles {
    size_t form;  // Index into templates_.
    Vec3f along;
    SheetPlace place;
  };
  std::vector<Needles> places_;
};

}  // namespace

Asset MakeConifer(const ConiferParams& p) { return ConiferGrower(p).Grow(); }

Asset SampleConifer(Rng& rng) {
  ConiferParams p;
  p.species = static_cast<size_t>(rng.UniformInt(0, static_cast<int>(ConiferTable().size()) - 1));
  const ConiferSpecies& species = ConiferTable()[p.species];
  p.height_m = Draw(rng, static_cast<double>(species.height_low_m),
                    static_cast<double>(species.height_high_m));
  const double season = rng.Uniform();
  p.season = season < 0.25   ? Season::kSpring
             : season < 0.65 ? Season::kSummer
             : season < 0.88 ? Season::kAutumn
                             : Season::kWinter;
  p.seed = rng.Seed();
  return MakeConifer(p);
}

}  // namespace parallax
