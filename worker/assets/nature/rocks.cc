// Stones: boulders, slabs, piles, pebbles.
#include <algorithm>
#include <array>
#include <cmath>

#include "worker/assets/kernel/detail_scope.h"
#include "worker/assets/nature/ground_cover.h"
#include "worker/assets/nature/limb.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// Unit directions over a sphere: a cube of `n` cells a side, blown up; triangles face outwards.
struct Sphere {
  std::vector<Vec3f> points;
  std::vector<std::array<uint32_t, 3>> triangles;
};
Sphere CubeSphere(int n) {
  Sphere sphere;
  constexpr uint32_t kNone = 0xffffffff;
  const int side = n + 1;
  std::vector<uint32_t> seen(static_cast<size_t>(side * side * side), kNone);
  const auto vertex = [&](const std::array<int, 3>& at) {
    uint32_t& index = seen[static_cast<size_t>((at[0] * side + at[1]) * side + at[2])];
    if (index == kNone) {
      index = static_cast<uint32_t>(sphere.points.size());
      Vec3f p;
      for (size_t k = 0; k < 3; ++k) {
        // Evenly by angle, so that cells are alike.
        const float t = 2.0f * static_cast<float>(at[k]) / static_cast<float>(n) - 1.0f;
        p[static_cast<int>(k)] = std::tan(0.25f * kPi * t);
      }
      sphere.points.push_back(p.normalized());
    }
    return index;
  };
  for (size_t axis = 0; axis < 3; ++axis) {
    for (const int end : {0, n}) {
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          const auto corner = [&](int u, int v) {
            std::array<int, 3> at{};
            at[axis] = end;
            at[(axis + 1) % 3] = u;
            at[(axis + 2) % 3] = v;
            return vertex(at);
          };
          const uint32_t a = corner(i, j), b = corner(i + 1, j), c = corner(i + 1, j + 1),
                         d = corner(i, j + 1);
          if (end == n) {
            sphere.triangles.insert(sphere.triangles.end(), {{a, b, c}, {a, c, d}});
          } else {
            sphere.triangles.insert(sphere.triangles.end(), {{a, c, b}, {a, d, c}});
          }
        }
      }
    }
  }
  return sphere;
}

// A body cut from a block by planes, its edges chipped and worn, cracked, rough at two scales.
class Stone {
 public:
  Stone(const StoneForm& form, Rng& rng) : form_(form), noise_(rng) {
    planes_.push_back({-Vec3f::UnitZ(), Draw(rng, 0.5, 0.7)});  // It rests on a flat side.
    if (form.bedding > 0) AddSides(rng);
    for (int k = 1; k < form.planes; ++k) {
      const float z = Draw(rng, -1, 1), a = Draw(rng, 0, 2 * kPi), s = std::sqrt(1 - z * z);
      planes_.push_back({Vec3f(s * std::cos(a), s * std::sin(a), z), Draw(rng, 0.62, 1.0)});
    }
    for (int k = 0; k < form.cracks; ++k) {
      const float z = Draw(rng, -0.5, 0.5), a = Draw(rng, 0, 2 * kPi), s = std::sqrt(1 - z * z);
      cracks_.push_back({Vec3f(s * std::cos(a), s * std::sin(a), z), Draw(rng, -0.45, 0.45)});
    }
    beds_ = Vec3f{Draw(rng, -0.25, 0.25), Draw(rng, -0.25, 0.25), 1}.normalized();
  }

  // In the form's size. What is rough stands out along the surface's normal, about: along `way` a
  // slab's flat sides would fold over.
  Vec3f Surface(const Vec3f& way) const {
    // The polytope's distance along `way`; a soft minimum rounds its edges off.
    float sum = 0;
    for (const Plane& plane : planes_) {
      const float facing = plane.normal.dot(way);
      if (facing > 0.05f) sum += std::pow(facing / plane.distance, form_.sharpness);
    }
    const float hull = sum > 0 ? std::pow(sum, -1 / form_.sharpness) : 1.15f;
    Vec3f p = std::min(hull, 1.2f) * way;
    const float chip = noise_.Ridges(1.6f * p + Vec3f::Constant(3.1f));
    float r = 1 + form_.rough * (0.5f * noise_.Fractal(1.3f * p, 3) - 0.35f * chip * chip);
    r += 0.22f * form_.rough * noise_.Fractal(6.5f * p, 3);
    if (form_.bedding > 0) r += form_.bedding * Bed(p);
    for (const Plane& crack : cracks_) {
      const float wander = 0.1f * noise_.At(2.2f * p) + 0.03f * noise_.At(8.0f * p);
      const float off = std::abs(crack.normal.dot(p) - crack.distance + wander);
      r -= 0.075f * std::exp(-off * off / (2 * 0.02f * 0.02f));
    }
    const Vec3f out = way.cwiseQuotient(form_.size).normalized();
    const float scale = std::min(std::cbrt(form_.size.prod()), 1.5f * form_.size.minCoeff());
    return p.cwiseProduct(form_.size) + (r - 1) * p.norm() * scale * out;
  }

 private:
  struct Plane {
    Vec3f normal;
    float distance;
  };
  // A slab broke off between two beds: level above, steep all around, not a lens.
  void AddSides(Rng& rng) {
    planes_.push_back({Vec3f::UnitZ(), Draw(rng, 0.45, 0.65)});
    for (int k = 0; k < 7; ++k) {
      const float a = 2.39996f * static_cast<float>(k) + Draw(rng, -0.3, 0.3);
      const Vec3f side{std::cos(a), std::sin(a), Draw(rng, -0.15, 0.15)};
      planes_.push_back({side.normalized(), Draw(rng, 0.55, 0.85)});
    }
  }
  // Layers that stand out by turns.
  float Bed(const Vec3f& p) const {
    const float level = 7 * beds_.dot(p) + 0.8f * noise_.At(1.2f * p);
    const float step = level - std::floor(level);
    const auto depth = [&](float bed) { return noise_.At(Vec3f(0.5f, 0.5f, bed + 0.5f)); };
    // Wider than a cell: a ledge, not a saw.
    return Lerp(depth(std::floor(level)), depth(std::floor(level) + 1), Smooth01(2 * step - 1)) +
           0.25f * std::min(1.0f, 3 * std::min(step, 1 - step));
  }

  const StoneForm& form_;
  Noise noise_;
  std::vector<Plane> planes_, cracks_;
  Vec3f beds_;
};

// Appends one stone at `place`; texture in metres.
void AddStone(Mesh& mesh, const StoneForm& form, uint16_t slot, const Eigen::Affine3f& place,
              Rng& rng) {
  const float usual = 2 * kPi * form.size.maxCoeff() / (4.0f * static_cast<float>(form.cells));
  const float edge = std::max(usual, TargetEdge());
  const int cells =
      std::clamp(static_cast<int>(0.5f * kPi * form.size.maxCoeff() / edge + 0.5f), 3, form.cells);
  const Sphere sphere = CubeSphere(cells);
  const Stone stone(form, rng);
  const size_t first_vertex = mesh.positions.size(), first_triangle = mesh.triangles.size();
  const Vec3f offset{Draw(rng, -20, 20), Draw(rng, -20, 20), Draw(rng, -20, 20)};
  for (const Vec3f& way : sphere.points) {
    const Vec3f p = stone.Surface(way);
    mesh.positions.push_back(place * p);
    mesh.normals.push_back(Vec3f::UnitZ());
    mesh.texture.push_back(p + offset);
    mesh.uv.push_back(Vec2f::Zero());
  }
  const auto base = static_cast<uint32_t>(first_vertex);
  for (const auto& t : sphere.triangles) {
    mesh.triangles.push_back({base + t[0], base + t[1], base + t[2], slot});
  }
  SetNormals(mesh, first_vertex, first_triangle);
}

// Moves the points from `first` on so that the lowest is at z = `up`.
void LetDown(Mesh& mesh, size_t first, float up) {
  float low = 1e9f;
  for (size_t i = first; i < mesh.positions.size(); ++i) low = std::min(low, mesh.positions[i].z());
  for (size_t i = first; i < mesh.positions.size(); ++i) mesh.positions[i].z() -= low - up;
}

Eigen::Affine3f Turned(const Vec3f& at, float turn, float tilt, float tilt_to) {
  Eigen::Affine3f place = Eigen::Affine3f::Identity();
  place.translate(at);
  place.rotate(Eigen::AngleAxisf(tilt, Vec3f(std::cos(tilt_to), std::sin(tilt_to), 0)));
  place.rotate(Eigen::AngleAxisf(turn, Vec3f::UnitZ()));
  return place;
}

MaterialSlot StoneSlot(uint64_t seed) {
  return Slot("stone", {seed % 5 < 3 ? "MossyRock" : "Rock", "MossyRock"});
}

// One stone in its own stream.
Asset OneStone(const BoulderParams& p, const char* stream, const MaterialSlot& slot) {
  Mesh mesh;
  mesh.slots.push_back(slot);
  Rng rng(SceneSeed{p.seed}, stream);
  AddStone(mesh, p.form, 0, Eigen::Affine3f::Identity(), rng);
  return FinishMeshes({&mesh}, p.seed);
}

// A heap of broken stones.
struct RockPileParams {
  float size_m = 0.9f;  // Half of its width.
  int stones = 12;
  uint64_t seed = 0;
};

Asset MakeRockPile(const RockPileParams& p) {
  Mesh mesh;
  mesh.slots.push_back(StoneSlot(p.seed));
  Rng rng(SceneSeed{p.seed}, "pile");
  for (int k = 0; k < p.stones; ++k) {
    const float rank = static_cast<float>(k) / static_cast<float>(p.stones);
    StoneForm form;
    const float size = p.size_m * Lerp(0.42f, 0.13f, std::sqrt(rank)) * Draw(rng, 0.8, 1.2);
    form.size = size * Vec3f{Draw(rng, 0.8, 1.25), Draw(rng, 0.7, 1.0), Draw(rng, 0.55, 0.85)};
    form.planes = rng.UniformInt(12, 24);
    form.sharpness = Draw(rng, 9, 22);
    form.rough = Draw(rng, 0.1, 0.18);
    // Faces of one size on large and small stones.
    form.cells = std::clamp(static_cast<int>(40 * size / p.size_m), 7, 16);
    const float a = 2.39996f * static_cast<float>(k) + Draw(rng, -0.5, 0.5),
                r = p.size_m * 0.62f * std::sqrt(rank) * Draw(rng, 0.75, 1.2);
    // Early, large ones lie below; some later ones lie on top of them.
    const float up = k > 2 && rng.Bernoulli(0.35) ? p.size_m * Draw(rng, 0.25, 0.42) : 0.0f;
    const float inward = up > 0 ? 0.45f : 1.0f;
    const float turn = Draw(rng, 0, 6.2), tilt = Draw(rng, 0, 0.5), to = Draw(rng, 0, 6.2);
    const size_t first = mesh.positions.size();
    AddStone(mesh, form, 0,
             Turned({inward * r * std::cos(a), inward * r * std::sin(a), 0}, turn, tilt, to), rng);
    LetDown(mesh, first, up);
  }
  return FinishMeshes({&mesh}, p.seed);
}

// A patch of pebbles.
struct PebblesParams {
  float radius_m = 0.2f;  // Size of the patch.
  float coarse = 1;
  int stones = 36;
  uint64_t seed = 0;
};

Asset MakePebbles(const PebblesParams& p) {
  Mesh mesh{.slots = {Slot("stones", {"Rock", "MossyRock"}), Slot("pale", {"Sandstone", "Rock"})}};
  Rng rng(SceneSeed{p.seed}, "pebbles");
  const int large = std::max(1, p.stones / 6);
  for (int k = 0; k < p.stones; ++k) {
    StoneForm form;
    const float size = (k < large ? Draw(rng, 0.018, 0.032) : Draw(rng, 0.006, 0.016)) * p.coarse;
    form.size = size * Vec3f{Draw(rng, 0.9, 1.3), Draw(rng, 0.75, 1.0), Draw(rng, 0.45, 0.7)};
    form.planes = 14;
    form.sharpness = Draw(rng, 4, 9);
    form.rough = 0.06f;
    form.cells = k < large ? 9 : 6;
    const float a = Draw(rng, 0, 6.2832), r = p.radius_m * std::sqrt(Draw(rng, 0, 1));
    const float turn = Draw(rng, 0, 6.2), tilt = Draw(rng, 0, 0.4), to = Draw(rng, 0, 6.2);
    const size_t first = mesh.positions.size();
    AddStone(mesh, form, rng.Bernoulli(0.3) || k == 0 ? 1 : 0,
             Turned({r * std::cos(a), r * std::sin(a), 0}, turn, tilt, to), rng);
    LetDown(mesh, first, 0);
  }
  return FinishMeshes({&mesh}, p.seed);
}

}  // namespace

Asset MakeBoulder(const BoulderParams& p) { return OneStone(p, "boulder", StoneSlot(p.seed)); }

Asset SampleBoulder(Rng& rng) {
  BoulderParams p;
  const float size = Draw(rng, 0.25, 1.0);
  p.form.size = size * Vec3f{Draw(rng, 0.8, 1.2), Draw(rng, 0.7, 1.0), Draw(rng, 0.55, 0.9)};
  p.form.planes = rng.UniformInt(14, 30);
  p.form.cracks = rng.UniformInt(0, 3);
  p.form.sharpness = Draw(rng, 9, 26);
  p.form.rough = Draw(rng, 0.1, 0.2);
  p.seed = rng.Seed();
  return MakeBoulder(p);
}

Asset SampleSlab(Rng& rng) {
  BoulderParams p;
  const float size = Draw(rng, 0.35, 1.1);
  p.form.size = size * Vec3f{Draw(rng, 0.9, 1.3), Draw(rng, 0.6, 1.0), Draw(rng, 0.14, 0.26)};
  p.form.planes = rng.UniformInt(16, 26);
  p.form.cracks = rng.UniformInt(0, 2);
  p.form.sharpness = Draw(rng, 16, 34);
  p.form.rough = Draw(rng, 0.1, 0.18);
  p.form.bedding = Draw(rng, 0.012, 0.035);
  p.seed = rng.Seed();
  return MakeBoulder(p);
}

Asset SampleSeaStack(Rng& rng) {
  BoulderParams p;
  const float size = Draw(rng, 0.95, 1.3);
  const bool pillar = rng.Bernoulli(0.5);
  p.form.size = size * Vec3f{Draw(rng, 0.8, 1.3), Draw(rng, 0.6, 1.0),
                             pillar ? Draw(rng, 1.2, 1.8) : Draw(rng, 0.75, 1.1)};
  p.form.planes = rng.UniformInt(11, 16);
  p.form.cracks = rng.UniformInt(4, 8);
  p.form.sharpness = Draw(rng, 14, 26);
  p.form.rough = Draw(rng, 0.26, 0.36);
  p.form.bedding = Draw(rng, 0.03, 0.05);  // Surf has bared its beds.
  p.form.cells = 57;
  p.seed = rng.Seed();
  return OneStone(p, "stack", Slot("stone", {"Rock"}));
}

Asset SampleIceBlock(Rng& rng) {
  BoulderParams p;
  const float size = Draw(rng, 0.4, 1.0);
  p.form.size = size * Vec3f{Draw(rng, 0.9, 1.4), Draw(rng, 0.6, 1.0), Draw(rng, 0.35, 0.8)};
  p.form.planes = rng.UniformInt(10, 15);
  p.form.cracks = rng.UniformInt(1, 4);
  p.form.sharpness = Draw(rng, 24, 42);
  p.form.rough = Draw(rng, 0.06, 0.12);
  p.form.cells = 36;
  p.seed = rng.Seed();
  return OneStone(p, "ice", Slot("ice", {"SeaIce"}));
}

Asset SampleRockPile(Rng& rng) {
  return MakeRockPile(
      {.size_m = Draw(rng, 0.5, 1.3), .stones = rng.UniformInt(9, 18), .seed = rng.Seed()});
}

Asset SamplePebbles(Rng& rng) {
  return MakePebbles({.radius_m = Draw(rng, 0.12, 0.3),
                      .coarse = Draw(rng, 0.8, 1.6),
                      .stones = rng.UniformInt(24, 48),
                      .seed = rng.Seed()});
}

}  // namespace parallax
