#include "worker/assets/nature/species.h"

namespace parallax {

std::span<const BroadleafSpecies> BroadleafTable() {
  static const std::vector<BroadleafSpecies>& table = *new std::vector<BroadleafSpecies>{
      // clang-format off
    // name      low_m high_m base   radius profile
    // trunk    leader wander  up     gaps   twig_m twig_hang per_twig leaves
    // leaf                                               leaf_m  leaf_hang cover
    // bark                            twig_bark
      {"oak",    7,    11,    0.22f, 0.43f, {0.62f, 0.96f, 1.0f, 0.86f, 0.3f},
       0.030f,  0.42f, 0.030f, 0.12f, 0.34f, 0.38f, 0.05f,    8,       16000,
       {LeafShape::kLobed, 0.62f, 0.5f, 0.0f, 3, 0.3f},   0.11f,  0.25f,    4.2f,
       {"FurrowedBark"},               {"FurrowedBark"}},
      {"maple",  7,    11,    0.2f,  0.36f, {0.5f, 0.92f, 1.0f, 0.8f, 0.22f},
       0.024f,  0.55f, 0.018f, 0.3f,  0.27f, 0.34f, 0.08f,    6,       9500,
       {LeafShape::kPalmate, 1.0f, 0.5f, 0.22f, 0, 0.0f}, 0.12f,  0.5f,     4.6f,
       {"SmoothBark", "FurrowedBark"}, {"SmoothBark"}},
      {"birch",  8,    12.5f, 0.22f, 0.23f, {0.55f, 1.0f, 0.86f, 0.55f, 0.14f},
       0.0125f, 0.9f,  0.02f,  0.35f, 0.36f, 0.55f, 0.42f,    11,      15000,
       {LeafShape::kOvate, 0.72f, 0.4f, 0.0f, 3, 0.3f},   0.06f,  0.7f,     4.6f,
       {"BirchBark"},                  {"SmoothBark"}},
      {"willow", 6.5f, 9.5f,  0.3f,  0.45f, {0.8f, 1.0f, 0.95f, 0.75f, 0.3f},
       0.034f,  0.36f, 0.03f,  0.22f, 0.3f,  1.7f,  0.95f,    26,      26000,
       {LeafShape::kLance, 0.17f, 0.6f, 0.0f, 2, 0.5f},   0.11f,  0.8f,     3.2f,
       {"FurrowedBark"},               {"SmoothBark"}},
      {"acacia", 4.8f, 7.5f,  0.66f, 0.72f, {0.55f, 0.98f, 1.0f, 0.82f, 0.4f},
       0.022f,  0.3f,  0.032f, 0.1f,  0.36f, 0.28f, 0.0f,     10,      16000,
       {LeafShape::kOblong, 0.34f, 0.3f, 0.0f, 2, 0.2f},  0.055f, 0.1f,     2.7f,
       {"FurrowedBark"},               {"FurrowedBark"}},
      // clang-format on
  };
  return table;
}

std::span<const ConiferSpecies> ConiferTable() {
  static const std::vector<ConiferSpecies>& table = *new std::vector<ConiferSpecies>{
      // clang-format off
    // name      low_m high_m base   radius roundness trunk   whorl_m boughs rise_low
    // rise_high sag     needles               needle_m hang   lost   sheds  bark
      {"spruce", 8,    14,    0.07f, 0.2f,  0.85f,    0.014f, 0.42f,  6,     -0.3f,
       0.75f,    0.13f,  NeedleKind::kSpray,   0.25f,   0.45f, 0.08f, false, {"ConiferBark"}},
      {"pine",   8,    13,    0.4f,  0.27f, 0.4f,     0.017f, 0.42f,  5,     0.2f,
       1.0f,     -0.06f, NeedleKind::kTuft,    0.14f,   0.0f,  0.14f, false, {"ConiferBark"}},
      {"larch",  8,    13,    0.16f, 0.2f,  0.75f,    0.014f, 0.34f,  4,     -0.05f,
       0.7f,     0.08f,  NeedleKind::kRosette, 0.08f,   0.3f,  0.1f,  true,  {"ConiferBark"}},
      // clang-format on
  };
  return table;
}

std::vector<std::string> LeafMaterials(Season season) {
  switch (season) {
    case Season::kSpring:
      return {"SpringLeaf"};
    case Season::kAutumn:
      return {"AutumnLeaf"};
    default:
      return {"SummerLeaf"};
  }
}

}  // namespace parallax
