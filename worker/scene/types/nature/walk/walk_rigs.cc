// Stage scene: the walks, and the rigs along them.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/config/config.h"
#include "common/math/stereo.h"
#include "worker/scene/rigs/walk.h"
#include "worker/scene/types/nature/ground/land_materials.h"
#include "worker/scene/types/nature/nature.h"
#include "worker/scene/types/nature/rules/masks.h"
#include "worker/scene/types/nature/rules/recipe.h"
#include "worker/scene/types/nature/walk/arena.h"

namespace parallax {
namespace {

constexpr int kArenas = 5;          // Parts of the land in which walks are looked for.
constexpr size_t kWalkTries = 160;  // Tries per arena and wanted walk.
constexpr size_t kEnough = 7;       // Walks to choose the best from, for each that is wanted.
constexpr double kAround_m = 380;   // The site's ground is at its finest there.
// Walks are put up so often, with others for those that prove blocked.
constexpr int kRounds = 3, kRoundsOfSeveral = 6;
// The way is tested on what stands this near, or this much farther away than it must be.
constexpr float kNearby_m = 1.5f, kBeyond_m = 0.65f;
constexpr double kRoom_m = 0.01;  // Room that plants leave beyond what the walk needs.
constexpr float kShoreLeast_m = 3, kShoreMost_m = 22;
constexpr float kDryFeet_m = 0.12f;  // Above the water's level.
constexpr uint32_t kWaterBody = 1;   // MakeArena.
// Places are looked at until one is so even (rise over run), or this many.
constexpr float kEven = 0.22f;
constexpr uint64_t kPlaces = 40;
constexpr float kCoarseRoof_m = 4;
constexpr double kInCave = 0.55;                // Walks begin in this part of a cave's length.
constexpr double kBelow_m = 75, kAbove_m = 35;  // From the foot of a cliff.
constexpr double kTowards = 0.4;                // Cosine of the angle between view and uphill.
constexpr float kUnlikely = 4;  // Penalty, as steepness, where the recipe lets no walk begin.

class WalkRigs {
 public:
  WalkRigs(const v1::SceneConfig& config, SceneInProgress& scene)
      : config_(config),
        recipe_(scene.recipe),
        land_(*scene.recipe.mutable_place()->mutable_terrain()),
        root_(scene.seed, "dress/rigs"),
        baselines_(scene.seed, "dress/rig"),
        walks_(std::clamp(config.nature().walk().walks(), 1, config.rigs().count())),
        frames_((config.rigs().count() + walks_ - 1) / walks_),
        wanted_(static_cast<size_t>(walks_)) {}

  // Leaves the recipe without rigs, and says why, where no walk is found.
  absl::Status Place(const CancelToken& cancel, std::string& why_not) {
    RETURN_IF_ERROR(CheckRules(land_));  // A job may bring its layout.
    ASSIGN_OR_RETURN(const std::shared_ptr<const Terrain> terrain, TerrainOf(land_));
    const RigCamera camera =
        DrawRigCamera(config_.rigs(), root_.Child("fov", 0).Uniform(), root_.Child("camera", 0));
    WalkFinder finder(config_, frames_);
    AskForRoom(finder);
    const auto roof = RoofOf(land_, *terrain, kCoarseRoof_m);
    for (int arena = 0; arena < kArenas; ++arena) {
      const Rng rng = root_.Child("arena", static_cast<uint64_t>(arena));
      const Vec2f middle = MiddleOf(*terrain, MaskOnGround(land_.walk()), rng);
      ASSIGN_OR_RETURN(const auto solid, MakeArena(land_, *terrain, middle));
      WalkLand land{[&](const Vec2f& p) { return terrain->Height(p, 0.15f); }, *solid, middle,
                    land_.has_roof() ? 12.0f
                    : walks_ > 1     ? 60.0f
                                     : 28.0f};
      if (terrain->water() != nullptr) {
        land.wet = [&](const Vec2f& p) { return IsWet(*terrain, p); };
        land.water_body = kWaterBody;
      }
      std::vector<Walk> found;
      for (size_t i = 0; i < kWalkTries * wanted_ && found.size() < kEnough * wanted_; ++i) {
        if (cancel.cancelled()) return Cancelled("solve: cancelled");
        auto walk = finder.Try(land, rng.Child("try", i), camera);
        if (!walk || !Inside(*walk, roof.get()) || !SeesWall(*walk, terrain->spec())) continue;
        found.push_back(*std::move(walk));
      }
      std::stable_sort(found.begin(), found.end(),
                       [](const Walk& a, const Walk& b) { return a.score() > b.score(); });
      ASSIGN_OR_RETURN(const bool taken, Take(found, finder));
      if (taken) return absl::OkStatus();
    }
    why_not = Reason(finder);
    return absl::OkStatus();
  }

 private:
  // Makes plants leave as much room as the walk must have, where that is more than they leave
  // anyway.
  void AskForRoom(const WalkFinder& finder) {
    const double room_m = config_.nature().walk().clearance_m() + kRoom_m;
    if (room_m <= static_cast<double>(kLeastTube_m)) return;
    land_.set_clearance_m(room_m);
    land_.set_clearance_baseline_m(static_cast<double>(finder.reach_m()));
  }

  std::string Reason(const WalkFinder& finder) const {
    std::string reason = fmt::format("walk: {} of {} walks found in the best of {} places: {}",
                                     best_, wanted_, kArenas, finder.Reasons());
    if (blocked_ > 0) reason += fmt::format(", {} blocked by what is rendered", blocked_);
    if (!too_much_.empty()) reason += "; " + too_much_;
    return reason;
  }

  // Whether feet, half a step around too, are in water or where the last wave ran.
  static bool IsWet(const Terrain& terrain, const Vec2f& p) {
    for (const Vec2f& step :
         {Vec2f(0, 0), Vec2f(0.5f, 0), Vec2f(-0.5f, 0), Vec2f(0, 0.5f), Vec2f(0, -0.5f)}) {
      if (terrain.AboveWater(p + step) < kDryFeet_m) return true;
    }
    return false;
  }

  // Somewhere in the site; beside water, near its shore.
  Vec2f PlaceIn(const Terrain& terrain, Rng& place) const {
    if (terrain.water() != nullptr) {
      const auto along = static_cast<float>(place.Uniform(-kAround_m, kAround_m));
      const auto away = static_cast<float>(place.Uniform(kShoreLeast_m, kShoreMost_m));
      return terrain.water()->Beside(along, away, place.Bernoulli(0.5) ? 1.0f : -1.0f);
    }
    return AnyPlace(terrain.spec(), place);
  }

  // Somewhere that people would walk: the least steep of some places where the recipe lets walks
  // begin, or the likeliest of them.
  Vec2f MiddleOf(const Terrain& terrain, const MaskOnGround& where, const Rng& rng) const {
    Vec2f best = Vec2f::Zero();
    float least = 1e9f;
    for (uint64_t i = 0; i < kPlaces && least > kEven; ++i) {
      Rng place = rng.Child("place", i);
      const Vec2f middle = PlaceIn(terrain, place);
      const float steep =
          SteepnessAround(terrain, middle) + kUnlikely * (1 - where.At(terrain, middle));
      if (steep >= least) continue;
      least = steep;
      best = middle;
    }
    return best;
  }

  // Draws a point evenly in the middle of the site, or along the foot of a cliff or gorge.
  Vec2f AnyPlace(const TerrainSpec& spec, Rng& place) const {
    const double angle = place.Uniform(0, 2 * std::numbers::pi);
    const double away = kAround_m * std::sqrt(place.Uniform());
    for (const TerrainTerm& term : spec.cover) {
      const double reach =
          land_.has_roof() ? kInCave * land_.roof().half_length_m() : 0.8 * kAround_m;
      const auto along = static_cast<float>(place.Uniform(-reach, reach));
      if (term.kind == TermKind::kGorge) return GorgeMiddle(term, along);
      if (term.kind != TermKind::kScarp) continue;
      return ScarpFoot(term, along, static_cast<float>(place.Uniform(-kBelow_m, kAbove_m)));
    }
    return Vec2d(away * std::cos(angle), away * std::sin(angle)).cast<float>();
  }

  // Mean over the ground where walks may begin.
  static float SteepnessAround(const Terrain& terrain, const Vec2f& middle) {
    float sum = 0;
    constexpr int kPoints = 24;
    for (int i = 0; i < kPoints; ++i) {
      const float angle = 2.399963f * static_cast<float>(i);
      const float away = 35 * std::sqrt((static_cast<float>(i) + 0.5f) / kPoints);
      sum += terrain.Steepness(middle + away * Vec2f(std::cos(angle), std::sin(angle)));
    }
    return sum / kPoints;
  }

  // Whether all of it is in the cave, if there is one, and not on top of it.
  static bool Inside(const Walk& walk, const CaveRoof* roof) {
    return roof == nullptr ||
           std::all_of(walk.frames.begin(), walk.frames.end(), [&](const Walk::Frame& frame) {
             return frame.eye.z() <
                    static_cast<double>(roof->VaultAt(frame.eye.head<2>().cast<float>()));
           });
  }

  // Whether a walk below a cliff looks towards it; true where none exists.
  static bool SeesWall(const Walk& walk, const TerrainSpec& spec) {
    const Walk::Frame& frame = walk.frames[walk.frames.size() / 2];
    for (const TerrainTerm& term : spec.cover) {
      if (term.kind != TermKind::kScarp) continue;
      const double towards = std::cos(frame.yaw_rad - static_cast<double>(term.direction_rad));
      const float height = TermHeight(term, frame.eye.head<2>().cast<float>(), 1);
      if (height < 0.5f * term.amplitude_m && towards < kTowards) return false;
    }
    return true;
  }

  // Takes the best of those found whose way is clear on what is rendered, too. Walks that prove
  // blocked there give way to the next best.
  absl::StatusOr<bool> Take(const std::vector<Walk>& found, const WalkFinder& finder) {
    std::vector<const Walk*> chosen;
    auto next = found.begin();
    for (int round = 0; round < (wanted_ > 1 ? kRoundsOfSeveral : kRounds); ++round) {
      best_ = std::max(best_, chosen.size());
      while (chosen.size() < wanted_ && next != found.end()) chosen.push_back(&*next++);
      if (chosen.size() < wanted_) break;
      ASSIGN_OR_RETURN(const bool fits, LeaveClear(finder, chosen));
      if (!fits) break;
      if (chosen.size() == wanted_) return true;
    }
    best_ = std::max(best_, chosen.size());
    recipe_.clear_rigs();
    return false;
  }

  // Puts up the rigs of walks and leaves those whose way is clear on what the rules make for them.
  // Returns false, and notes why, where that is too much.
  absl::StatusOr<bool> LeaveClear(const WalkFinder& finder, std::vector<const Walk*>& chosen) {
    recipe_.clear_rigs();
    for (size_t k = 0; k < chosen.size(); ++k) AddRigs(*chosen[k], static_cast<int>(k));
    const auto expansion = ExpandTerrain(land_, recipe_.rigs());
    const absl::Status fits =
        expansion.ok() ? CheckIndices(recipe_, **expansion) : expansion.status();
    if (fits.code() == absl::StatusCode::kOutOfRange) {
      too_much_ = std::string(ToStd(fits.message()));
      return false;
    }
    RETURN_IF_ERROR(fits);
    const float within_m =
        std::max(kNearby_m, static_cast<float>(config_.nature().walk().clearance_m()) + kBeyond_m);
    ASSIGN_OR_RETURN(const auto nearby,
                     MakeNearby(land_, **expansion, recipe_.rigs(), within_m, finder.reach_m()));
    blocked_ +=
        std::erase_if(chosen, [&](const Walk* walk) { return !finder.Clear(*nearby, *walk); });
    return true;
  }

  // Adds the frames of walk `k`: all walks share them evenly.
  void AddRigs(const Walk& walk, int k) {
    const int frames = config_.rigs().count() / walks_ + (k < config_.rigs().count() % walks_);
    const bool each = config_.nature().walk().baseline_per() == v1::WalkConfig::BASELINE_PER_FRAME;
    for (int number = 0; number < frames; ++number) {
      const Walk::Frame& frame = walk.frames[static_cast<size_t>(number)];
      const auto index = static_cast<uint32_t>(recipe_.rigs_size());
      Rng baseline = baselines_.Child("baseline", each ? index : 0);
      *recipe_.add_rigs() =
          MakeRig({.index = index,
                   .position = frame.eye,
                   .axes = CameraAxes(frame.yaw_rad, frame.pitch_rad),
                   .baseline_m = Draw(config_.rigs().baseline_m(), baseline.Uniform()),
                   .k = walk.camera.k,
                   .width_px = config_.rigs().width_px(),
                   .height_px = config_.rigs().height_px()});
      v1::Rig& rig = *recipe_.mutable_rigs(static_cast<int>(index));
      rig.set_depth_std_m(walk.log_depth_std);
      rig.set_path(static_cast<uint32_t>(k) + 1);
      rig.set_time_s(number / config_.nature().walk().fps());
      AddRawCameras(config_.rigs(), root_.Child("camera", 0), &rig);
    }
  }

  const v1::SceneConfig& config_;
  v1::Scene& recipe_;
  v1::Terrain& land_;
  const Rng root_, baselines_;
  const int walks_, frames_;  // As the config says; the most frames of a walk.
  const size_t wanted_;       // `walks_` as size_t.
  // Why a seed is rejected: the most walks that one place has, those that are blocked by what is
  // rendered, and the error of a place where too much would stand.
  size_t best_ = 0, blocked_ = 0;
  std::string too_much_;
};

}  // namespace

absl::Status PlaceWalkRigs(const v1::SceneConfig& config, const CancelToken& cancel,
                           SceneInProgress& scene) {
  return WalkRigs(config, scene).Place(cancel, scene.why_no_rigs);
}

}  // namespace parallax
