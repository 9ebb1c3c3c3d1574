#include <algorithm>

#include "common/calibration/calibration.h"

namespace parallax {
namespace {

struct Preset {
  const char* name;
  int width_px, height_px;
  double fx_px, fy_px, cx_px, cy_px;
  double baseline_m;
  ProjectorFacts projector;
};

// Rectified intrinsics. Cameras off the shelf have the numbers of their data sheet and the axis
// in the middle: each unit has its own calibration, which `calibration` imports.
constexpr Preset kPresets[] = {
    // 2.1 mm lens, pixels of 4 um at 1280x720 (HD720), baseline 120 mm.
    // Source: Stereolabs, ZED 2i datasheet rev 1 and "What is the camera focal length".
    {"zed_2i", 1280, 720, 525, 525, 640, 360, 0.12, {}},
    // 1.93 mm lens, pixels of 3 um, 1280x720 of the infrared cameras, baseline 50 mm. Its
    // projector:
    // 850 nm, 360 mW on average, 90 x 63 degrees ("wide"), some 5000 dots.
    // Source: as below (D430 module, camera D435).
    {"realsense_d435", 1280, 720, 643.333333, 643.333333, 640, 360, 0.05, {0.36, 5000, 90, 63}},
    // 1.93 mm lens, pixels of 3 um, 1280x720 of the infrared cameras, baseline 95 mm.
    // Source: Intel RealSense product family D400, datasheet 337029 (D450 module).
    {"realsense_d455", 1280, 720, 643.333333, 643.333333, 640, 360, 0.095, {}},
    // 2.35 mm lens, pixels of 3 um, 1280x800 of the OV9282 pair, baseline 75 mm.
    // Source: Luxonis, OAK-D spec sheet.
    {"oak_d", 1280, 800, 783.333333, 783.333333, 640, 400, 0.075, {}},
    // Source: KITTI, 2011_09_26/calib_cam_to_cam.txt: P_rect_02, P_rect_03, S_rect_02.
    {"kitti", 1242, 375, 721.5377, 721.5377, 609.5593, 172.854, 0.532725, {}},
    // Half of the size, as its benchmark's "H". Source: Middlebury 2014,
    // Adirondack-perfect/calib.txt.
    {"middlebury", 1440, 994, 2080.6105, 2080.6105, 722.7885, 492.343, 0.176252, {}},
    // Source: ETH3D low-res two-view, delivery_area_1l/calib.txt.
    {"eth3d", 941, 490, 541.764, 541.764, 553.869, 232.396, 0.0599054, {}},
    // A quarter of 4112x3008, baseline 80 mm. Source: Zama Ramirez et al., "Booster", CVPR 2022.
    // The focal length is nominal, 3200 px at full size: its scenes have calibrations of their own.
    {"booster", 1028, 752, 800, 800, 514, 376, 0.08, {}},
};

}  // namespace

const std::vector<std::string>& CameraPresets() {
  static const std::vector<std::string>* names = [] {
    auto* all = new std::vector<std::string>;
    for (const Preset& preset : kPresets) all->push_back(preset.name);
    return all;
  }();
  return *names;
}

std::optional<StereoCalibration> FindCameraPreset(std::string_view name) {
  const auto* found = std::find_if(std::begin(kPresets), std::end(kPresets),
                                   [&](const Preset& preset) { return name == preset.name; });
  if (found == std::end(kPresets)) return std::nullopt;
  StereoCalibration calibration;
  calibration.format = "preset";
  calibration.width_px = found->width_px;
  calibration.height_px = found->height_px;
  calibration.rectified = {found->fx_px, found->fy_px, found->cx_px, found->cy_px};
  calibration.baseline_m = found->baseline_m;
  if (found->projector.power_w > 0) calibration.projector = found->projector;
  return calibration;
}

}  // namespace parallax
