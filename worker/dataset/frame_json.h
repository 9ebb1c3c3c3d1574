// frame.json: cameras, tables and numbers of one stereo pair.
#pragma once

#include <array>
#include <string>

#include "parallax/v1/scene.pb.h"
#include "worker/dataset/statistics.h"

namespace parallax {

// Row-major 4x4 of a pose.
std::array<std::array<double, 4>, 4> MatrixOf(const v1::Transform& transform);

// The right camera: the left one moved by the baseline along its own +x.
v1::Transform WorldFromRight(const v1::Rig& rig);

// One key a line at the top, so that a person can read and diff it. No times: equal inputs give
// equal bytes.
std::string FrameJson(const v1::Scene& scene, const v1::Rig& rig, double exposure,
                      const FrameStatistics& statistics, const v1::RenderConfig& render);

}  // namespace parallax
