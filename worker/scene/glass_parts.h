// The study's option to leave glass out of objects: panes hide from stereo the things behind them.
#pragma once

#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "worker/geometry/mesh.h"
#include "worker/scene/dress.h"

namespace parallax {

// Lists the glass parts of every object as omitted unless the config keeps them. Objects made only
// of glass stay whole. Parts of the place have options of their own (room.window_glass).
// Errors: those of the objects' models.
absl::Status OmitGlassParts(const v1::AssetConfig& config, SceneInProgress& scene);

// Returns the mesh without the triangles of the named slots, and without vertices and slots that
// only they used. A mesh that would become empty is returned whole.
Mesh WithoutSlots(const Mesh& mesh, const std::vector<std::string>& omitted);

}  // namespace parallax
