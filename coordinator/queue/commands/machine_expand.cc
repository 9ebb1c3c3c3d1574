// Makes the scenes that variants need, a window of them at a time.
#include <algorithm>

#include "coordinator/queue/commands/machine.h"
#include "coordinator/study/expansion.h"

namespace parallax {

absl::Status Machine::TopUp(Variant& variant, const ScenePlan& plan) {
  ASSIGN_OR_RETURN(SceneRow * scene, OpenScene(variant.id, plan.ordinal, /*change=*/true));
  const uint32_t before = scene->rigs;
  scene->rigs = plan.rigs;
  ledger_.Change(variant).pairs_planned += plan.rigs - before;
  return kinds_[kinds_.begins_scenes()].OnMorePairs(*this, variant.id, plan.ordinal, before,
                                                    plan.rigs - before);
}

absl::StatusOr<bool> Machine::Expand(int64_t limit) {
  const std::vector<int64_t> hungry(hungry_.begin(), hungry_.end());
  for (const int64_t id : hungry) {
    ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(id));
    ASSIGN_OR_RETURN(Study * study, ledger_.FindStudy(variant->study));
    const int64_t missing = variant->pairs_wanted - variant->tally.pairs_planned;
    if (missing <= 0 || study->tally.cancelled || !variant->tally.problem.empty()) {
      hungry_.erase(id);
      continue;
    }
    if (limit <= 0) return true;
    VariantPlan plan{.pairs_wanted = variant->pairs_wanted,
                     .pairs_planned = variant->tally.pairs_planned,
                     .rigs_per_scene = variant->rigs_per_scene,
                     .next_ordinal = static_cast<uint32_t>(variant->tally.next_ordinal),
                     .scenes_open = variant->tally.scenes_open,
                     // A large farm needs more than a small one to choose from.
                     .scenes_ahead = std::max<int64_t>(options_.scenes_ahead, 2 * leased_now_)};
    RETURN_IF_ERROR(FlushScene());
    ASSIGN_OR_RETURN(const std::optional<uint32_t> highest, scenes_.HighestLiving(id));
    if (highest) {
      ASSIGN_OR_RETURN(const SceneRow* scene, OpenScene(id, *highest, /*change=*/false));
      if (scene->rigs_lost == 0) plan.highest_living = ScenePlan{*highest, scene->rigs};
    }
    const Expansion expansion = NextScenes(plan, limit);
    if (expansion.top_up) RETURN_IF_ERROR(TopUp(*variant, *expansion.top_up));
    for (const ScenePlan& scene : expansion.scenes) {
      RETURN_IF_ERROR(FlushScene());
      scene_ = {.variant = id, .ordinal = scene.ordinal, .is_new = true, .changed = true};
      scene_.row.rigs = scene.rigs;
      VariantTally& tally = ledger_.Change(*variant);
      tally.next_ordinal = scene.ordinal + 1;
      tally.pairs_planned += scene.rigs;
      RETURN_IF_ERROR(AddJob({.kind = kinds_[kinds_.begins_scenes()].name(),
                              .variant = id,
                              .ordinal = scene.ordinal})
                          .status());
      // Seeds known to be bad may have used up the variant's patience.
      if (!variant->tally.problem.empty()) break;
    }
    limit -= static_cast<int64_t>(expansion.scenes.size()) + (expansion.top_up ? 1 : 0);
    // With no room in its window it comes back when one of its scenes ends.
    if (expansion.scenes.empty() && !expansion.top_up) hungry_.erase(id);
  }
  return !hungry_.empty();
}

}  // namespace parallax
