// Pass `raw`: the pair before rectification, with the exposure of the rectified one.
#include <fmt/core.h>

#include "common/base/system/memory_budget.h"
#include "worker/render/film/exposure.h"
#include "worker/render/passes/pass.h"
#include "worker/render/truth/raw_pair.h"

namespace parallax {
namespace {

constexpr int kBytesPerPixel = 400;  // Both eyes' films and maps, the denoiser's buffers.
constexpr int kFirstStream = 2;      // The eyes' streams: no two pictures share their noise.

bool HasRawCameras(const v1::Rig& rig) { return rig.has_raw_left(); }

int64_t PixelsOfRawPair(const v1::Rig& rig) {
  const v1::RawCamera &left = rig.raw_left(), &right = rig.raw_right();
  return int64_t{left.width_px()} * left.height_px() +
         int64_t{right.width_px()} * right.height_px();
}

absl::Status RunRaw(PassScene& scene, Shot& shot, const CancelToken& cancel) {
  const v1::Rig& rig = shot.rig;
  StereoFrame* frame = &shot.frame;
  const FilmTracer tracer = scene.Tracer();
  ASSIGN_OR_RETURN(const StereoCamera raw, StereoCamera::RawFromRig(rig));
  RETURN_IF_ERROR(
      CheckMemory(fmt::format("render: raw images of rig {}", rig.index()),
                  int64_t{kBytesPerPixel} * raw.eyes[0].width_px * raw.eyes[0].height_px));
  RETURN_IF_ERROR(
      TraceCorrespondence(*scene.geometry, raw, cancel, &frame->raw_left, &frame->raw_right));
  RawView* views[2] = {&frame->raw_left, &frame->raw_right};
  for (int eye = 0; eye < 2; ++eye) {
    const PinholeCamera& camera = raw.eyes[eye];
    const auto stream = [&](uint32_t part) {
      return scene.StreamOf(rig, kFirstStream + eye, part);
    };
    Film film(camera);
    tracer.TraceEye(camera, stream(0), nullptr, {}, shot.clamp, cancel, &shot.meter, &film);
    if (cancel.cancelled()) return Cancelled("render: cancelled");
    tracer.TraceGuides(camera, stream(4), nullptr, cancel, &shot.meter, &film);
    tracer.TraceEdges(camera, stream(3), shot.clamp, frame->exposure, cancel, &shot.meter, &film);
    if (cancel.cancelled()) return Cancelled("render: cancelled");
    RETURN_IF_ERROR(scene.Denoise(frame->exposure, cancel, &film));
    BlackenUnseen(*camera.lens, &film.color);
    views[eye]->color = ToSrgb(film.color, frame->exposure);
    views[eye]->radiance = std::move(film.color);
  }
  frame->rays = shot.meter.rays();
  return absl::OkStatus();
}

}  // namespace

extern const Pass kRawPass{"raw",  &StereoFrame::trace_s, 0, &PixelsOfRawPair, &HasRawCameras,
                           &RunRaw};

}  // namespace parallax
