#include "worker/scene/solve_scene.h"

#include <fmt/core.h>

#include <string>
#include <utility>
#include <variant>

#include "common/base/seconds.h"
#include "common/base/system/clock.h"
#include "common/base/version.h"
#include "common/config/stages.h"
#include "worker/layout/layout.h"
#include "worker/scene/dress.h"
#include "worker/scene/rigs/rig_camera.h"
#include "worker/scene/rigs/rig_projector.h"
#include "worker/scene/types/scene_types.h"
#include "worker/scene/upgrade.h"

namespace parallax {
namespace {

// The layout of the job, or a new one, which `result` then holds too. Nothing when the seed has
// none: `result` says why.
absl::StatusOr<std::optional<v1::Layout>> LayoutOf(const SceneType& type, const v1::SolveJob& job,
                                                   const CancelToken& cancel,
                                                   v1::SolveResult& result) {
  if (job.has_layout()) {
    v1::Layout layout = job.layout();
    RETURN_IF_ERROR(UpgradeLayout(layout));
    RETURN_IF_ERROR(CheckPlace(type, layout.place()));
    return layout;
  }
  const SteadyTime start = Clock::System().Steady();
  // A layout is given nothing but the fields in its key.
  ASSIGN_OR_RETURN(auto solved, type.layout(FieldsOf(job.config(), v1::FieldRule::LAYOUT),
                                            SceneSeed{job.scene_seed()}, cancel));
  result.set_layout_s(SecondsSince(start));
  if (const Rejected* rejected = std::get_if<Rejected>(&solved)) {
    result.mutable_rejected()->set_reason(rejected->reason);
    return std::optional<v1::Layout>();
  }
  *result.mutable_layout() = std::get<v1::Layout>(std::move(solved));
  return result.layout();
}

SceneInProgress Begin(const SceneType& type, const v1::SolveJob& job, v1::Layout layout) {
  SceneInProgress scene;
  scene.seed = SceneSeed{job.scene_seed()};
  v1::Scene& recipe = scene.recipe;
  recipe.set_layout_version(kLayoutVersion);
  recipe.set_generator_version(kSceneVersion);
  recipe.set_scene_seed(job.scene_seed());
  recipe.set_type(type.type);
  recipe.mutable_place()->Swap(layout.mutable_place());
  recipe.mutable_objects()->Swap(layout.mutable_objects());
  recipe.mutable_lights()->Swap(layout.mutable_lights());
  if (layout.has_report()) recipe.mutable_report()->Swap(layout.mutable_report());
  recipe.mutable_room_reports()->Swap(layout.mutable_room_reports());
  scene.surroundings = type.surroundings(recipe.place());
  return scene;
}

// Dresses `layout`. A rejection leaves `result` with its reason.
absl::Status Dress(const SceneType& type, const v1::SolveJob& job, v1::Layout layout,
                   const CancelToken& cancel, v1::SolveResult& result) {
  SceneInProgress scene = Begin(type, job, std::move(layout));
  ASSIGN_OR_RETURN(scene.own, ReadOwnContent(job.config()));
  RETURN_IF_ERROR(type.rigs(job.config(), cancel, scene));
  const int rigs = scene.recipe.rigs_size(), wanted = job.config().rigs().count();
  if (rigs < wanted) {
    result.mutable_rejected()->set_reason(
        !scene.why_no_rigs.empty()
            ? scene.why_no_rigs
            : fmt::format("rigs: only {} of {} places are free", rigs, wanted));
    return absl::OkStatus();
  }
  AddBaselines(job.config().rigs(), scene.recipe);
  RETURN_IF_ERROR(CheckRawCameras(scene.recipe));
  AddProjectors(job.config().lighting().projector(), scene.seed, scene.recipe);
  RETURN_IF_ERROR(type.dress(job.config(), cancel, scene));
  ChooseEnvironments(job.config().lighting(), scene.own, scene.seed, scene.recipe);
  *result.mutable_scene() = std::move(scene.recipe);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<v1::SolveResult> Solve(const v1::SolveJob& job, const CancelToken& cancel) {
  ASSIGN_OR_RETURN(const SceneType* type, FindSceneType(job.config().type()));
  const v1::RigConfig& rigs = job.config().rigs();
  if (rigs.count() < 1 || rigs.width_px() < 1 || rigs.height_px() < 1) {
    return InvalidArgument("rigs: count, width_px and height_px must be at least 1");
  }
  v1::SolveResult result;
  ASSIGN_OR_RETURN(std::optional<v1::Layout> layout, LayoutOf(*type, job, cancel, result));
  if (!layout) return result;
  const SteadyTime dressing = Clock::System().Steady();
  RETURN_IF_ERROR(Dress(*type, job, *std::move(layout), cancel, result));
  result.set_dress_s(SecondsSince(dressing));
  return result;
}

}  // namespace parallax
