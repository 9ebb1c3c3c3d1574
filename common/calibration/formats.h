// Inner part of common/calibration: one function for each format, over the fields of the file.
//
// Errors of all functions: kInvalidArgument that names file, line and field.
#pragma once

#include "common/calibration/calibration.h"
#include "common/calibration/fields.h"

namespace parallax::calibration_internal {

inline constexpr double kMillimetre_m = 1e-3;

using Parsed = absl::StatusOr<StereoCalibration>;

// Make a calibration of the file's fields; see calibration.h for the fields of each format.
Parsed FromMiddlebury(const Fields& fields, const CalibrationOptions& options);
Parsed FromKitti(const Fields& fields, const CalibrationOptions& options);
Parsed FromOpenCv(const Fields& fields, const CalibrationOptions& options);
Parsed FromRealSense(const Fields& fields, const CalibrationOptions& options);
Parsed FromKalibr(const Fields& fields, const CalibrationOptions& options);
Parsed FromOak(const Fields& fields, const CalibrationOptions& options);
Parsed FromOrbSlam3(const Fields& fields, const CalibrationOptions& options);
Parsed FromZed(const Fields& fields, const CalibrationOptions& options);

// Stands between the files of the two eyes, left first, where both are one text.
inline constexpr std::string_view kNextEye = "\n---\n# parallax: the other eye\n";
// Makes a calibration of ROS's ost.txt of a pair, or of the YAML of one or both eyes.
Parsed FromRos(std::string_view text, const std::string& file, const CalibrationOptions& options);

// Returns fx, fy, cx, cy of a row-major 3x3 or 3x4 matrix with `columns` columns.
// Errors: kInvalidArgument, naming `name`, if a focal length is not positive or there is skew.
absl::StatusOr<Intrinsics> IntrinsicsOf(const Fields& fields, const std::string& name,
                                        const std::vector<double>& matrix, size_t columns);

// Rectifies a pair as cv::stereoRectify does, but for its choice of K and zoom: turns each camera
// by half of the rotation, then both so that the baseline is their x axis. `rotation` and
// `translation_m` map left to right: X_right = R X_left + t. Sets rectified_from_raw of both
// cameras and baseline_m. Errors: kInvalidArgument, naming `name`, if the second camera is not to
// the right of the first.
absl::Status Rectify(const Fields& fields, const std::string& name, const Eigen::Matrix3d& rotation,
                     const Eigen::Vector3d& translation_m, StereoCalibration* calibration);

// Returns the 3x3 matrix of nine row-major numbers.
Eigen::Matrix3d MatrixOf(const std::vector<double>& rows);
// Returns the rotation nearest to `matrix`. Errors: kInvalidArgument, naming `name`, if `matrix`
// differs from a rotation by more than 1e-3.
absl::StatusOr<Eigen::Matrix3d> RotationOf(const Fields& fields, const std::string& name,
                                           const Eigen::Matrix3d& matrix);

}  // namespace parallax::calibration_internal
