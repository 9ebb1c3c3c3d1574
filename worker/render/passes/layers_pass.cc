// Pass `layers`: what is behind glass and water, of both eyes.
#include <fmt/core.h>

#include "worker/render/passes/pass.h"
#include "worker/render/truth/layers.h"

namespace parallax {
namespace {

absl::Status RunLayers(PassScene& scene, Shot& shot, const CancelToken& cancel) {
  StereoFrame& frame = shot.frame;
  for (int eye = 0; eye < 2; ++eye) {
    const std::string name = eye == 0 ? "left" : "right";
    ASSIGN_OR_RETURN(LayerMaps maps, TraceLayers(*scene.geometry, shot.stereo.eyes[eye],
                                                 shot.stereo.baseline_m, cancel));
    frame.more["layers_" + name + ".png"] = std::move(maps.count);
    for (size_t i = 0; i < maps.behind.size() && !maps.behind[i].depth_m.empty(); ++i) {
      LayerMaps::Layer& layer = maps.behind[i];
      frame.more[fmt::format("depth{}_{}.exr", i + 2, name)] = std::move(layer.depth_m);
      frame.more[fmt::format("disparity{}_{}.exr", i + 2, name)] = std::move(layer.disparity_px);
      frame.more[fmt::format("objects{}_{}.png", i + 2, name)] = std::move(layer.objects);
      frame.more[fmt::format("materials{}_{}.png", i + 2, name)] = std::move(layer.materials);
    }
    frame.clear_materials.merge(maps.clear);
  }
  frame.interiors = scene.geometry->geometry().surroundings.interiors;
  return absl::OkStatus();
}

}  // namespace

extern const Pass kLayersPass{"layers", &StereoFrame::truth_s, 80, nullptr, nullptr, &RunLayers};

}  // namespace parallax
