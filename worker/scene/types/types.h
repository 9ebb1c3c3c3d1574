// Types of scenes. Everything that depends on what kind of scene it is stands in the type's folder
// and is reached through SceneType; types.cc lists them.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/ids.h"
#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/geometry/mesh.h"
#include "worker/geometry/scene_geometry.h"
#include "worker/geometry/surroundings.h"
#include "worker/layout/layout.h"
#include "worker/scene/dress.h"

namespace parallax {

// Costs of the stages of one scene, core-seconds, measured on an AMD EPYC with AVX-512.
struct SceneCosts {
  double layout_s = 0;  // 0: there is nothing to solve, and nothing that variants could share.
  double dress_s = 0;   // All of its rigs included.
  // Whether the rigs of a scene read one radiance cache.
  bool rigs_share_light = true;
  double build_s = 0;      // A scene's renderer takes this much longer to build than a room's.
  double trace_times = 1;  // Tracing of a sample over that in a room.
};

// A place seen from above: what `scene show` draws.
struct GroundPlan {
  // A gap in an edge of `extent`: 0 at y low (south), 1 at x high, 2 at y high, 3 at x low; along
  // it from its smaller coordinate.
  struct Gap {
    int edge = 0;
    double from_m = 0, to_m = 0;
    char glyph = ' ';
  };
  // World; what stands outside of it is not drawn.
  Eigen::AlignedBox3d extent;
  std::vector<Gap> gaps;
};

// A recipe's place in words.
struct SceneDescription {
  std::string kind;                // "kitchen"; empty where places are all alike.
  std::vector<std::string> lines;  // A description for people.
  std::optional<GroundPlan> plan;
};

// Free functions; all are pure, and deterministic in their arguments.
struct SceneType {
  v1::SceneType type = v1::SCENE_TYPE_UNSPECIFIED;
  v1::Place::KindCase place = v1::Place::KIND_NOT_SET;  // Where its scenes are.

  // Stage `layout`: the place and what stands in it.
  // Errors: kCancelled; kInvalidArgument for a config that names unknown classes.
  absl::StatusOr<std::variant<v1::Layout, Rejected>> (*layout)(const v1::SceneConfig& config,
                                                               SceneSeed seed,
                                                               const CancelToken& cancel);
  // Stage `scene`, of a recipe that holds the layout: adds the rigs, as many as it finds up to
  // config.rigs.count. Comes before anything that variants differ in, so that they share rigs.
  // Errors: kCancelled; kNotFound for unknown classes.
  absl::Status (*rigs)(const v1::SceneConfig& config, const CancelToken& cancel,
                       SceneInProgress& scene);
  // The rest of the stage: what floats, lights, sky, materials.
  // Errors: kCancelled; kInvalidArgument for unknown classes or materials.
  absl::Status (*dress)(const v1::SceneConfig& config, const CancelToken& cancel,
                        SceneInProgress& scene);

  // Mesh of an object that is a part of the place (SceneObject.part), object frame.
  // Errors: kNotFound for a part that the place does not have.
  absl::StatusOr<Mesh> (*part)(const v1::Scene& scene, const v1::SceneObject& object);
  Surroundings (*surroundings)(const v1::Place& place);

  SceneCosts (*costs)(const v1::SceneConfig& config);
  SceneDescription (*describe)(const v1::Scene& scene);

  // Adds what stands there by the place's rules rather than as an object of the recipe; nullptr:
  // nothing does. Errors: kInternal when it is not what the recipe was made with.
  absl::Status (*expand)(const v1::Scene& scene, SceneGeometry& geometry) = nullptr;
  // Such an object: class, name, seed and role by its index; nothing for an index of no object.
  std::optional<v1::SceneObject> (*grown)(const v1::Scene& scene, uint32_t index) = nullptr;
  // The place from above as lines of text, for people; may take seconds. nullptr: `describe` says
  // all.
  std::vector<std::string> (*map)(const v1::Scene& scene) = nullptr;
};

// In the order in which they were added.
const std::vector<const SceneType*>& SceneTypes();

// Errors: kInvalidArgument for a type that no folder stands for; names those that there are.
absl::StatusOr<const SceneType*> FindSceneType(v1::SceneType type);
// The type of a recipe that UpgradeScene has seen.
// Errors: as FindSceneType; kInvalidArgument for a place that is not the type's.
absl::StatusOr<const SceneType*> TypeOf(const v1::Scene& scene);
// Errors: kInvalidArgument for a place that is not the type's.
absl::Status CheckPlace(const SceneType& type, const v1::Place& place);

// Mesh of an object of the recipe that is a part of its place. Errors: as TypeOf, SceneType.part.
absl::StatusOr<Mesh> MakePart(const v1::Scene& scene, const v1::SceneObject& object);

}  // namespace parallax
