// Pass `exact_occlusion`: occlusion by rays from the other eye.
#include "worker/render/passes/pass.h"
#include "worker/render/truth/optical_flow.h"

namespace parallax {
namespace {

absl::Status RunExactOcclusion(PassScene& scene, Shot& shot, const CancelToken& cancel) {
  return TraceOcclusion(*scene.geometry, shot.stereo, cancel, &shot.frame);
}

}  // namespace

extern const Pass kExactOcclusionPass{"exact_occlusion", &StereoFrame::truth_s, 0, nullptr,
                                      nullptr,           &RunExactOcclusion};

}  // namespace parallax
