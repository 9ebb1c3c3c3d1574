#include "coordinator/queue/moves/expander.h"

#include <algorithm>

namespace parallax {

absl::Status Expander::TopUp(Variant& variant, const ScenePlan& plan) {
  ASSIGN_OR_RETURN(SceneRow * scene,
                   tables_.scenes.Open(variant.id, plan.ordinal, /*change=*/true));
  const uint32_t before = scene->rigs;
  scene->rigs = plan.rigs;
  tables_.ledger.Change(variant).pairs_planned += plan.rigs - before;
  return tables_.kinds[tables_.kinds.begins_scenes()].OnMorePairs(
      jobs_.desk(), variant.id, plan.ordinal, before, plan.rigs - before);
}

absl::StatusOr<bool> Expander::Expand(int64_t limit) {
  const std::vector<int64_t> hungry(tables_.hungry.begin(), tables_.hungry.end());
  for (const int64_t id : hungry) {
    ASSIGN_OR_RETURN(Variant * variant, tables_.ledger.FindVariant(id));
    ASSIGN_OR_RETURN(Study * study, tables_.ledger.FindStudy(variant->study));
    const int64_t missing = variant->pairs_wanted - variant->tally.pairs_planned;
    if (missing <= 0 || study->tally.cancelled || !variant->tally.problem.empty()) {
      tables_.hungry.erase(id);
      continue;
    }
    if (limit <= 0) return true;
    VariantPlan plan{
        .pairs_wanted = variant->pairs_wanted,
        .pairs_planned = variant->tally.pairs_planned,
        .rigs_per_scene = variant->rigs_per_scene,
        .next_ordinal = static_cast<uint32_t>(variant->tally.next_ordinal),
        .scenes_open = variant->tally.scenes_open,
        // A large farm needs more than a small one to choose from.
        .scenes_ahead = std::max<int64_t>(tables_.options.scenes_ahead, 2 * tables_.leased_now)};
    ASSIGN_OR_RETURN(const std::optional<uint32_t> highest, tables_.scenes.HighestLiving(id));
    if (highest) {
      ASSIGN_OR_RETURN(const SceneRow* scene, tables_.scenes.Open(id, *highest, /*change=*/false));
      if (scene->rigs_lost == 0) plan.highest_living = ScenePlan{*highest, scene->rigs};
    }
    const Expansion expansion = NextScenes(plan, limit);
    if (expansion.top_up) RETURN_IF_ERROR(TopUp(*variant, *expansion.top_up));
    for (const ScenePlan& scene : expansion.scenes) {
      RETURN_IF_ERROR(tables_.scenes.Add(id, scene.ordinal, scene.rigs));
      VariantTally& tally = tables_.ledger.Change(*variant);
      tally.next_ordinal = scene.ordinal + 1;
      tally.pairs_planned += scene.rigs;
      RETURN_IF_ERROR(jobs_
                          .AddJob({.kind = tables_.kinds[tables_.kinds.begins_scenes()].name(),
                                   .variant = id,
                                   .ordinal = scene.ordinal})
                          .status());
      // Seeds known to be bad may have used up the variant's patience.
      if (!variant->tally.problem.empty()) break;
    }
    limit -= static_cast<int64_t>(expansion.scenes.size()) + (expansion.top_up ? 1 : 0);
    // With no room in its window it comes back when one of its scenes ends.
    if (expansion.scenes.empty() && !expansion.top_up) tables_.hungry.erase(id);
  }
  return !tables_.hungry.empty();
}

}  // namespace parallax
