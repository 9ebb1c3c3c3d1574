// Pass `infrared`: both eyes' pictures of the room's light and the rig's projector.
#include "worker/render/passes/pass.h"
#include "worker/render/truth/infrared.h"

namespace parallax {
namespace {

constexpr uint32_t kStream = 5;

absl::Status RunInfrared(PassScene& scene, Shot& shot, const CancelToken& cancel) {
  // A left eye that several rigs share has one picture.
  const SampleStream streams[2] = {scene.StreamOf(shot.pairing.leader, 0, kStream),
                                   scene.StreamOf(shot.rig, 1, kStream)};
  return RenderInfrared(*scene.geometry, shot.stereo, shot.rig, streams, shot.pairing.shared(),
                        cancel, &shot.frame);
}

}  // namespace

extern const Pass kInfraredPass{"infrared", &StereoFrame::trace_s, 0, nullptr,
                                nullptr,    &RunInfrared};

}  // namespace parallax
