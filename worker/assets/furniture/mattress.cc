// Mattress: plain, quilted, buttoned or in channels.
#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/furniture/bed_parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// How far the top is drawn down at a point: 0 where it swells most. Metres.
float TopRelief(MattressTop top, const Vec2f& q) {
  switch (top) {
    case MattressTop::kLozenges: {
      const float pitch = 0.17f;
      const float a = std::sin(kPi * (q.x() + q.y()) / pitch),
                  c = std::sin(kPi * (q.x() - q.y()) / pitch);
      return 0.016f * (std::pow(std::abs(a * c), 0.4f) - 1.0f);
    }
    case MattressTop::kTufts: {
      const float pitch = 0.24f;  // Distance between buttons.
      const Vec2f cell = q / pitch;
      const Vec2f off = (cell - Vec2f(std::round(cell.x()), std::round(cell.y()))) * pitch;
      return -0.03f * std::exp(-off.squaredNorm() / (0.045f * 0.045f));
    }
    case MattressTop::kChannels:
      return 0.014f * (std::pow(std::abs(std::sin(kPi * q.y() / 0.16f)), 0.4f) - 1.0f);
    default:
      return 0;
  }
}

// Buttons in the tufts' pits.
Shape TuftButtons(const MattressParams& p) {
  const float pitch = 0.24f;
  Shape buttons;
  const int nx = static_cast<int>((0.5f * p.width_m - 0.1f) / pitch),
            ny = static_cast<int>((0.5f * p.length_m - 0.1f) / pitch);
  for (int i = -nx; i <= nx; ++i) {
    for (int j = -ny; j <= ny; ++j) {
      buttons.Add(Ball(0.011f, 10)
                      .Moved(pitch * static_cast<float>(i), pitch * static_cast<float>(j),
                             p.height_m - 0.024f));
    }
  }
  return buttons;
}

// Webbing loops on the long sides.
Shape CarryStraps(const MattressParams& p) {
  Shape straps;
  const float z = 0.5f * p.height_m, half = 0.09f;
  for (int k = 0; k < p.straps; ++k) {
    const float y =
        p.length_m * ((static_cast<float>(k) + 0.5f) / static_cast<float>(p.straps) - 0.5f);
    for (const float s : {-1.0f, 1.0f}) {
      const float x = 0.5f * p.width_m;
      const SweepOptions options{.up = Vec3f::UnitZ(), .keep_up = true};
      straps.Add(Sweep(Spline(Path3{{s * (x - 0.002f), y - half, z},
                                    {s * (x + 0.006f), y - 0.6f * half, z},
                                    {s * (x + 0.009f), y, z - 0.004f},
                                    {s * (x + 0.006f), y + 0.6f * half, z},
                                    {s * (x - 0.002f), y + half, z}},
                              4),
                       RectSection(0.004f, 0.03f, 0.0015f, 2), options));
    }
  }
  return straps;
}

// Puts the faces of the sides, which no point of top or underside belongs to, into group 1.
void GroupSides(Shape& shape, float half_height) {
  for (Face& face : shape.faces) {
    float high = 0;
    for (int c = 0; c < face.corners; ++c)
      high = std::max(high, std::abs(shape.points[static_cast<size_t>(face.v[c])].z()));
    face.group = high < half_height - 0.03f ? 1 : 0;
  }
}

}  // namespace

Shape MattressBody(const MattressParams& p) {
  const Noise noise(p.seed);
  BoxOptions box{.bevel_m = 0.045f, .bevel_steps = 3};
  const bool worked = p.top != MattressTop::kPlain;
  box.pieces = {worked ? static_cast<int>(p.width_m / 0.03f) : 24,
                worked ? static_cast<int>(p.length_m / 0.03f) : 28, 2};
  const float hx = 0.5f * p.width_m, hy = 0.5f * p.length_m, hz = 0.5f * p.height_m;
  Shape shape = RoundedBox({p.width_m, p.length_m, p.height_m}, box).Bent([&](const Vec3f& q) {
    Vec3f r = q;
    const float inside =
        Smooth01((hx - std::abs(q.x())) / 0.12f) * Smooth01((hy - std::abs(q.y())) / 0.12f);
    if (q.z() > 0.2f * hz) {
      r.z() += inside * TopRelief(p.top, q.head<2>());
      r.z() += 0.006f * inside + 0.004f * noise.At(q * 2.0f);
    }
    return r;
  });
  for (size_t i = 0; i < shape.points.size(); ++i) shape.texture[i] = shape.points[i];
  GroupSides(shape, hz);
  for (const float s : {-1.0f, 1.0f}) {
    Path3 cord;
    const float drop = 0.013f;
    for (const Vec2f& q : RectSection(p.width_m - 2 * drop, p.length_m - 2 * drop, 0.045f, 5))
      cord.emplace_back(q.x(), q.y(), s * (hz - drop));
    shape.Add(Ring(cord, 0.006f));
  }
  return shape.Moved(0, 0, hz);
}

Asset MakeMattress(const MattressParams& p) {
  AssetBuilder b(p.seed);
  b.Add(MattressBody(p), {Slot("mattress", {"fabric"}), Slot("mattress_side", {"fabric"})});
  if (p.top == MattressTop::kTufts) b.Add(TuftButtons(p), Slot("buttons", {"leather", "fabric"}));
  if (p.straps > 0) b.Add(CarryStraps(p), Slot("straps", {"fabric"}));
  return b.Finish();
}

Asset SampleMattress(Rng& rng) {
  MattressParams p;
  const float widths[] = {0.9f, 1.2f, 1.4f, 1.6f, 1.8f};
  p.width_m = widths[rng.UniformInt(0, 4)];
  p.length_m = Draw(rng, 1.9, 2.05);
  p.height_m = Draw(rng, 0.16, 0.28);
  p.top = DrawEnum<MattressTop>(rng, static_cast<int>(MattressTop::kCount));
  p.straps = rng.UniformInt(0, 3);
  p.seed = rng.Seed();
  return MakeMattress(p);
}

}  // namespace parallax
