// Presets of sensors: the values that SensorConfig.preset stands for.
#pragma once

#include <string_view>

#include "parallax/v1/config.pb.h"

namespace parallax {

// Sets every field of `sensor` to the preset's value, `preset` included. An unknown name only sets
// `preset`, which the check of the config then reports.
void TakeSensorPreset(std::string_view name, v1::SensorConfig* sensor);

}  // namespace parallax
