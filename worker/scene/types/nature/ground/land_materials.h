// The materials of a land and the instances of its rules: the last steps of the stage `scene`, for
// landscapes and for houses that stand in one.
#pragma once

#include "common/base/rng.h"
#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/scene/types/nature/ground/expand.h"

namespace parallax {

// Adds materials to `recipe` and binds them to the ground (the object of land.ground_object_index),
// to water and roof, and to all prototypes. Draws from addresses below `root`.
// Errors: kInvalidArgument for a biome that is neither built in nor `nature`'s own; those of
// PrototypeMesh.
absl::Status ChooseLandMaterials(const v1::NatureConfig& nature, const Rng& root, v1::Scene& recipe,
                                 v1::Terrain& land);

// Expands the land for `views` and writes its hash, its number of instances, and the object indices
// of its layers, which follow the largest of `recipe`.
// Errors: those of CheckIndices and ExpandTerrain.
absl::Status CountLand(const v1::Scene& recipe,
                       const google::protobuf::RepeatedPtrField<v1::Rig>& views, v1::Terrain& land);

// Checks that the things of an expansion can be numbered after the objects of `recipe`. Errors:
// kOutOfRange for more objects than indices.
absl::Status CheckIndices(const v1::Scene& recipe, const Expansion& expansion);

}  // namespace parallax
