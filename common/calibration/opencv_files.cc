// Stereo files that OpenCV's samples and the tools around it write.
#include <fmt/core.h>

#include <algorithm>
#include <tuple>

#include "common/base/names.h"
#include "common/calibration/formats.h"

namespace parallax::calibration_internal {
namespace {

using Names = std::vector<std::string>;

// Names of a camera's values; `eye` 0 left, 1 right.
struct EyeNames {
  Names k, d, rectification, projection;
};

EyeNames NamesOf(int eye) {
  const std::string number = eye == 0 ? "1" : "2", side = eye == 0 ? "left" : "right";
  const std::string letter = eye == 0 ? "L" : "R", upper = eye == 0 ? "LEFT" : "RIGHT";
  return {
      {"M" + number, "K" + number, "cameraMatrix" + number, "camera_matrix_" + side, "K_" + side,
       "mtx" + letter, "camera_matrix" + number, upper + ".K"},
      {"D" + number, "distCoeffs" + number, "dist_coeffs_" + side, "D_" + side, "dist" + letter,
       "distortion_coefficients_" + side, "dist_coeffs" + number, upper + ".D"},
      {"R" + number, "R_" + side, "rect_mat" + letter, "rectification_matrix_" + side,
       upper + ".R"},
      {"P" + number, "P_" + side, "proj_mat" + letter, "projection_matrix_" + side, upper + ".P"}};
}

absl::Status ReadSize(const Fields& fields, StereoCalibration* calibration) {
  const std::string both =
      fields.FirstOf({"imageSize", "image_size", "size", "resolution", "img_size"});
  if (!both.empty()) {
    ASSIGN_OR_RETURN(std::tie(calibration->width_px, calibration->height_px), fields.Size(both));
    return absl::OkStatus();
  }
  const std::string width = fields.FirstOf({"image_width", "width", "LEFT.width"});
  const std::string height = fields.FirstOf({"image_height", "height", "LEFT.height"});
  if (width.empty() && height.empty()) return absl::OkStatus();
  ASSIGN_OR_RETURN(calibration->width_px, fields.Pixels(width.empty() ? "image_width" : width));
  ASSIGN_OR_RETURN(calibration->height_px, fields.Pixels(height.empty() ? "image_height" : height));
  return absl::OkStatus();
}

bool SaysFisheye(const Fields& fields) {
  const std::string name =
      fields.FirstOf({"distortion_model", "camera_model", "model", "model_type"});
  std::string text = fields.Text(name);
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) {
    return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  });
  for (const char* word : {"fisheye", "equidistant", "kannala"}) {
    if (text.find(word) != std::string::npos) return true;
  }
  return fields.Text("fisheye") == "1" || fields.Text("fisheye") == "true";
}

absl::StatusOr<LensDistortion> ReadLens(const Fields& fields, const std::string& name,
                                        bool fisheye) {
  LensDistortion lens;
  if (name.empty()) return lens;
  ASSIGN_OR_RETURN(std::vector<double> d, fields.Numbers(name, 0));
  const bool fits =
      fisheye ? d.size() == 4 : d.size() == 4 || d.size() == 5 || d.size() == 8 || d.size() >= 12;
  if (!fits) {
    return fields.Error(name, fmt::format("{} coefficients, allowed are {}", d.size(),
                                          fisheye ? "4" : "4, 5 or 8"));
  }
  for (size_t i = 8; i < d.size(); ++i) {
    if (d[i] != 0) {
      return fields.Error(name, "thin prism or tilted sensor, allowed are 4, 5 or 8 coefficients");
    }
  }
  d.resize(std::min<size_t>(d.size(), 8));
  lens.model =
      fisheye ? LensDistortion::Model::kKannalaBrandt : LensDistortion::Model::kBrownConrady;
  std::copy(d.begin(), d.end(), lens.c.begin());
  return lens;
}

absl::Status ReadRaw(const Fields& fields, StereoCalibration* calibration) {
  const bool fisheye = SaysFisheye(fields);
  calibration->raw.emplace();
  for (int eye = 0; eye < 2; ++eye) {
    const EyeNames names = NamesOf(eye);
    RawIntrinsics& raw = (*calibration->raw)[static_cast<size_t>(eye)];
    const std::string name = fields.FirstOf(names.k);
    ASSIGN_OR_RETURN(const std::vector<double> k,
                     fields.Numbers(name.empty() ? names.k.front() : name, 9));
    ASSIGN_OR_RETURN(raw.k, IntrinsicsOf(fields, name, k, 3));
    ASSIGN_OR_RETURN(raw.lens, ReadLens(fields, fields.FirstOf(names.d), fisheye));
    raw.width_px = calibration->width_px;
    raw.height_px = calibration->height_px;
  }
  return absl::OkStatus();
}

// The name under which the file has T; empty if it has none.
std::string PlaceIn(const Fields& fields) {
  return fields.FirstOf({"T", "Trns", "translation", "translation_vector"});
}

// P1 and P2 as they stand.
absl::Status ReadProjections(const Fields& fields, double unit_m, StereoCalibration* calibration) {
  const std::string left = fields.FirstOf(NamesOf(0).projection);
  const std::string right = fields.FirstOf(NamesOf(1).projection);
  ASSIGN_OR_RETURN(const std::vector<double> p_left, fields.Numbers(left, 12));
  ASSIGN_OR_RETURN(calibration->rectified, IntrinsicsOf(fields, left, p_left, 4));
  ASSIGN_OR_RETURN(const std::vector<double> p_right, fields.Numbers(right, 12));
  ASSIGN_OR_RETURN(const Intrinsics k, IntrinsicsOf(fields, right, p_right, 4));
  calibration->baseline_m = -p_right[3] / k.fx_px * unit_m;
  return absl::OkStatus();
}

// The raw cameras' rotations, from R1 and R2 or, where the file has none, from R and T.
absl::Status ReadRotations(const Fields& fields, double unit_m, StereoCalibration* calibration) {
  const std::string names[] = {fields.FirstOf(NamesOf(0).rectification),
                               fields.FirstOf(NamesOf(1).rectification)};
  if (!names[0].empty() && !names[1].empty()) {
    for (size_t eye = 0; eye < 2; ++eye) {
      ASSIGN_OR_RETURN(const std::vector<double> r, fields.Numbers(names[eye], 9));
      ASSIGN_OR_RETURN((*calibration->raw)[eye].rectified_from_raw,
                       RotationOf(fields, names[eye], MatrixOf(r)));
    }
    return absl::OkStatus();
  }
  const std::string rotation = fields.FirstOf({"R", "Rot", "rotation", "rotation_matrix"});
  const std::string place = PlaceIn(fields);
  ASSIGN_OR_RETURN(const std::vector<double> r,
                   fields.Numbers(rotation.empty() ? "R" : rotation, 9));
  ASSIGN_OR_RETURN(const std::vector<double> t, fields.Numbers(place.empty() ? "T" : place, 3));
  ASSIGN_OR_RETURN(const Eigen::Matrix3d matrix, RotationOf(fields, rotation, MatrixOf(r)));
  return Rectify(fields, place, matrix, unit_m * Eigen::Vector3d(t[0], t[1], t[2]), calibration);
}

}  // namespace

Parsed FromOpenCv(const Fields& fields, const CalibrationOptions& options) {
  StereoCalibration calibration;
  calibration.format = "opencv";
  RETURN_IF_ERROR(ReadSize(fields, &calibration));
  const bool projected = !fields.FirstOf(NamesOf(0).projection).empty() &&
                         !fields.FirstOf(NamesOf(1).projection).empty();
  const bool raw = !fields.FirstOf(NamesOf(0).k).empty() || !fields.FirstOf(NamesOf(1).k).empty();
  if (!projected && !raw) {
    return fields.Error("M1", "missing, allowed are M1 D1 M2 D2 R T, or P1 P2");
  }
  // Booster's files are in millimetres.
  const double unit_m = options.unit_m.value_or(fields.Has("baselineLR") ? 1e-3 : 1);
  if (raw) {
    RETURN_IF_ERROR(ReadRaw(fields, &calibration));
    calibration.rectified = (*calibration.raw)[0].k;
    const bool turned = !fields.FirstOf({"R", "Rot", "rotation", "rotation_matrix"}).empty() ||
                        !fields.FirstOf(NamesOf(0).rectification).empty();
    if (turned || !projected) {
      RETURN_IF_ERROR(ReadRotations(fields, unit_m, &calibration));
    } else {
      calibration.raw.reset();  // Nothing says how the cameras are turned.
    }
  }
  if (projected) RETURN_IF_ERROR(ReadProjections(fields, unit_m, &calibration));
  if (const std::string place = PlaceIn(fields); !calibration.baseline_m && !place.empty()) {
    ASSIGN_OR_RETURN(const std::vector<double> t, fields.Numbers(place, 3));
    calibration.baseline_m = unit_m * Eigen::Vector3d(t[0], t[1], t[2]).norm();
  }
  return calibration;
}

}  // namespace parallax::calibration_internal
