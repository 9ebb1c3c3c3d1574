// Layers: all surfaces along a pixel's straight line up to the first opaque one, at most
// kMostLayers. Nothing bends the line: behind solid glass and water the picture, which refracts,
// shows another place. Exact hits, independent of sampling and denoising.
//
// Two hits of one surface, of one object and material, that are less than kSamePlace_m apart along
// the line are one layer: front and back of a thin pane.
#pragma once

#include <array>
#include <map>

#include "worker/render/camera/camera.h"
#include "worker/render/camera/stereo_frame.h"
#include "worker/render/scene/render_scene.h"

namespace parallax {

inline constexpr int kMostLayers = 4;
inline constexpr double kSamePlace_m = 2e-3;
inline constexpr uint8_t kMoreLayers = 128;  // Bit of LayerMaps::count.

// The layers of one eye behind the first, which is TraceGroundTruth's.
struct LayerMaps {
  struct Layer {
    ImageF depth_m, disparity_px;  // 0 = no such layer.
    ImageU16 objects, materials;   // 0 = no such layer, or none.
  };
  // Number of layers, 0 to 4; with kMoreLayers set if there are more.
  ImageU8 count;
  std::array<Layer, kMostLayers - 1> behind;  // From the second on; empty where no pixel has one.
  std::map<uint32_t, Clearness> clear;        // Materials of all layers that are not opaque.
};

// Traces the layers of one eye. Errors: kCancelled.
absl::StatusOr<LayerMaps> TraceLayers(const RenderScene& scene, const PinholeCamera& camera,
                                      double baseline_m, const CancelToken& cancel);

}  // namespace parallax
