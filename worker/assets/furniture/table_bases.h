// Tables: their parameters and bases.
#pragma once

#include "worker/assets/parts.h"

namespace parallax {

// Outlines of table tops.
enum class TopStyle { kSquare, kRound, kOval, kRounded, kPlanks, kCount };

enum class TableBase { kLegs, kTrestle, kPedestal, kSledge, kCrossed, kHairpin, kColumn, kCount };

// A table of any height.
struct TableParams {
  float width_m = 1.6f;  // Along x.
  float depth_m = 0.9f;
  float height_m = 0.75f;
  float top_m = 0.032f;  // Thickness of the top.
  TopStyle top = TopStyle::kSquare;
  TableBase base = TableBase::kLegs;
  LegStyle legs = LegStyle::kTapered;
  int leg_variant = 0;
  float leg_m = 0.065f;
  bool apron = true;
  bool shelf = false;  // A lower board between the legs.
  bool rungs = false;  // Bars between the legs, for feet.
  bool glass_top = false;
  uint64_t seed = 0;
};

// Adds the base that the parameters name, below the top; one with a shelf declares its support.
void AddTableBase(kernel::AssetBuilder& b, const TableParams& p);

}  // namespace parallax
