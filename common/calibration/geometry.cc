// Matrices of calibrations, and the rectification of a pair.
#include <Eigen/SVD>

#include "common/calibration/formats.h"

namespace parallax::calibration_internal {

absl::StatusOr<Intrinsics> IntrinsicsOf(const Fields& fields, const std::string& name,
                                        const std::vector<double>& matrix, size_t columns) {
  const Intrinsics k{matrix[0], matrix[columns + 1], matrix[2], matrix[columns + 2]};
  if (!(k.fx_px > 0) || !(k.fy_px > 0)) {
    return fields.Error(name, "its focal lengths are not above 0");
  }
  if (matrix[1] != 0 || matrix[columns] != 0 || matrix[2 * columns + 2] != 1) {
    return fields.Error(name, "not of the form [fx 0 cx; 0 fy cy; 0 0 1]");
  }
  return k;
}

Eigen::Matrix3d MatrixOf(const std::vector<double>& rows) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data());
}

absl::StatusOr<Eigen::Matrix3d> RotationOf(const Fields& fields, const std::string& name,
                                           const Eigen::Matrix3d& matrix) {
  const double off =
      (matrix.transpose() * matrix - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(off <= 1e-3) || matrix.determinant() < 0) return fields.Error(name, "not a rotation");
  // Files round their digits.
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return Eigen::Matrix3d(svd.matrixU() * svd.matrixV().transpose());
}

absl::Status Rectify(const Fields& fields, const std::string& name, const Eigen::Matrix3d& rotation,
                     const Eigen::Vector3d& translation_m, StereoCalibration* calibration) {
  // R = half^-2; in frames turned by half of R each, only a translation is left.
  Eigen::AngleAxisd turn(rotation);
  turn.angle() *= -0.5;
  const Eigen::Matrix3d half = turn.toRotationMatrix();
  const Eigen::Vector3d between = half * translation_m;
  if (!(between.x() < 0)) {
    return fields.Error(name, "the second camera does not stand to the right of the first");
  }
  const Eigen::Matrix3d level =
      Eigen::Quaterniond::FromTwoVectors(between, -Eigen::Vector3d::UnitX()).toRotationMatrix();
  (*calibration->raw)[0].rectified_from_raw = level * half.transpose();
  (*calibration->raw)[1].rectified_from_raw = level * half;
  calibration->baseline_m = translation_m.norm();
  return absl::OkStatus();
}

}  // namespace parallax::calibration_internal
