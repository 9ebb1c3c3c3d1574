#include "worker/dataset/frame/sensor_stage.h"

#include <tbb/parallel_invoke.h>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/config/config.h"
#include "common/config/frame_files.h"
#include "common/image/io.h"
#include "worker/dataset/frame/frame_images.h"
#include "worker/dataset/frame/frame_json.h"
#include "worker/dataset/frame/frame_reader.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;
using PathOfFile = std::function<std::string(const std::string& name)>;

constexpr char kSensorEntry[] = "sensor";
constexpr const char* kDepthFiles[2] = {"depth_left.exr", "depth_right.exr"};

Json DrawJson(const SensorDraw& draw) {
  return {{"exposure_ev", draw.exposure_ev},   {"red_ev", draw.red_ev},
          {"blue_ev", draw.blue_ev},           {"white_e", draw.white_e},
          {"read_noise_e", draw.read_noise_e}, {"psf_sigma_px", draw.psf_sigma_px},
          {"defocus_px", draw.defocus_px},     {"focus_m", draw.focus_m},
          {"vignetting", draw.vignetting},     {"bayer", draw.bayer},
          {"jpeg_quality", draw.jpeg_quality}, {"exposure_ms", draw.exposure_ms},
          {"shake_m_s", draw.shake_m_s},       {"shake_rad_s", draw.shake_rad_s}};
}

absl::StatusOr<SensorDraw> DrawOfJson(const Json& json) {
  SensorDraw draw;
  try {
    json.at("exposure_ev").get_to(draw.exposure_ev);
    json.at("red_ev").get_to(draw.red_ev);
    json.at("blue_ev").get_to(draw.blue_ev);
    json.at("white_e").get_to(draw.white_e);
    json.at("read_noise_e").get_to(draw.read_noise_e);
    json.at("psf_sigma_px").get_to(draw.psf_sigma_px);
    json.at("defocus_px").get_to(draw.defocus_px);
    json.at("focus_m").get_to(draw.focus_m);
    json.at("vignetting").get_to(draw.vignetting);
    json.at("bayer").get_to(draw.bayer);
    json.at("jpeg_quality").get_to(draw.jpeg_quality);
    // Frames of version 0.2.0 tell no motion, because their sensors knew none.
    draw.exposure_ms = json.value("exposure_ms", 0.0);
    draw.shake_m_s = json.value("shake_m_s", draw.shake_m_s);
    draw.shake_rad_s = json.value("shake_rad_s", draw.shake_rad_s);
  } catch (const Json::exception& error) {
    return DataLoss("sensor: {}", error.what());
  }
  return draw;
}

// The facts on a pair in its frame.json.
struct PairFacts {
  SensorFrame frame;
  uint32_t rig = 0;
  EyeMotion left;            // As its path moves it.
  bool motion_told = false;  // False: a frame of a path by version 0.2.0.
  double baseline_m = 0;
};

Vec3d VectorOf(const Json& json) {
  const auto values = json.get<std::array<double, 3>>();
  return {values[0], values[1], values[2]};
}

absl::StatusOr<PairFacts> FactsOfFrame(const Json& json) {
  const Json seeds = json.value("seeds", Json::object());
  const auto seed = SeedOf(seeds.value("scene", Json()));
  if (!seed || !json.contains("rig") || !json["rig"].is_number_unsigned()) {
    return DataLoss("frame.json says no seed or no rig");
  }
  PairFacts facts;
  try {
    facts.rig = json.at("rig").get<uint32_t>();
    facts.frame = {SceneSeed{*seed}, json.value("left_rig", facts.rig), 0};
    facts.baseline_m = json.at("baseline_m").get<double>();
    const Json& k = json.at("intrinsics");
    facts.left.fx_px = k.at("fx").get<double>();
    facts.left.fy_px = k.at("fy").get<double>();
    facts.left.cx_px = k.at("cx").get<double>();
    facts.left.cy_px = k.at("cy").get<double>();
    facts.motion_told = !json.contains("sequence") || json.contains("motion");
    if (!json.contains("sequence")) return facts;
    facts.frame.path = json.at("sequence").at("path").get<uint32_t>();
    if (!facts.motion_told) return facts;
    facts.left.velocity_m_s = VectorOf(json.at("motion").at("velocity_m_s"));
    facts.left.turn_rad_s = VectorOf(json.at("motion").at("turn_rad_s"));
  } catch (const Json::exception& error) {
    return DataLoss("frame.json: {}", error.what());
  }
  return facts;
}

// The eyes are fixed to each other: a turn moves the right one as well.
EyeMotion MotionOf(const SensorDraw& draw, const PairFacts& pair, int eye) {
  EyeMotion motion = pair.left;
  motion.exposure_s = 1e-3 * draw.exposure_ms;
  motion.velocity_m_s += Vec3d(draw.shake_m_s.data());
  motion.turn_rad_s += Vec3d(draw.shake_rad_s.data());
  if (eye == 1) motion.velocity_m_s += motion.turn_rad_s.cross(Vec3d(pair.baseline_m, 0, 0));
  return motion;
}

// Returns what a frame keeps of one eye; its depth only if that is asked for.
using ViewOfEye = std::function<absl::StatusOr<LinearView>(int eye, bool with_depth)>;

ViewOfEye FromFiles(const PathOfFile& path_of) {
  return [path_of](int eye, bool with_depth) -> absl::StatusOr<LinearView> {
    LinearView view;
    absl::StatusOr<ImageF3> light = ReadExrRgb(path_of(kLinearFiles[eye]));
    if (absl::IsNotFound(light.status())) {
      return FailedPrecondition(
          "a sensor makes its pictures of linear ones, and the frame keeps none (render.keep_hdr): "
          "{}",
          light.status().message());
    }
    RETURN_IF_ERROR(light.status());
    view.light = *std::move(light);
    if (with_depth) {
      ASSIGN_OR_RETURN(view.depth_m, ReadExrY(path_of(kDepthFiles[eye])));
    }
    return view;
  };
}

ViewOfEye FromMemory(const StereoFrame& frame) {
  return [&frame](int eye, bool with_depth) -> absl::StatusOr<LinearView> {
    const View& rendered = eye == 0 ? frame.left : frame.right;
    LinearView view{.light = LightOf(rendered, frame.exposure)};
    if (with_depth) view.depth_m = rendered.depth_m;
    return view;
  };
}

absl::StatusOr<ImageRgb8> TakeEye(const SensorDraw& draw, const PairFacts& pair, int eye,
                                  const ViewOfEye& view_of) {
  const EyeMotion motion = MotionOf(draw, pair, eye);
  ASSIGN_OR_RETURN(LinearView view, view_of(eye, draw.defocus_px > 0 || !motion.IsStill()));
  view.motion = motion;
  const uint32_t rig = eye == 0 ? pair.frame.rig : pair.rig;
  return TakePicture(draw, {pair.frame.seed, rig, eye}, std::move(view));
}

absl::StatusOr<SensorPictures> TakeBoth(const SensorDraw& draw, const PairFacts& pair,
                                        const ViewOfEye& view_of) {
  if (draw.exposure_ms > 0 && !pair.motion_told) {
    return DataLoss("frame.json says no motion of its path, which sensor.exposure_ms needs");
  }
  absl::StatusOr<ImageRgb8> left = ImageRgb8(), right = ImageRgb8();
  tbb::parallel_invoke([&] { left = TakeEye(draw, pair, 0, view_of); },
                       [&] { right = TakeEye(draw, pair, 1, view_of); });
  RETURN_IF_ERROR(left.status());
  RETURN_IF_ERROR(right.status());
  return SensorPictures{*std::move(left), *std::move(right)};
}

}  // namespace

std::vector<std::string> FilesForSensor(const v1::SensorConfig& config) {
  std::vector<std::string> names = {"frame.json", kLinearFiles[0], kLinearFiles[1]};
  if (SupportOf(config.defocus_px()).high > 0 || SupportOf(config.exposure_ms()).high > 0) {
    names.insert(names.end(), {kDepthFiles[0], kDepthFiles[1]});
  }
  return names;
}

std::string SensorKey(const v1::SensorConfig& config,
                      const google::protobuf::RepeatedPtrField<v1::FileEntry>& files) {
  Sha256 hash;
  hash.Update("sensor ").Update(kSensorVersion).Update("\n").Update(config.SerializeAsString());
  for (const std::string& name : FilesForSensor(config)) {
    for (const v1::FileEntry& file : files) {
      if (file.name() == name) hash.Update(name).Update(file.sha256());
    }
  }
  return HexOf(hash.Finish());
}

absl::StatusOr<std::map<std::string, std::string>> MakeSensorFiles(const v1::SensorConfig& config,
                                                                   const std::string& key,
                                                                   const PathOfFile& path_of) {
  ASSIGN_OR_RETURN(const std::string text, ReadFile(path_of("frame.json")));
  Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return DataLoss("{}: not JSON", path_of("frame.json"));
  ASSIGN_OR_RETURN(const PairFacts pair, FactsOfFrame(json));
  const SensorDraw draw = DrawSensor(config, pair.frame);
  ASSIGN_OR_RETURN(const SensorPictures pictures, TakeBoth(draw, pair, FromFiles(path_of)));

  json[kSensorEntry] = {{"key", key}, {"version", kSensorVersion}, {"preset", config.preset()}};
  json[kSensorEntry].update(DrawJson(draw));
  absl::StatusOr<std::string> left = std::string(), right = std::string();
  tbb::parallel_invoke([&] { left = EncodePng(pictures.left); },
                       [&] { right = EncodePng(pictures.right); });
  RETURN_IF_ERROR(left.status());
  RETURN_IF_ERROR(right.status());
  return std::map<std::string, std::string>{{"left.png", *std::move(left)},
                                            {"right.png", *std::move(right)},
                                            {"frame.json", FrameJsonText(json)}};
}

std::string SensorKeyOf(const Json& frame_json) {
  const Json entry = frame_json.value(kSensorEntry, Json::object());
  return entry.is_object() && entry.contains("key") && entry["key"].is_string()
             ? entry["key"].get<std::string>()
             : "";
}

absl::StatusOr<SensorPictures> RepeatSensor(const Json& frame_json, const std::string& dir) {
  ASSIGN_OR_RETURN(const SensorDraw draw,
                   DrawOfJson(frame_json.value(kSensorEntry, Json::object())));
  ASSIGN_OR_RETURN(const PairFacts pair, FactsOfFrame(frame_json));
  return TakeBoth(draw, pair,
                  FromFiles([&dir](const std::string& name) { return dir + "/" + name; }));
}

absl::StatusOr<SensorPictures> TakeSensor(const v1::SensorConfig& config, const v1::Scene& scene,
                                          const v1::Rig& rig, const StereoFrame& frame,
                                          double scale) {
  // The facts are read as they are from a frame on disk.
  ASSIGN_OR_RETURN(const std::string json, FrameJson(scene, rig, frame, {}, {}));
  ASSIGN_OR_RETURN(const PairFacts pair, FactsOfFrame(Json::parse(json)));
  SensorDraw draw = DrawSensor(config, pair.frame);
  draw.psf_sigma_px *= scale;
  draw.defocus_px *= scale;
  return TakeBoth(draw, pair, FromMemory(frame));
}

}  // namespace parallax
