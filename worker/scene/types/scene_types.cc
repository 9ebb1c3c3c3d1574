#include "worker/scene/types/scene_types.h"

#include <google/protobuf/descriptor.h>

#include "worker/scene/types/dense/dense.h"
#include "worker/scene/types/indoor/indoor.h"
#include "worker/scene/types/nature/nature.h"

namespace parallax {

// The registry: one line a type.
const std::vector<const SceneType*>& SceneTypes() {
  static const std::vector<const SceneType*> types = {
      &kIndoorScenes,
      &kDenseScenes,
      &kNatureScenes,
  };
  return types;
}

absl::StatusOr<const SceneType*> FindSceneType(v1::SceneType type) {
  std::string known;
  for (const SceneType* entry : SceneTypes()) {
    if (entry->type == type) return entry;
    known += (known.empty() ? "" : ", ") + v1::SceneType_Name(entry->type);
  }
  return InvalidArgument("type: no scenes of type {} ({}) can be made; there are {}",
                         static_cast<int>(type), v1::SceneType_Name(type), known);
}

absl::StatusOr<const SceneType*> TypeOf(const v1::Scene& scene) {
  ASSIGN_OR_RETURN(const SceneType* type, FindSceneType(scene.type()));
  RETURN_IF_ERROR(CheckPlace(*type, scene.place()));
  return type;
}

absl::Status CheckPlace(const SceneType& type, const v1::Place& place) {
  if (place.kind_case() == type.place) return type.check ? type.check(place) : absl::OkStatus();
  const auto name = [](int number) {
    const auto* field = v1::Place::descriptor()->FindFieldByNumber(number);
    return field == nullptr ? std::string("nowhere") : field->name();
  };
  return InvalidArgument("place: {}, but {} scenes want {}", name(place.kind_case()),
                         v1::SceneType_Name(type.type), name(type.place));
}

absl::StatusOr<Mesh> MakePart(const v1::Scene& scene, const v1::SceneObject& object) {
  ASSIGN_OR_RETURN(const SceneType* type, TypeOf(scene));
  return type->part(scene, object);
}

}  // namespace parallax
