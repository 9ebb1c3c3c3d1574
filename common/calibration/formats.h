// Inner part of common/calibration: one function a format, over the fields of the file.
#pragma once

#include "common/calibration/calibration.h"
#include "common/calibration/fields.h"

namespace parallax::calibration_internal {

inline constexpr double kMillimetre_m = 1e-3;

using Parsed = absl::StatusOr<StereoCalibration>;

Parsed FromMiddlebury(const Fields& fields, const CalibrationOptions& options);
Parsed FromKitti(const Fields& fields, const CalibrationOptions& options);
Parsed FromOpenCv(const Fields& fields, const CalibrationOptions& options);
Parsed FromRealSense(const Fields& fields, const CalibrationOptions& options);
Parsed FromZed(const Fields& fields, const CalibrationOptions& options);

// fx, fy, cx, cy of a row-major 3x3 or 3x4 matrix.
// Errors: kInvalidArgument, naming `name`, for a focal length that is not positive or skew.
absl::StatusOr<Intrinsics> IntrinsicsOf(const Fields& fields, const std::string& name,
                                        const std::vector<double>& matrix, size_t columns);

// The same camera centres, rotations and K as cv::stereoRectify would choose but for K and zoom:
// each camera is turned by half of R, then both so that the baseline is their x axis. Sets
// rectified_from_raw of both and baseline_m; X_right = R X_left + translation_m.
// Errors: kInvalidArgument, naming `name`, when the second camera does not stand right of the
// first.
absl::Status Rectify(const Fields& fields, const std::string& name, const Eigen::Matrix3d& rotation,
                     const Eigen::Vector3d& translation_m, StereoCalibration* calibration);

// Row-major.
Eigen::Matrix3d MatrixOf(const std::vector<double>& rows);
// Errors: kInvalidArgument, naming `name`, for what is no rotation to 1e-3; else the nearest one.
absl::StatusOr<Eigen::Matrix3d> RotationOf(const Fields& fields, const std::string& name,
                                           const Eigen::Matrix3d& matrix);

}  // namespace parallax::calibration_internal
