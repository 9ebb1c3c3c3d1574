// A scene of constant materials written for other renderers: scene.json beside raw arrays.
//
// scene.json: "materials" (principled parameters), "meshes" (file, material, emission radiance or
// null), "points" (position, intensity W/sr), "sun" (direction to it, irradiance, angular radius)
// or null, "sky" (file of a latitude-longitude map, float32 RGB, without the sun; u = azimuth / 2
// pi from +x to +y, row 0 = +z) or null, "portals" (corner, edges: openings of the room), "cameras"
// (rig, eye, pose, intrinsics). Meshes are binary PLY in the world frame, vertices with normals,
// one file for each material and light.
#pragma once

#include <string>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"
#include "worker/scene/build_geometry.h"

namespace parallax::bench {

absl::Status ExportScene(const v1::Scene& recipe, const SceneGeometry& geometry,
                         const std::string& folder);

}  // namespace parallax::bench
