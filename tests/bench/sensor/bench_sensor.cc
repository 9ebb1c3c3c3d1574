// The photon transfer of the sensors' presets: noise over signal, as the sensor takes flat fields,
// beside the model. Prints one JSON line; it has per preset the largest deviation of the variance
// of the electrons, relative to the model, and of the noise of the 8-bit levels.
//
//   bench_sensor [--csv FILE] [--side 512] [--devices 3]
//
// Devices of a preset: the one in the middle of its ranges, and some that are drawn as for pairs.
// All that differs from pixel to pixel for other reasons is left out: lens, vignetting, JPEG.
// Levels are of each pixel's own colour, which the interpolation of the mosaic leaves as it was
// measured.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/system/file.h"
#include "common/config/config.h"
#include "common/config/sensor_presets.h"
#include "measure.h"
#include "tests/bench/program_main.h"
#include "transfer_model.h"
#include "worker/sensor/draw.h"
#include "worker/sensor/mosaic.h"
#include "worker/sensor/sensor_noise.h"
#include "worker/sensor/take_picture.h"

namespace parallax {
namespace {

constexpr const char* kPresets[] = {"industrial", "stereo_module", "webcam", "phone"};
const double kStep = std::sqrt(2.0);  // From one exposure to the next.
constexpr SceneSeed kSeed{1288};

struct Arguments {
  std::string csv;
  int side = 512;
  int devices = 3;
};

struct Device {
  std::string preset;
  int number = 0;  // 0: the one in the middle.
  SensorDraw draw;
};

// One exposure of one device.
struct Point {
  double electrons = 0;  // Wanted mean.
  Moments seen, model;   // Electrons.
  Moments seen_levels, model_levels;
};

double MiddleOf(const v1::Distribution& distribution) {
  const Support support = SupportOf(distribution);
  return (support.low + support.high) / 2;
}

std::vector<Device> DevicesOf(const std::string& preset, int drawn) {
  v1::SensorConfig config;
  TakeSensorPreset(preset, &config);
  std::vector<Device> devices(1, {preset, 0, {}});
  devices[0].draw.white_e = MiddleOf(config.white_e());
  devices[0].draw.read_noise_e = MiddleOf(config.read_noise_e());
  devices[0].draw.bayer = config.bayer();
  for (int i = 1; i <= drawn; ++i) {
    const SensorDraw all = DrawSensor(config, {kSeed, static_cast<uint32_t>(i), 0});
    Device& device = devices.emplace_back(Device{preset, i, {}});
    device.draw.white_e = all.white_e;
    device.draw.read_noise_e = all.read_noise_e;
    device.draw.bayer = all.bayer;
  }
  return devices;
}

// Darkness, then steps from an electron to just below where the pixel is full, there, and above.
std::vector<double> ExposuresOf(const SensorDraw& draw) {
  const double full = kFullWell * draw.white_e;
  std::vector<double> electrons = {0};
  const double unclipped = full - 5 * std::sqrt(full);
  for (double e = 1; e < unclipped; e *= kStep) electrons.push_back(e);
  electrons.push_back(unclipped);
  electrons.push_back(full);
  electrons.push_back(kStep * full);
  return electrons;
}

Moments MomentsOf(const std::vector<float>& values) {
  Moments moments;
  const auto count = static_cast<double>(values.size());
  for (const float v : values) moments.mean += double{v} / count;
  for (const float v : values) {
    moments.variance += (double{v} - moments.mean) * (double{v} - moments.mean) / (count - 1);
  }
  return moments;
}

// As a raw file has it.
Moments MeasureElectrons(const NoiseModel& model, double electrons, const Rng& stream, int side) {
  ImageF raw(side, side, static_cast<float>(electrons / model.white_e));
  AddNoise(model, stream, raw);
  Moments moments = MomentsOf(raw.values());
  moments.mean *= model.white_e;
  moments.variance *= model.white_e * model.white_e;
  return moments;
}

// As the picture of the whole sensor has it.
absl::StatusOr<Moments> MeasureLevels(const SensorDraw& draw, double electrons, uint32_t rig,
                                      int side) {
  const auto light = static_cast<float>(electrons / draw.white_e);
  ASSIGN_OR_RETURN(const ImageRgb8 picture,
                   TakePicture(draw, {kSeed, rig, 0}, {ImageF3(side, side, light), {}, {}}));
  std::vector<float> levels;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) levels.push_back(picture.At(x, y)[MosaicChannel(x, y)]);
  }
  return MomentsOf(levels);
}

// Takes one exposure, the device's `number`th.
absl::StatusOr<Point> Expose(const Device& device, double electrons, uint32_t number, int side) {
  const NoiseModel model{device.draw.white_e, device.draw.read_noise_e};
  const Rng stream = Rng(kSeed, device.preset)
                         .Child("device", static_cast<uint64_t>(device.number))
                         .Child("exposure", number);
  Point point;
  point.electrons = electrons;
  point.seen = MeasureElectrons(model, electrons, stream, side);
  point.model = ModelElectrons(model, electrons);
  ASSIGN_OR_RETURN(point.seen_levels, MeasureLevels(device.draw, electrons, number, side));
  point.model_levels = ModelLevels(model, electrons);
  return point;
}

// The largest deviations from the model, over all exposures of a preset's devices.
struct Deviations {
  double variance = 0;  // The variance of electrons deviates by this share of the model's.
  double noise_dn = 0;  // The standard deviation of 8-bit levels deviates by so many levels.
  int exposures = 0;

  void Take(const Point& p) {
    variance = std::max(variance, std::abs(p.seen.variance / p.model.variance - 1));
    noise_dn = std::max(
        noise_dn, std::abs(std::sqrt(p.seen_levels.variance) - std::sqrt(p.model_levels.variance)));
    ++exposures;
  }
};

constexpr char kCsvHeader[] =
    "preset,device,white_e,read_noise_e,electrons,mean_e,variance_e2,model_mean_e,"
    "model_variance_e2,mean_dn,variance_dn2,model_mean_dn,model_variance_dn2\n";

std::string CsvRow(const Device& device, const Point& p) {
  std::string row = fmt::format("{},{},{:.6g},{:.6g},{:.6g}", device.preset, device.number,
                                device.draw.white_e, device.draw.read_noise_e, p.electrons);
  for (const Moments& m : {p.seen, p.model, p.seen_levels, p.model_levels}) {
    row += fmt::format(",{:.6g},{:.6g}", m.mean, m.variance);
  }
  return row + "\n";
}

absl::StatusOr<Deviations> MeasurePreset(const std::string& preset, const Arguments& arguments,
                                         std::string* csv) {
  Deviations deviations;
  for (const Device& device : DevicesOf(preset, arguments.devices)) {
    uint32_t number = 0;
    for (const double electrons : ExposuresOf(device.draw)) {
      ASSIGN_OR_RETURN(const Point point, Expose(device, electrons, number++, arguments.side));
      deviations.Take(point);
      *csv += CsvRow(device, point);
    }
  }
  return deviations;
}

absl::Status Measure(const Arguments& arguments, const std::string& command) {
  std::string csv = kCsvHeader;
  nlohmann::ordered_json presets = nlohmann::ordered_json::object();
  double worst = 0;
  for (const char* preset : kPresets) {
    ASSIGN_OR_RETURN(const Deviations seen, MeasurePreset(preset, arguments, &csv));
    presets[preset] = {{"variance_deviation", seen.variance},
                       {"noise_deviation_dn", seen.noise_dn},
                       {"exposures", seen.exposures}};
    worst = std::max(worst, seen.variance);
  }
  if (!arguments.csv.empty()) RETURN_IF_ERROR(WriteFile(arguments.csv, csv));
  const double pixels = double{1} * arguments.side * arguments.side;
  const nlohmann::ordered_json line = {{"bench", "sensor"},
                                       {"largest_variance_deviation", worst},
                                       {"standard_error", std::sqrt(2 / pixels)},
                                       {"presets", presets},
                                       {"pixels", pixels},
                                       {"machine", MachineText()},
                                       {"commit", FirstLineOf("git rev-parse --short HEAD")},
                                       {"command", command}};
  std::printf("%s\n", line.dump().c_str());
  return absl::OkStatus();
}

absl::Status Run(int argc, char** argv, int* exit_code) {
  Arguments arguments;
  CLI::App app("The photon transfer of the sensors' presets beside the model; one JSON line.",
               "bench_sensor");
  app.add_option("--csv", arguments.csv, "File for the curves");
  app.add_option("--side", arguments.side, "Pixels of a flat field are its square (default 512)")
      ->check(CLI::Range(16, 4096));
  app.add_option("--devices", arguments.devices, "Drawn devices of each preset (default 3)")
      ->check(CLI::Range(0, 100));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error);
    return absl::OkStatus();
  }
  std::string command = "bench_sensor";
  for (int i = 1; i < argc; ++i) command += std::string(" ") + argv[i];
  return Measure(arguments, command);
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  return parallax::ProgramMain("bench_sensor", &parallax::Run, argc, argv);
}
