// The types of scenes. All code that depends on the type of a scene is in the type's folder and is
// called through SceneType; types.cc lists the types.
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
  double layout_s = 0;  // 0: nothing to solve, and nothing for variants to share.
  double dress_s = 0;   // For all rigs of the scene.
  // Whether the rigs of a scene read one radiance cache.
  bool rigs_share_light = true;
  double build_s = 0;      // Time to build its renderer beyond that of a room's.
  double trace_times = 1;  // Time to trace a sample over that in a room.
};

// A place seen from above: what `scene show` draws.
struct GroundPlan {
  // A gap in an edge of `extent`: 0 at low y (south), 1 at high x, 2 at high y, 3 at low x;
  // measured along the edge from its smaller coordinate.
  struct Gap {
    int edge = 0;
    double from_m = 0, to_m = 0;
    char glyph = ' ';
  };
  // World; objects outside of it are not drawn.
  Eigen::AlignedBox3d extent;
  std::vector<Gap> gaps;
};

// A recipe's place, described for people.
struct SceneDescription {
  std::string kind;                // "kitchen"; empty where all places are alike.
  std::vector<std::string> lines;  // A description for people.
  std::optional<GroundPlan> plan;
};

// A scene type as a table of functions; all are pure, and deterministic in their arguments.
struct SceneType {
  v1::SceneType type = v1::SCENE_TYPE_UNSPECIFIED;
  v1::Place::KindCase place = v1::Place::KIND_NOT_SET;  // The kind of place of its scenes.

  // Stage `layout`: makes the place and the objects in it.
  // Errors: kCancelled; kInvalidArgument for a config that names unknown classes.
  absl::StatusOr<std::variant<v1::Layout, Rejected>> (*layout)(const v1::SceneConfig& config,
                                                               SceneSeed seed,
                                                               const CancelToken& cancel);
  // Stage `scene`, for a recipe that holds the layout: adds rigs, as many as it finds up to
  // config.rigs.count. Runs before anything in which variants differ, so that they share rigs.
  // Errors: kCancelled; kNotFound for unknown classes.
  absl::Status (*rigs)(const v1::SceneConfig& config, const CancelToken& cancel,
                       SceneInProgress& scene);
  // Does the rest of the stage `scene`: floating objects, lights, sky, materials.
  // Errors: kCancelled; kInvalidArgument for unknown classes or materials.
  absl::Status (*dress)(const v1::SceneConfig& config, const CancelToken& cancel,
                        SceneInProgress& scene);

  // Makes the mesh of an object that is a part of the place (SceneObject.part), object frame.
  // Errors: kNotFound for a part that the place does not have.
  absl::StatusOr<Mesh> (*part)(const v1::Scene& scene, const v1::SceneObject& object);
  Surroundings (*surroundings)(const v1::Place& place);

  SceneCosts (*costs)(const v1::SceneConfig& config);
  SceneDescription (*describe)(const v1::Scene& scene);

  // Adds the geometry that the place's rules make and the recipe does not list; null: there is
  // none. Errors: kInternal when it differs from that with which the recipe was made.
  absl::Status (*expand)(const v1::Scene& scene, SceneGeometry& geometry) = nullptr;
  // Describes such an object: class, name, seed and role by its index; nothing for an unused index.
  std::optional<v1::SceneObject> (*grown)(const v1::Scene& scene, uint32_t index) = nullptr;
  // Returns a map of the place as lines of text, for people; may take seconds. Null: `describe`
  // says all.
  std::vector<std::string> (*map)(const v1::Scene& scene) = nullptr;
  // Checks what the other functions take for granted of a place, because recipes may come from
  // strangers. Null: each checks what it reads. Errors: kInvalidArgument naming what is wrong.
  absl::Status (*check)(const v1::Place& place) = nullptr;
};

// Returns all types, in the order in which they were added.
const std::vector<const SceneType*>& SceneTypes();

// Errors: kInvalidArgument for a type without a folder, naming the known ones.
absl::StatusOr<const SceneType*> FindSceneType(v1::SceneType type);
// Returns the type of a recipe that UpgradeScene has upgraded.
// Errors: as FindSceneType and CheckPlace.
absl::StatusOr<const SceneType*> TypeOf(const v1::Scene& scene);
// Checks that the place is of the type's kind and sound.
// Errors: kInvalidArgument for a place that is not the type's; those of SceneType.check.
absl::Status CheckPlace(const SceneType& type, const v1::Place& place);

// Makes the mesh of an object that is a part of its place. Errors: as TypeOf, SceneType.part.
absl::StatusOr<Mesh> MakePart(const v1::Scene& scene, const v1::SceneObject& object);

}  // namespace parallax
