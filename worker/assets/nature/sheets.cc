#include "worker/assets/nature/sheets.h"

#include <algorithm>
#include <cmath>

#include "worker/assets/kernel/curves.h"
#include "worker/assets/nature/limb.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using kernel::kPi;

// Half of the outline's width at `t` of the length, 1 at its widest.
float OutlineAt(LeafShape shape, float t) {
  const auto hump = [](float s, float power) {
    return std::pow(std::max(0.0f, std::sin(kPi * s)), power);
  };
  switch (shape) {
    case LeafShape::kOvate:
      return 1.05f * hump(std::pow(t, 0.62f), 1.1f);
    case LeafShape::kLance:
      return hump(std::pow(t, 0.75f), 0.9f);
    case LeafShape::kOblong:
      return hump(t, 0.45f);
    case LeafShape::kBlade:
      return t < 0.3f ? 0.7f + t : 1.0f - 0.98f * std::pow((t - 0.3f) / 0.7f, 1.6f);
    case LeafShape::kPetal:
      return hump(std::pow(t, 1.7f), 0.6f);
    default:
      return hump(std::pow(t, 0.9f), 0.8f);
  }
}

// The stations of a lobed leaf go in and out by turns.
float LobeAt(LeafShape shape, int station) {
  if (shape != LeafShape::kLobed) return 1.0f;
  return station % 2 == 1 ? 1.0f : 0.48f;
}

// The middle of the blade, bent down, and its frame there.
struct Midrib {
  Vec3f at, across, up;
};
Midrib MidribAt(const LeafForm& form, float t) {
  const float angle = form.droop * t, half = 0.5f * angle;
  const float turn = form.twist * t;
  const Vec3f up(0, std::sin(angle), std::cos(angle));
  return {t * Vec3f(0, std::cos(half), -std::sin(half)),
          std::cos(turn) * Vec3f::UnitX() + std::sin(turn) * up,
          std::cos(turn) * up - std::sin(turn) * Vec3f::UnitX()};
}

// A fan about the end of the stalk: lobes point forwards, to the sides and a little back.
SheetTemplate MakePalmate(const LeafForm& form) {
  // Half of the outline, from the stalk round to the tip.
  static constexpr std::array<std::array<float, 2>, 6> kOutline = {
      {{0.06f, 0.0f}, {0.6f, 0.27f}, {0.3f, 0.4f}, {0.4f, 0.74f}, {0.14f, 0.64f}, {0.0f, 1.0f}}};
  SheetTemplate leaf;
  const auto place = [&](float x, float y) {
    const Midrib rib = MidribAt(form, y);
    const float out = form.width / 0.62f * 0.5f * x;
    return leaf.Add(rib.at + out * rib.across + std::abs(out) * form.fold * rib.up);
  };
  const uint32_t center = leaf.Add(MidribAt(form, 0.24f).at);
  uint32_t right = place(kOutline[0][0], kOutline[0][1]), left = place(-kOutline[0][0], 0.0f);
  leaf.triangles.push_back({center, left, right});
  for (size_t k = 1; k < kOutline.size(); ++k) {
    const auto [x, y] = kOutline[k];
    const bool tip = k + 1 == kOutline.size();
    const uint32_t next_right = place(x, y), next_left = tip ? next_right : place(-x, y);
    leaf.triangles.push_back({center, right, next_right});
    leaf.triangles.push_back({center, next_left, left});
    right = next_right;
    left = next_left;
  }
  leaf.Finish();
  return leaf;
}

}  // namespace

uint32_t SheetTemplate::Add(const Vec3f& point) {
  points.push_back(point);
  return static_cast<uint32_t>(points.size() - 1);
}

void SheetTemplate::Finish() {
  normals.assign(points.size(), Vec3f::Zero());
  area = 0;
  for (const auto& t : triangles) {
    const Vec3f n = (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]);
    area += 0.5f * n.norm();
    for (const uint32_t v : t) normals[v] += n;
  }
  for (Vec3f& n : normals) n = n.squaredNorm() > 0 ? n.normalized() : Vec3f::UnitZ();
}

SheetTemplate MakeLeafTemplate(const LeafForm& form) {
  if (form.shape == LeafShape::kPalmate) return MakePalmate(form);
  SheetTemplate leaf;
  const bool folded = form.fold > 0;
  const int stations = std::max(1, form.stations);
  const bool blade = form.shape == LeafShape::kBlade;
  // Left, middle (when folded) and right of the last station; equal at the pointed ends.
  std::array<uint32_t, 3> before{};
  for (int k = 0; k <= stations + 1; ++k) {
    const float t = static_cast<float>(k) / static_cast<float>(stations + 1);
    const Midrib rib = MidribAt(form, t);
    std::array<uint32_t, 3> here;
    const bool point = k == stations + 1 || (k == 0 && !blade);
    if (point) {
      here.fill(leaf.Add(rib.at));
    } else {
      const float half = 0.5f * form.width * OutlineAt(form.shape, t) * LobeAt(form.shape, k);
      const Vec3f lift = half * form.fold * rib.up;
      here = {leaf.Add(rib.at - half * rib.across + lift), 0, 0};
      if (folded) here[1] = leaf.Add(rib.at);
      here[2] = leaf.Add(rib.at + half * rib.across + lift);
    }
    const auto join = [&](size_t a, size_t b) {
      const std::array<uint32_t, 3> lower{before[a], before[b], here[b]},
          upper{before[a], here[b], here[a]};
      if (before[a] != before[b]) leaf.triangles.push_back(lower);
      if (here[a] != here[b]) leaf.triangles.push_back(upper);
    };
    if (k > 0 && folded) join(0, 1), join(1, 2);
    if (k > 0 && !folded) join(0, 2);
    before = here;
  }
  leaf.Finish();
  return leaf;
}

SheetTemplate MakeSprayTemplate(int teeth, float needle, float fold) {
  SheetTemplate spray;
  for (const float side : {-1.0f, 1.0f}) {
    for (int k = 0; k < teeth; ++k) {
      const float s = static_cast<float>(k) / static_cast<float>(teeth),
                  step = 1.0f / static_cast<float>(teeth);
      const float reach = needle * (1.0f - 0.55f * s * s) * (k % 2 == 0 ? 1.0f : 0.82f);
      const uint32_t a = spray.Add({0, s, 0}), b = spray.Add({0, s + 0.7f * step, 0});
      const float lift = fold * (k % 2 == 0 ? 1.0f : 0.35f);
      const uint32_t tip = spray.Add({side * reach * 0.8f, s + 0.75f * reach, lift * reach});
      if (side > 0) {
        spray.triangles.push_back({a, tip, b});
      } else {
        spray.triangles.push_back({a, b, tip});
      }
    }
  }
  spray.Finish();
  return spray;
}

SheetTemplate MakeTuftTemplate(int count, float spread_rad, float width, Rng& rng) {
  SheetTemplate tuft;
  for (int k = 0; k < count; ++k) {
    const float around = 2.39996f * static_cast<float>(k) + Draw(rng, -0.3, 0.3);
    const float open = spread_rad *
                       std::sqrt((static_cast<float>(k) + 0.5f) / static_cast<float>(count)) *
                       Draw(rng, 0.8, 1.15);
    const Vec3f out(std::cos(around), 0, std::sin(around));
    const Vec3f along = std::cos(open) * Vec3f::UnitY() + std::sin(open) * out;
    const Vec3f across = 0.5f * width * along.cross(out).normalized();
    const float length = Draw(rng, 0.75, 1.0);
    const Vec3f from = 0.06f * along;
    const uint32_t a = tuft.Add(from - across), b = tuft.Add(from + across),
                   tip = tuft.Add(length * along + 0.08f * length * out);
    tuft.triangles.push_back({a, b, tip});
  }
  tuft.Finish();
  return tuft;
}

SheetGrower::SheetGrower(const MaterialSlot& slot, Rng rng) : rng_(std::move(rng)) {
  mesh_.slots.push_back(slot);
}

void SheetGrower::Add(const SheetTemplate& sheet, const SheetPlace& place) {
  const Vec3f y = place.along.normalized();
  Vec3f x = y.cross(place.up);
  if (x.squaredNorm() < 1e-6f)
    x = y.cross(std::abs(y.z()) < 0.9f ? Vec3f::UnitZ() : Vec3f::UnitX());
  x.normalize();
  const Vec3f z = x.cross(y);
  const auto first = static_cast<uint32_t>(mesh_.positions.size());
  const Vec2f own{static_cast<float>(rng_.Uniform()), static_cast<float>(rng_.Uniform())};
  const Vec3f shift(0, 0, 3.0f * own.y());
  const size_t first_triangle = mesh_.triangles.size();
  const float ground = 0.001f + 0.012f * own.x();
  bool lies = false;
  for (size_t i = 0; i < sheet.points.size(); ++i) {
    const Vec3f &p = sheet.points[i], &n = sheet.normals[i];
    mesh_.positions.push_back(place.at + place.length_m * (p.x() * x + p.y() * y + p.z() * z));
    float& height = mesh_.positions.back().z();
    lies |= height < ground;
    // Not quite flat: a blade stays a surface even where it points straight down.
    if (height < ground) height = ground * (0.6f + 0.4f / (1 + ground - height));
    mesh_.normals.push_back((n.x() * x + n.y() * y + n.z() * z).normalized());
    mesh_.texture.push_back(place.length_m * Vec3f(p.y(), p.x(), 0) + shift);
    mesh_.uv.push_back(own);
  }
  for (const auto& t : sheet.triangles) {
    mesh_.triangles.push_back({first + t[0], first + t[1], first + t[2], 0});
  }
  if (lies) SetNormals(mesh_, first, first_triangle);
  ++count_;
}

}  // namespace parallax
