// Calibrations of cameras as other tools write them: any text ends in a camera that a config may
// have, or in an error. The first byte chooses what the user says beside the file.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "common/base/system/file.h"
#include "common/calibration/calibration.h"
#include "common/config/config.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 2) return 0;
  const char* const parts[] = {"", "HD", "2K", "00", "02"};
  parallax::CalibrationOptions options;
  options.part = parts[data[0] % 5];
  if (data[0] & 128) options.unit_m = 0.001;
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  const auto camera = parallax::ParseCalibration(text, "fuzz", options);
  if (camera.ok() && !(std::isfinite(camera->rectified.fx_px) && camera->rectified.fx_px > 0)) {
    std::fprintf(stderr, "a camera without a focal length was accepted\n");
    std::abort();
  }
  if (!camera.ok()) return 0;
  const std::string path = parallax::FuzzFolder() + "/camera";
  if (!parallax::WriteFile(path, text).ok()) return 0;
  std::string config =
      "rigs:\n  width_px: 640\n  height_px: 480\n  camera:\n    calibration: " + path + "\n";
  if (!options.part.empty()) config += "    calibration_part: \"" + options.part + "\"\n";
  if (options.unit_m) config += "    calibration_unit_m: 0.001\n";
  (void)parallax::ParseSceneConfig(config, "/fuzz.yaml");
  return 0;
}
