#include "worker/scene/rigs/rig_camera.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/config/config.h"
#include "common/math/raw_rig.h"

namespace parallax {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180;

double DrawOr(bool given, const v1::Distribution& distribution, const Rng& stream, const char* name,
              double otherwise) {
  return given ? Draw(distribution, stream.Child(name).Uniform()) : otherwise;
}

// Picture size that the config's numbers are given for, and the scale from it to that of the rig.
struct Scale {
  int width_px, height_px;
  double x, y;
};

Scale ScaleOf(const v1::RigConfig& config) {
  const v1::CameraConfig& camera = config.camera();
  Scale scale{config.width_px(), config.height_px(), 1, 1};
  if (!camera.has_width_px() || !camera.has_height_px()) return scale;
  scale.width_px = camera.width_px();
  scale.height_px = camera.height_px();
  scale.x = static_cast<double>(config.width_px()) / scale.width_px;
  scale.y = static_cast<double>(config.height_px()) / scale.height_px;
  return scale;
}

void AddLens(const v1::LensConfig& lens, const Rng& stream, v1::RawCamera* raw) {
  raw->set_lens(lens.model() == v1::LensConfig::MODEL_UNSPECIFIED ? v1::LensConfig::MODEL_NONE
                                                                  : lens.model());
  const auto add = [&](bool given, const v1::Distribution& k, const char* name) {
    raw->add_distortion(DrawOr(given, k, stream, name, 0));
  };
  if (raw->lens() == v1::LensConfig::MODEL_NONE) return;
  add(lens.has_k1(), lens.k1(), "k1");
  add(lens.has_k2(), lens.k2(), "k2");
  if (raw->lens() == v1::LensConfig::MODEL_KANNALA_BRANDT) {
    add(lens.has_k3(), lens.k3(), "k3");
    add(lens.has_k4(), lens.k4(), "k4");
    return;
  }
  add(lens.has_p1(), lens.p1(), "p1");
  add(lens.has_p2(), lens.p2(), "p2");
  add(lens.has_k3(), lens.k3(), "k3");
  if (!lens.has_k4() && !lens.has_k5() && !lens.has_k6()) return;
  add(lens.has_k4(), lens.k4(), "k4");
  add(lens.has_k5(), lens.k5(), "k5");
  add(lens.has_k6(), lens.k6(), "k6");
}

// `eye` 0 left, 1 right.
v1::RawCamera DrawRaw(const v1::RigConfig& config, int eye, const Rng& stream, const v1::Rig& rig) {
  const v1::CameraConfig& camera = config.camera();
  const v1::RawCameraConfig& own = eye == 0 ? camera.raw_left() : camera.raw_right();
  const Scale scale = ScaleOf(config);
  v1::RawCamera raw;
  raw.set_width_px(own.has_width_px() ? static_cast<int>(std::lround(own.width_px() * scale.x))
                                      : rig.width_px());
  raw.set_height_px(own.has_height_px() ? static_cast<int>(std::lround(own.height_px() * scale.y))
                                        : rig.height_px());
  const double fx = DrawOr(own.has_fx_px(), own.fx_px(), stream, "fx", rig.fx_px() / scale.x);
  const double fy = DrawOr(own.has_fy_px(), own.fy_px(), stream, "fy",
                           own.has_fx_px() ? fx : rig.fy_px() / scale.y);
  raw.set_fx_px(fx * scale.x);
  raw.set_fy_px(fy * scale.y);
  raw.set_cx_px(DrawOr(own.has_cx_px(), own.cx_px(), stream, "cx", rig.cx_px() / scale.x) *
                scale.x);
  raw.set_cy_px(DrawOr(own.has_cy_px(), own.cy_px(), stream, "cy", rig.cy_px() / scale.y) *
                scale.y);
  AddLens(own.has_lens() ? own.lens() : camera.lens(), stream, &raw);
  CameraTurn turn;
  turn.yaw_rad = (eye == 0 ? kRadiansPerDegree : -kRadiansPerDegree) *
                 DrawOr(own.has_vergence_deg(), own.vergence_deg(), stream, "vergence", 0);
  turn.pitch_rad =
      kRadiansPerDegree * DrawOr(own.has_pitch_deg(), own.pitch_deg(), stream, "pitch", 0);
  turn.roll_rad = kRadiansPerDegree * DrawOr(own.has_roll_deg(), own.roll_deg(), stream, "roll", 0);
  const Eigen::Quaterniond rotation(RotationOfTurn(turn));
  raw.set_qw(rotation.w());
  raw.set_qx(rotation.x());
  raw.set_qy(rotation.y());
  raw.set_qz(rotation.z());
  return raw;
}

}  // namespace

double RigCamera::Corner() const {
  const double x = half_x + std::abs(shift_x), y = half_y + std::abs(shift_y);
  return std::sqrt(1 + x * x + y * y);
}

RigCamera DrawRigCamera(const v1::RigConfig& config, double fov_draw, const Rng& stream) {
  const v1::CameraConfig& given = config.camera();
  const int width = config.width_px(), height = config.height_px();
  const Scale scale = ScaleOf(config);
  RigCamera camera;
  if (given.has_fx_px()) {
    const double fx = Draw(given.fx_px(), stream.Child("fx").Uniform());
    camera.k.fx_px = fx * scale.x;
    camera.k.fy_px = DrawOr(given.has_fy_px(), given.fy_px(), stream, "fy", fx) * scale.y;
    camera.half_x = width / 2.0 / camera.k.fx_px;
    camera.half_y = height / 2.0 / camera.k.fy_px;
  } else {
    const double fov = Draw(config.horizontal_fov_deg(), fov_draw) * std::numbers::pi / 180;
    camera.k = CentredIntrinsics(fov, width, height);
    camera.half_x = std::tan(fov / 2);
    camera.half_y = camera.half_x * (static_cast<double>(height) / width);
  }
  camera.k.cx_px =
      DrawOr(given.has_cx_px(), given.cx_px(), stream, "cx", scale.width_px / 2.0) * scale.x;
  camera.k.cy_px =
      DrawOr(given.has_cy_px(), given.cy_px(), stream, "cy", scale.height_px / 2.0) * scale.y;
  camera.shift_x = (width / 2.0 - camera.k.cx_px) / camera.k.fx_px;
  camera.shift_y = (height / 2.0 - camera.k.cy_px) / camera.k.fy_px;
  return camera;
}

double LargestBaseline(const v1::RigConfig& config) {
  const auto& several = config.baselines_m();
  return several.empty() ? SupportOf(config.baseline_m()).high
                         : *std::max_element(several.begin(), several.end());
}

void AddBaselines(const v1::RigConfig& config, v1::Scene& recipe) {
  if (config.baselines_m().empty()) return;
  google::protobuf::RepeatedPtrField<v1::Rig> lefts;
  lefts.Swap(recipe.mutable_rigs());
  for (const v1::Rig& left : lefts) {
    for (int i = 0; i < config.baselines_m_size(); ++i) {
      v1::Rig& rig = *recipe.add_rigs() = left;
      rig.set_index(static_cast<uint32_t>(recipe.rigs_size() - 1));
      rig.set_baseline_m(config.baselines_m(i));
      rig.set_shares_left(i > 0);
    }
  }
}

void AddRawCameras(const v1::RigConfig& config, const Rng& stream, v1::Rig* rig) {
  const v1::CameraConfig& camera = config.camera();
  if (!camera.has_lens() && !camera.has_raw_left() && !camera.has_raw_right()) return;
  *rig->mutable_raw_left() = DrawRaw(config, 0, stream.Child("raw", 0), *rig);
  *rig->mutable_raw_right() = DrawRaw(config, 1, stream.Child("raw", 1), *rig);
}

absl::Status CheckRawCameras(const v1::Scene& scene) {
  for (const v1::Rig& rig : scene.rigs()) {
    if (!rig.has_raw_left()) continue;
    for (int eye = 0; eye < 2; ++eye) {
      const v1::RawCamera& raw = eye == 0 ? rig.raw_left() : rig.raw_right();
      const absl::Status status = CheckRawCamera(raw);
      if (!status.ok()) {
        return WithContext(status, fmt::format("rig {}: rigs.camera: the {} lens", rig.index(),
                                               eye == 0 ? "left" : "right"));
      }
    }
  }
  return absl::OkStatus();
}

}  // namespace parallax
