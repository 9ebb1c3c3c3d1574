// Measures the cost of a material: nanoseconds a point for an Evaluate and a Height, each class, as
// one JSON line. Points come eight at a time, as in the renderer.
//   bench_materials [NAME-PART...]
#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>

#include "nlohmann/json.hpp"
#include "worker/catalogue/figures.h"

namespace parallax {
namespace {

int Run(int argc, char** argv) {
  nlohmann::json classes = nlohmann::json::object();
  double sum = 0, worst = 0;
  std::string worst_name;
  for (const MaterialClass& c : MaterialCatalogue()) {
    const bool wanted = argc < 2 || std::any_of(argv + 1, argv + argc, [&](const char* part) {
                          return c.name.find(part) != std::string::npos;
                        });
    if (!wanted) continue;
    const MaterialFigures figures = MeasureMaterialClass(c);
    classes[c.name] = {{"evaluate_ns", std::round(figures.evaluate_ns)},
                       {"height_ns", std::round(figures.height_ns)}};
    sum += figures.evaluate_ns;
    if (figures.evaluate_ns > worst) {
      worst = figures.evaluate_ns;
      worst_name = c.name;
    }
  }
  if (classes.empty()) {
    std::cerr << "bench_materials: no class is called so\n";
    return 1;
  }
  std::cout << nlohmann::json{{"bench", "materials"},
                              {"mean_evaluate_ns",
                               std::round(sum / static_cast<double>(classes.size()))},
                              {"worst_evaluate_ns", std::round(worst)},
                              {"worst_class", worst_name},
                              {"classes", classes}}
                   .dump()
            << "\n";
  return 0;
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) { return parallax::Run(argc, argv); }
