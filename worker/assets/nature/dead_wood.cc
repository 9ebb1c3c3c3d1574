// Dead wood: snags, stumps, logs and fallen trunks.
#include <algorithm>
#include <cmath>

#include "worker/assets/nature/limb.h"
#include "worker/assets/nature/trees.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// State that all parts of one piece of wood share.
struct Timber {
  Rng rng;
  Mesh mesh;
  uint16_t bark = 0, end = 0;
  float lumps = 0.07f;

  Timber(uint64_t seed, const MaterialSlot& bark_slot, const MaterialSlot& end_slot)
      : rng(SceneSeed{seed}, "timber") {
    mesh.slots = {bark_slot, end_slot};
    end = 1;
  }
  Asset Finish(uint64_t seed) {
    AssetBuilder b(seed);
    if (std::none_of(mesh.triangles.begin(), mesh.triangles.end(),
                     [](const Triangle& t) { return t.slot == 1; })) {
      mesh.slots.pop_back();
    }
    b.AddMesh(mesh, Eigen::Affine3f::Identity());
    return b.Finish(Anchor::kGround);
  }
};

// Factor on a trunk's radius: knots and lumps, and at the foot (`flare` > 0) roots.
std::function<float(float, float)> Surface(Timber& t, float radius, float flare) {
  const Noise noise(t.rng);
  const int roots = t.rng.UniformInt(4, 7);
  const float phase = Draw(t.rng, 0, 2 * kPi), lumps = t.lumps;
  return [=](float a, float along) {
    const float foot = std::exp(-along / (1.1f * radius)), low = std::exp(-along / (3 * radius));
    const float wave = static_cast<float>(roots) * a + phase + 0.9f * std::sin(a + 2 * phase);
    const Vec3f on(std::cos(a), std::sin(a), along / (3 * radius));
    return (1 + flare * (0.22f * low + foot * (0.2f + 0.6f * (0.5f + 0.5f * std::cos(wave))))) *
           (1 + lumps * (noise.At(1.5f * on) + 0.7f * noise.At(3.7f * on)));
  };
}

// Torn fibres about a broken end: thin spikes along `way` from a disc.
void AddSplinters(Timber& t, const Vec3f& at, const Vec3f& way, float radius, float length) {
  const Vec3f x =
      way.cross(std::abs(way.z()) < 0.9f ? Vec3f::UnitZ() : Vec3f::UnitX()).normalized();
  const Vec3f y = way.cross(x);
  const int count = t.rng.UniformInt(14, 22);
  const float high = Draw(t.rng, 0, 2 * kPi);
  for (int k = 0; k < count; ++k) {
    const float a = 2.39996f * static_cast<float>(k),
                r = radius * std::sqrt(Draw(t.rng, 0.05, 0.85));
    const Vec3f out = std::cos(a) * x + std::sin(a) * y;
    const float own = length * Draw(t.rng, 0.25, 1.0) * (0.65f + 0.35f * std::cos(a - high));
    const float thick = radius * Draw(t.rng, 0.16, 0.34);
    const Vec3f lean = 0.08f * own * out;
    LimbOptions options;
    options.sides = 5;
    options.slot = t.end;
    options.texture_offset_m = Vec3f{Draw(t.rng, -9, 9), Draw(t.rng, -9, 9), Draw(t.rng, -9, 9)};
    const Vec3f from = at + r * out - 0.6f * radius * way;
    const Vec3f top = at + r * out + own * way + lean;
    AddLimb(t.mesh,
            {{from, thick}, {0.45f * from + 0.55f * top, 0.72f * thick}, {top, 0.05f * thick}},
            options);
  }
}

// A broken limb's rest.
void AddStub(Timber& t, const Vec3f& from, const Vec3f& way, float length, float radius) {
  const Vec3f bend{Draw(t.rng, -0.25, 0.25), Draw(t.rng, -0.25, 0.25), Draw(t.rng, -0.1, 0.3)};
  const Vec3f middle = from + 0.55f * length * way, end = middle + 0.45f * length * (way + bend);
  AddLimb(t.mesh,
          SmoothRings({{from, 1.3f * radius}, {middle, 0.8f * radius}, {end, 0.45f * radius}}, 3),
          {.sides = 8,
           .slot = t.bark,
           .texture_offset_m = Vec3f{Draw(t.rng, -9, 9), Draw(t.rng, -9, 9), Draw(t.rng, -9, 9)}});
}

// Rings of a trunk from `from` on along `way`, with a bend.
std::vector<LimbRing> TrunkRings(Timber& t, const Vec3f& from, const Vec3f& way, float length,
                                 float radius, float end_radius) {
  const Vec3f side =
      way.cross(std::abs(way.z()) < 0.9f ? Vec3f::UnitZ() : Vec3f::UnitX()).normalized();
  const float bend = length * Draw(t.rng, -0.03, 0.03), wave = length * Draw(t.rng, -0.012, 0.012);
  const int pieces = std::max(8, static_cast<int>(length / (0.55f * radius)));
  std::vector<LimbRing> rings;
  for (int k = 0; k <= pieces; ++k) {
    const float s = static_cast<float>(k) / static_cast<float>(pieces);
    rings.push_back(
        {from + s * length * way + (bend * 4 * s * (1 - s) + wave * std::sin(7 * s)) * side,
         Lerp(radius, end_radius, s)});
  }
  return rings;
}

LimbOptions CutTrunk(Timber& t, float radius, float flare, int sides) {
  LimbOptions options{
      .sides = sides, .modulate = Surface(t, radius, flare), .cut_slot = t.end, .slot = t.bark};
  options.texture_offset_m = Vec3f(Draw(t.rng, -9, 9), 0, 0);  // The rings stay about the middle.
  return options;
}

// How deep a foot reaches below the ground, in its radii: no daylight between roots.
constexpr float kBuried = 0.34f;

// Roots that run out over the ground and into it.
void AddRoots(Timber& t, float radius) {
  const int count = t.rng.UniformInt(4, 6);
  const float phase = Draw(t.rng, 0, 2 * kPi);
  for (int k = 0; k < count; ++k) {
    const float a = phase + 2 * kPi * static_cast<float>(k) / static_cast<float>(count) +
                    Draw(t.rng, -0.4, 0.4);
    const Vec3f out(std::cos(a), std::sin(a), 0), side(-std::sin(a), std::cos(a), 0);
    const float reach = radius * Draw(t.rng, 1.0, 2.0), turn = reach * Draw(t.rng, -0.4, 0.4);
    LimbOptions options;
    options.sides = 8;
    options.slot = t.bark;
    options.texture_offset_m = Vec3f{Draw(t.rng, -9, 9), Draw(t.rng, -9, 9), Draw(t.rng, -9, 9)};
    AddLimb(t.mesh,
            SmoothRings(
                {{0.45f * radius * out + Vec3f(0, 0, 0.75f * radius), 0.34f * radius},
                 {1.15f * radius * out + Vec3f(0, 0, 0.06f * radius), 0.26f * radius},
                 {(radius + 0.6f * reach) * out + 0.4f * turn * side - Vec3f(0, 0, 0.2f * radius),
                  0.17f * radius},
                 {(radius + reach) * out + turn * side - Vec3f(0, 0, kBuried * radius),
                  0.05f * radius}},
                3),
            options);
  }
}

std::vector<std::string> BarkFor(Rng& rng) {
  static const std::vector<std::string> kBarks[] = {
      {"FurrowedBark"}, {"ConiferBark"}, {"BirchBark"}, {"DeadWood"}, {"SmoothBark"}};
  return kBarks[rng.UniformInt(0, 4)];
}

// A standing dead tree.
struct SnagParams {
  float height_m = 5;
  float radius_m = 0.16f;  // At breast height.
  bool conifer = false;
  uint64_t seed = 0;
};

// A dead trunk that still stands, broken off above, with stubs of limbs.
Asset MakeSnag(const SnagParams& p) {
  Timber t(p.seed, Slot("bark", {p.conifer ? "ConiferBark" : "DeadWood", "DeadWood"}),
           Slot("wood", {"DeadWood"}));
  const float top = p.radius_m * Draw(t.rng, 0.5, 0.75);
  const Vec3f lean{Draw(t.rng, -0.08, 0.08), Draw(t.rng, -0.08, 0.08), 1};
  const Vec3f way = lean.normalized();
  const std::vector<LimbRing> rings =
      TrunkRings(t, -kBuried * p.radius_m * way, way, p.height_m, p.radius_m, top);
  AddLimb(t.mesh, rings, CutTrunk(t, p.radius_m, 1, 26));
  AddRoots(t, p.radius_m);
  AddSplinters(t, rings.back().at, way, top, p.radius_m * Draw(t.rng, 2.2, 4.5));
  const int stubs = static_cast<int>(p.height_m * Draw(t.rng, 1.2, 2.6));
  for (int k = 0; k < stubs; ++k) {
    const float s = Draw(t.rng, 0.22, 0.97), a = Draw(t.rng, 0, 2 * kPi);
    const auto ring = static_cast<size_t>(s * static_cast<float>(rings.size() - 1));
    const Vec3f out = Vec3f(std::cos(a), std::sin(a), Draw(t.rng, -0.1, 0.6)).normalized();
    const float length = p.radius_m * Draw(t.rng, 1.2, 7.0);
    AddStub(t, rings[ring].at, out, length + rings[ring].radius,
            std::min(0.4f * rings[ring].radius, 0.006f + 0.035f * length));
  }
  return t.Finish(p.seed);
}

// A stump with its roots.
struct StumpParams {
  float radius_m = 0.22f, height_m = 0.35f;
  bool splintered = false;  // Broken by wind instead of cut.
  uint64_t seed = 0;
};

Asset MakeStump(const StumpParams& p) {
  Timber t(p.seed, Slot("bark", {p.seed % 2 == 0 ? "FurrowedBark" : "ConiferBark"}),
           Slot("wood", {p.splintered ? "DeadWood" : "EndGrain"}));
  const Vec3f lean{Draw(t.rng, -0.1, 0.1), Draw(t.rng, -0.1, 0.1), 1};
  const Vec3f way = lean.normalized();
  const std::vector<LimbRing> rings =
      TrunkRings(t, -kBuried * p.radius_m * way, way, p.height_m, p.radius_m, 0.93f * p.radius_m);
  AddLimb(t.mesh, rings, CutTrunk(t, p.radius_m, 1.1f, 44));
  AddRoots(t, p.radius_m);
  if (p.splintered) AddSplinters(t, rings.back().at, way, p.radius_m, p.radius_m);
  return t.Finish(p.seed);
}

// A log or a fallen trunk.
struct LogParams {
  float length_m = 3, radius_m = 0.14f;
  bool cut = true;        // By a saw at both ends; false: a fallen trunk with torn ends and limbs.
  bool bleached = false;  // Driftwood: without bark.
  uint64_t seed = 0;
};

// Lies along x on the ground.
Asset MakeLog(const LogParams& p) {
  Rng choice(SceneSeed{p.seed}, "bark");
  Timber t(p.seed,
           Slot("bark", p.bleached ? std::vector<std::string>{"DeadWood"} : BarkFor(choice)),
           Slot("wood", {p.cut ? "EndGrain" : "DeadWood"}));
  const float end = p.radius_m * Draw(t.rng, p.cut ? 0.8 : 0.4, p.cut ? 0.95 : 0.7);
  const float tilt = (end - p.radius_m) / p.length_m;  // Both ends lie on the ground.
  const Vec3f way = Vec3f(1, 0, tilt).normalized();
  const std::vector<LimbRing> rings =
      TrunkRings(t, {-0.5f * p.length_m, 0, p.radius_m}, way, p.length_m, p.radius_m, end);
  AddLimb(t.mesh, rings, CutTrunk(t, p.radius_m, p.cut ? 0.0f : 0.12f, 26));
  if (!p.cut) {
    AddSplinters(t, rings.front().at, -way, p.radius_m, 1.6f * p.radius_m);
    AddSplinters(t, rings.back().at, way, end, 2.0f * end);
  }
  const int stubs = static_cast<int>(
      p.length_m * Draw(t.rng, p.cut ? 0.3 : 1.2, p.cut ? 1.2 : 2.4) * (p.bleached ? 0.5f : 1.0f));
  for (int k = 0; k < stubs; ++k) {
    const auto ring =
        static_cast<size_t>(Draw(t.rng, 0.1, 0.95) * static_cast<float>(rings.size()));
    const float a = Draw(t.rng, 0.05 * kPi, 0.95 * kPi);
    const Vec3f out = Vec3f(Draw(t.rng, 0.1, 0.7), std::cos(a), std::sin(a)).normalized();
    const float length = p.radius_m * (p.cut ? Draw(t.rng, 0.2, 0.9) : Draw(t.rng, 1.0, 7.0));
    AddStub(t, rings[ring].at, out, rings[ring].radius + length,
            std::min(0.38f * rings[ring].radius, 0.012f + 0.04f * length));
  }
  return t.Finish(p.seed);
}

}  // namespace

Asset SampleSnag(Rng& rng) {
  return MakeSnag({.height_m = Draw(rng, 2.2, 7),
                   .radius_m = Draw(rng, 0.09, 0.2),
                   .conifer = rng.Bernoulli(0.5),
                   .seed = rng.Seed()});
}

Asset SampleStump(Rng& rng) {
  return MakeStump({.radius_m = Draw(rng, 0.12, 0.32),
                    .height_m = Draw(rng, 0.22, 0.55),
                    .splintered = rng.Bernoulli(0.35),
                    .seed = rng.Seed()});
}

Asset SampleLog(Rng& rng) {
  return MakeLog(
      {.length_m = Draw(rng, 0.9, 3.2), .radius_m = Draw(rng, 0.09, 0.22), .seed = rng.Seed()});
}

Asset SampleDriftwood(Rng& rng) {
  LogParams p{.length_m = Draw(rng, 0.8, 3.4), .cut = false, .bleached = true};
  p.radius_m = 0.045f * p.length_m * Draw(rng, 0.7, 1.3);
  p.seed = rng.Seed();
  return MakeLog(p);
}

Asset SampleFallenTrunk(Rng& rng) {
  return MakeLog({.length_m = Draw(rng, 3, 6.5),
                  .radius_m = Draw(rng, 0.1, 0.24),
                  .cut = false,
                  .seed = rng.Seed()});
}

}  // namespace parallax
