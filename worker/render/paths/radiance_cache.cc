#include "worker/render/paths/radiance_cache.h"

#include <tbb/parallel_for.h>

#include <bit>
#include <cmath>
#include <unordered_map>

#include "worker/render/surface/sampling.h"
#include "worker/render/surface/shared_exponent.h"

namespace parallax {
namespace {

uint64_t Mix(uint64_t x) {
  x ^= x >> 32;
  x *= 0xd6e8feb86659fd93u;
  x ^= x >> 32;
  x *= 0xd6e8feb86659fd93u;
  x ^= x >> 32;
  return x;
}

// The index of the facing (one of six) of a normal.
uint32_t FaceOf(const Vec3f& normal) {
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return static_cast<uint32_t>(2 * axis) + (normal[axis] < 0.0f ? 1 : 0);
}
Int8 FaceOf(const Vec3x8& normal) {
  const Float8 x = Abs(normal.x), y = Abs(normal.y), z = Abs(normal.z);
  const Mask8 by_x = (x >= y) & (x >= z), by_y = y >= z;
  // A lane of the mask is -1 where the normal looks backward.
  const Mask8 back = by_x ? normal.x < 0.0f : (by_y ? normal.y < 0.0f : normal.z < 0.0f);
  return (by_x ? Int8{} : (by_y ? Int8{} + 2 : Int8{} + 4)) - back;
}

// Walls often lie at round coordinates: shift the cubes so that their faces do not.
const Vec3f kShift_m(0.0137f, 0.0219f, 0.0171f);

constexpr float kMostlyRough = 0.9f;
constexpr float kBrightPart = 0.15f;  // Share of a cell's records.

}  // namespace

float CacheGrid::WidthAt(const Vec3f& position) const {
  const float d2 = eyes_.squaredExteriorDistance(position);
  if (d2 < Square(2 * kFullDetail_m)) return cell_m_;
  // The width doubles with every doubling of the distance.
  return std::ldexp(cell_m_, std::ilogb(std::sqrt(d2) / kFullDetail_m));
}

Float8 CacheGrid::WidthAt(const Vec3x8& position) const {
  const auto beyond = [](Float8 x, float low, float high) {
    return Max(Max(low - x, x - high), 0.0f);
  };
  const Vec3f &low = eyes_.min(), &high = eyes_.max();
  const Vec3x8 out{beyond(position.x, low.x(), high.x()), beyond(position.y, low.y(), high.y()),
                   beyond(position.z, low.z(), high.z())};
  Float8 width = Splat(cell_m_);
  const Mask8 far = Dot(out, out) >= Square(2 * kFullDetail_m);
  for (int lane = 0; Any(far) && lane < kLanes; ++lane) {
    if (far[lane]) width[lane] = WidthAt(position.Get(lane));
  }
  return width;
}

Vec3x8 CacheGrid::CubeOf(const Vec3x8& positions, Float8 width_m) {
  const Vec3x8 cube = (positions + kShift_m) * (1.0f / width_m);
  return {Floor(cube.x), Floor(cube.y), Floor(cube.z)};
}

uint64_t CacheGrid::KeyOf(const CachePlace& place, float width_m) {
  const Eigen::Vector3i cube =
      ((place.position + kShift_m) * (1.0f / width_m)).array().floor().cast<int>().matrix();
  return KeyOf(cube, FaceOf(place.normal), place.group, place.slot, width_m);
}

uint64_t CacheGrid::KeyOf(const Eigen::Vector3i& cube, uint32_t face, uint32_t group, uint16_t slot,
                          float width_m) {
  const auto bits = [](int x) { return static_cast<uint64_t>(static_cast<uint32_t>(x)); };
  const uint64_t a = bits(cube.x()) | bits(cube.y()) << 32;
  const uint64_t b =
      bits(cube.z()) | static_cast<uint64_t>(face) << 32 | static_cast<uint64_t>(slot) << 35;
  const uint64_t c = group | static_cast<uint64_t>(std::bit_cast<uint32_t>(width_m)) << 32;
  return Mix(a * 0x9e3779b97f4a7c15u + b * 0xc2b2ae3d27d4eb4fu + c * 0x165667b19e3779f9u) | 1u;
}

void RadianceCache::Ask(const CacheQuestions8& questions, uint64_t* keys) const {
  std::fill_n(keys, kLanes, uint64_t{0});
  if (empty()) return;
  const Float8 width = grid_.WidthAt(questions.position) * questions.coarse;
  uint32_t asked = questions.asked & BitsOf(width <= questions.widest_m);
  const Frame8 frame(questions.normal);
  const Vec3x8 moved =
      questions.position +
      (frame.x * (questions.jitter_u - 0.5f) + frame.y * (questions.jitter_v - 0.5f)) * width;
  const Vec3x8 cube = CacheGrid::CubeOf(moved, width);
  const Int8 x = ToInt(cube.x), y = ToInt(cube.y), z = ToInt(cube.z);
  const Int8 face = FaceOf(questions.normal);
  for (; asked != 0; asked &= asked - 1) {
    const int lane = __builtin_ctz(asked);
    keys[lane] = CacheGrid::KeyOf({x[lane], y[lane], z[lane]}, static_cast<uint32_t>(face[lane]),
                                  static_cast<uint32_t>(questions.group[lane]),
                                  static_cast<uint16_t>(questions.slot[lane]), width[lane]);
    table_.Prefetch(keys[lane]);
  }
}

bool RadianceCache::Answer(uint64_t key, const CachePlace& place, Vec3f* radiance) const {
  if (key == 0) return false;
  const Entry* entry = table_.Find(key);
  if (!entry) entry = table_.Find(grid_.KeyOf(place));
  if (!entry) return false;
  *radiance = UnpackRadiance(entry->radiance);
  return true;
}

void CacheRecord::Cut(float luminance) {
  constexpr float kMostExcess = 64;
  const float whole = Luminance(radiance);
  if (whole <= luminance) return;
  excess = radiance * (std::min(whole - luminance, kMostExcess * luminance) / whole);
  radiance *= luminance / whole;
}

void CacheBuilder::Add(const CacheRecord& record) {
  Cell* cell = cells_.Get(record.key);
  if (!cell) return;
  if (cell->count++ == 0) cell->region = record.region;
  if (!record.rough) return;
  ++cell->rough;
  cell->sum += record.radiance;
  if (record.excess.isZero()) return;
  ++cell->cut;
  cell->excess += record.excess;
}

void CacheBuilder::Add(const std::vector<Batch>& batches) {
  tbb::parallel_for(size_t{0}, CellTable<Cell>::kShards, [&](size_t s) {
    for (const Batch& batch : batches) {
      for (const CacheRecord& record : batch.shards[s]) Add(record);
    }
  });
}

bool CacheBuilder::Cell::bright() const {
  return static_cast<float>(cut) >= kBrightPart * static_cast<float>(rough);
}

RadianceCache CacheBuilder::Freeze(int min_records) const {
  RadianceCache cache;
  cache.grid_ = grid_;
  const auto known = [&](const Cell& cell) {
    return cell.rough >= static_cast<uint32_t>(std::max(min_records, 1)) &&
           static_cast<float>(cell.rough) >= kMostlyRough * static_cast<float>(cell.count);
  };
  struct Region {
    Vec3f excess = Vec3f::Zero();
    Vec3f kept = Vec3f::Zero();
  };
  std::unordered_map<uint64_t, Region> regions;
  size_t count = 0;
  cells_.ForEach([&](const Cell& cell) {
    count += known(cell) ? 1 : 0;
    if (cell.rough == 0 || cell.bright()) return;
    Region& region = regions[cell.region];
    region.excess += cell.excess;
    region.kept += cell.sum;
  });
  cache.table_ = FrozenCells<RadianceCache::Entry>(2 * count);
  cells_.ForEach([&](const Cell& cell) {
    if (!known(cell)) return;
    const auto rough = static_cast<float>(cell.rough);
    Vec3f mean = (cell.bright() ? Vec3f(cell.sum + cell.excess) : cell.sum) / rough;
    if (!cell.bright()) {
      const Region& region = regions.at(cell.region);
      const float kept = Luminance(region.kept);
      if (kept > 0.0f) mean += region.excess * (Luminance(mean) / kept);
    }
    cache.table_.Add(cell.key, {.radiance = PackRadiance(mean)});
  });
  return cache;
}

}  // namespace parallax
