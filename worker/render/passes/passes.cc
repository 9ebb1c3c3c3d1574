#include "worker/render/film/overexposed.h"
#include "worker/render/passes/pass.h"

namespace parallax {

extern const Pass kTruthPass, kExactOcclusionPass, kFlowPass, kLayersPass, kFilmPass, kInfraredPass,
    kRawPass;

std::span<const Pass* const> Passes() {
  static constexpr const Pass* kAll[] = {&kTruthPass,  &kExactOcclusionPass, &kFlowPass,
                                         &kLayersPass, &kFilmPass,           &kInfraredPass,
                                         &kRawPass};
  return kAll;
}

absl::Status PassScene::Denoise(float exposure, const CancelToken& cancel, Film* film) const {
  if (!denoiser) return absl::OkStatus();
  const ImageF3 excess = TakeExcess(Overexposed(film->color, exposure), exposure, &film->color);
  RETURN_IF_ERROR(denoiser->Execute(cancel, film->albedo, film->normal, &film->color));
  for (size_t i = 0; i < excess.values().size(); ++i) {
    film->color.values()[i] += excess.values()[i];
  }
  return absl::OkStatus();
}

}  // namespace parallax
