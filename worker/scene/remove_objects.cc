#include <algorithm>
#include <utility>

#include "worker/scene/dress.h"

namespace parallax {

void RemoveObjects(const std::function<bool(const v1::SceneObject&)>& goes, v1::Scene& recipe) {
  std::vector<uint32_t> removed;
  for (const v1::SceneObject& object : recipe.objects()) {
    if (goes(object)) removed.push_back(object.index());
  }
  const auto is_removed = [&](uint32_t index) {
    return std::find(removed.begin(), removed.end(), index) != removed.end();
  };
  auto& objects = *recipe.mutable_objects();
  objects.erase(std::remove_if(objects.begin(), objects.end(),
                               [&](const auto& object) { return is_removed(object.index()); }),
                objects.end());
  auto& lights = *recipe.mutable_lights();
  lights.erase(std::remove_if(lights.begin(), lights.end(),
                              [&](const v1::Light& light) {
                                return light.kind() == v1::Light::KIND_MESH &&
                                       is_removed(light.object_index());
                              }),
               lights.end());
}

}  // namespace parallax
