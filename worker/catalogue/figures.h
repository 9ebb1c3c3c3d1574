// Measured sizes, triangle counts and times of the catalogues' classes. Times are processor times
// of the calling thread, so that other work on the machine does not count. Thread-safe.
#pragma once

#include <string>
#include <vector>

#include "worker/assets/asset.h"
#include "worker/materials/kernel/material.h"

namespace parallax {

// Figures of one asset class over its seeds.
struct AssetFigures {
  const AssetClass* asset_class = nullptr;
  Vec3f least_m = Vec3f::Zero(), most_m = Vec3f::Zero();        // AssetClass::size.
  Vec3f smallest_m = Vec3f::Zero(), largest_m = Vec3f::Zero();  // Measured, axis by axis.
  size_t median_triangles = 0, most_triangles = 0;
  std::vector<double> ms;  // Processor time of each seed in ms, ascending.
  double median_ms = 0;
  std::vector<std::string> slots;  // Names of all material slots seen, in order of first use.
  bool offers_support = false;     // Other things can stand on it.
};

// Makes the class with seeds 1..`seeds` and measures each, after one seed that is not counted.
AssetFigures MeasureAssetClass(const AssetClass& asset_class, int seeds);

// Times of one material class.
struct MaterialFigures {
  const MaterialClass* material_class = nullptr;
  // Per point, in batches of eight, at a pixel's footprint; mean of three seeds.
  double evaluate_ns = 0;
  double height_ns = 0;  // As above, for the height.
};

// Measures three seeds of the class.
MaterialFigures MeasureMaterialClass(const MaterialClass& material_class);

// Returns the value below which the fraction `p` in [0, 1] of the sorted values lies; 0 for an
// empty list.
double Percentile(const std::vector<double>& sorted, double p);

// Returns the words for a placement: "floor", "floor against wall", "on top", "on wall", "ceiling",
// "opening"...
const char* PlacementName(Placement placement);

// Returns the tags that are set, joined by ", ": "floor", "walls", "metal or glass"...
std::string TagNames(const MaterialTags& tags);

}  // namespace parallax
