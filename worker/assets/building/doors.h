// Door leaves with handles and hinges. The wall plane is y = 0, the leaf is in front of it and
// looks right from both sides.
#pragma once

#include <vector>

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {

// The filling of an opening in the leaf.
enum class DoorFill { kPanel, kGlass, kLouver };
enum class DoorHandle { kLever, kKnob, kPull, kCount };

// Stiles and rails around rows of openings.
struct DoorParams {
  struct Row {
    float share = 1;  // Weight of this row in the height that rails leave.
    int columns = 1;
    DoorFill fill = DoorFill::kPanel;
    int lites_x = 1, lites_y = 1;  // Glazing bars within an opening.
  };
  std::vector<Row> rows{Row{}};  // From the bottom.
  float width_m = 0.82f;
  float height_m = 2.03f;
  float thickness_m = 0.042f;
  float stile_m = 0.11f;
  float rail_m = 0.12f;
  float bottom_rail_m = 0.2f;
  bool raised = true;  // Panels with a raised field.
  bool hinged_right = false;
  DoorHandle handle = DoorHandle::kLever;
  uint64_t seed = 0;
};
Asset MakeDoor(const DoorParams& params);

}  // namespace parallax
