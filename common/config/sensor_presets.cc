#include "common/config/sensor_presets.h"

#include <yaml-cpp/yaml.h>

#include "common/config/defaults.h"
#include "common/config/yaml/yaml_reader.h"

namespace parallax {
namespace {

// Numbers that data sheets of such cameras and their measurements by EMVA Standard 1288 lie around.
// Few electrons stand for white where pixels are small or the gain is high.
constexpr struct {
  std::string_view name;
  const char* yaml;
} kSensorPresets[] = {
    {"off", "{}"},
    {"ideal", "{}"},
    // Global shutter, pixels of 3.5 to 6 um, fixed lens; both eyes triggered and set together.
    {"industrial", R"({
       exposure_ev: {uniform: [-0.3, 0.3]}, exposure_mismatch_ev: {clip_gaussian: [0, 0.03, -0.1, 0.1]},
       white_balance_ev: {uniform: [-0.05, 0.05]},
       white_balance_mismatch_ev: {clip_gaussian: [0, 0.02, -0.06, 0.06]},
       white_e: {uniform: [2500, 10000]}, read_noise_e: {uniform: [2, 7]},
       psf_sigma_px: {uniform: [0.35, 0.6]}, vignetting: {uniform: [0.05, 0.25]}, bayer: true})"},
    // A ready-made stereo camera: pixels of about 3 um, small lenses focused far away.
    {"stereo_module", R"({
       exposure_ev: {uniform: [-0.5, 0.5]}, exposure_mismatch_ev: {clip_gaussian: [0, 0.06, -0.2, 0.2]},
       white_balance_ev: {uniform: [-0.12, 0.12]},
       white_balance_mismatch_ev: {clip_gaussian: [0, 0.04, -0.12, 0.12]},
       white_e: {uniform: [800, 6000]}, read_noise_e: {uniform: [3, 8]},
       psf_sigma_px: {uniform: [0.45, 0.9]}, defocus_px: {uniform: [0, 1.5]},
       focus_m: {uniform: [1.5, 4]}, vignetting: {uniform: [0.1, 0.4]}, bayer: true})"},
    // Two cheap cameras side by side, each with its own automatics.
    {"webcam", R"({
       exposure_ev: {uniform: [-0.8, 0.8]}, exposure_mismatch_ev: {clip_gaussian: [0, 0.15, -0.5, 0.5]},
       white_balance_ev: {uniform: [-0.25, 0.25]},
       white_balance_mismatch_ev: {clip_gaussian: [0, 0.1, -0.3, 0.3]},
       white_e: {uniform: [150, 2000]}, read_noise_e: {uniform: [4, 10]},
       psf_sigma_px: {uniform: [0.6, 1.2]}, defocus_px: {uniform: [0, 3]}, focus_m: {uniform: [0.6, 2]},
       vignetting: {uniform: [0.15, 0.5]}, bayer: true, jpeg_quality: {uniform_int: [70, 95]}})"},
    // Pixels of about 1 um that a large aperture makes up for.
    {"phone", R"({
       exposure_ev: {uniform: [-0.4, 0.4]}, exposure_mismatch_ev: {clip_gaussian: [0, 0.08, -0.25, 0.25]},
       white_balance_ev: {uniform: [-0.12, 0.12]},
       white_balance_mismatch_ev: {clip_gaussian: [0, 0.06, -0.2, 0.2]},
       white_e: {uniform: [400, 4000]}, read_noise_e: {uniform: [1.5, 4]},
       psf_sigma_px: {uniform: [0.5, 0.9]}, defocus_px: {uniform: [0, 4]}, focus_m: {uniform: [0.8, 5]},
       vignetting: {uniform: [0.1, 0.35]}, bayer: true, jpeg_quality: {uniform_int: [85, 98]}})"},
};

}  // namespace

void TakeSensorPreset(std::string_view name, v1::SensorConfig* sensor) {
  for (const auto& preset : kSensorPresets) {
    if (preset.name != name) continue;
    sensor->Clear();
    sensor->set_preset(std::string(name));  // First: the default of this field leads here again.
    config_internal::ConfigErrors errors;
    config_internal::YamlReader("built-in sensor", &errors)
        .Merge(YAML::Load(preset.yaml), sensor, "");
    config_internal::ApplyDefaults(sensor);
  }
  sensor->set_preset(std::string(name));
}

}  // namespace parallax
