// Meshes of a recipe's prototypes. Thread-safe.
#pragma once

#include <memory>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"
#include "worker/assets/nature/plant_detail.h"
#include "worker/geometry/mesh.h"

namespace parallax {

// Makes shape `shape` of a prototype at a level of detail. `asset_class` is a class of the
// catalogue; trees add the row of their species table ("BroadleafTree/oak", "Conifer/spruce") and
// then have the prototype's season. The process keeps meshes while they are in use, or until their
// number grows large. Errors: kNotFound for unknown classes and species.
absl::StatusOr<std::shared_ptr<const Mesh>> PrototypeMesh(const v1::Prototype& prototype,
                                                          uint32_t shape, PlantDetail detail);

// The class of the catalogue: "BroadleafTree" of "BroadleafTree/oak".
std::string CatalogueClass(const v1::Prototype& prototype);

}  // namespace parallax
