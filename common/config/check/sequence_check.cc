#include <fmt/core.h>

#include <algorithm>

#include "common/config/check/checks.h"
#include "common/config/check/field_rules.h"
#include "common/config/check/limits.h"
#include "common/config/check/rig_counts.h"
#include "common/config/frame_maps.h"

namespace parallax::config_internal {
namespace {

constexpr int kMostBaselines = 8;

class SequenceChecker {
 public:
  SequenceChecker(const v1::SceneConfig& config, const std::string& path, Findings* findings)
      : config_(config), rigs_(config.rigs()), path_(path), findings_(findings) {}

  void Run() {
    CheckBaselines();
    CheckPaths();
    const bool nature = config_.type() == v1::SCENE_TYPE_NATURE;
    if (HasMap(config_.render(), "flow") && !HasPaths() && !nature) {
      Tell("render.maps",
           "flow without a sequence, allowed with rigs.path.paths >= 1, or in scenes of type "
           "nature, whose walks are sequences");
    }
    if (config_.floating().motion().p() > 0 && !HasPaths()) {
      Tell("floating.motion.p",
           "moves things, but there is no sequence, allowed with rigs.path.paths >= 1");
    }
  }

 private:
  void Tell(const char* field, std::string what) {
    findings_->push_back({Dotted(path_, field), std::move(what)});
  }

  bool HasPaths() const { return rigs_.path().paths() > 0; }

  void CheckBaselines() {
    const auto& baselines = rigs_.baselines_m();
    if (baselines.size() > kMostBaselines) {
      Tell("rigs.baselines_m",
           fmt::format("a list of {}, allowed are at most {}", baselines.size(), kMostBaselines));
    }
    for (int i = 1; i < baselines.size(); ++i) {
      if (std::find(baselines.begin(), baselines.begin() + i, baselines[i]) ==
          baselines.begin() + i) {
        continue;
      }
      Tell("rigs.baselines_m", "has one number twice, allowed are different baselines");
    }
    const int64_t pairs = PairsOfScene(rigs_);
    if (baselines.size() > 1 && pairs > kMaxRigsPerScene) {
      Tell("rigs.count",
           fmt::format(
               "{} left eyes with {} right ones make {} pairs a scene, allowed are at most {}",
               rigs_.count(), baselines.size(), pairs, kMaxRigsPerScene));
    }
  }

  void CheckPaths() {
    if (!HasPaths()) return;
    if (config_.type() == v1::SCENE_TYPE_NATURE) {
      Tell("rigs.path.paths",
           "camera paths are for rooms, allowed in scenes of type indoor; landscapes have "
           "nature.walk.walks");
    } else if (config_.type() == v1::SCENE_TYPE_DENSE) {
      Tell("rigs.path.paths", "camera paths are for rooms, allowed in scenes of type indoor");
    }
    if (rigs_.path().paths() > rigs_.count()) {
      Tell("rigs.path.paths",
           fmt::format("{} paths share {} frames (rigs.count), allowed is at most one path a frame",
                       rigs_.path().paths(), rigs_.count()));
    }
  }

  const v1::SceneConfig& config_;
  const v1::RigConfig& rigs_;
  const std::string path_;
  Findings* findings_;
};

}  // namespace

void CheckSequences(const v1::SceneConfig& config, const std::string& path, Findings* findings) {
  SequenceChecker(config, path, findings).Run();
}

}  // namespace parallax::config_internal
