// Drainage of a height field: the neighbour into which each sample drains, an order in which
// everything downstream comes first, and drainage areas. Hollows are treated as filled with gentle
// fans that rise from their spill, so that all water reaches the border.
//
// Source: Barnes, Lehman, Mulla, "Priority-Flood", Computers & Geosciences 62, 2014, with a bucket
// queue: heights are told apart to 1/2^16 of the relief.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/terrain/field.h"

namespace parallax {

// The drainage graph of a height field, by index of samples.
struct FlowGraph {
  // Index of the sample that each one drains into; outlets: itself.
  std::vector<uint32_t> receivers;
  std::vector<uint32_t> order;  // Every sample once; a receiver stands before its donors.
  std::vector<float> filled;    // Height with hollows filled.
};

// Drains `height` to the field's border. Requires at least 3 x 3 samples and finite values.
FlowGraph RouteFlow(const Field& height);

// Returns the area that drains through each sample, its own included, in square metres.
Field DrainageArea(const Field& height, const FlowGraph& flow);

// Returns the topographic wetness index ln(area per width / slope), scaled to [0, 1] by its 2 % and
// 98 % quantiles: 1 in valley bottoms and flats, 0 on ridges.   Source: Beven, Kirkby 1979.
Field Wetness(const Field& height, const Field& drainage_area);

}  // namespace parallax
