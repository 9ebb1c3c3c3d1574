// Names of the worker's catalogues that a study may use. The coordinator checks studies and does
// not link the worker, so the names stand here once more; CatalogueNames tests in tests/worker
// compare them with the catalogues. Sorted, except that material families come in byte order among
// the classes. Thread-safe; the lists live for ever.
#pragma once

#include <string>
#include <vector>

namespace parallax {

// Classes of worker/assets.
const std::vector<std::string>& AssetClassNames();
// What `floating.classes` may name beside classes.
const std::vector<std::string>& AssetGroupNames();
// What `materials.diffuse_material` may name, in any case: families and classes of worker/materials
// that any object can have.
const std::vector<std::string>& ObjectMaterialNames();
// Benchmarks of worker/evaluate that need no path.
const std::vector<std::string>& BenchmarkNames();
// Predictors of worker/evaluate that need no training.
const std::vector<std::string>& BaselineNames();

}  // namespace parallax
