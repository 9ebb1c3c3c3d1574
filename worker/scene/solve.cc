#include "worker/scene/solve.h"

#include <algorithm>
#include <string>
#include <utility>
#include <variant>

#include "common/base/clock.h"
#include "common/base/version.h"
#include "common/math/proto.h"
#include "worker/layout/layout.h"
#include "worker/layout/room_shell.h"
#include "worker/scene/dense.h"
#include "worker/scene/dress.h"
#include "worker/scene/glass_parts.h"

namespace parallax {
namespace {

double SecondsSince(SteadyTime start) {
  return std::chrono::duration<double>(Clock::System().Steady() - start).count();
}

// A removed ceiling takes what hangs from it along. Indices of the others stay, so that they
// compare across variants.
void RemoveCeiling(v1::Scene& scene) {
  v1::Scene kept = scene;
  kept.clear_objects();
  kept.clear_lights();
  std::vector<uint32_t> removed;
  for (const v1::SceneObject& object : scene.objects()) {
    const bool above = object.room_part() == "ceiling" || object.room_part() == "cornice" ||
                       object.relation() == "on_ceiling";
    if (object.room_index() == 0 && above) {
      removed.push_back(object.index());
    } else {
      *kept.add_objects() = object;
    }
  }
  for (const v1::Light& light : scene.lights()) {
    const bool hung =
        light.kind() == v1::Light::KIND_MESH &&
        std::find(removed.begin(), removed.end(), light.object_index()) != removed.end();
    if (!hung) *kept.add_lights() = light;
  }
  scene = std::move(kept);
}

// The study's "no background objects": furniture and what stands on it, lamps included. What is
// left keeps its indices.
void RemoveFurniture(v1::Scene& scene) {
  std::vector<uint32_t> removed;
  v1::Scene kept = scene;
  kept.clear_objects();
  kept.clear_lights();
  for (const v1::SceneObject& object : scene.objects()) {
    if (object.role() == v1::OBJECT_ROLE_FURNITURE) {
      removed.push_back(object.index());
    } else {
      *kept.add_objects() = object;
    }
  }
  for (const v1::Light& light : scene.lights()) {
    const bool gone =
        light.kind() == v1::Light::KIND_MESH &&
        std::find(removed.begin(), removed.end(), light.object_index()) != removed.end();
    if (!gone) *kept.add_lights() = light;
  }
  scene = std::move(kept);
}

// Dresses `layout`. A rejection leaves `result` with its reason.
absl::Status Dress(const v1::SolveJob& job, const v1::Layout& layout, const CancelToken& cancel,
                   v1::SolveResult& result) {
  SceneInProgress scene;
  scene.seed = SceneSeed{job.scene_seed()};
  v1::Scene& recipe = scene.recipe;
  recipe.set_layout_version(kLayoutVersion);
  recipe.set_generator_version(kSceneVersion);
  recipe.set_scene_seed(job.scene_seed());
  recipe.set_type(job.config().type());
  *recipe.mutable_room() = layout.room();
  *recipe.mutable_objects() = layout.objects();
  *recipe.mutable_lights() = layout.lights();
  *recipe.mutable_report() = layout.report();
  *recipe.mutable_rooms() = layout.rooms();
  *recipe.mutable_room_reports() = layout.room_reports();

  const auto stop = [&] {
    return cancel.cancelled() ? absl::CancelledError("solve: cancelled") : absl::OkStatus();
  };
  RETURN_IF_ERROR(AddSolids(scene, 0));
  RETURN_IF_ERROR(stop());
  uint32_t next_index = 1;
  for (const auto& object : recipe.objects()) {
    next_index = std::max(next_index, object.index() + 1);
  }
  scene.solid.Commit();
  // Before anything that variants differ in: they share their viewpoints.
  const int rigs = ChooseRigs(job.config().rigs(), scene);
  if (rigs < job.config().rigs().count()) {
    result.mutable_rejected()->set_reason("rigs: only " + std::to_string(rigs) + " of " +
                                          std::to_string(job.config().rigs().count()) +
                                          " places are free");
    return absl::OkStatus();
  }
  RETURN_IF_ERROR(stop());
  if (!job.config().furniture().enabled()) {
    RemoveFurniture(recipe);
    scene.solid = RayScene();
    RETURN_IF_ERROR(AddSolids(scene, 0));
    scene.solid.Commit();
  }
  RETURN_IF_ERROR(AddFloating(job.config(), next_index, scene));
  RETURN_IF_ERROR(stop());
  scene.solid.Commit();
  ChooseLighting(job.config().lighting(), scene);
  RETURN_IF_ERROR(OmitGlassParts(job.config().assets(), scene));
  RETURN_IF_ERROR(ChooseMaterials(job.config().materials(), scene));
  if (recipe.ceiling_removed()) RemoveCeiling(recipe);
  *result.mutable_scene() = std::move(recipe);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<v1::SolveResult> Solve(const v1::SolveJob& job, const CancelToken& cancel) {
  if (job.config().type() != v1::SCENE_TYPE_INDOOR && job.config().type() != v1::SCENE_TYPE_DENSE) {
    return absl::InvalidArgumentError("type: only indoor and dense scenes can be solved");
  }
  const v1::RigConfig& rigs = job.config().rigs();
  if (rigs.count() < 1 || rigs.width_px() < 1 || rigs.height_px() < 1) {
    return absl::InvalidArgumentError("rigs: count, width_px and height_px must be at least 1");
  }
  v1::SolveResult result;
  v1::Layout layout;
  const SteadyTime start = Clock::System().Steady();
  if (job.config().type() == v1::SCENE_TYPE_DENSE) {
    result.mutable_layout();  // Nothing stands still in a dense scene.
    ASSIGN_OR_RETURN(*result.mutable_scene(),
                     SolveDense(job.config(), SceneSeed{job.scene_seed()}, cancel));
    result.set_dress_s(SecondsSince(start));
    return result;
  }
  if (job.has_layout()) {
    layout = job.layout();
  } else {
    // Furniture is left out by `dress`, so that a variant without it shares layout and rigs.
    v1::SceneConfig furnished = job.config();
    furnished.mutable_furniture()->set_enabled(true);
    ASSIGN_OR_RETURN(auto solved, SolveLayout(furnished, SceneSeed{job.scene_seed()}, cancel));
    result.set_layout_s(SecondsSince(start));
    if (const Rejected* rejected = std::get_if<Rejected>(&solved)) {
      result.mutable_rejected()->set_reason(rejected->reason);
      return result;
    }
    layout = std::get<v1::Layout>(std::move(solved));
    *result.mutable_layout() = layout;
  }
  const SteadyTime dressing = Clock::System().Steady();
  RETURN_IF_ERROR(Dress(job, layout, cancel, result));
  result.set_dress_s(SecondsSince(dressing));
  return result;
}

}  // namespace parallax
