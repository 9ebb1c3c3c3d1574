// Family `carpet`: cut and looped pile, patterned rugs.
#include <array>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

constexpr std::array<uint32_t, 16> kYarns = {
    0xcfc4b2, 0xb5a68f, 0x8f8373, 0x6a625a, 0x45423f, 0xd9d4c8, 0x7f8a8f, 0x4a5a6b,
    0x2c3a52, 0x7a3a34, 0xa5553f, 0xb98f4f, 0x5a6b52, 0x8a5f6b, 0x37545a, 0xc9a78f};

// Tufts stand in jittered rows; each has its own tone and height.
struct Pile {
  float tuft_m = 0.004f;
  float strands = 0.2f;  // How much the single yarns show.
  uint32_t seed = 0;

  // About [0, 1]: 1 on top of a tuft. `id` is the tuft's.
  template <typename Real>
  Real At(const PlaneOf8<Real>& plane, Float8 w, Bits8* id) const {
    const float mean = 0.55f;
    const Float8 fade = Fade(1.3f * tuft_m, w);
    const auto cell = noise::Cells2(plane.u / tuft_m, plane.v / tuft_m, seed, 0.85f);
    *id = fade > 0 ? cell.id : Bits8{} + 0x80808080u;
    Real top =
        Saturate(1.0f - 1.5f * cell.f1 * cell.f1) * SmoothStep(0.0f, 0.35f, cell.f2 - cell.f1);
    // Strands: a tuft is many yarns that lean this way and that.
    const Real lean =
        noise::Gradient2(plane.u / (2.5f * tuft_m), plane.v / (2.5f * tuft_m), seed + 1);
    const Real a = plane.u * 4.0f / tuft_m + 5.0f * lean, b = plane.v * 4.0f / tuft_m - 5.0f * lean;
    top += strands * Fade(0.3f * tuft_m, w) *
           (noise::Gradient2(a, 0.3f * b, seed + 2) + noise::Gradient2(0.3f * a, b, seed + 3));
    return mean + fade * (top - mean);
  }
};

class Carpet final : public Carved<Carpet> {
 public:
  Carpet(Rng& rng, double tuft_low_mm, double tuft_high_mm) {
    yarn_ = VaryColor(rng, SrgbColor(rng.Pick(kYarns)), 0.12, 0.05);
    second_ = VaryColor(rng, yarn_, Draw(rng, 0.05, 0.5), 0.05);
    pile_ = {Draw(rng, tuft_low_mm, tuft_high_mm) * 1e-3f, tuft_low_mm > 5 ? 0.7f : 0.2f,
             DrawSeed(rng)};
    height_m_ = 0.35f * pile_.tuft_m;
    trodden_ = Draw(rng, 0.04, 0.12);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const PlanePoint8 plane = OnPlane(point);
    Bits8 id;
    const Float8 top = pile_.At(plane, w, &id);
    const Float8 fade = Fade(1.3f * pile_.tuft_m, w);
    const Float8 mottle = Fbm3(point.texture_m, 0.03f, 3, w, pile_.seed + 3, 0.6f);
    const Float8 trodden = Fbm3(point.texture_m, 0.5f, 3, w, pile_.seed + 4);
    const Float8 mix = Saturate(0.5f + fade * (UnitByte(id, 0) - 0.5f) + 0.4f * mottle);
    return {.base_color =
                Albedo(Mix(yarn_, second_, mix) *
                       ((0.55f + 0.75f * top) * (1.0f + trodden_ * trodden + 0.06f * mottle))),
            .roughness = Splat(0.95f),
            .specular = Splat(0.15f),
            .sheen = Splat(0.3f)};
  }
  auto HeightOf(const auto& point) const {
    Bits8 id;
    return height_m_ * pile_.At(OnPlane(point), point.footprint_m, &id);
  }

 private:
  Vec3f yarn_, second_;
  Pile pile_;
  float height_m_, trodden_;
};

// A knotted pattern in steps of knots: repeats that are mirrored both ways, with bands between, as
// kilims have.
class RugPattern final : public PointMaterial {
 public:
  explicit RugPattern(Rng& rng) {
    const int dyes = static_cast<int>(dyes_.size());
    for (Vec3f& dye : dyes_) dye = VaryColor(rng, SrgbColor(rng.Pick(kYarns)), 0.12, 0.06);
    knot_m_ = Draw(rng, 0.004, 0.009);
    // Half of a mirrored motif, drawn in knots: stepped diamonds, bars, and small stars.
    for (uint8_t& knot : motif_) knot = 0;
    const int shapes = rng.UniformInt(4, 8);
    for (int k = 0; k < shapes; ++k) {
      const int kind = rng.UniformInt(0, 3);
      const int cx = rng.UniformInt(0, 1) * (kSide - 1),
                cy = rng.UniformInt(0, 2) * (kSide - 1) / 2;
      const int outer = rng.UniformInt(3, kSide - 2), inner = outer - rng.UniformInt(1, 5);
      const int step = rng.UniformInt(1, 3);
      const auto dye = static_cast<uint8_t>(rng.UniformInt(0, dyes - 1));
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          const int dx = std::abs(x - cx) / step * step, dy = std::abs(y - cy) / step * step;
          int d = dx + dy;                                                   // Diamond.
          if (kind == 1) d = std::max(dx, dy);                               // Square.
          if (kind == 2) d = std::min(dx, dy) * 3;                           // Cross.
          if (kind == 3) d = std::max(std::max(dx, dy), (dx + dy) * 2 / 3);  // Octagon.
          if (d <= outer && d > inner) motif_[static_cast<size_t>(y * kSide + x)] = dye;
        }
      }
    }
    for (size_t further = 0; further < dyes_.size(); ++further) {
      means_[further].setZero();
      for (uint8_t knot : motif_)
        means_[further] +=
            dyes_[(knot + further) % dyes_.size()] / static_cast<float>(motif_.size());
    }
    large_ = rng.UniformInt(5, 9);
    abrash_ = Draw(rng, 0.05, 0.18);
    seed_ = DrawSeed(rng);
    border_m_ = rng.Bernoulli(0.75) ? Draw(rng, 0.06, 0.2) : 0.0f;
  }
  SurfaceSample EvaluatePoint(const SurfacePoint& point) const override {
    const float w = point.footprint_m;
    const PlanePoint plane = OnPlane(point);
    const float x = plane.u / knot_m_, y = plane.v / knot_m_;
    const int i = noise::FloorInt(x), j = noise::FloorInt(y);
    const float fine = Fade(1.5f * knot_m_, w);
    Vec3f color = Bordered(point.uv, x, y, w);
    if (fine > 0) {
      color *= 1.0f + 0.3f * fine * (UnitByte(Hash(i, j, seed_), 0) - 0.5f) +
               0.35f * fine * (Knot(x, y) - 0.6f);
    }
    // Abrash: each batch of dye came out a little different, in bands across the rug.
    const float band =
        noise::Gradient2(0.4f * plane.u, plane.v * 14.0f, seed_ + 2) * Fade(0.07f, w);
    const float worn = Fbm3(point.texture_m, 0.3f, 4, w, seed_ + 4);
    return {.base_color = Albedo(color * (1.0f + abrash_ * band + 0.08f * worn)),
            .roughness = 0.92f,
            .specular = 0.2f,
            .sheen = 0.3f};
  }
  float HeightOfPoint(const SurfacePoint& point) const override {
    const float fade = Fade(1.5f * knot_m_, point.footprint_m);
    if (fade <= 0) return 0;
    const PlanePoint plane = OnPlane(point);
    return 0.22f * knot_m_ * fade * Knot(plane.u / knot_m_, plane.v / knot_m_);
  }

 private:
  static constexpr int kSide = 17;

  static float Knot(float x, float y) {
    const float a = 2.0f * noise::Fract(x) - 1.0f, b = 2.0f * noise::Fract(y) - 1.0f;
    return (1.0f - a * a) * (1.0f - b * b * b * b);
  }
  size_t MotifAt(int i, int j) const {
    const auto fold = [](int k) {
      k = ((k % (2 * kSide)) + 2 * kSide) % (2 * kSide);
      return k < kSide ? k : 2 * kSide - 1 - k;
    };
    return motif_[static_cast<size_t>(fold(j) * kSide + fold(i))];
  }
  const Vec3f& Dye(int i, int j, size_t further) const {
    return dyes_[(MotifAt(i, j) + further) % dyes_.size()];
  }
  // The motif again, `large_` times as large, says by how many dyes the small one is shifted: what
  // one sees across the room.
  Vec3f Field(float x, float y, float w) const {
    const auto size = static_cast<float>(large_);
    const auto at = [&](int i, int j) { return Repeat(x, y, w, MotifAt(i, j)); };
    const float u = x / size, v = y / size;
    if (w < 0.35f * size * knot_m_) return at(noise::FloorInt(u), noise::FloorInt(v));
    const float fx = std::floor(u - 0.5f), fy = std::floor(v - 0.5f);
    const float tx = u - 0.5f - fx, ty = v - 0.5f - fy;
    const int i = static_cast<int>(fx), j = static_cast<int>(fy);
    const Vec3f near =
        Mix(Mix(at(i, j), at(i + 1, j), tx), Mix(at(i, j + 1), at(i + 1, j + 1), tx), ty);
    return Mix(means_[0], near, Fade(4.0f * size * knot_m_, w));
  }
  // The small motif in dyes so many further, its mean where knots are smaller than the footprint.
  Vec3f Repeat(float x, float y, float w, size_t further) const {
    const float fade = Fade(4.0f * knot_m_, w);
    if (fade <= 0) return means_[further];
    return Mix(means_[further], Blend(x, y, w / knot_m_, further), fade);
  }
  // A rug says in uv how far its edge is, in metres: there the pattern is framed by a plain edge, a
  // guard stripe, a border in other dyes and another stripe. Elsewhere uv is 0.
  Vec3f Bordered(const Vec2f& uv, float x, float y, float w) const {
    const Vec3f field = Field(x, y, w);
    if (border_m_ <= 0 || uv == Vec2f::Zero()) return field;
    const float d = uv.minCoeff();
    const float stripe = 3 * knot_m_, edge = 5 * knot_m_;
    if (d > edge + 2 * stripe + border_m_ + w) return field;
    // Dyes one further: the border's repeat is the field's, in other colours and half as large.
    const Vec3f border = Repeat(2 * x + 7, 2 * y + 7, 2 * w, 1);
    Vec3f color = dyes_[1];
    color = Mix(color, dyes_[2], Edge(d - edge, 0, w));
    color = Mix(color, border, Edge(d - edge - stripe, 0, w));
    color = Mix(color, dyes_[2], Edge(d - edge - stripe - border_m_, 0, w));
    color = Mix(color, field, Edge(d - edge - 2 * stripe - border_m_, 0, w));
    return Mix(field, color, Fade(4.0f * (edge + stripe + border_m_), w));
  }
  // The knot under the query, or from half a knot's footprint on a tent over its neighbours.
  Vec3f Blend(float x, float y, float w_knots, size_t further) const {
    if (w_knots < 0.35f) return Dye(noise::FloorInt(x), noise::FloorInt(y), further);
    const float fx = std::floor(x - 0.5f), fy = std::floor(y - 0.5f);
    const float tx = x - 0.5f - fx, ty = y - 0.5f - fy;
    const int i = static_cast<int>(fx), j = static_cast<int>(fy);
    return Mix(Mix(Dye(i, j, further), Dye(i + 1, j, further), tx),
               Mix(Dye(i, j + 1, further), Dye(i + 1, j + 1, further), tx), ty);
  }

  std::array<Vec3f, 5> dyes_;
  std::array<uint8_t, kSide * kSide> motif_;
  std::array<Vec3f, 5> means_;  // Mean colours of the motif, by the shift of its dyes.
  float knot_m_, abrash_, border_m_ = 0;
  int large_;
  uint32_t seed_;
};

}  // namespace

void AddCarpetMaterials(MaterialList& list) {
  const MaterialTags floor = {.diffuse = true, .floor = true};
  list.push_back(Entry<Carpet>("Carpet", "carpet", floor, 2.5, 5.0));
  list.push_back(Entry<RugPattern>("RugPattern", "carpet", floor));
  list.push_back(Entry<Carpet>("ShagCarpet", "carpet", {.diffuse = true}, 7.0, 14.0));
}

}  // namespace parallax
