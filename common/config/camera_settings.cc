#include "common/config/camera_settings.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "common/base/hash.h"
#include "common/base/names.h"
#include "common/base/system/file.h"
#include "common/calibration/calibration.h"
#include "common/config/check/field_rules.h"
#include "common/config/config.h"
#include "common/config/frame_maps.h"

namespace parallax::config_internal {
namespace {

constexpr size_t kMostBytes = 1 << 20;   // Size of a calibration file.
constexpr double kNarrowest = 1.0 / 12;  // Focal length over width: 161 degrees.
constexpr double kDegree = std::numbers::pi / 180;
// Numbers without the size of their picture are taken to be of another size if they give a field of
// view beyond these, or a principal point farther from the middle than this share of a side.
constexpr double kLeastFov_deg = 20, kMostFov_deg = 120, kMostOffCentre = 0.2;

void SetIntrinsics(const Intrinsics& k, auto* message) {
  message->mutable_fx_px()->set_constant(k.fx_px);
  message->mutable_fy_px()->set_constant(k.fy_px);
  message->mutable_cx_px()->set_constant(k.cx_px);
  message->mutable_cy_px()->set_constant(k.cy_px);
}

void SetLens(const LensDistortion& lens, v1::LensConfig* config) {
  using Model = LensDistortion::Model;
  const auto set = [](v1::Distribution* field, double value) { field->set_constant(value); };
  config->set_model(lens.model == Model::kNone           ? v1::LensConfig::MODEL_NONE
                    : lens.model == Model::kBrownConrady ? v1::LensConfig::MODEL_BROWN_CONRADY
                                                         : v1::LensConfig::MODEL_KANNALA_BRANDT);
  if (lens.model == Model::kNone) return;
  set(config->mutable_k1(), lens.c[0]);
  set(config->mutable_k2(), lens.c[1]);
  if (lens.model == Model::kKannalaBrandt) {
    set(config->mutable_k3(), lens.c[2]);
    set(config->mutable_k4(), lens.c[3]);
    return;
  }
  set(config->mutable_p1(), lens.c[2]);
  set(config->mutable_p2(), lens.c[3]);
  set(config->mutable_k3(), lens.c[4]);
  if (lens.c[5] == 0 && lens.c[6] == 0 && lens.c[7] == 0) return;
  set(config->mutable_k4(), lens.c[5]);
  set(config->mutable_k5(), lens.c[6]);
  set(config->mutable_k6(), lens.c[7]);
}

// `eye` 0 left, 1 right.
void SetRaw(const RawIntrinsics& raw, int eye, v1::RawCameraConfig* config) {
  SetIntrinsics(raw.k, config);
  SetLens(raw.lens, config->mutable_lens());
  const CameraTurn turn = TurnOfRotation(raw.rectified_from_raw);
  config->mutable_vergence_deg()->set_constant((eye == 0 ? 1 : -1) * turn.yaw_rad / kDegree);
  config->mutable_pitch_deg()->set_constant(turn.pitch_rad / kDegree);
  config->mutable_roll_deg()->set_constant(turn.roll_rad / kDegree);
  if (raw.width_px == 0) return;
  config->set_width_px(raw.width_px);
  config->set_height_px(raw.height_px);
}

// Replaces the camera of the rigs.
void SetCamera(const StereoCalibration& calibration, v1::RigConfig* rigs) {
  rigs->clear_camera();
  v1::CameraConfig& camera = *rigs->mutable_camera();
  SetIntrinsics(calibration.rectified, &camera);
  if (calibration.width_px > 0) {
    camera.set_width_px(calibration.width_px);
    camera.set_height_px(calibration.height_px);
    rigs->set_width_px(calibration.width_px);
    rigs->set_height_px(calibration.height_px);
  }
  if (calibration.baseline_m) rigs->mutable_baseline_m()->set_constant(*calibration.baseline_m);
  if (!calibration.raw) return;
  SetRaw((*calibration.raw)[0], 0, camera.mutable_raw_left());
  SetRaw((*calibration.raw)[1], 1, camera.mutable_raw_right());
}

void SetProjector(const ProjectorFacts& facts, v1::ProjectorConfig* projector) {
  projector->mutable_power_w()->set_constant(facts.power_w);
  projector->mutable_dots()->set_constant(facts.dots);
  projector->mutable_horizontal_fov_deg()->set_constant(facts.horizontal_fov_deg);
  projector->mutable_vertical_fov_deg()->set_constant(facts.vertical_fov_deg);
}

// The camera's fields in `node`, before anything is merged.
class CameraNode {
 public:
  CameraNode(YamlReader& reader, const YAML::Node& node, std::string path)
      : reader_(reader), path_(std::move(path)) {
    if (!node.IsMap() || !node["rigs"] || !node["rigs"].IsMap()) return;
    rigs_.reset(node["rigs"]);
    if (rigs_["camera"] && rigs_["camera"].IsMap()) camera_.reset(rigs_["camera"]);
  }

  bool Has(const char* field) const { return camera_.IsMap() && camera_[field]; }
  bool RigsHave(const char* field) const { return rigs_.IsMap() && rigs_[field]; }
  bool given() const { return camera_.IsMap(); }

  // Tells of numbers that are probably of pictures of another size. `k` are those that were merged,
  // without a size of their own.
  void CheckSize(const v1::CameraConfig& k, int width, int height) const {
    const double fx = SupportOf(k.fx_px()).high, cx = SupportOf(k.cx_px()).high;
    const double fov_deg = 2 * std::atan(width / 2.0 / std::max(fx, 1e-9)) / kDegree;
    const std::string remedy = fmt::format(
        "; if the numbers are of pictures of another size, give that size beside them, such as "
        "camera: {{width_px: 1920, height_px: 1080}}; if not, give width_px: {}, height_px: {}",
        width, height);
    if (Has("fx_px") && k.fx_px().kind_case() != 0 && fx >= width * kNarrowest &&
        (fov_deg < kLeastFov_deg || fov_deg > kMostFov_deg)) {
      Tell("fx_px", fmt::format("{} px on pictures of {} px are {:.0f} degrees{}", NumberText(fx),
                                width, fov_deg, remedy));
    }
    const auto check = [&](const char* field, bool given, double at, int side) {
      // CheckInside tells of a point outside of the picture.
      if (!given || !Has(field) || at < 0 || at > side) return;
      if (std::abs(at - side / 2.0) <= kMostOffCentre * side) return;
      Tell(field, fmt::format("{} px is far from the middle of pictures of {} px{}", NumberText(at),
                              side, remedy));
    };
    check("cx_px", k.has_cx_px(), cx, width);
    check("cy_px", k.has_cy_px(), SupportOf(k.cy_px()).high, height);
  }

  // The preset or calibration put into the config's rigs, and the projector that a preset has;
  // errors are told. Returns the hash of the file that was read.
  std::string Resolve(v1::SceneConfig* config) const {
    v1::RigConfig* const rigs = config->mutable_rigs();
    if (Has("preset") && Has("calibration")) {
      Tell("calibration", "given beside a preset, allowed is one of them");
      return "";
    }
    if (Has("preset")) {
      const auto calibration = FindCameraPreset(Text("preset"));
      if (!calibration) return "";  // The field's own check tells.
      SetCamera(*calibration, rigs);
      if (calibration->projector) {
        SetProjector(*calibration->projector, config->mutable_lighting()->mutable_projector());
      }
      return "";
    }
    if (!Has("calibration") || Text("calibration").empty()) return "";
    const std::string wanted = Text("calibration_sha256");
    if (!wanted.empty() && Has("fx_px")) {
      rigs->clear_camera();
      return "";
    }
    return ReadFileOf(wanted, rigs);
  }

 private:
  std::string Text(const char* field) const {
    return Has(field) && camera_[field].IsScalar() ? camera_[field].Scalar() : "";
  }
  void Tell(const char* field, std::string_view what) const {
    reader_.Error(camera_[field], Dotted(path_, std::string("rigs.camera.") + field), what);
  }

  std::string ReadFileOf(const std::string& wanted, v1::RigConfig* rigs) const {
    const std::string named = Text("calibration");
    const std::filesystem::path path =
        (std::filesystem::path(reader_.file()).parent_path() / named).lexically_normal();
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) {
      Tell("calibration", path.string() +
                              ": no such file, allowed is a calibration file, "
                              "relative to the folder of this one");
      return "";
    }
    const absl::StatusOr<std::string> text = ReadCalibrationFile(path, kMostBytes);
    if (!text.ok()) {
      Tell("calibration", ToStd(text.status().message()));
      return "";
    }
    const std::string seen = Sha256Hex(*text);
    if (!wanted.empty() && wanted != seen) {
      Tell("calibration",
           path.string() + " is not the file of calibration_sha256 (its SHA-256 is " + seen + ")");
      return "";
    }
    CalibrationOptions options;
    options.part = Text("calibration_part");
    if (const std::string unit = Text("calibration_unit_m"); !unit.empty()) {
      options.unit_m = std::strtod(unit.c_str(), nullptr);  // Its own check tells what is wrong.
    }
    const absl::StatusOr<StereoCalibration> calibration =
        ParseCalibration(*text, path.string(), options);
    if (!calibration.ok()) {
      Tell("calibration", ToStd(calibration.status().message()));
      return "";
    }
    if (calibration->width_px == 0 && !(RigsHave("width_px") && RigsHave("height_px")) &&
        !(Has("width_px") && Has("height_px"))) {
      Tell("calibration", path.string() +
                              " does not say the size of the picture, allowed is "
                              "rigs.width_px and rigs.height_px beside it");
      return "";
    }
    SetCamera(*calibration, rigs);
    return seen;
  }

  YamlReader& reader_;
  const std::string path_;
  YAML::Node rigs_, camera_;
};

// Returns whether the camera has numbers that depend on the picture's size.
bool HasNumbers(const v1::CameraConfig& camera) {
  const auto any = [](const auto& k) {
    return k.has_fx_px() || k.has_fy_px() || k.has_cx_px() || k.has_cy_px();
  };
  return any(camera) || any(camera.raw_left()) || any(camera.raw_right());
}

class CameraChecker {
 public:
  CameraChecker(const v1::SceneConfig& config, const std::string& path, Findings* findings)
      : rigs_(config.rigs()),
        camera_(config.rigs().camera()),
        path_(Dotted(path, "rigs.camera")),
        findings_(findings) {
    CheckRaw(config, Dotted(path, "render.maps"));
    if (!rigs_.has_camera()) return;
    CheckSource();
    CheckFocal(Dotted(path, "rigs.horizontal_fov_deg"));
    CheckPair(camera_.has_width_px(), camera_.has_height_px(), path_);
    CheckShape(Dotted(path, "rigs."));
    const size_t before = findings_->size();
    CheckLens(camera_.lens(), path_ + ".lens");
    CheckEye(camera_.raw_left(), path_ + ".raw_left");
    CheckEye(camera_.raw_right(), path_ + ".raw_right");
    if (findings_->size() > before) return;
    CheckReach(camera_.raw_left(), path_ + ".raw_left");
    CheckReach(camera_.raw_right(), path_ + ".raw_right");
  }

 private:
  void Tell(const std::string& path, std::string what) {
    findings_->push_back({path, std::move(what)});
  }

  void CheckRaw(const v1::SceneConfig& config, const std::string& path) {
    if (camera_.has_lens() || camera_.has_raw_left() || camera_.has_raw_right()) return;
    if (!HasMap(config.render(), "raw")) return;
    Tell(path, "raw without a raw pair, allowed with rigs.camera.lens, raw_left or raw_right");
  }

  void CheckSource() {
    if (camera_.has_preset() && camera_.has_calibration()) {
      Tell(path_ + ".calibration", "given beside a preset, allowed is one of them");
    }
    const char* source = camera_.has_preset() ? ".preset" : ".calibration";
    const bool named = camera_.has_preset() || !camera_.calibration().empty();
    if (named && !camera_.has_fx_px()) {
      Tell(path_ + source,
           "without its numbers, allowed is what reading a study file makes of it: "
           "fx_px and the fields beside it");
    }
    if (!camera_.calibration().empty() && camera_.calibration_sha256().empty()) {
      Tell(path_ + ".calibration",
           "without calibration_sha256, allowed is the SHA-256 of the file");
    }
  }

  void CheckFocal(const std::string& fov_path) {
    if (camera_.has_fx_px() && rigs_.has_horizontal_fov_deg()) {
      Tell(fov_path, "given beside the focal length of rigs.camera (fx_px" +
                         (camera_.has_preset() ? ", preset " + camera_.preset()
                          : camera_.calibration().empty()
                              ? ""
                              : ", calibration " + Quoted(camera_.calibration())) +
                         "), allowed is one of them");
    }
    if (camera_.has_fy_px() && !camera_.has_fx_px()) {
      Tell(path_ + ".fy_px", "given without fx_px, allowed are both or fx_px alone");
    }
    const int width = camera_.has_width_px() ? camera_.width_px() : rigs_.width_px();
    const int height = camera_.has_height_px() ? camera_.height_px() : rigs_.height_px();
    CheckNarrow(camera_.has_fx_px(), camera_.fx_px(), width, "fx_px");
    CheckNarrow(camera_.has_fy_px(), camera_.fy_px(), height, "fy_px");
    CheckInside(camera_.has_cx_px(), camera_.cx_px(), width, "cx_px");
    CheckInside(camera_.has_cy_px(), camera_.cy_px(), height, "cy_px");
  }

  void CheckNarrow(bool given, const v1::Distribution& focal, int side, const char* field) {
    if (!given || side <= 0) return;
    const double low = SupportOf(focal).low, least = side * kNarrowest;
    if (low >= least) return;
    Tell(path_ + "." + field,
         fmt::format(
             "reaches down to {}, allowed is at least {} px for a side of {} px (161 degrees)",
             NumberText(low), NumberText(least), side));
  }

  void CheckInside(bool given, const v1::Distribution& point, int side, const char* field) {
    if (!given || side <= 0) return;
    const Support support = SupportOf(point);
    if (support.low >= 0 && support.high <= side) return;
    Tell(path_ + "." + field,
         fmt::format("reaches from {} to {}, allowed 0 to {} px: a point of the picture; if the "
                     "numbers are of pictures of another size, give that size beside them, such as "
                     "camera: {{width_px: 1920, height_px: 1080}}",
                     NumberText(support.low), NumberText(support.high), side));
  }

  void CheckPair(bool width, bool height, const std::string& path) {
    if (width == height) return;
    Tell(path + (width ? ".width_px" : ".height_px"),
         "given alone, allowed are both sides or none");
  }

  // Pictures of another shape than the camera's would have stretched pixels.
  void CheckShape(const std::string& rigs_path) {
    const double width = camera_.width_px(), height = camera_.height_px();
    if (width <= 0 || height <= 0 || rigs_.width_px() <= 0 || rigs_.height_px() <= 0) return;
    const double kept_height = rigs_.width_px() * height / width;
    const double kept_width = rigs_.height_px() * width / height;
    if (std::abs(kept_height - rigs_.height_px()) < 1 ||
        std::abs(kept_width - rigs_.width_px()) < 1) {
      return;
    }
    Tell(rigs_path + "height_px",
         fmt::format("pictures of {} x {} px by a camera of {} x {} px, whose pixels they would "
                     "stretch, allowed is its shape, such as {} x {:.0f} px; for a part of its "
                     "picture give rigs.camera the numbers of that part",
                     rigs_.width_px(), rigs_.height_px(), width, height, rigs_.width_px(),
                     kept_height));
  }

  void CheckLens(const v1::LensConfig& lens, const std::string& path) {
    const struct {
      const char* name;
      bool given, fisheye;
    } coefficients[] = {{"k1", lens.has_k1(), true},  {"k2", lens.has_k2(), true},
                        {"p1", lens.has_p1(), false}, {"p2", lens.has_p2(), false},
                        {"k3", lens.has_k3(), true},  {"k4", lens.has_k4(), true},
                        {"k5", lens.has_k5(), false}, {"k6", lens.has_k6(), false}};
    for (const auto& coefficient : coefficients) {
      if (!coefficient.given) continue;
      const std::string at = path + "." + coefficient.name;
      if (lens.model() == v1::LensConfig::MODEL_UNSPECIFIED ||
          lens.model() == v1::LensConfig::MODEL_NONE) {
        Tell(at, "given without a model, allowed with model: brown_conrady or kannala_brandt");
      } else if (lens.model() == v1::LensConfig::MODEL_KANNALA_BRANDT && !coefficient.fisheye) {
        Tell(at, "kannala_brandt has k1, k2, k3 and k4");
      }
    }
  }

  void CheckEye(const v1::RawCameraConfig& eye, const std::string& path) {
    CheckLens(eye.lens(), path + ".lens");
    CheckPair(eye.has_width_px(), eye.has_height_px(), path);
    if (eye.has_fy_px() && !eye.has_fx_px()) {
      Tell(path + ".fy_px", "given without fx_px, allowed are both or fx_px alone");
    }
  }

  // The lens of an eye has a direction for the middles of the picture's sides, with its
  // coefficients at either end of their ranges. Polynomials of real lenses may end before the
  // corners.
  void CheckReach(const v1::RawCameraConfig& eye, const std::string& path) {
    const v1::LensConfig& lens = eye.has_lens() ? eye.lens() : camera_.lens();
    const bool fisheye = lens.model() == v1::LensConfig::MODEL_KANNALA_BRANDT;
    if (!fisheye && lens.model() != v1::LensConfig::MODEL_BROWN_CONRADY) return;
    using Model = LensDistortion::Model;
    const std::vector<const v1::Distribution*> coefficients =
        fisheye ? std::vector{&lens.k1(), &lens.k2(), &lens.k3(), &lens.k4()}
                : std::vector{&lens.k1(), &lens.k2(), &lens.p1(), &lens.p2(),
                              &lens.k3(), &lens.k4(), &lens.k5(), &lens.k6()};
    const Vec2d corner = FarthestCorner(eye);
    for (unsigned ends = 0; ends < 1u << coefficients.size(); ++ends) {
      LensDistortion drawn{fisheye ? Model::kKannalaBrandt : Model::kBrownConrady, {}};
      bool anew = true;  // Not the same as with other ends.
      for (size_t i = 0; i < coefficients.size(); ++i) {
        const Support support = SupportOf(*coefficients[i]);
        const bool high = (ends >> i & 1) != 0;
        anew = anew && !(high && support.low == support.high);
        drawn.c[i] = high ? support.high : support.low;
      }
      const double reach = drawn.Reach();
      if (!anew ||
          (drawn.Unproject({corner.x(), 0}, reach) && drawn.Unproject({0, corner.y()}, reach))) {
        continue;
      }
      std::string numbers;
      for (size_t i = 0; i < coefficients.size(); ++i) {
        numbers += (i > 0 ? " " : "") + NumberText(drawn.c[i]);
      }
      return Tell(
          eye.has_lens() ? path + ".lens" : path_ + ".lens",
          "with the coefficients " + numbers +
              " no direction leads to the sides of the picture, allowed are those for which "
              "they show something");
    }
  }

  // Returns the farthest corner of the widest camera that may be drawn, in focal lengths.
  Vec2d FarthestCorner(const v1::RawCameraConfig& eye) const {
    const auto low = [](bool given, const v1::Distribution& own, double otherwise) {
      return given ? SupportOf(own).low : otherwise;
    };
    const int width = camera_.has_width_px() ? camera_.width_px() : rigs_.width_px();
    const int height = camera_.has_height_px() ? camera_.height_px() : rigs_.height_px();
    const double widest = SupportOf(rigs_.horizontal_fov_deg()).high * kDegree;
    double fx = low(camera_.has_fx_px(), camera_.fx_px(),
                    widest > 0 ? width / 2.0 / std::tan(widest / 2) : width);
    double fy = low(camera_.has_fy_px(), camera_.fy_px(), fx);
    fx = low(eye.has_fx_px(), eye.fx_px(), fx);
    fy = low(eye.has_fy_px(), eye.fy_px(), eye.has_fx_px() ? fx : fy);
    const double raw_width = eye.has_width_px() ? eye.width_px() : width;
    const double raw_height = eye.has_height_px() ? eye.height_px() : height;
    const auto side = [&](bool own, const v1::Distribution& at, bool shared,
                          const v1::Distribution& common, double length) {
      const Support support = own      ? SupportOf(at)
                              : shared ? SupportOf(common)
                                       : Support{length / 2, length / 2};
      return std::max(support.high, length - support.low);
    };
    return {
        side(eye.has_cx_px(), eye.cx_px(), camera_.has_cx_px(), camera_.cx_px(), raw_width) / fx,
        side(eye.has_cy_px(), eye.cy_px(), camera_.has_cy_px(), camera_.cy_px(), raw_height) / fy};
  }

  const v1::RigConfig& rigs_;
  const v1::CameraConfig& camera_;
  const std::string path_;
  Findings* findings_;
};

}  // namespace

void MergeSceneConfig(YamlReader& reader, const YAML::Node& node, v1::SceneConfig* config,
                      const std::string& path, Origins* origins) {
  const CameraNode camera(reader, node, path);
  std::string hash;
  if (camera.given()) hash = camera.Resolve(config);
  reader.Merge(node, config, path, origins);
  if (!camera.given()) return;
  v1::RigConfig& rigs = *config->mutable_rigs();
  v1::CameraConfig& merged = *rigs.mutable_camera();
  if (!hash.empty()) merged.set_calibration_sha256(hash);
  if (merged.has_fx_px() && !camera.RigsHave("horizontal_fov_deg")) rigs.clear_horizontal_fov_deg();
  if (HasNumbers(merged) && !merged.has_width_px() && !merged.has_height_px()) {
    camera.CheckSize(merged, rigs.width_px(), rigs.height_px());
    merged.set_width_px(rigs.width_px());
    merged.set_height_px(rigs.height_px());
  }
  if (merged.ByteSizeLong() == 0) rigs.clear_camera();
}

void CheckCamera(const v1::SceneConfig& config, const std::string& path, Findings* findings) {
  CameraChecker(config, path, findings);
}

}  // namespace parallax::config_internal
