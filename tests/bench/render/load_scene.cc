#include "tests/bench/render/load_scene.h"

#include <google/protobuf/text_format.h>

#include <chrono>
#include <fstream>
#include <sstream>

#include "tests/bench/render/demo_room.h"

namespace parallax::bench {

absl::StatusOr<LoadedScene> LoadScene(const std::string& path, uint64_t seed) {
  LoadedScene loaded;
  const auto start = std::chrono::steady_clock::now();
  if (path.empty()) {
    test::TestScene room = MakeDemoRoom(seed);
    loaded.recipe = std::move(room.recipe);
    loaded.geometry = std::move(room.geometry);
  } else {
    std::ifstream file(path, std::ios::binary);
    std::stringstream content;
    content << file.rdbuf();
    if (!file) return MakeError(absl::StatusCode::kNotFound, "cannot read " + path);
    const bool text =
        path.find(".txtpb") != std::string::npos || path.find(".textproto") != std::string::npos;
    const bool parsed =
        text ? google::protobuf::TextFormat::ParseFromString(content.str(), &loaded.recipe)
             : loaded.recipe.ParseFromString(content.str());
    if (!parsed) return MakeError(absl::StatusCode::kInvalidArgument, path + ": not a scene");
#ifdef PARALLAX_HAVE_SCENE
    ASSIGN_OR_RETURN(loaded.geometry, BuildSceneGeometry(loaded.recipe));
#else
    return MakeError(absl::StatusCode::kUnimplemented, "built without worker/scene");
#endif
  }
  loaded.geometry_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return loaded;
}

}  // namespace parallax::bench
