// Named sensors: what SensorConfig.preset stands for.
#pragma once

#include <string_view>

#include "parallax/v1/config.pb.h"

namespace parallax {

// Sets every field of `sensor` to the preset's, `preset` included. An unknown name sets that alone:
// the check of texts tells of it.
void TakeSensorPreset(std::string_view name, v1::SensorConfig* sensor);

}  // namespace parallax
