#include "worker/scene/types/nature/ground/roof.h"

#include <algorithm>
#include <cmath>

#include "worker/materials/kernel/noise.h"
#include "worker/terrain/plane_noise.h"

namespace parallax {
namespace {

// Rock from the vault up to the hill, at least, and beside a skylight.
constexpr float kLip_m = 0.9f;
constexpr float kBehind_m = 4.5f;

Vec3f RoofVector(const Vec3f& p, uint32_t seed) {
  return {noise::Gradient3(p, seed), noise::Gradient3(p, seed + 1), noise::Gradient3(p, seed + 2)};
}

// Hollows that water dissolved, sharp edges between them; in [0, 1], 1 on an edge.
float Scallops(const Vec3f& p, uint32_t seed) {
  return 1 - std::min(1.0f, 2.2f * std::fabs(noise::Gradient3(p, seed)));
}

// Displacement of the vault's rock at `p`, metres.
Vec3f RoughRock(const Vec3f& p, uint32_t seed) {
  return 1.1f * RoofVector(p / 7.0f, seed) + 0.5f * RoofVector(p / 2.6f, seed + 10) +
         0.16f * RoofVector(p / 0.95f, seed + 20) -
         Vec3f(0, 0, 0.22f * Scallops(p / 1.7f, seed + 30) + 0.08f * Scallops(p / 0.6f, seed + 31));
}

}  // namespace

CaveRoof::CaveRoof(const v1::Terrain& recipe, const Terrain& terrain, float cell_m)
    : roof_(recipe.roof()),
      gorge_(terrain.spec().cover.front()),
      half_m_(static_cast<float>(roof_.half_length_m())),
      reach_m_(static_cast<float>(roof_.reach_m())),
      seed_(roof_.seed()) {
  const int metres = static_cast<int>(2 * half_m_) + 3;
  for (int i = 0; i < metres; ++i) {
    const float along = static_cast<float>(i) - half_m_ - 1;
    // The mean over the floor's width: the vault does not follow every stone.
    float sum = 0;
    for (const float side : {-3.0f, 0.0f, 3.0f}) {
      sum += terrain.Height(PointOf({along, side}), 4) / 3;
    }
    floors_.push_back(sum);
  }
  Build(cell_m);
}

Vec2f CaveRoof::PlanOf(const Vec2f& p) const {
  const Vec2f ahead(std::cos(gorge_.direction_rad), std::sin(gorge_.direction_rad));
  const Vec2f left(-ahead.y(), ahead.x());
  const float along = ahead.dot(p);
  return {along, left.dot(p - GorgeMiddle(gorge_, along))};
}

Vec2f CaveRoof::PointOf(const Vec2f& plan) const {
  const Vec2f left(-std::sin(gorge_.direction_rad), std::cos(gorge_.direction_rad));
  return GorgeMiddle(gorge_, plan.x()) + plan.y() * left;
}

float CaveRoof::FloorAt(float along_m) const {
  const float at =
      std::clamp(along_m + half_m_ + 1, 0.0f, static_cast<float>(floors_.size()) - 1.001f);
  const auto i = static_cast<size_t>(at);
  return noise::Lerp(floors_[i], floors_[i + 1], at - std::floor(at));
}

float CaveRoof::FromSkylight(const Vec2f& p) const {
  float least = 1e9f;
  for (const v1::CaveRoof::Skylight& hole : roof_.skylights()) {
    const Vec2f from = p - Vec2d(hole.x_m(), hole.y_m()).cast<float>();
    const float ragged =
        1 + 0.35f * PlaneNoise(p / 1.9f, seed_ + 50) + 0.14f * PlaneNoise(p / 0.7f, seed_ + 51);
    least = std::min(least, from.norm() - static_cast<float>(hole.radius_m()) * ragged);
  }
  return least;
}

Vec3f CaveRoof::Under(const Vec2f& plan) const {
  const Vec2f p = PointOf(plan);
  const float spring = static_cast<float>(roof_.spring_m());
  const float rise = static_cast<float>(roof_.rise_m()) *
                     (1 + 0.3f * PlaneNoise({plan.x() / 21.0f, 0.3f}, seed_ + 40));
  // The vault springs from behind the walls, wherever these are.
  const float wide = PlaceInGorge(gorge_, GorgeMiddle(gorge_, plan.x())).half_m + kBehind_m;
  const float out = std::min(1.0f, std::fabs(plan.y()) / wide);
  const float vault = std::sqrt(std::max(0.0f, 1 - out * out));
  // The rim of the ends hangs lower and is rugged.
  const float end = noise::SmoothStep(half_m_ - 5, half_m_, std::fabs(plan.x()));
  const Vec3f smooth(p.x(), p.y(),
                     FloorAt(plan.x()) + spring + (rise - spring) * vault * (1 - 0.25f * end));
  return smooth + RoughRock(smooth, seed_);
}

// The hill's surface, sunk beside skylights, where it fell in.
Vec3f CaveRoof::Top(const Vec2f& plan) const {
  const Vec2f p = PointOf(plan);
  const float hill = FloorAt(plan.x()) + gorge_.amplitude_m - 0.7f;
  const Vec3f under = Under(plan);
  const float sunk = under.z() + kLip_m + 0.75f * std::max(0.0f, FromSkylight(p));
  const float bumps = 0.35f * PlaneNoise(p / 3.1f, seed_ + 60);
  return {under.x(), under.y(), std::max(under.z() + 0.5f * kLip_m, std::min(hill, sunk) + bumps)};
}

std::optional<float> CaveRoof::CeilingAt(const Vec2f& p) const {
  Vec2f plan = PlanOf(p);
  if (std::fabs(plan.x()) > half_m_ || std::fabs(plan.y()) > reach_m_) return std::nullopt;
  // The rock above `p` was moved there from a place near it.
  for (int i = 0; i < 3; ++i) plan -= PlanOf(Under(plan).head<2>()) - PlanOf(p);
  if (std::fabs(plan.x()) > half_m_ || FromSkylight(PointOf(plan)) < 0.3f) return std::nullopt;
  return Under(plan).z();
}

void CaveRoof::Build(float cell_m) {
  const int columns = static_cast<int>(2 * half_m_ / cell_m) + 1,
            rows = static_cast<int>(2 * reach_m_ / cell_m) + 1;
  const auto plan_of = [&](int column, int row) {
    return Vec2f(
        2 * half_m_ * static_cast<float>(column) / static_cast<float>(columns - 1) - half_m_,
        2 * reach_m_ * static_cast<float>(row) / static_cast<float>(rows - 1) - reach_m_);
  };
  const auto index = [&](int column, int row) {
    return static_cast<size_t>(row * columns + column);
  };
  std::vector<Vec2f> plan(static_cast<size_t>(columns * rows));
  std::vector<char> in_hole(plan.size());
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      plan[index(column, row)] = plan_of(column, row);
      in_hole[index(column, row)] = FromSkylight(PointOf(plan_of(column, row))) < 0;
    }
  }
  std::vector<char> open(plan.size());  // By the square's lowest corner.
  for (int row = 0; row + 1 < rows; ++row) {
    for (int column = 0; column + 1 < columns; ++column) {
      open[index(column, row)] = in_hole[index(column, row)] || in_hole[index(column + 1, row)] ||
                                 in_hole[index(column, row + 1)] ||
                                 in_hole[index(column + 1, row + 1)];
    }
  }
  // Rims are the holes' own lines, not the grid's.
  for (int row = 1; row + 1 < rows; ++row) {
    for (int column = 1; column + 1 < columns; ++column) {
      const int opens = open[index(column, row)] + open[index(column - 1, row)] +
                        open[index(column, row - 1)] + open[index(column - 1, row - 1)];
      if (opens == 0 || opens == 4) continue;
      Vec2f& at = plan[index(column, row)];
      for (int i = 0; i < 2; ++i) {
        const float away = FromSkylight(PointOf(at));
        constexpr float kStep = 0.05f;
        const Vec2f slope = Vec2f(FromSkylight(PointOf(at + Vec2f(kStep, 0))) - away,
                                  FromSkylight(PointOf(at + Vec2f(0, kStep))) - away) /
                            kStep;
        at -=
            std::clamp(away, -cell_m, 1.2f * cell_m) * slope / std::max(0.3f, slope.squaredNorm());
      }
    }
  }
  mesh_.slots = {{"rock", {"rock"}, false}};
  for (const bool top : {false, true}) {
    for (const Vec2f& at : plan) mesh_.positions.push_back(top ? Top(at) : Under(at));
  }
  AddFaces(columns, rows, open);
}

void CaveRoof::AddFaces(int columns, int rows, const std::vector<char>& open) {
  const auto under = [&](int column, int row) {
    return static_cast<uint32_t>(row * columns + column);
  };
  const auto top = [&](int column, int row) {
    return static_cast<uint32_t>(columns * rows) + under(column, row);
  };
  const auto is_open = [&](int column, int row) {
    return column < 0 || row < 0 || column + 1 >= columns || row + 1 >= rows ||
           open[under(column, row)] != 0;
  };
  const auto quad = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    mesh_.triangles.push_back({a, b, c, 0});
    mesh_.triangles.push_back({a, c, d, 0});
  };
  for (int row = 0; row + 1 < rows; ++row) {
    for (int column = 0; column + 1 < columns; ++column) {
      if (is_open(column, row)) continue;
      const int c = column, r = row, c1 = column + 1, r1 = row + 1;
      quad(under(c, r), under(c, r1), under(c1, r1), under(c1, r));
      quad(top(c, r), top(c1, r), top(c1, r1), top(c, r1));
      // Walls where the next square is open.
      if (is_open(c, r - 1)) quad(under(c, r), under(c1, r), top(c1, r), top(c, r));
      if (is_open(c1, r)) quad(under(c1, r), under(c1, r1), top(c1, r1), top(c1, r));
      if (is_open(c, r1)) quad(under(c1, r1), under(c, r1), top(c, r1), top(c1, r1));
      if (is_open(c - 1, r)) quad(under(c, r1), under(c, r), top(c, r), top(c, r1));
    }
  }
  // Vertices inside of holes belong to no face.
  std::vector<uint32_t> place(mesh_.positions.size(), 0xffffffff);
  std::vector<Vec3f> used;
  for (Triangle& t : mesh_.triangles) {
    for (uint32_t* v : {&t.a, &t.b, &t.c}) {
      if (place[*v] == 0xffffffff) {
        place[*v] = static_cast<uint32_t>(used.size());
        used.push_back(mesh_.positions[*v]);
      }
      *v = place[*v];
    }
  }
  mesh_.positions = std::move(used);
  mesh_.texture = mesh_.positions;
  mesh_.uv.assign(mesh_.positions.size(), Vec2f::Zero());
  std::vector<Vec3f> sums(mesh_.positions.size(), Vec3f::Zero());
  for (const Triangle& t : mesh_.triangles) {
    const Vec3f normal = (mesh_.positions[t.b] - mesh_.positions[t.a])
                             .cross(mesh_.positions[t.c] - mesh_.positions[t.a]);
    for (const uint32_t v : {t.a, t.b, t.c}) sums[v] += normal;
  }
  for (const Vec3f& sum : sums) {
    mesh_.normals.push_back(sum.squaredNorm() > 1e-24f ? sum.stableNormalized()
                                                       : Vec3f(-Vec3f::UnitZ()));
  }
}

SkyEnclosure EnclosureUnder(const v1::Terrain& recipe, const Terrain& terrain) {
  const v1::CaveRoof& roof = recipe.roof();
  const TerrainTerm& gorge = terrain.spec().cover.front();
  const CaveRoof vault(recipe, terrain, 4);
  const auto half = static_cast<float>(roof.half_length_m()),
             reach = static_cast<float>(roof.reach_m()), rise = static_cast<float>(roof.rise_m());
  const Vec3f ahead(std::cos(gorge.direction_rad), std::sin(gorge.direction_rad), 0);
  const Vec3f left(-ahead.y(), ahead.x(), 0);
  SkyEnclosure enclosure;
  for (const float end : {-half, half}) {
    const Vec2f middle = GorgeMiddle(gorge, end);
    const float floor = terrain.Height(middle, 4);
    const Vec3f corner = Vec3f(middle.x(), middle.y(), floor - 0.5f) - reach * left;
    const Vec3f out = (end > 0 ? 1.0f : -1.0f) * ahead;
    enclosure.portals.push_back({corner, 2 * reach * left, {0, 0, 1.4f * rise}, out, 1});
    enclosure.within.push_back({out, out.dot(corner)});
    for (const float side : {-reach, reach}) {
      for (const float up : {-4.0f, 1.6f * rise}) {
        enclosure.box.extend(Vec3f(middle.x(), middle.y(), floor + up) + side * left);
      }
    }
  }
  for (const v1::CaveRoof::Skylight& hole : roof.skylights()) {
    const Vec2f middle = Vec2d(hole.x_m(), hole.y_m()).cast<float>();
    const auto radius = 1.4f * static_cast<float>(hole.radius_m());
    const float height = vault.VaultAt(middle);
    enclosure.portals.push_back({{middle.x() - radius, middle.y() - radius, height},
                                 {2 * radius, 0, 0},
                                 {0, 2 * radius, 0},
                                 Vec3f::UnitZ(),
                                 0.2f});
  }
  return enclosure;
}

}  // namespace parallax
