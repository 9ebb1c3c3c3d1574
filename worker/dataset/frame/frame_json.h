// frame.json: cameras, tables and numbers of one stereo pair.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <string>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"
#include "worker/dataset/frame/frame_statistics.h"

namespace parallax {

// Returns the pose as a row-major 4x4 matrix.
std::array<std::array<double, 4>, 4> MatrixOf(const v1::Transform& transform);

// Returns the text of frame.json. One top-level key a line, so that a person can read and diff it.
// It holds no times: equal inputs give equal bytes. Errors: as TypeOf.
absl::StatusOr<std::string> FrameJson(const v1::Scene& scene, const v1::Rig& rig,
                                      const StereoFrame& frame, const FrameStatistics& statistics,
                                      const v1::RenderConfig& render);

// Returns the text of frame.json: one top-level key a line, one entry of the tables a line.
std::string FrameJsonText(const nlohmann::ordered_json& json);

}  // namespace parallax
