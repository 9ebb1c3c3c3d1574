// Scenes of the type nature: landscapes seen from a walk.
#pragma once

#include "worker/scene/types/scene_types.h"

namespace parallax {

extern const SceneType kNatureScenes;

// The functions of this SceneType, one file each; see types.h. Errors: kInvalidArgument when no
// biome has a weight; kCancelled.
absl::StatusOr<std::variant<v1::Layout, Rejected>> LayOutLand(const v1::SceneConfig& config,
                                                              SceneSeed seed,
                                                              const CancelToken& cancel);
// Adds the rigs of the best walks found, and says in `scene` why it finds too few, or why too much
// would stand around them. Where nature.walk.clearance_m is larger than what plants leave free
// anyway, the recipe tells them to leave more.
// Errors: kCancelled; as ExpandTerrain but for kOutOfRange.
absl::Status PlaceWalkRigs(const v1::SceneConfig& config, const CancelToken& cancel,
                           SceneInProgress& scene);
// Adds sky, lights and materials, and numbers the layers' objects.
// Errors: kCancelled; as CountLand.
absl::Status DressLand(const v1::SceneConfig& config, const CancelToken& cancel,
                       SceneInProgress& scene);
// The place in words, and a map as lines of text.
SceneDescription DescribeLand(const v1::Scene& scene);

// A land as it stands in a recipe, of landscapes and of houses in one. `views`: the rigs that see
// it. Its ground's mesh, the slots of which are its rules. Errors: as ExpandTerrain.
absl::StatusOr<Mesh> GroundPart(const v1::Terrain& land,
                                const google::protobuf::RepeatedPtrField<v1::Rig>& views);
// Adds the instances of a `land` of the `scene` to `geometry`, which has the scene's materials.
// Errors: kInternal when the expansion's hash is not the recipe's; kInvalidArgument for missing
// materials; as ExpandTerrain.
absl::Status GrowLand(const v1::Scene& scene, const v1::Terrain& land,
                      const google::protobuf::RepeatedPtrField<v1::Rig>& views,
                      SceneGeometry& geometry);
// SceneType::grown.
std::optional<v1::SceneObject> GrownThing(const v1::Terrain& land, uint32_t index);
std::vector<std::string> DescribeMap(const v1::Scene& scene);

}  // namespace parallax
