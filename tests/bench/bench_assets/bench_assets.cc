// Measures the cost of an object at default detail: milliseconds of one core over all classes and
// 20 seeds, as one JSON line.
//   bench_assets [NAME-PART...]
#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>

#include "nlohmann/json.hpp"
#include "worker/catalogue/figures.h"

namespace parallax {
namespace {

constexpr int kSeeds = 20;

double Rounded(double ms) { return std::round(1000 * ms) / 1000; }

int Run(int argc, char** argv) {
  nlohmann::ordered_json classes = nlohmann::ordered_json::object();
  std::vector<double> all;
  double worst = 0;
  std::string worst_class;
  for (const AssetClass& c : AssetCatalogue()) {
    bool wanted = argc < 2;
    for (int i = 1; i < argc; ++i) wanted = wanted || c.name.find(argv[i]) != std::string::npos;
    if (!wanted) continue;
    const AssetFigures figures = MeasureAssetClass(c, kSeeds);
    all.insert(all.end(), figures.ms.begin(), figures.ms.end());
    classes[c.name] = {{"median_ms", Rounded(figures.median_ms)},
                       {"max_ms", Rounded(figures.ms.back())},
                       {"triangles", figures.median_triangles},
                       {"max_triangles", figures.most_triangles}};
    if (figures.ms.back() > worst) {
      worst = figures.ms.back();
      worst_class = c.name;
    }
  }
  if (all.empty()) {
    std::cerr << "bench_assets: no class is called so\n";
    return 1;
  }
  std::sort(all.begin(), all.end());
  std::cout << nlohmann::ordered_json{{"bench", "assets"},
                                      {"median_ms", Rounded(Percentile(all, 0.5))},
                                      {"p95_ms", Rounded(Percentile(all, 0.95))},
                                      {"max_ms", Rounded(worst)},
                                      {"worst_class", worst_class},
                                      {"objects", all.size()},
                                      {"seeds", kSeeds},
                                      {"classes", classes}}
                   .dump()
            << "\n";
  return 0;
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) { return parallax::Run(argc, argv); }
