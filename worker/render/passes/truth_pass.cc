// Pass `truth`: exact first hits of both eyes, and occlusion by re-projection.
#include "worker/render/passes/pass.h"
#include "worker/render/truth/ground_truth.h"

namespace parallax {
namespace {

absl::Status RunTruth(PassScene& scene, Shot& shot, const CancelToken& cancel) {
  for (int eye = 0; eye < 2; ++eye) {
    const PinholeCamera& camera = shot.stereo.eyes[eye];
    View& view = shot.view(eye);
    if (eye == 0 && shot.kept) {
      view = shot.kept->view;
      view.disparity_px = DisparityOf(view.depth_m, camera.fx_px * shot.stereo.baseline_m);
      continue;
    }
    RETURN_IF_ERROR(
        TraceGroundTruth(*scene.geometry, camera, shot.stereo.baseline_m, cancel, &view));
    MarkVeiled(scene.lights.haze(), camera, &view);
  }
  MarkOcclusion(&shot.frame.left, &shot.frame.right);
  return absl::OkStatus();
}

}  // namespace

extern const Pass kTruthPass{"truth", &StereoFrame::truth_s, 0, nullptr, nullptr, &RunTruth};

}  // namespace parallax
