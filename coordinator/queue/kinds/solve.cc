// Kind `solve`: layout (unless another job has made it), then dress: one scene's recipe.
//
// Results: "layout" by layout key (the group's part), "recipe" by the hash of the scene, and
// "scene" by scene key: the hash of its recipe, or why the seed has no valid scene.
#include <fmt/core.h>

#include <algorithm>
#include <cstring>

#include "common/base/status.h"
#include "common/config/check/rig_counts.h"
#include "coordinator/queue/database/compress.h"
#include "coordinator/queue/database/sqlite.h"
#include "coordinator/queue/job_kind.h"
#include "coordinator/queue/kinds/result_figures.h"
#include "coordinator/study/rigs.h"
#include "parallax/v1/jobs.pb.h"

namespace parallax {
namespace {

struct CheckedSolve final : CheckedResult {
  bool rejected = false;
  std::string reason;
  Sha256Digest scene_hash{};
  std::string scene_z;
  uint64_t seed = 0;
  uint32_t rigs = 0;
  std::string layout_z;  // Empty: the result has no layout.
  double layout_s = 0, dress_s = 0;
};

std::string BytesOf(const Sha256Digest& digest) { return {digest.begin(), digest.end()}; }

absl::StatusOr<Sha256Digest> DigestOf(std::string_view bytes) {
  Sha256Digest digest;
  if (bytes.size() != digest.size()) {
    return DataLoss("database: a scene's result is no hash");
  }
  std::memcpy(digest.data(), bytes.data(), digest.size());
  return digest;
}

constexpr JobKind::Invariant kInvariants[] = {
    {"a solved scene has its result",
     "SELECT j.id FROM all_jobs AS j LEFT JOIN results AS r ON r.work_key = j.work_key"
     " LEFT JOIN scenes AS s ON s.variant_id = j.variant_id AND s.ordinal = j.ordinal"
     " WHERE j.kind = 'solve' AND j.state = 'SUCCEEDED' AND j.study_id IN"
     " (SELECT id FROM studies WHERE forgotten = 0) AND (r.bytes IS NULL"
     " OR s.scene_hash IS NULL OR r.bytes <> s.scene_hash)"},
    {"a rejected scene has its verdict",
     "SELECT j.id FROM all_jobs AS j WHERE j.kind = 'solve' AND j.state = 'REJECTED'"
     " AND j.study_id IN (SELECT id FROM studies WHERE forgotten = 0)"
     " AND NOT EXISTS (SELECT 1 FROM results AS r WHERE r.work_key = j.work_key"
     " AND r.rejected IS NOT NULL) AND NOT EXISTS (SELECT 1 FROM results AS r"
     " WHERE r.work_key = j.group_key AND r.rejected IS NOT NULL)"},
    {"a ready scene's layout is not rejected",
     "SELECT j.id FROM jobs AS j JOIN results AS r ON r.work_key = j.group_key"
     " WHERE j.kind = 'solve' AND j.state = 'READY' AND r.rejected IS NOT NULL"},
    {"a scene's result has its recipe",
     "SELECT hex(s.work_key) FROM results AS s LEFT JOIN results AS r ON r.work_key = s.bytes"
     " WHERE s.stage = 'scene' AND s.rejected IS NULL AND r.stage IS NOT 'recipe'"},
    {"reused scenes are counted right",
     "SELECT id FROM variants AS v WHERE study_id IN (SELECT id FROM studies"
     " WHERE forgotten = 0) AND solves_reused <> (SELECT count(*) FROM all_jobs AS j"
     " WHERE j.variant_id = v.id AND j.kind = 'solve' AND j.state = 'SUCCEEDED'"
     " AND j.reused = 1)"},
};

class SolveKind final : public JobKind {
 public:
  SolveKind()
      : JobKind("solve", {.stages = {"layout", "scene"},
                          .doing = "solving",
                          .of_scene = true,
                          .begins_scenes = true,
                          .may_reject = true,
                          .shares_part = true}) {}

  // ---- Messages
  absl::StatusOr<std::string> Spec(const LeasedJob& lease, ResultReader& results) const override {
    v1::SolveJob spec;
    spec.set_scene_seed(SceneSeedOf(lease.seed, lease.job.ordinal).value);
    *spec.mutable_config() = *lease.config;
    if (lease.job.part_given) {
      ASSIGN_OR_RETURN(const std::string layout_z, results.ResultBytes(lease.job.group_key));
      RETURN_IF_ERROR(UnpackMessage(layout_z, *spec.mutable_layout()));
    }
    return spec.SerializeAsString();
  }

  std::shared_ptr<const CheckedResult> CheckResult(std::string_view bytes) const override {
    auto out = std::make_shared<CheckedSolve>();
    v1::SolveResult result;
    if (!result.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
      out->invalid = "a result that is no SolveResult";
      return out;
    }
    for (const double seconds : {result.layout_s(), result.dress_s()}) {
      if (out->invalid.empty()) out->invalid = WhyNotIn("a time in seconds", seconds, 0, kLongestS);
    }
    out->layout_s = result.layout_s();
    out->dress_s = result.dress_s();
    if (result.has_layout()) out->layout_z = PackMessage(result.layout());
    switch (result.outcome_case()) {
      case v1::SolveResult::kScene: {
        const std::string scene = DeterministicBytes(result.scene());
        out->scene_hash = Sha256Of(scene);
        out->scene_z = Compress(scene);
        out->seed = result.scene().scene_seed();
        out->rigs = static_cast<uint32_t>(result.scene().rigs_size());
        break;
      }
      case v1::SolveResult::kRejected:
        out->rejected = true;
        out->reason = result.rejected().reason();
        break;
      case v1::SolveResult::OUTCOME_NOT_SET:
        out->invalid = "a solve result with neither a scene nor a rejection";
    }
    return out;
  }

  std::vector<StageSeconds> StagesOf(std::string_view bytes) const override {
    v1::SolveResult result;
    if (!result.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return {};
    return {{"layout", result.layout_s()}, {"dress", result.dress_s()}};
  }

  // ---- Hooks
  absl::StatusOr<JobKeys> Keys(WorkDesk& desk, const JobFacts& job) const override {
    ASSIGN_OR_RETURN(const VariantFacts variant, desk.VariantOf(job.variant));
    const SceneSeed seed = SceneSeedOf(variant.seed, job.ordinal);
    return JobKeys{SceneKey(desk.versions(), *variant.digests, seed),
                   LayoutKey(desk.versions(), *variant.digests, seed)};
  }

  absl::StatusOr<KnownWork> Look(WorkDesk& desk, const JobFacts& job) const override {
    ASSIGN_OR_RETURN(KnownWork known, JobKind::Look(desk, job));
    if (known.state != KnownWork::State::kOpen) return known;
    ASSIGN_OR_RETURN(const auto layout, desk.FindResult(job.group_key));
    known.part_missing = !layout;
    if (layout && layout->rejected) {
      known.state = KnownWork::State::kRejected;
      known.reason = layout->reason;
    }
    return known;
  }

  absl::StatusOr<bool> HasPart(WorkDesk& desk, const JobFacts& job) const override {
    ASSIGN_OR_RETURN(const auto layout, desk.FindResult(job.group_key));
    return layout && !layout->rejected;
  }

  absl::StatusOr<std::string> WhyNot(WorkDesk& desk, const JobFacts& job,
                                     const CheckedResult& result) const override {
    const auto& solve = static_cast<const CheckedSolve&>(result);
    if (solve.rejected) return std::string();
    ASSIGN_OR_RETURN(const VariantFacts variant, desk.VariantOf(job.variant));
    const uint64_t seed = SceneSeedOf(variant.seed, job.ordinal).value;
    if (solve.seed != 0 && solve.seed != seed) {
      return fmt::format("a scene of seed {}, wanted {}", solve.seed, seed);
    }
    const uint32_t wanted = std::max(variant.rigs_per_scene,
                                     static_cast<uint32_t>(PairsOfScene(variant.config->rigs())));
    if (solve.rigs < wanted) {
      return fmt::format("a scene with {} rigs, wanted {}", solve.rigs, wanted);
    }
    return std::string();
  }

  absl::StatusOr<Ending> Store(WorkDesk& desk, const JobFacts& job,
                               const CheckedResult& result) const override {
    const auto& solve = static_cast<const CheckedSolve&>(result);
    // A rejection without a layout, by a job that had to make one, holds for every scene with this
    // layout.
    const bool layout_rejected = solve.rejected && solve.layout_z.empty() && !job.part_given;
    if (layout_rejected || !solve.layout_z.empty()) {
      RETURN_IF_ERROR(
          desk.PutResult(job, "layout", job.group_key,
                         {solve.layout_z, layout_rejected, solve.reason, solve.layout_s})
              .status());
    }
    if (layout_rejected) return Ending{.rejected = true, .reason = solve.reason};
    Ending ending{.rejected = solve.rejected, .reason = solve.reason};
    if (!solve.rejected) {
      ending.result = BytesOf(solve.scene_hash);
      ASSIGN_OR_RETURN(ending.is_fresh,
                       desk.PutResult(job, "recipe", solve.scene_hash, {solve.scene_z, false, ""}));
    }
    const StoredResult own{ending.result, solve.rejected, solve.reason, solve.dress_s};
    ASSIGN_OR_RETURN(const bool is_first, desk.PutResult(job, "scene", job.work_key, own));
    if (is_first) return ending;
    ASSIGN_OR_RETURN(const auto first, desk.FindResult(job.work_key));
    if (!first) return ending;
    return Ending{first->rejected, first->reason, first->bytes,
                  ending.is_fresh && first->bytes == ending.result};
  }

  absl::Status OnSuccess(WorkDesk& desk, const JobFacts& job, const Ending& ending,
                         bool) const override {
    ASSIGN_OR_RETURN(const Sha256Digest scene_hash, DigestOf(ending.result));
    RETURN_IF_ERROR(desk.SetScene(job, scene_hash));
    ASSIGN_OR_RETURN(const SceneFacts scene, desk.SceneOf(job.variant, job.ordinal));
    return AddRender(desk, job.variant, job.ordinal, RigRange(0, scene.rigs), ending.is_fresh);
  }

  absl::Status OnMorePairs(WorkDesk& desk, int64_t variant, uint32_t ordinal, uint32_t first,
                           uint32_t count) const override {
    ASSIGN_OR_RETURN(const SceneFacts scene, desk.SceneOf(variant, ordinal));
    if (!scene.scene_hash) return absl::OkStatus();  // Its solve will ask for all of them.
    return AddRender(desk, variant, ordinal, RigRange(first, count), false);
  }

  // ---- Audit
  std::span<const Invariant> Invariants() const override { return kInvariants; }

  absl::Status Audit(SqliteConnection& db, std::vector<std::string>& violations) const override {
    SqliteQuery recipes(db, "SELECT work_key, bytes FROM results WHERE stage = 'recipe'");
    while (recipes.Next()) {
      const auto bytes = Decompress(recipes.Blob(1));
      if (!bytes.ok() || Sha256Of(*bytes) != recipes.Digest(0)) {
        violations.push_back("a recipe hashes to its name: not " + HexOf(recipes.Digest(0)));
      }
    }
    return recipes.status();
  }

 private:
  static absl::Status AddRender(WorkDesk& desk, int64_t variant, uint32_t ordinal,
                                std::vector<uint32_t> rigs, bool is_fresh) {
    return desk
        .AddJob({.kind = "render",
                 .variant = variant,
                 .ordinal = ordinal,
                 .rigs = std::move(rigs),
                 .is_fresh = is_fresh})
        .status();
  }
};

}  // namespace

std::unique_ptr<JobKind> MakeSolveKind() { return std::make_unique<SolveKind>(); }

}  // namespace parallax
