#include "worker/terrain/terrain.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/base/rng.h"
#include "worker/materials/kernel/noise.h"
#include "worker/terrain/flow.h"
#include "worker/terrain/plane_noise.h"

namespace parallax {
namespace {

constexpr float kDebris_m = 2;        // Depth of the aprons of walls.
constexpr float kOutcrop_m = 0.6f;    // Height of outcrops above a slope, times its roughness.
constexpr uint32_t kCragOctaves = 3;  // Longest octaves of detail, above 10 m.

Field SteepnessOf(const Field& height) {
  Field steepness = height;
  const int n = height.size;
  ForRows(height, [&](int row) {
    for (int column = 0; column < n; ++column) {
      const auto at = [&](int x, int y) {
        return height.At(std::clamp(x, 0, n - 1), std::clamp(y, 0, n - 1));
      };
      steepness.At(column, row) = Vec2f(at(column + 1, row) - at(column - 1, row),
                                        at(column, row + 1) - at(column, row - 1))
                                      .norm() /
                                  (2 * height.cell_m);
    }
  });
  return BoxBlurred(steepness, 1);
}

void Shape(const std::optional<Water>& water, Field& height) {
  if (!water) return;
  ForRows(height, [&](int row) {
    for (int column = 0; column < height.size; ++column) {
      float& at = height.At(column, row);
      at = water->Shaped(height.PositionOf(column, row), at).height_m;
    }
  });
}

// Returns the offset added to `p` before a raster with cells of `cell_m` is read, so that mask
// borders do not follow its cells.
Vec2f Frayed(const Vec2f& p, float cell_m, uint32_t seed) {
  Vec2f sum = Vec2f::Zero();
  float wavelength_m = 3.1f * cell_m, reach_m = 1.3f * cell_m;
  for (uint32_t octave = 0; octave < 4; ++octave) {
    const Vec2f q = p / wavelength_m;
    sum += reach_m * Vec2f(noise::Gradient3(q.x(), q.y(), 0.5f, seed + 2 * octave),
                           noise::Gradient3(q.x(), q.y(), 0.5f, seed + 2 * octave + 1));
    wavelength_m *= 0.45f;
    reach_m *= 0.5f;
  }
  return sum;
}

// A shift of some metres that turns straight courses between the region's samples into bends.
Vec2f Bend(const Vec2f& p, uint32_t seed) {
  return 16.0f * Vec2f(PlaneNoise(p / 90, seed), PlaneNoise(p / 90, seed + 1)) +
         6.0f * Vec2f(PlaneNoise(p / 31, seed + 2), PlaneNoise(p / 31, seed + 3));
}

}  // namespace

float Terrain::Weight(const Field& field, const Vec2f& p) {
  const float half = 0.5f * field.extent_m();
  const Vec2f from_center = (p - field.origin - Vec2f::Constant(half)).cwiseAbs() / half;
  return 1 - noise::SmoothStep(0.72f, 0.96f, from_center.maxCoeff());
}

float Terrain::Blend(const Field& site, const Field& region, const Vec2f& p) const {
  const float weight = Weight(site, p);
  if (weight <= 0) return region.Sample(p);
  if (weight >= 1) return site.Sample(p);
  return noise::Lerp(region.Sample(p), site.Sample(p), weight);
}

float Terrain::Base(const Vec2f& p) const {
  const float in_site = Weight(site_, p);
  if (in_site >= 1) return site_.SampleSmooth(p);
  const float in_region = Weight(region_, p);
  float height = 0;
  if (in_region > 0) height += in_region * region_.SampleSmooth(p);
  if (in_region < 1) {
    float far = 0;
    for (const TerrainTerm& term : spec_.terms) far += TermHeight(term, p, region_.cell_m);
    height += (1 - in_region) * far;
  }
  return in_site > 0 ? noise::Lerp(height, site_.SampleSmooth(p), in_site) : height;
}

// Bedrock breaks through slopes in patches, most on their steeper parts.
float Terrain::Outcrop(const Vec2f& p) const {
  const float slope = noise::SmoothStep(0.22f, 0.6f, Steepness(p));
  if (slope <= 0) return 0;
  const uint32_t seed = detail_seed_ + 4001u;
  const float form = PlaneNoise(p / 74, seed) + 0.55f * PlaneNoise(p / 23, seed + 1) +
                     0.3f * PlaneNoise(p / 7.3f, seed + 2);
  return slope * noise::SmoothStep(0.06f, 0.17f, form);
}

// Octaves from a few cells of the raster, the site's or the region's, down to the footprint. Steep
// ground is rocky and rough, laid-down ground is smooth.
float Terrain::Detail(const Vec2f& p, float footprint_m) const {
  if (spec_.roughness <= 0) return 0;
  const float outcrop = Outcrop(p);
  const float rocky = std::max(noise::SmoothStep(0.35f, 1.0f, Steepness(p)), outcrop);
  const float loose = (1 - outcrop) * noise::SmoothStep(0.05f, 0.6f, Deposit(p));
  const float strength = spec_.roughness * noise::Lerp(0.35f, 1.6f, rocky) * (1 - 0.5f * loose);
  // Crags and gullies: the region's samples hold none, only rock has them.
  const float crags = rocky * (1 - Weight(site_, p));
  float sum = outcrop * kOutcrop_m, wavelength_m = 86.7f, amplitude_m = 3.3f;
  // Soil is as smooth at every scale, rock is rougher the closer one looks.
  const float fade_of_octaves = noise::Lerp(0.45f, 0.62f, rocky);
  Vec2f q = p;
  for (uint32_t octave = 0; octave < 12; ++octave) {
    const float kept = noise::Fade(wavelength_m, footprint_m);
    if (kept <= 0) break;
    const float share = octave < kCragOctaves ? crags : 1;
    if (share > 0) {
      float value = PlaneNoise(q / wavelength_m, detail_seed_ + octave * 131u);
      // Rock has edges, soil has not.
      const float edged = 0.55f - 1.9f * std::min(0.6f, std::fabs(value));
      value = noise::Lerp(value, edged, 0.8f * rocky);
      sum += share * kept * amplitude_m * value;
    }
    q = Vec2f(0.8f * q.x() - 0.6f * q.y(), 0.6f * q.x() + 0.8f * q.y());
    wavelength_m *= 0.47f;
    amplitude_m *= fade_of_octaves;
  }
  return strength * sum;
}

float Terrain::Covered(const Vec2f& p, float eroded_m, float footprint_m, float* loose) const {
  float height = eroded_m, most = 0;
  for (const TerrainTerm& term : spec_.cover) {
    float debris = 0;
    height += TermHeight(term, p, footprint_m, &debris);
    most = std::max(most, debris);
  }
  if (loose) *loose = most;
  return strata_.any() ? strata_.Stepped(p, height, most) : height;
}

void Terrain::AddCover(Field& height, Field& deposit) const {
  ForRows(height, [&](int row) {
    for (int column = 0; column < height.size; ++column) {
      const Vec2f p = height.PositionOf(column, row);
      float& at = height.At(column, row);
      float loose = 0;
      at = Covered(p, at, height.cell_m, &loose);
      deposit.At(column, row) += kDebris_m * loose;
    }
  });
}

float Terrain::Height(const Vec2f& p, float footprint_m) const {
  Water::Form form{Base(p), 1};
  if (water_) form = water_->Shaped(p, form.height_m);
  float height = form.height_m;
  if (!spec_.cover.empty() || strata_.any()) height = Covered(p, height, footprint_m);
  float detail = form.detail * Detail(p, footprint_m);
  if (site_snow_.size > 0) {
    const float snow = SnowDepth(p);
    height += snow;
    detail *= 1 - 0.93f * noise::SmoothStep(0.04f, 0.4f, snow);
  }
  return height + detail - p.squaredNorm() / (2 * kEarthRadius_m);
}

float Terrain::AboveWater(const Vec2f& p) const {
  constexpr float kFootprint_m = 0.4f;
  if (!water_ || water_->FromShore(p) > water_->reach_m()) return kDry;
  return Height(p, kFootprint_m) - water_->Level(p);
}

float Terrain::Ledge(const Vec2f& p, float height_m) const {
  if (!has_ledges()) return 0;
  const float face =
      noise::SmoothStep(0.9f, 1.6f, Steepness(p)) * (1 - noise::SmoothStep(0.2f, 0.8f, Deposit(p)));
  return face > 0 ? face * strata_.Ledge({p.x(), p.y(), height_m}) : 0;
}

Vec2f Terrain::Slope(const Vec2f& p, float footprint_m) const {
  const float half = std::max(0.5f * footprint_m, 0.01f);
  const Vec2f along_x(half, 0), along_y(0, half);
  return Vec2f(Height(p + along_x, footprint_m) - Height(p - along_x, footprint_m),
               Height(p + along_y, footprint_m) - Height(p - along_y, footprint_m)) /
         (2 * half);
}

float Terrain::DrainageArea(const Vec2f& p) const { return Blend(site_area_, region_area_, p); }
float Terrain::Wetness(const Vec2f& p) const { return Blend(site_wetness_, region_wetness_, p); }
float Terrain::Deposit(const Vec2f& p) const { return Blend(site_deposit_, region_deposit_, p); }
float Terrain::Steepness(const Vec2f& p) const {
  return Blend(site_steepness_, region_steepness_, p);
}
float Terrain::SnowDepth(const Vec2f& p) const {
  if (site_snow_.size == 0) return 0;
  const float weight = Weight(site_snow_, p);
  if (weight >= 1) return site_snow_.Sample(p);
  const float far = region_snow_.Sample(p + Frayed(p, region_snow_.cell_m, detail_seed_ + 7));
  return weight <= 0 ? far : noise::Lerp(far, site_snow_.Sample(p), weight);
}

Terrain MakeTerrain(const TerrainSpec& spec) {
  const Rng rng(SceneSeed{spec.seed}, "terrain");
  Terrain terrain;
  terrain.spec_ = spec;
  terrain.strata_ = Strata(spec.strata);
  terrain.detail_seed_ = rng.Child("detail").Bits32();
  if (spec.water) terrain.water_.emplace(*spec.water);

  // The region: valleys.
  Field region = Field::Square(spec.region_samples, spec.region_m);
  FillWithTerms(spec.terms, region);
  Shape(terrain.water_, region);
  StreamPowerOptions streams = spec.streams;
  streams.seed = rng.Child("streams").Bits32();
  ErodeByStreams(region, streams);
  region = BoxBlurred(region, 1);  // Streams follow the raster's diagonals: not seen after this.
  Field region_deposit = Field::Square(spec.region_samples, spec.region_m);
  ThermalOptions gravity = spec.gravity;
  gravity.seed = rng.Child("gravity").Bits32();
  ErodeByGravity(region, region_deposit, gravity);

  // The site: what the terms have between the region's samples, then gullies, fans and screes.
  const uint32_t bend_seed = rng.Child("bend").Bits32();
  Field site = Field::Square(spec.site_samples, spec.site_m);
  ForRows(site, [&](int row) {
    for (int column = 0; column < site.size; ++column) {
      const Vec2f p = site.PositionOf(column, row);
      float finer = 0;
      for (const TerrainTerm& term : spec.terms) {
        finer += TermHeight(term, p, site.cell_m) - TermHeight(term, p, region.cell_m);
      }
      site.At(column, row) = region.SampleSmooth(p + Bend(p, bend_seed)) + finer;
    }
  });
  Field site_deposit = Field::Square(spec.site_samples, spec.site_m);
  DropletOptions rain = spec.rain;
  rain.seed = rng.Child("rain").Bits64();
  ErodeByDroplets(site, site_deposit, rain);
  ErodeByGravity(site, site_deposit, gravity);

  Shape(terrain.water_, region);
  Shape(terrain.water_, site);

  // Masks.
  tbb::parallel_invoke(
      [&] {
        terrain.region_area_ = DrainageArea(region, RouteFlow(region));
        terrain.region_wetness_ = BoxBlurred(Wetness(region, terrain.region_area_), 1);
      },
      [&] {
        terrain.site_area_ = DrainageArea(site, RouteFlow(site));
        terrain.site_wetness_ = BoxBlurred(Wetness(site, terrain.site_area_), 2);
      });
  Field region_surface = region;
  if (!spec.cover.empty() || terrain.strata_.any()) {
    terrain.surface_ = site;
    terrain.AddCover(region_surface, region_deposit);
    terrain.AddCover(terrain.surface_, site_deposit);
  }
  const Field& site_surface = terrain.surface_.size > 0 ? terrain.surface_ : site;
  terrain.region_steepness_ = SteepnessOf(region_surface);
  terrain.site_steepness_ = SteepnessOf(site_surface);
  if (spec.snow.depth_m > 0) {
    SnowSpec snow = spec.snow;
    snow.seed = rng.Child("snow").Bits32();
    terrain.region_snow_ = BoxBlurred(SnowOn(region_surface, snow), 1);
    terrain.site_snow_ = SnowOn(site_surface, snow);
  }
  terrain.region_deposit_ = std::move(region_deposit);
  terrain.site_deposit_ = std::move(site_deposit);
  terrain.region_ = std::move(region);
  terrain.site_ = std::move(site);
  return terrain;
}

}  // namespace parallax
