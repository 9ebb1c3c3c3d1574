// The parameters in which tree species differ: rows of two tables. Lengths named `_m` are metres;
// the others are parts of the tree's height unless they say otherwise.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "worker/assets/nature/sheets.h"

namespace parallax {

// The season, which decides number and colour of leaves.
enum class Season { kSpring, kSummer, kAutumn, kWinter, kCount };

// A broadleaf tree; a row of the first table.
struct BroadleafSpecies {
  std::string_view name;
  float height_low_m, height_high_m;
  float crown_base;              // Where the crown begins.
  float crown_radius;            // At its widest.
  std::array<float, 5> profile;  // Crown's radius at 0, 1/4... 1 of its height; 1 is the widest.
  float trunk_radius;            // Above the flare.
  float leader;                  // Where the trunk dissolves into limbs.
  float wander;                  // How far trunk and limbs wander.
  float up;                      // How much limbs turn upwards, in steps; negative: they hang.
  float gaps;                    // Share of the crown without limbs.
  float twig_m;
  float twig_hang;  // 0 straight on, 1 down.
  int leaves_per_twig;
  int leaves;  // In summer, near.
  LeafForm leaf;
  float leaf_m;     // At least; more where the crown is large.
  float leaf_hang;  // 0 spread, 1 down.
  float cover;      // Area of all leaves over that of the crown's ground plan.
  std::vector<std::string> bark, twig_bark;
};

// Arrangement of needles: flat sprays (spruce), tufts (pine), rosettes (larch).
enum class NeedleKind { kSpray, kTuft, kRosette };

// A conifer; a row of the second table.
struct ConiferSpecies {
  std::string_view name;
  float height_low_m, height_high_m;
  float crown_base;
  float crown_radius;  // Length of the lowest whole boughs.
  float roundness;     // Exponent of the crown's outline: 1 a cone, 0.4 a dome.
  float trunk_radius;
  float whorl_m;    // Between two whorls.
  int boughs;       // A whorl.
  float rise_low;   // Radians above the horizon of the lowest boughs...
  float rise_high;  // ...and of the highest.
  float sag;        // How far boughs hang before their ends turn up, in their lengths.
  NeedleKind needles;
  float needle_m;  // Length of a spray or a tuft.
  float hang;      // How far side twigs hang.
  float lost;      // Share of boughs that are missing, more below; and how uneven they are.
  bool sheds;      // Golden in autumn, bare in winter.
  std::vector<std::string> bark;
};

// Return the rows of the two tables, which BroadleafParams and ConiferParams index. The rows live
// as long as the program.
std::span<const BroadleafSpecies> BroadleafTable();
std::span<const ConiferSpecies> ConiferTable();

// Returns the material classes for leaves of a season.
std::vector<std::string> LeafMaterials(Season season);

}  // namespace parallax
