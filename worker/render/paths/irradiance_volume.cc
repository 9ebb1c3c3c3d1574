#include "worker/render/paths/irradiance_volume.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "worker/render/surface/sampling.h"

namespace parallax {
namespace {

constexpr int kTerms = IncomingLight8::kTerms;
constexpr int kLog2Parent = 2;          // A parent's width over its child's.
constexpr float kRecordsOfParent = 16;  // Records that a parent's mean counts for.
constexpr float kLeastOverMean = 0.02f;
constexpr uint32_t kLevelFace = 6;  // Beyond the facings of the radiance cache.

// Real spherical harmonics of degree 0 to 2 in a unit direction.
template <typename Number>
void Harmonics(const Number& x, const Number& y, const Number& z, Number* of) {
  of[0] = x * 0 + 0.282095f;
  of[1] = 0.488603f * y;
  of[2] = 0.488603f * z;
  of[3] = 0.488603f * x;
  of[4] = 1.092548f * x * y;
  of[5] = 1.092548f * y * z;
  of[6] = 0.315392f * (3.0f * z * z - 1.0f);
  of[7] = 1.092548f * x * z;
  of[8] = 0.546274f * (x * x - y * y);
}

// The sum of the terms in a direction, each degree scaled.
Vec3x8 Weighted(const std::array<Vec3x8, kTerms>& terms, const Vec3x8& direction, float degree0,
                float degree1, float degree2) {
  Float8 of[kTerms];
  Harmonics(direction.x, direction.y, direction.z, of);
  Vec3x8 sum = terms[0] * (of[0] * degree0);
  for (int k = 1; k < 4; ++k) sum = sum + terms[k] * (of[k] * degree1);
  for (int k = 4; k < kTerms; ++k) sum = sum + terms[k] * (of[k] * degree2);
  return sum;
}

Vec3x8 AtLeast(const Vec3x8& a, const Vec3x8& b) {
  return {Max(a.x, b.x), Max(a.y, b.y), Max(a.z, b.z)};
}

struct Cube {
  Eigen::Vector3i at;
  float width_m;
  uint64_t KeyAt(int level) const {
    const Eigen::Vector3i parent(at.x() >> (kLog2Parent * level), at.y() >> (kLog2Parent * level),
                                 at.z() >> (kLog2Parent * level));
    return CacheGrid::KeyOf(parent, kLevelFace, static_cast<uint32_t>(level), 0, width_m);
  }
};

Cube CubeAt(const CacheGrid& grid, const Vec3f& position) {
  const float width_m = grid.WidthAt(position);
  return {CacheGrid::CubeOf(Vec3x8(position), Splat(width_m)).Get(0).cast<int>(), width_m};
}

}  // namespace

// A cosine lobe keeps pi, 2/3 pi and 1/4 pi of the degrees.
Vec3x8 IncomingLight8::Irradiance(const Vec3x8& normal) const {
  const Vec3x8 mean = AtLeast(terms[0], Vec3x8::Zero()) * (kPi * 0.282095f);
  return AtLeast(Weighted(terms, normal, kPi, kPi * 2 / 3, kPi / 4), mean * kLeastOverMean);
}

Vec3x8 IncomingLight8::RadianceAbout(const Vec3x8& direction) const {
  return AtLeast(Weighted(terms, direction, 1, 2.0f / 3, 0), Vec3x8::Zero());
}

PARALLAX_LANE_CLONES IncomingLight8 IrradianceVolume::At(const Vec3x8& positions,
                                                         const Vec3x8& jitter, Mask8 lanes) const {
  IncomingLight8 light;
  light.known = Mask8{};
  if (empty()) lanes = Mask8{};
  const Float8 width = grid_.WidthAt(positions);
  const Vec3x8 cube = CacheGrid::CubeOf(positions + jitter * width, width);
  const Int8 x = ToInt(cube.x), y = ToInt(cube.y), z = ToInt(cube.z);
  Float8 rows[4][kLanes]{};
  for (uint32_t left = BitsOf(lanes); left != 0; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    const Cube at{{x[lane], y[lane], z[lane]}, width[lane]};
    const Entry* entry = nullptr;
    for (int level = 0; !entry && level < VolumeBuilder::kLevels; ++level) {
      entry = table_.Find(at.KeyAt(level));
    }
    if (!entry) continue;
    light.known[lane] = -1;
    const auto* halves = reinterpret_cast<const __m128i*>(entry);
    for (int part = 0; part < 4; ++part) {
      rows[part][lane] = _mm256_cvtph_ps(_mm_load_si128(halves + part));
    }
  }
  for (auto& part : rows) Transpose(part);
  const auto number = [&](int k) { return rows[k / kLanes][k % kLanes]; };
  for (int k = 0; k < kTerms; ++k) {
    light.terms[static_cast<size_t>(k)] = {number(3 * k), number(3 * k + 1), number(3 * k + 2)};
  }
  return light;
}

uint64_t VolumeBuilder::KeyAt(const Vec3f& position) const {
  return CubeAt(grid_, position).KeyAt(0);
}

void VolumeBuilder::Put(const VolumeRecord& record, Batch* batch) const {
  const Cube at = CubeAt(grid_, record.position);
  uint64_t key = at.KeyAt(0);
  for (int level = 0; level < kLevels; ++level) {
    const uint64_t parent = level + 1 < kLevels ? at.KeyAt(level + 1) : 0;
    (*batch)[CellTable<Cell>::ShardOf(key)].push_back(
        {key, parent, record.direction, record.radiance});
    key = parent;
  }
}

void VolumeBuilder::Add(const Part& part) {
  Cell* cell = cells_.Get(part.key);
  if (!cell) return;
  cell->parent = part.parent;
  ++cell->count;
  float of[kTerms];
  Harmonics(part.direction.x(), part.direction.y(), part.direction.z(), of);
  const Vec3f light = part.radiance * (4 * kPi);  // Over the density of directions.
  for (size_t k = 0; k < kTerms; ++k) {
    for (size_t c = 0; c < 3; ++c) cell->sums[3 * k + c] += of[k] * light[static_cast<int>(c)];
  }
}

void VolumeBuilder::Add(const std::vector<Batch>& batches) {
  tbb::parallel_for(size_t{0}, CellTable<Cell>::kShards, [&](size_t s) {
    for (const Batch& batch : batches) {
      for (const Part& part : batch[s]) Add(part);
    }
  });
}

std::array<float, 3 * kTerms> VolumeBuilder::MeansOf(const Cell& cell) const {
  const Cell* parent = cells_.Find(cell.parent);
  std::array<float, 3 * kTerms> means{};
  if (parent) means = MeansOf(*parent);
  const float prior = parent ? kRecordsOfParent : 0;
  for (size_t k = 0; k < means.size(); ++k) {
    means[k] = (cell.sums[k] + prior * means[k]) / (cell.count + prior);
  }
  return means;
}

IrradianceVolume VolumeBuilder::Freeze() const {
  IrradianceVolume volume;
  volume.grid_ = grid_;
  volume.table_ = FrozenCells<IrradianceVolume::Entry>((4 * cells_.cells() + 2) / 3);
  std::vector<std::vector<std::pair<uint64_t, IrradianceVolume::Entry>>> made(
      CellTable<Cell>::kShards);
  tbb::parallel_for(size_t{0}, made.size(), [&](size_t s) {
    cells_.ForEachOf(s, [&](const Cell& cell) {
      auto& [key, entry] = made[s].emplace_back();
      key = cell.key;
      const auto means = MeansOf(cell);
      for (size_t k = 0; k < means.size(); ++k) {
        constexpr float kMost = 65000;
        entry.terms[k] = static_cast<uint16_t>(
            _cvtss_sh(std::clamp(means[k], -kMost, kMost), _MM_FROUND_TO_NEAREST_INT));
      }
    });
  });
  for (const auto& shard : made) {
    for (const auto& [key, entry] : shard) volume.table_.Add(key, entry);
  }
  return volume;
}

}  // namespace parallax
