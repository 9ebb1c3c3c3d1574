// Family `fabric`: woven, twilled, knitted and piled cloth. Threads are real relief; slubs and
// streaks along the threads keep cloth from looking like plain paint from across the room.
#include <array>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

// Colours that furnishing cloth comes in: naturals first, then dyes.
constexpr std::array<uint32_t, 26> kDyes = {
    0xd9cfbf, 0xc7b8a1, 0xa99b86, 0x8c8072, 0x6c655d, 0x4a4744, 0x2e2e30, 0xe6e0d4, 0xbfc3c4,
    0x7f8a91, 0x3c4a5a, 0x24324a, 0x5b7a8c, 0x8fb0b5, 0x4f7a6a, 0x7c8a5a, 0x3f5140, 0xb7a24a,
    0xd2a03c, 0xb5653a, 0x9b3f34, 0x6e2a33, 0xb97f86, 0x7a5a78, 0x54406a, 0x2f6b6b};

Vec3f DrawDye(Rng& rng) { return VaryColor(rng, SrgbColor(rng.Pick(kDyes)), 0.12, 0.06); }

// ---- Weaves

enum class Weave { kPlain, kTwill, kBasket };

struct WovenStyle {
  Weave weave = Weave::kPlain;
  double thread_low_mm = 0.5, thread_high_mm = 1.4;
  double slub = 0.5;  // Uneven thread: linen much, cotton little.
  // How far the weft's colour may stand from the warp's, beyond one dye.
  double thread_contrast = 0;
  bool two_dyes = false;
  double sheen = 0.3;
};

// The visible thread at points of a weave.
template <typename Real>
struct Thread {
  Mask8 warp;   // Runs along v; else weft, along u.
  Int8 index;   // Which one.
  Real height;  // [0, 1]: over the ground of the cloth.
};

template <typename Real>
Thread<Real> ThreadAt(Weave weave, const Real& u, const Real& v) {
  const Int8 i = noise::FloorInt(u), j = noise::FloorInt(v);
  const Real x = u - ToFloat(i) - 0.5f, y = v - ToFloat(j) - 0.5f;
  Mask8 warp_up;
  Real run_u, run_v;  // Place within a thread's float, -0.5..0.5: it dives at both ends.
  if (weave == Weave::kPlain) {
    warp_up = ((i + j) & 1) == 0;
    run_u = x;
    run_v = y;
  } else if (weave == Weave::kTwill) {
    const Int8 k = (i + j) & 3;
    warp_up = k < 2;
    // A float covers two cells; is this the first of them?
    const Mask8 first = (k & 1) == 0;
    run_v = Select(first, y - 0.5f, y + 0.5f) * 0.5f;
    run_u = Select(first, x - 0.5f, x + 0.5f) * 0.5f;
  } else {
    warp_up = (((i >> 1) + (j >> 1)) & 1) == 0;
    run_u = Select((i & 1) == 0, x - 0.5f, x + 0.5f) * 0.5f;
    run_v = Select((j & 1) == 0, y - 0.5f, y + 0.5f) * 0.5f;
  }
  const Real across = Select(warp_up, x, y);
  const Real along = Select(warp_up, run_v, run_u);
  // Both factors are 0 at the ends, so that the relief is continuous from thread to thread.
  const Real bent = 4.0f * along * along;
  return {warp_up, warp_up ? i : j, (1.0f - 4.0f * across * across) * (1.0f - bent * bent)};
}

class WovenFabric : public Carved<WovenFabric> {
 public:
  WovenFabric(Rng& rng, const WovenStyle& style) : style_(style) {
    pitch_m_ = Draw(rng, style.thread_low_mm, style.thread_high_mm) * 1e-3f;
    warp_ = DrawDye(rng);
    weft_ = style.two_dyes
                ? DrawDye(rng)
                : VaryColor(rng, warp_, style.thread_contrast, 0.3 * style.thread_contrast);
    slub_ = Float(style.slub) * Draw(rng, 0.6, 1.2);
    uneven_ = Draw(rng, 0.06, 0.16);
    roughness_ = Draw(rng, 0.75, 0.95);
    sheen_ = Float(style.sheen) * Draw(rng, 0.6, 1.4);
    seed_ = DrawSeed(rng);
  }

  SurfaceSample8 Evaluate(const SurfacePoint8& point) const final {
    const PlanePoint8 plane = OnPlane(point);
    const Float8 w = point.footprint_m;
    const Float8 fade = Fade(2.0f * pitch_m_, w);
    SurfaceSample8 out;
    const Vec3x8 warp = DyeOf(true, plane, w), weft = DyeOf(false, plane, w);
    Vec3x8 color = Mix(warp, weft, Splat(0.5f));
    if (Any(fade > 0)) {
      const Thread thread = ThreadAt(style_.weave, plane.u / pitch_m_, plane.v / pitch_m_);
      const Float8 own =
          1.0f +
          uneven_ * (UnitByte(Hash(thread.index, seed_ + (Bits8)(thread.warp & 1)), 0) - 0.5f);
      const Vec3x8 near = Select(thread.warp, warp, weft) * (own * (0.62f + 0.55f * thread.height));
      color = Mix(color, near, fade);
    }
    // Slubs: stretches of thicker, lighter thread, long along their thread. Then wear, broad and
    // faint.
    color *= 1.0f + Slubs(plane, w);
    color *= 1.0f + 0.07f * noise::Fbm3(InPlane(plane), 0.11f, 2, w, seed_ + 9);
    out.base_color = Albedo(color);
    out.roughness = Splat(roughness_);
    out.specular = Splat(0.25f);
    out.sheen = Splat(noise::Saturate(sheen_));
    return out;
  }

  auto HeightOf(const auto& point) const {
    const auto plane = OnPlane(point);
    const Float8 fade = Fade(2.0f * pitch_m_, point.footprint_m);
    auto height = 0.08f * pitch_m_ * Slubs(plane, point.footprint_m);
    if (Any(fade > 0)) {
      height += 0.3f * pitch_m_ * fade *
                ThreadAt(style_.weave, plane.u / pitch_m_, plane.v / pitch_m_).height;
    }
    return height;
  }

 protected:
  // The colour of the threads of one direction here.
  virtual Vec3x8 DyeOf(bool warp, const PlanePoint8& plane, Float8 footprint_m) const {
    (void)plane, (void)footprint_m;
    return warp ? warp_ : weft_;
  }

  Vec3f warp_, weft_;
  float pitch_m_;

 private:
  template <typename Real>
  Real Slubs(const PlaneOf8<Real>& plane, Float8 w) const {
    const Float8 thin = Fade(3.0f * pitch_m_, w), thick = Fade(0.009f, w);
    Real sum = Splat(0);
    if (Any(thin > 0)) {
      const float k = 0.35f / pitch_m_;
      sum += 0.22f * thin *
             (Gradient2(plane.u * 25.0f, plane.v * k, seed_ + 2) +
              Gradient2(plane.u * k, plane.v * 25.0f, seed_ + 3));
    }
    if (Any(thick > 0)) {
      sum += 0.16f * thick *
             (Gradient2(plane.u * 9.0f, plane.v * 160.0f, seed_ + 4) +
              Gradient2(plane.u * 160.0f, plane.v * 9.0f, seed_ + 5));
    }
    return slub_ * sum;
  }

  WovenStyle style_;
  float slub_, uneven_, roughness_, sheen_;
};

// Bands of colour: along one direction (stripes) or both (tartan), in a sequence that repeats and
// mirrors.
class BandedFabric final : public WovenFabric {
 public:
  BandedFabric(Rng& rng, const WovenStyle& style, bool both)
      : WovenFabric(rng, style), both_(both) {
    const int dyes = rng.UniformInt(2, 4);
    std::array<Vec3f, 4> palette;
    for (int i = 0; i < dyes; ++i) palette[static_cast<size_t>(i)] = DrawDye(rng);
    bands_ = rng.UniformInt(3, static_cast<int>(kMaxBands));
    float at = 0;
    int previous = -1;
    for (int i = 0; i < bands_; ++i) {
      int dye = rng.UniformInt(0, dyes - 1);
      if (dye == previous) dye = (dye + 1) % dyes;
      previous = dye;
      at += rng.Bernoulli(0.4) ? Draw(rng, 0.003, 0.008) : Draw(rng, 0.010, 0.045);
      ends_m_[static_cast<size_t>(i)] = at;
      colors_[static_cast<size_t>(i)] = palette[static_cast<size_t>(dye)];
    }
    mean_.setZero();
    for (int i = 0; i < bands_; ++i) {
      const auto k = static_cast<size_t>(i);
      mean_ += colors_[k] * ((ends_m_[k] - (i > 0 ? ends_m_[k - 1] : 0.0f)) / at);
    }
  }

 private:
  static constexpr size_t kMaxBands = 7;

  Vec3x8 DyeOf(bool warp, const PlanePoint8& plane, Float8 w) const override {
    if (!warp && !both_) return Band(plane.u, w);  // Weft takes the warp's bands: solid stripes.
    return Band(warp ? plane.u : plane.v, w);
  }
  Vec3x8 Band(Float8 x, Float8 w) const {
    const float period = ends_m_[static_cast<size_t>(bands_ - 1)];
    const Float8 fade = Fade(period * 0.5f, w);
    if (!Any(fade > 0)) return mean_;
    // Mirrored, so that neighbouring repeats meet in one colour.
    const Float8 t = noise::Fract(x / (2.0f * period)) * 2.0f;
    const Float8 place = (t < 1.0f ? t : 2.0f - t) * period;
    Vec3x8 color = colors_[0];
    for (int i = 0; i + 1 < bands_; ++i) {
      const auto k = static_cast<size_t>(i);
      color = Mix(color, colors_[k + 1], Edge(place - ends_m_[k], 0.5f * pitch_m_, 1.5f * w));
    }
    return Mix(mean_, color, fade);
  }

  bool both_;
  int bands_;
  std::array<float, kMaxBands> ends_m_;
  std::array<Vec3f, kMaxBands> colors_;
  Vec3f mean_;
};

// Indigo warp over white weft, worn pale in broad patches.
class Denim final : public WovenFabric {
 public:
  explicit Denim(Rng& rng)
      : WovenFabric(rng, {.weave = Weave::kTwill,
                          .thread_low_mm = 0.6,
                          .thread_high_mm = 0.9,
                          .slub = 0.9,
                          .sheen = 0.15}) {
    warp_ = PickColor(rng, {0x2c3d5c, 0x3b5379, 0x22304a, 0x5b769b, 0x2b2f38}, 0.1, 0.04);
    weft_ = Mix(warp_, SrgbColor(0xcfd3d6), Draw(rng, 0.25, 0.6));
    wear_ = Draw(rng, 0.05, 0.35);
  }

 private:
  Vec3x8 DyeOf(bool warp, const PlanePoint8& plane, Float8 w) const override {
    const Float8 worn =
        wear_ * SmoothStep(-0.1f, 0.8f, noise::Fbm3(InPlane(plane), 0.16f, 3, w, seed_ + 20));
    return Mix(warp ? warp_ : weft_, weft_, worn);
  }
  float wear_;
};

// ---- Knits

// Stocking stitch: columns of V, each V two leaning loops; cables are columns that swell.
class KnitFabric final : public Carved<KnitFabric> {
 public:
  explicit KnitFabric(Rng& rng) {
    width_m_ = Draw(rng, 0.003, 0.009);
    height_m_ = width_m_ * Draw(rng, 0.6, 0.8);
    yarn_ = DrawDye(rng);
    second_ = rng.Bernoulli(0.35) ? DrawDye(rng) : yarn_;
    rows_ = rng.UniformInt(4, 14);
    melange_ = Draw(rng, 0.05, 0.22);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const PlanePoint8 plane = OnPlane(point);
    const Float8 w = point.footprint_m;
    const Float8 fade = Fade(width_m_, w);
    const auto stitch = At(plane);
    const Int8 band = stitch.row >= 0 ? stitch.row / rows_ : ~(~stitch.row / rows_);
    Vec3x8 color = Mix(Mix(yarn_, second_, 0.5f), Select((band & 1) != 0, second_, yarn_),
                       Fade(2.0f * static_cast<float>(rows_) * height_m_, w));
    color *= 1.0f + fade * (0.6f * (stitch.height - 0.6f) +
                            0.15f * (UnitByte(Hash(stitch.column, stitch.row, seed_), 0) - 0.5f));
    color *= 1.0f + melange_ * noise::Fbm3(Vec3x8(plane.u, plane.v * 3.0f, Splat(0)), 0.012f, 3, w,
                                           seed_ + 1);
    return {.base_color = Albedo(color),
            .roughness = Splat(0.92f),
            .specular = Splat(0.2f),
            .sheen = Splat(0.45f)};
  }
  auto HeightOf(const auto& point) const {
    const auto plane = OnPlane(point);
    const Float8 w = point.footprint_m;
    const auto fibre = noise::Fbm3(InPlane(plane), 0.0015f, 2, w, seed_ + 2);
    return 0.16f * width_m_ * Fade(width_m_, w) * At(plane).height + 3e-5f * fibre;
  }

 private:
  template <typename Real>
  struct Stitch {
    Int8 column, row;
    Real height;  // [0, 1]
  };
  template <typename Real>
  Stitch<Real> At(const PlaneOf8<Real>& plane) const {
    const Real s = plane.u / width_m_;
    const Int8 column = noise::FloorInt(s);
    const Real x = s - ToFloat(column) - 0.5f;  // -0.5..0.5, the V's axis at 0.
    const Real lean = 0.9f * Abs(x);
    const Real t = plane.v / height_m_ - lean;
    const Int8 row = noise::FloorInt(t);
    const Real y = t - ToFloat(row) - 0.5f;
    // A loop is an arch across its lean and rounds off towards the axis and the column's edge.
    const Real side = 4.0f * Abs(x) - 1.0f;
    return {column, row, (1.0f - 4.0f * y * y) * (1.0f - 0.85f * side * side)};
  }

  float width_m_, height_m_, melange_;
  Vec3f yarn_, second_;
  int rows_;
};

// ---- Pile

// Short pile: hardly any relief, but the nap lies this way and that.
class VelvetFabric final : public Carved<VelvetFabric> {
 public:
  explicit VelvetFabric(Rng& rng) {
    static constexpr std::array<uint32_t, 12> kJewels = {0x1f4a3f, 0x18385c, 0x5a1f33, 0x6b2a54,
                                                         0x8c6a2f, 0x2f5d62, 0x4a2a20, 0x3a3a44,
                                                         0x8d8a86, 0xb08d84, 0x224b2c, 0x6a1b1f};
    pile_ = VaryColor(rng, SrgbColor(rng.Pick(kJewels)), 0.15, 0.06);
    crush_ = Draw(rng, 0.12, 0.45);
    patch_m_ = Draw(rng, 0.05, 0.16);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Vec3x8& p = point.texture_m;
    const Float8 w = point.footprint_m;
    const Float8 warp = 0.4f * Gradient3(p / patch_m_, seed_);
    const Float8 nap =
        noise::Fbm3(p + Vec3x8::All(warp * patch_m_), patch_m_, 4, w, seed_ + 1, 0.6f);
    const Float8 grain = 0.12f * Fade(1e-3f, w) * Gradient3(p * 1000.0f, seed_ + 9);
    return {.base_color = Albedo(pile_ * (1.0f + crush_ * nap + grain)),
            .roughness = noise::Saturate(0.8f + 0.15f * nap),
            .specular = Splat(0.2f),
            .sheen = noise::Saturate(0.85f + 0.3f * nap)};
  }
  auto HeightOf(const auto& point) const {
    const auto& p = point.texture_m;
    const Float8 w = point.footprint_m;
    return 0.25e-3f * crush_ * noise::Fbm3(p, 0.25f * patch_m_, 3, w, seed_ + 2) +
           5e-5f * Fade(1e-3f, w) * Gradient3(p * 1000.0f, seed_ + 9);
  }

 private:
  Vec3f pile_;
  float crush_, patch_m_;
};

// Teddy, boucle, terry: small loops in disorder.
class BoucleFabric final : public Carved<BoucleFabric> {
 public:
  explicit BoucleFabric(Rng& rng) {
    loop_m_ = Draw(rng, 0.002, 0.006);
    yarn_ = DrawDye(rng);
    deep_ = yarn_ * Draw(rng, 0.45, 0.7);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 fade = Fade(1.5f * loop_m_, w);
    Float8 top = Splat(0.6f), own = Splat(0);
    if (Any(fade > 0)) {
      const noise::Cell8 cell = CellAt(point.texture_m);
      top += fade * (Loop(cell) - 0.6f);
      own = fade * (UnitByte(cell.id, 1) - 0.5f);
    }
    const Float8 broad = noise::Fbm3(point.texture_m, 0.05f, 2, w, seed_ + 3);
    return {.base_color = Albedo(Mix(deep_, yarn_, top) * (1.0f + 0.2f * own + 0.08f * broad)),
            .roughness = Splat(0.95f),
            .specular = Splat(0.2f),
            .sheen = Splat(0.4f)};
  }
  auto HeightOf(const auto& point) const {
    return 0.3f * loop_m_ * Loops(point.texture_m, point.footprint_m);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Loops(const Vec& p, Float8 w) const {
    const Float8 fade = Fade(1.5f * loop_m_, w);
    if (!Any(fade > 0)) return Splat(0);
    return fade * Loop(CellAt(p));
  }
  template <typename Vec>
  noise::CellOf8<Vec> CellAt(const Vec& p) const {
    // Loops lean every way: the lattice is shaken at their own size.
    const auto q = p / loop_m_;
    const auto shake = 0.35f * Gradient3(q * 1.4f, seed_ + 5);
    return noise::Cells3(q + VecOf(shake, -shake, shake), seed_);
  }
  template <typename Vec>
  static RealOf<Vec> Loop(const noise::CellOf8<Vec>& cell) {
    return noise::Saturate(1.0f - 1.6f * cell.f1 * cell.f1) *
           SmoothStep(0.0f, 0.25f, cell.f2 - cell.f1);
  }

  float loop_m_;
  Vec3f yarn_, deep_;
};

}  // namespace

void AddFabricMaterials(MaterialList& list) {
  const MaterialTags cloth = {.diffuse = true};
  list.push_back(Entry<WovenFabric>(
      "WovenFabric", "fabric", cloth,
      WovenStyle{.thread_low_mm = 0.8, .thread_high_mm = 2.0, .thread_contrast = 0.25}));
  list.push_back(Entry<WovenFabric>("BasketWeaveFabric", "fabric", cloth,
                                    WovenStyle{.weave = Weave::kBasket,
                                               .thread_low_mm = 0.9,
                                               .thread_high_mm = 2.2,
                                               .slub = 0.4,
                                               .two_dyes = true}));
  list.push_back(Entry<WovenFabric>("LinenFabric", "fabric", cloth,
                                    WovenStyle{.thread_low_mm = 0.45,
                                               .thread_high_mm = 0.9,
                                               .slub = 1.1,
                                               .thread_contrast = 0.12,
                                               .sheen = 0.2}));
  list.push_back(Entry<WovenFabric>("TwillFabric", "fabric", cloth,
                                    WovenStyle{.weave = Weave::kTwill,
                                               .thread_low_mm = 0.7,
                                               .thread_high_mm = 1.6,
                                               .slub = 0.4,
                                               .two_dyes = true}));
  list.push_back(Entry<BandedFabric>(
      "StripedFabric", "fabric", cloth,
      WovenStyle{.thread_low_mm = 0.5, .thread_high_mm = 1.0, .slub = 0.5}, false));
  list.push_back(Entry<BandedFabric>(
      "TartanFabric", "fabric", cloth,
      WovenStyle{.weave = Weave::kTwill, .thread_low_mm = 0.6, .thread_high_mm = 1.2, .slub = 0.3},
      true));
  list.push_back(Entry<BoucleFabric>("BoucleFabric", "fabric", cloth));
  list.push_back(Entry<Denim>("Denim", "fabric", cloth));
  list.push_back(Entry<KnitFabric>("KnitFabric", "fabric", cloth));
  list.push_back(Entry<VelvetFabric>("VelvetFabric", "fabric", cloth));
}

}  // namespace parallax
