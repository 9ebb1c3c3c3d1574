// Names of the worker's catalogues that a study may use. The coordinator checks studies but does
// not link the worker, so the names are repeated here; the CatalogueNames tests in tests/worker
// compare them with the catalogues. All lists are in byte order. Thread-safe; the lists live as
// long as the program.
#pragma once

#include <string>
#include <vector>

namespace parallax {

// Classes of worker/assets.
const std::vector<std::string>& AssetClassNames();
// Groups of classes that `floating.classes` may name beside classes.
const std::vector<std::string>& AssetGroupNames();
// Families and classes of worker/materials that any object can have; `materials.diffuse_material`
// may name them in upper or lower case.
const std::vector<std::string>& ObjectMaterialNames();
// Materials that the ground of a land can have.
const std::vector<std::string>& GroundMaterialNames();
// Trees with their species, as lands name them: "BroadleafTree/oak".
const std::vector<std::string>& TreeNames();
// Kinds of rooms that `room.kinds` may name, beside a config's own.
const std::vector<std::string>& RoomKindNames();
// Benchmarks of worker/evaluate that need no path.
const std::vector<std::string>& BenchmarkNames();
// Predictors of worker/evaluate that need no training.
const std::vector<std::string>& BaselineNames();

}  // namespace parallax
