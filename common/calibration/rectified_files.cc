// Files of datasets: Middlebury, ETH3D, KITTI.
#include <tuple>

#include "common/base/names.h"
#include "common/calibration/formats.h"

namespace parallax::calibration_internal {
namespace {

// The raw camera `number` of calib_cam_to_cam.txt.
absl::StatusOr<RawIntrinsics> RawKitti(const Fields& fields, const std::string& number) {
  RawIntrinsics raw;
  ASSIGN_OR_RETURN(const std::vector<double> k, fields.Numbers("K_" + number, 9));
  ASSIGN_OR_RETURN(raw.k, IntrinsicsOf(fields, "K_" + number, k, 3));
  ASSIGN_OR_RETURN(const std::vector<double> d, fields.Numbers("D_" + number, 5));
  ASSIGN_OR_RETURN(const std::vector<double> r, fields.Numbers("R_rect_" + number, 9));
  raw.lens.model = LensDistortion::Model::kBrownConrady;
  std::copy(d.begin(), d.end(), raw.lens.c.begin());
  ASSIGN_OR_RETURN(std::tie(raw.width_px, raw.height_px), fields.Size("S_" + number));
  ASSIGN_OR_RETURN(raw.rectified_from_raw, RotationOf(fields, "R_rect_" + number, MatrixOf(r)));
  return raw;
}

}  // namespace

Parsed FromMiddlebury(const Fields& fields, const CalibrationOptions& options) {
  StereoCalibration calibration;
  calibration.format = "middlebury";
  ASSIGN_OR_RETURN(const std::vector<double> k, fields.Numbers("cam0", 9));
  ASSIGN_OR_RETURN(calibration.rectified, IntrinsicsOf(fields, "cam0", k, 3));
  ASSIGN_OR_RETURN(calibration.width_px, fields.Pixels("width"));
  ASSIGN_OR_RETURN(calibration.height_px, fields.Pixels("height"));
  ASSIGN_OR_RETURN(const double baseline, fields.Number("baseline"));
  calibration.baseline_m = baseline * options.unit_m.value_or(kMillimetre_m);
  return calibration;
}

Parsed FromKitti(const Fields& fields, const CalibrationOptions& options) {
  StereoCalibration calibration;
  calibration.format = "kitti";
  // KITTI-360 has the grey pair only.
  const bool grey = !fields.Has("P_rect_02") && fields.Has("P_rect_00");
  const std::string left = !options.part.empty() ? options.part : grey ? "00" : "02";
  if (left != "00" && left != "02") {
    return fields.Error("calibration_part", Quoted(left) + " is no left camera, allowed 00 or 02");
  }
  const std::string right = left == "00" ? "01" : "03";
  // calib.txt of the odometry and object sets has P0 to P3.
  const bool projections = !fields.Has("P_rect_" + left);
  const auto name = [&](const std::string& number) {
    return projections ? "P" + number.substr(1) : "P_rect_" + number;
  };
  ASSIGN_OR_RETURN(const std::vector<double> p_left, fields.Numbers(name(left), 12));
  ASSIGN_OR_RETURN(const std::vector<double> p_right, fields.Numbers(name(right), 12));
  ASSIGN_OR_RETURN(calibration.rectified, IntrinsicsOf(fields, name(left), p_left, 4));
  // The fourth column is K times the place of the first camera.
  calibration.baseline_m =
      (p_left[3] - p_right[3]) / calibration.rectified.fx_px * options.unit_m.value_or(1);
  if (projections) return calibration;
  ASSIGN_OR_RETURN(std::tie(calibration.width_px, calibration.height_px),
                   fields.Size("S_rect_" + left));
  if (!fields.Has("K_" + left)) return calibration;
  calibration.raw.emplace();
  ASSIGN_OR_RETURN((*calibration.raw)[0], RawKitti(fields, left));
  ASSIGN_OR_RETURN((*calibration.raw)[1], RawKitti(fields, right));
  return calibration;
}

}  // namespace parallax::calibration_internal
