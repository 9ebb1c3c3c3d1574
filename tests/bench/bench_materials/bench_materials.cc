// What a material costs: nanoseconds an Evaluate and a Height, each class, as one JSON line. Points
// lie a pixel's width apart on a surface two metres away, as a renderer meets them.
//   bench_materials [NAME-PART...]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <string_view>

#include "nlohmann/json.hpp"
#include "worker/materials/material.h"

namespace parallax {
namespace {

constexpr int kPoints = 4000;

std::vector<SurfacePoint> Points() {
  Rng rng(SceneSeed{1}, "bench");
  std::vector<SurfacePoint> points(kPoints);
  for (SurfacePoint& point : points) {
    point.texture_m =
        Vec3f(static_cast<float>(rng.Uniform(0, 1)), static_cast<float>(rng.Uniform(0, 1)), 0.1f);
    point.uv = point.texture_m.head<2>();
    point.texture_normal = Vec3f::UnitZ();
    point.footprint_m = 0.001f;
    point.footprint_uv = 0.002f;
  }
  return points;
}

// The best of five passes: the machine's other work only ever adds.
template <typename Call>
double NanosecondsOf(const std::vector<SurfacePoint>& points, const Call& call) {
  double best = 1e9;
  for (int pass = 0; pass < 5; ++pass) {
    const auto start = std::chrono::steady_clock::now();
    float sum = 0;
    for (const SurfacePoint& point : points) sum += call(point);
    const std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - start;
    volatile float keep = sum;
    (void)keep;
    best = std::min(best, spent.count() / static_cast<double>(points.size()));
  }
  return best;
}

int Run(int argc, char** argv) {
  const std::vector<SurfacePoint> points = Points();
  nlohmann::json classes = nlohmann::json::object();
  double sum = 0, worst = 0;
  std::string worst_name;
  for (const MaterialClass& c : MaterialCatalogue()) {
    bool wanted = argc < 2;
    for (int i = 1; i < argc; ++i) wanted = wanted || c.name.find(argv[i]) != std::string::npos;
    if (!wanted) continue;
    double evaluate = 0, height = 0;
    for (uint64_t seed = 0; seed < 3; ++seed) {
      const auto material = *MakeMaterial(c.name, seed);
      evaluate += NanosecondsOf(points,
                                [&](const SurfacePoint& p) {
                                  const SurfaceSample s = material->Evaluate(p);
                                  return s.base_color.x() + s.roughness;
                                }) /
                  3;
      height +=
          NanosecondsOf(points, [&](const SurfacePoint& p) { return material->Height(p); }) / 3;
    }
    classes[c.name] = {{"evaluate_ns", std::round(evaluate)}, {"height_ns", std::round(height)}};
    sum += evaluate;
    if (evaluate > worst) {
      worst = evaluate;
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
