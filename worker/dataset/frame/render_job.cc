#include "worker/dataset/frame/render_job.h"

#include <new>

#include "worker/dataset/frame/render_frames.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/own_content.h"
#include "worker/scene/scene_pictures.h"
#include "worker/scene/upgrade.h"

namespace parallax {
namespace {

absl::StatusOr<std::unique_ptr<Renderer>> BuildRenderer(const v1::Scene& scene,
                                                        const v1::RenderConfig& config) {
  ASSIGN_OR_RETURN(SceneGeometry geometry, BuildSceneGeometry(scene));
  return Renderer::Create(scene, std::move(geometry), config);
}

}  // namespace

absl::StatusOr<v1::RenderResult> RunRenderJob(const v1::RenderJob& job,
                                              const RenderJobContext& context) {
  static RendererCache* cache = new RendererCache;  // Lives as long as the worker.
  v1::RenderJob upgraded = job;
  RETURN_IF_ERROR(UpgradeScene(*upgraded.mutable_scene()));
  try {
    RETURN_IF_ERROR(LocatePictures(job.picture_dir(), *upgraded.mutable_scene()));
    RETURN_IF_ERROR(LocateOwnContent(upgraded));
    return RenderFrames(upgraded, context, &BuildRenderer, *cache);
  } catch (const std::bad_alloc&) {
    return ResourceExhausted("not enough memory to render the scene");
  }
}

}  // namespace parallax
