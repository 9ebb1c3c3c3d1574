// Constant materials in place of a scene's procedural ones, so that another renderer can be given
// exactly the same surfaces.
#pragma once

#include <string>

#include "common/base/status.h"
#include "worker/scene/build_geometry.h"

namespace parallax::bench {

// kPrincipled: every material's average over its surfaces, opaque, no relief. kShared: the nearest
// surface whose model is the same in every renderer: Lambert, a white GGX mirror of alpha 0.04 to
// 0.1, smooth clear glass, or a clear thin pane, all on flat faces: where a smooth normal and its
// face disagree no two renderers do the same (light seeps through thin walls in Mitsuba, ours
// softens the terminator). kLambert: of these, Lambert and thin panes only;
// without caustics, so that a few samples say how well lights, geometry and cameras agree.
enum class Flavour { kPrincipled, kShared, kLambert };

// "principled", "shared" or "lambert". Errors: kInvalidArgument.
absl::StatusOr<Flavour> ParseFlavour(const std::string& name);

// Replaces all materials of `geometry`; index 0 stays empty.
void MakePlain(Flavour flavour, SceneGeometry* geometry);

// The constant surface of a material after MakePlain.
SurfaceSample PlainSurface(const Material* material);

}  // namespace parallax::bench
