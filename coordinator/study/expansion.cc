#include "coordinator/study/expansion.h"

#include <algorithm>
#include <set>
#include <string_view>

#include "common/base/names.h"
#include "common/config/check/limits.h"

namespace parallax {
namespace {

constexpr size_t kMostReasonBytes = 500;

absl::Status CheckRange(std::string_view field, int64_t seen, int64_t low, int64_t high) {
  if (seen >= low && seen <= high) return absl::OkStatus();
  return InvalidArgument("{}: {}, wanted {} to {}", field, seen, low, high);
}

// Folders of the user's are named with the hash of their content: results are kept by it.
absl::Status CheckContentIsNamed(const v1::SceneConfig& config) {
  const v1::MaterialConfig& materials = config.materials();
  const struct {
    bool wanted;
    const std::string& sha256;
    const char* field;
    const char* command;
  } folders[] = {{!materials.picture_dir().empty(), materials.pictures_sha256(),
                  "materials.pictures_sha256", "pictures"},
                 {!materials.texture_dir().empty(), materials.textures_sha256(),
                  "materials.textures_sha256", "textures"},
                 {!config.lighting().hdri_dir().empty(), config.lighting().hdris_sha256(),
                  "lighting.hdris_sha256", "hdris"},
                 {!config.assets().include().empty(), config.assets().include_sha256(),
                  "assets.include_sha256", "meshes"}};
  for (const auto& folder : folders) {
    if (!folder.wanted || !folder.sha256.empty()) continue;
    return InvalidArgument(
        "{} is missing; results are kept by the content of the folder, which `parallax config {} "
        "DIR` prints",
        folder.field, folder.command);
  }
  return absl::OkStatus();
}

std::string WhyHopeless(const SceneTally& tally) {
  const auto count = [](int64_t n) { return std::to_string(n); };
  if (tally.solved == 0 && tally.rejected >= kGiveUpRejected) {
    return "no valid scene: the first " + count(tally.rejected) + " seeds were all rejected";
  }
  if (tally.solved == 0 && tally.lost >= kGiveUpLost) {
    return "nothing works: the first " + count(tally.lost) + " scenes all failed";
  }
  if (tally.rejected > kGiveUpRejected + 20 * tally.solved) {
    return "hardly a valid scene: " + count(tally.rejected) + " seeds rejected, " +
           count(tally.solved) + " solved";
  }
  if (tally.lost > kGiveUpLost + tally.solved) {
    return "most scenes fail: " + count(tally.lost) + " failed, " + count(tally.solved) + " solved";
  }
  // Scenes may all be solved, and their renders fail nevertheless.
  if (tally.pairs == 0 && tally.lost >= kGiveUpLost) {
    return "nothing works: " + count(tally.lost) + " scenes failed and no pair was made";
  }
  if (tally.pairs && tally.lost > kGiveUpLost + kGiveUpLostAPair * *tally.pairs) {
    return "hardly a pair: " + count(tally.lost) +
           " scenes failed, pairs made: " + count(*tally.pairs);
  }
  return "";
}

}  // namespace

absl::Status CheckStudySpec(const v1::StudySpec& spec) {
  // The queue must be able to read it back, also if a caller of the library submits it.
  if (const size_t bytes = spec.ByteSizeLong(); bytes > kMaxStudyBytes) {
    return InvalidArgument("study: {} bytes, wanted at most {}", bytes, kMaxStudyBytes);
  }
  if (spec.has_stream()) {
    return InvalidArgument(
        "study.pairs: endless, wanted a number; `parallax stream FILE` begins an endless study");
  }
  if (spec.has_search()) {
    return InvalidArgument(
        "study.search: set, wanted none; `parallax search FILE` begins a search");
  }
  RETURN_IF_ERROR(
      CheckRange("study.variants: their number", spec.variants_size(), 1, kMaxVariants));
  std::set<std::string_view> names;
  for (const v1::VariantSpec& variant : spec.variants()) {
    const std::string where = "study.variants " + Quoted(variant.name());
    if (!names.insert(variant.name()).second) return InvalidArgument("{}: named twice", where);
    RETURN_IF_ERROR(WithContext(CheckRange("pairs", PairsOf(spec, variant), 1, kMaxPairs), where));
    RETURN_IF_ERROR(WithContext(
        CheckRange("rigs_per_scene", RigsPerSceneOf(spec, variant), 1, kMaxRigsPerScene), where));
    RETURN_IF_ERROR(WithContext(CheckContentIsNamed(variant.config()), where));
  }
  return absl::OkStatus();
}

int64_t TotalPairsOf(const v1::StudySpec& study) {
  int64_t pairs = 0;
  for (const v1::VariantSpec& variant : study.variants()) pairs += PairsOf(study, variant);
  return pairs;
}

Expansion NextScenes(const VariantPlan& plan, int64_t limit) {
  Expansion expansion;
  int64_t missing = plan.pairs_wanted - plan.pairs_planned;
  int64_t room = std::min(limit, plan.scenes_ahead - plan.scenes_open);
  if (missing > 0 && plan.highest_living && plan.highest_living->rigs < plan.rigs_per_scene) {
    // Not held back by `room`: it is the same scene again, and new ones must not overtake it.
    const int64_t more =
        std::min<int64_t>(missing, plan.rigs_per_scene - plan.highest_living->rigs);
    expansion.top_up = plan.highest_living;
    expansion.top_up->rigs += static_cast<uint32_t>(more);
    missing -= more;
    --room;
  }
  for (uint32_t ordinal = plan.next_ordinal; missing > 0 && room > 0; ++ordinal, --room) {
    const int64_t rigs = std::min<int64_t>(missing, plan.rigs_per_scene);
    expansion.scenes.push_back({ordinal, static_cast<uint32_t>(rigs)});
    missing -= rigs;
  }
  return expansion;
}

std::string GiveUpReason(const SceneTally& tally) {
  const std::string reason = WhyHopeless(tally);
  if (reason.empty() || tally.last_reason.empty()) return reason;
  return reason + "; the last: " + CutText(tally.last_reason, kMostReasonBytes);
}

}  // namespace parallax
