#include "tests/bench/render/load_scene.h"

#include <google/protobuf/text_format.h>

#include <chrono>
#include <ctime>
#include <fstream>
#include <sstream>

#include "common/base/seconds.h"
#include "common/config/config.h"
#include "tests/bench/render/demo_room.h"
#include "worker/scene/solve_scene.h"
#include "worker/scene/upgrade.h"

namespace parallax::bench {

namespace {

// "solve:SEED" or "solve:SEED:CONFIG".
absl::StatusOr<v1::Scene> SolveSeed(const std::string& request, int rigs) {
  const size_t colon = request.find(':', 6);
  v1::SolveJob job;
  job.set_scene_seed(std::strtoull(request.c_str() + 6, nullptr, 10));
  ASSIGN_OR_RETURN(
      *job.mutable_config(),
      LoadSceneConfig(colon == std::string::npos ? "indoor" : request.substr(colon + 1)));
  if (rigs > 0) job.mutable_config()->mutable_rigs()->set_count(rigs);
  ASSIGN_OR_RETURN(const v1::SolveResult result, Solve(job, {}));
  if (result.has_scene()) return result.scene();
  return NotFound("rejected: {}", result.rejected().reason());
}

}  // namespace

absl::StatusOr<LoadedScene> LoadScene(const std::string& path, uint64_t seed, int rigs) {
  LoadedScene loaded;
  const auto start = std::chrono::steady_clock::now();
  if (path.empty()) {
    test::TestScene room = MakeDemoRoom(seed);
    loaded.recipe = std::move(room.recipe);
    loaded.geometry = std::move(room.geometry);
  } else if (path.rfind("solve:", 0) == 0) {
    const std::clock_t begin = std::clock();
    ASSIGN_OR_RETURN(loaded.recipe, SolveSeed(path, rigs));
    loaded.solve_core_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    ASSIGN_OR_RETURN(loaded.geometry, BuildSceneGeometry(loaded.recipe));
  } else {
    std::ifstream file(path, std::ios::binary);
    std::stringstream content;
    content << file.rdbuf();
    if (!file) return NotFound("cannot read {}", path);
    const bool text =
        path.find(".txtpb") != std::string::npos || path.find(".textproto") != std::string::npos;
    const bool parsed =
        text ? google::protobuf::TextFormat::ParseFromString(content.str(), &loaded.recipe)
             : loaded.recipe.ParseFromString(content.str());
    if (!parsed) return InvalidArgument("{}: not a scene", path);
    RETURN_IF_ERROR(UpgradeScene(loaded.recipe));
    ASSIGN_OR_RETURN(loaded.geometry, BuildSceneGeometry(loaded.recipe));
  }
  loaded.geometry_s = SecondsSince(start);
  return loaded;
}

}  // namespace parallax::bench
