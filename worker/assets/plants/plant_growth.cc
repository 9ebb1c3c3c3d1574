#include "worker/assets/plants/plant_growth.h"

#include <algorithm>
#include <cmath>

#include "worker/assets/kernel/detail_scope.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A thin four-sided thorn.
void AddSpike(Shape& shape, const Vec3f& from, const Vec3f& to, float radius) {
  const Vec3f along = (to - from).normalized();
  const Vec3f x =
      (std::abs(along.z()) < 0.8f ? Vec3f::UnitZ() : Vec3f::UnitX()).cross(along).normalized();
  const Vec3f y = along.cross(x);
  uint32_t base[4];
  for (int k = 0; k < 4; ++k) {
    const float a = 0.5f * kPi * static_cast<float>(k);
    base[k] = shape.AddPoint(from + radius * (std::cos(a) * x + std::sin(a) * y),
                             {0, 0.01f * static_cast<float>(k), 0});
  }
  const uint32_t tip = shape.AddPoint(to, {(to - from).norm(), 0, 0});
  for (int k = 0; k < 4; ++k) shape.AddTriangle(base[k], base[(k + 1) % 4], tip);
  shape.AddQuad(base[3], base[2], base[1], base[0]);
}

// The blade of a leaf, as a thin closed sheet.
struct LeafParams {
  float length_m = 0.15f;
  float width_m = 0.05f;
  float droop = 0.5f;   // How far the tip bends down, in lengths.
  float fold = 0.25f;   // Fold of the halves about the midrib; 0 = flat.
  float wave = 0.0f;    // Undulation of the margin.
  float widest = 0.4f;  // Where along the length.
  float point = 1.0f;   // 1 = tapering tip, 0.5 = blunt.
  float thickness_m = 0.0006f;
  int lobes = 0;    // Cuts from the margin (monstera).
  int pieces = 10;  // Along the length.
};

// Starts at the origin and grows along +y, top side up (+z). A thin closed sheet.
Shape Leaf(const LeafParams& p) {
  const float half = 0.5f * p.width_m;
  const auto width = SmoothThrough({{0.0f, 0.08f},
                                    {0.5f * p.widest, 0.72f},
                                    {p.widest, 1.0f},
                                    {Lerp(p.widest, 1.0f, 0.6f), 0.3f + 0.4f * (1.5f - p.point)},
                                    {1.0f, 0.03f}});
  SheetOptions sheet;
  sheet.pieces_u = p.pieces > 4 ? 4 : 2;
  sheet.pieces_v = p.pieces;
  sheet.thickness_m = p.thickness_m;
  sheet.size_m = {p.width_m, p.length_m};
  sheet.round_rim = false;
  Shape leaf = Sheet(
      [&](float u, float v) {
        const float x = 2 * u - 1;
        float w = half * width(v);
        if (p.lobes > 0 && v > 0.12f && v < 0.93f) {
          const float cut = 0.5f - 0.5f * std::cos(2 * kPi * static_cast<float>(p.lobes) * v);
          w *= 1 - 0.62f * std::pow(cut, 5.0f);
        }
        const float bend = p.droop * v * v;
        const float along = p.length_m * v * (1 - 0.25f * bend);
        const float ripple =
            p.wave * p.length_m * std::abs(x) * std::sin(14 * v + (x > 0 ? 0.0f : 1.6f));
        return Vec3f(x * w, along, std::abs(x) * w * p.fold - p.length_m * 0.6f * bend + ripple);
      },
      sheet);
  for (size_t i = 0; i < leaf.points.size(); ++i)
    leaf.texture[i] = {leaf.texture[i].y(), leaf.texture[i].x(), leaf.texture[i].z()};
  leaf.crease_rad = 1.2f;
  return leaf;
}

}  // namespace

MaterialSlot LeafSlot() { return Slot("leaves", {"leaf"}); }
MaterialSlot StemSlot() { return Slot("stems", {"leaf", "bark"}); }

Eigen::Affine3f Growing(const Vec3f& at, float a, float pitch, float roll) {
  Eigen::Affine3f place = Eigen::Affine3f::Identity();
  place.translate(at);
  place.rotate(Eigen::AngleAxisf(a, Vec3f::UnitZ()));
  place.rotate(Eigen::AngleAxisf(pitch, Vec3f::UnitX()));
  place.rotate(Eigen::AngleAxisf(roll, Vec3f::UnitY()));
  return place;
}

// Arching grass-like blades.
void GrowBlades(AssetBuilder& b, float base_z, float size, float spread, Rng& rng) {
  const int count = rng.UniformInt(22, 38);
  for (int i = 0; i < count; ++i) {
    LeafParams leaf;
    leaf.length_m = size * Draw(rng, 0.7, 1.25);
    leaf.width_m = size * Draw(rng, 0.035, 0.06);
    leaf.droop = Draw(rng, 0.2, 0.75);
    leaf.fold = 0.5f;
    leaf.widest = 0.25f;
    leaf.pieces = 14;
    const float a = Golden(i) + Draw(rng, -0.2, 0.2), out = spread * Draw(rng, 0.0, 1.0);
    b.Add(Leaf(leaf).Placed(
              Growing({-out * std::sin(a), out * std::cos(a), base_z}, a, Draw(rng, 0.75, 1.45))),
          LeafSlot());
  }
}

// Fleshy leaves in a spiral: agave, echeveria.
void GrowRosette(AssetBuilder& b, float base_z, float size, Rng& rng) {
  const int count = rng.UniformInt(26, 42);
  const float plump = Draw(rng, 0.02, 0.05), slim = Draw(rng, 0.2, 0.36);
  for (int i = 0; i < count; ++i) {
    // 0 outside, 1 in the heart.
    const float t = static_cast<float>(i) / static_cast<float>(count - 1);
    const float length = size * Lerp(1.0f, 0.42f, t);
    Path3 spine;
    const int pieces = DetailedPieces(8, length, 4);
    for (int k = 0; k <= pieces; ++k) {
      const float s = static_cast<float>(k) / static_cast<float>(pieces);
      spine.emplace_back(0, length * s, 0.22f * length * s * s);
    }
    const auto width =
        SmoothThrough({{0, 0.7f}, {0.45f, 1.0f}, {0.8f, 0.62f}, {0.97f, 0.1f}, {1, 0.03f}});
    SweepOptions options;
    options.keep_up = true;
    options.end_round_m = 0.0004f;
    options.scale = [&](float s) { return Vec2f(width(s), 0.25f + 0.75f * width(s)); };
    // A section hollow on its upper side.
    Path2 section;
    const float w = slim * size * Lerp(1.0f, 0.7f, t), thick = plump * size * 2;
    const int sides = DetailedSegments(16, 0.5f * w);
    for (int k = 0; k < sides; ++k) {
      const float a = 2 * kPi * static_cast<float>(k) / static_cast<float>(sides);
      const float y = std::sin(a) * 0.5f * thick;
      section.emplace_back(0.5f * w * std::cos(a), y + 0.35f * thick * std::cos(a) * std::cos(a));
    }
    b.Add(
        Sweep(spine, section, options)
            .Placed(Growing({0, 0, base_z + 0.02f * size * t}, Golden(i),
                            Lerp(0.12f, 1.32f, t * t * 0.6f + 0.4f * t) + Draw(rng, -0.05, 0.05))),
        LeafSlot());
  }
}

// Broad leaves on stalks from the ground.
void GrowBroad(AssetBuilder& b, float base_z, float size, float spread, bool lobed, Rng& rng) {
  const int count = lobed ? rng.UniformInt(12, 18) : rng.UniformInt(20, 32);
  for (int i = 0; i < count; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(count);
    const float a = Golden(i) + Draw(rng, -0.2, 0.2),
                reach = size * Draw(rng, 0.18, 0.45) * (1.1f - 0.5f * t),
                high = size * Lerp(0.35f, 0.85f, t) * Draw(rng, 0.85, 1.15);
    const Vec3f out(-std::sin(a), std::cos(a), 0);
    const Vec3f from = spread * Draw(rng, 0.0, 0.5) * out + Vec3f(0, 0, base_z);
    const Vec3f tip = from + reach * out + Vec3f(0, 0, high);
    const Path3 stalk = Spline(Path3{from, from + 0.25f * reach * out + Vec3f(0, 0, 0.5f * high),
                                     from + 0.7f * reach * out + Vec3f(0, 0, 0.9f * high), tip},
                               5);
    const float thick = 0.009f * size + 0.0008f;
    SweepOptions taper;
    taper.scale = [](float s) { return Vec2f::Constant(1.0f - 0.45f * s).eval(); };
    b.Add(Sweep(stalk, EllipseSection(2 * thick, 2 * thick, 8), taper), StemSlot());
    LeafParams leaf{.length_m = size * (lobed ? Draw(rng, 0.34, 0.46) : Draw(rng, 0.26, 0.42))};
    leaf.width_m = leaf.length_m * (lobed ? 0.92f : Draw(rng, 0.42, 0.6));
    leaf.droop = Draw(rng, 0.15, 0.4);
    leaf.fold = Draw(rng, 0.1, 0.25);
    leaf.wave = lobed ? 0.02f : 0.035f;
    leaf.widest = lobed ? 0.3f : 0.38f;
    leaf.lobes = lobed ? 5 : 0;
    leaf.pieces = lobed ? 28 : 12;
    const float pitch = Draw(rng, -0.35, 0.25), roll = Draw(rng, -0.3, 0.3);
    b.Add(Leaf(leaf).Placed(Growing(tip - 0.004f * out, a, pitch, roll)), LeafSlot());
  }
}

// Fronds with leaflets on both sides.
void GrowFern(AssetBuilder& b, float base_z, float size, bool palm, Rng& rng) {
  const int count = palm ? rng.UniformInt(8, 12) : rng.UniformInt(12, 18);
  for (int i = 0; i < count; ++i) {
    const float a = Golden(i) + Draw(rng, -0.2, 0.2), length = size * Draw(rng, 0.75, 1.15),
                pitch = Draw(rng, 0.7, 1.35);
    const float droop = Draw(rng, 0.5, 1.2);
    const auto at = [&](float s) {
      // A rachis that bends over by `droop` radians in all.
      const float angle = pitch - droop * s * 0.8f;
      return Vec3f(0, length * s * std::cos(0.5f * (pitch + angle)),
                   length * s * std::sin(0.5f * (pitch + angle)));
    };
    Path3 rachis;
    for (int k = 0; k <= 12; ++k) rachis.push_back(at(static_cast<float>(k) / 12.0f));
    Shape frond = Tube(rachis, 0.005f * size + 0.0006f, 0, 6);
    const Eigen::Affine3f place = Growing({0, 0, base_z}, a, 0);
    b.Add(frond.Placed(place), StemSlot());
    const int pairs = palm ? 20 : 18;
    for (int k = 0; k < pairs; ++k) {
      const float s = Lerp(palm ? 0.22f : 0.15f, 0.99f,
                           (static_cast<float>(k) + 0.5f) / static_cast<float>(pairs));
      const float envelope =
          palm ? std::sin(kPi * std::pow(s, 0.75f)) * 0.75f + 0.25f : std::pow(1 - s, 0.7f) + 0.12f;
      LeafParams leaf{.length_m = length * (palm ? 0.42f : 0.26f) * envelope};
      leaf.width_m = palm ? 0.1f * leaf.length_m + 0.003f : 0.3f * leaf.length_m;
      leaf.droop = palm ? 0.35f : 0.15f;
      leaf.fold = 0.2f;
      leaf.pieces = 4;
      const Vec3f p = at(s), ahead = (at(std::min(1.0f, s + 0.02f)) - at(s - 0.02f)).normalized();
      for (const float side : {-1.0f, 1.0f}) {
        // The leaflet grows sidewards and ahead, its top turned up.
        const Vec3f grow = (side * Vec3f::UnitX() * (palm ? 0.75f : 1.0f) +
                            (palm ? 0.8f : 0.35f) * ahead + Vec3f(0, 0, palm ? 0.25f : 0.0f))
                               .normalized();
        Vec3f up = Vec3f::UnitX().cross(ahead);
        Vec3f across = grow.cross(up).normalized();
        up = across.cross(grow);
        Eigen::Affine3f own = Eigen::Affine3f::Identity();
        own.translate(p);
        Mat3f axes;
        axes.col(0) = across;
        axes.col(1) = grow;
        axes.col(2) = up;
        own.rotate(axes);
        b.Add(Leaf(leaf).Placed(place * own), LeafSlot());
      }
    }
  }
}

// Stiff upright blades, slightly twisted.
void GrowSnake(AssetBuilder& b, float base_z, float size, float spread, Rng& rng) {
  const int count = rng.UniformInt(7, 13);
  for (int i = 0; i < count; ++i) {
    const float a = Golden(i),
                out = spread * 0.75f * std::sqrt(static_cast<float>(i) / static_cast<float>(count));
    const float length = size * Draw(rng, 0.6, 1.1);
    const Vec3f from(-out * std::sin(a), out * std::cos(a), base_z - 0.01f);
    const Vec3f lean = Vec3f(-std::sin(a), std::cos(a), 0) *
                       (0.12f + 0.1f * out / std::max(spread, 1e-3f)) * length;
    Path3 path;
    for (int k = 0; k <= 18; ++k) {
      const float s = static_cast<float>(k) / 18.0f;
      path.push_back(from + Vec3f(0, 0, length * s) + lean * s * s);
    }
    const auto width =
        SmoothThrough({{0, 0.55f}, {0.3f, 0.85f}, {0.65f, 1.0f}, {0.9f, 0.5f}, {1, 0.03f}});
    const float twist = Draw(rng, -0.8, 0.8), turn = Draw(rng, 0, 3.1);
    SweepOptions options;
    options.scale = [&](float s) { return Vec2f(width(s), 0.5f + 0.5f * width(s)); };
    options.twist_rad = [=](float s) { return turn + twist * s; };
    Path2 section;
    const float w = 0.085f * size + 0.012f, thick = 0.004f + 0.004f * size;
    for (int k = 0; k < 14; ++k) {
      const float q = 2 * kPi * static_cast<float>(k) / 14.0f;
      section.emplace_back(0.5f * w * std::cos(q),
                           0.5f * thick * std::sin(q) + 0.16f * w * std::cos(q) * std::cos(q));
    }
    b.Add(Sweep(path, section, options), LeafSlot());
  }
}

// A ribbed column or ball with spines on its ribs.
void GrowCactus(AssetBuilder& b, const CactusColumn& column, Rng& rng) {
  const float size = column.radius_m, spine_m = column.spine_m;
  const int ribs = column.ribs;
  const int around = ribs * 6;
  const SweepOptions options{.end_round_m = 0.94f * size};
  Path2 section;
  for (int k = 0; k < around; ++k) {
    const float a = 2 * kPi * static_cast<float>(k) / static_cast<float>(around);
    const float r =
        size *
        (0.88f + 0.12f * std::pow(std::abs(std::cos(0.5f * static_cast<float>(ribs) * a)), 0.7f));
    section.emplace_back(r * std::cos(a), r * std::sin(a));
  }
  Path3 path;
  for (const Vec3f& p : column.axis) path.push_back(column.base + p);
  const Shape body = Sweep(path, section, options);
  b.Add(body, Slot("flesh", {"leaf"}));
  // Spines stand on the crests, in clusters.
  const Path3 along = Resampled(path, 0.34f * size + 0.004f);
  Shape spines;
  for (size_t i = 1; i < along.size(); ++i) {
    const Vec3f t = (along[std::min(i + 1, along.size() - 1)] - along[i - 1]).normalized();
    Vec3f x = Vec3f::UnitY().cross(t);
    if (x.norm() < 0.1f) x = Vec3f::UnitX();
    x.normalize();
    const Vec3f y = t.cross(x);
    const float left = (along.back() - along[i]).norm();
    const float r =
        left < size ? size * std::sqrt(std::max(0.0f, 1 - (1 - left / size) * (1 - left / size)))
                    : size;
    if (r < 0.25f * size) continue;
    for (int k = 0; k < ribs; ++k) {
      const float a = 2 * kPi * static_cast<float>(k) / static_cast<float>(ribs);
      const Vec3f out = std::cos(a) * x + std::sin(a) * y;
      const Vec3f at = along[i] + 0.97f * r * out;
      for (int s = 0; s < 3; ++s) {
        const Vec3f to =
            (out + 0.7f * Vec3f{Draw(rng, -1, 1), Draw(rng, -1, 1), Draw(rng, -1, 1)}).normalized();
        AddSpike(spines, at, at + spine_m * to, 0.02f * spine_m + 0.0004f);
      }
    }
  }
  if (!spines.points.empty()) b.Add(spines, Slot("spines", {"wood", "plastic"}));
}

void TreeGrower::Branch(const Vec3f& from, const Vec3f& heading, float length, float radius,
                        int level) {
  Path3 path{from};
  Vec3f at = from, dir = heading.normalized();
  constexpr int kPieces = 5;
  for (int k = 0; k < kPieces; ++k) {
    dir = (dir + 0.2f * Vec3f{Draw(rng, -1, 1), Draw(rng, -1, 1), Draw(rng, -0.5, 1)}).normalized();
    at += dir * (length / kPieces);
    path.push_back(at);
  }
  wood.Add(Sweep(Spline(path, 2), EllipseSection(2 * radius, 2 * radius, level == 0 ? 12 : 7),
                 {.scale = [](float s) { return Vec2f::Constant(1.0f - 0.4f * s).eval(); }}));
  if (level == depth) {
    for (int k = 0; k < leaves_per_twig; ++k) {
      const float s = Lerp(
          0.2f, 1.0f, static_cast<float>(k) / static_cast<float>(std::max(1, leaves_per_twig - 1)));
      const float f = s * static_cast<float>(kPieces);
      const size_t i = std::min<size_t>(static_cast<size_t>(f), kPieces - 1);
      const Vec3f p = path[i] + (path[i + 1] - path[i]) * (f - static_cast<float>(i));
      LeafParams leaf{.length_m = leaf_m * Draw(rng, 0.7, 1.2)};
      leaf.width_m = leaf_width * leaf.length_m;
      leaf.droop = Draw(rng, 0.1, 0.5);
      leaf.fold = 0.2f;
      leaf.pieces = 2;
      const float turn = Golden(k) + Draw(rng, 0, 6), pitch = Draw(rng, -0.3, 0.9),
                  roll = Draw(rng, -0.4, 0.4);
      leaves.Add(Leaf(leaf).Placed(Growing(p, turn, pitch, roll)));
    }
    return;
  }
  const int children = level == 0 ? rng.UniformInt(3, 4) : rng.UniformInt(2, 3);
  const float turn = Draw(rng, 0, 6.2);
  for (int c = 0; c < children; ++c) {
    const float a = turn + 2 * kPi * static_cast<float>(c) / static_cast<float>(children);
    const Vec3f side(std::cos(a), std::sin(a), 0.25f);
    const Vec3f next = (dir + Draw(rng, 0.55, 1.0) * side).normalized();
    Branch(path[c == 0 ? kPieces : kPieces - (c % 2)], next, length * Draw(rng, 0.6, 0.82),
           radius * 0.6f, level + 1);
  }
}

void TreeGrower::Finish() {
  b.Add(wood, Slot("bark", {"bark", "wood"}));
  b.Add(leaves, LeafSlot());
}

}  // namespace parallax
