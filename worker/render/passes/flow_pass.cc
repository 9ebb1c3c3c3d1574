// Pass `flow`: flow to the frames before and after a frame of a sequence.
#include "worker/render/passes/pass.h"
#include "worker/render/truth/optical_flow.h"

namespace parallax {
namespace {

absl::Status RunFlow(PassScene& scene, Shot& shot, const CancelToken& cancel) {
  return TraceFlow(scene.book, shot.rig, shot.kept ? &shot.kept->view : nullptr, *scene.geometry,
                   scene.moving, cancel, &shot.frame);
}

}  // namespace

extern const Pass kFlowPass{"flow", &StereoFrame::truth_s, 52, nullptr, nullptr, &RunFlow};

}  // namespace parallax
