#include <fmt/core.h>

#include <set>

#include "common/base/names.h"
#include "common/config/check/checks.h"
#include "common/config/check/field_rules.h"
#include "common/config/check/limits.h"
#include "common/config/check/rig_counts.h"
#include "common/config/training_plan.h"

namespace parallax::config_internal {
namespace {

std::string WhyOutOfRange(int64_t value, int64_t low, int64_t high, std::string_view unit = "") {
  if (value >= low && value <= high) return "";
  v1::FieldRule rule;
  rule.set_min(static_cast<double>(low));
  rule.set_max(static_cast<double>(high));
  rule.set_unit(std::string(unit));
  return fmt::format("{} is out of range, allowed {}", value, AllowedRange(rule));
}

class StudyChecker {
 public:
  explicit StudyChecker(const v1::StudySpec& study) : study_(study) {}

  Findings Run() {
    const size_t bytes = study_.ByteSizeLong();
    if (bytes > kMaxStudyBytes) {
      Tell("", fmt::format(
                   "the study has {} bytes with every default written out, allowed are at most {}",
                   bytes, kMaxStudyBytes));
      return findings_;
    }
    if (!IsFolderName(study_.name())) Tell("study", WhyNotFolderName(study_.name()));
    Tell("pairs", WhyOutOfRange(study_.pairs(), 1, kMaxPairs));
    if (!study_.variants().empty()) {
      Tell("rigs_per_scene", WhyOutOfRange(study_.rigs_per_scene(), 1, kMaxRigsPerScene));
    }
    Tell("priority", WhyOutOfRange(study_.priority(), -kMaxPriority, kMaxPriority));
    Tell("memory_mb", WhyOutOfRange(study_.memory_mb(), 0, kMaxMemoryMb, "MB"));
    CheckTags();
    CheckSource();
    CheckVariants();
    CheckRigs();
    CheckNotify(study_, &findings_);
    CheckStream(study_, &findings_);
    CheckTraining(study_, &findings_);
    CheckSearch(study_, &findings_);
    return findings_;
  }

 private:
  void Tell(const std::string& path, std::string what) {
    if (!what.empty()) findings_.push_back({path, std::move(what)});
  }

  void CheckTags() {
    if (study_.tags_size() > kMaxTags) {
      return Tell("tags", fmt::format("a list of {}, allowed are at most {}", study_.tags_size(),
                                      kMaxTags));
    }
    std::set<std::string> seen;
    for (int i = 0; i < study_.tags_size(); ++i) {
      const std::string path = fmt::format("tags[{}]", i);
      const std::string& tag = study_.tags(i);
      if (!IsName(tag)) {
        Tell(path, WhyNotName(tag));
      } else if (!seen.insert(tag).second) {
        Tell(path, Quoted(tag) + " is there already, allowed is each tag once");
      }
    }
  }

  // The study file goes beside the dataset as it came.
  void CheckSource() {
    const std::string& source = study_.source_yaml();
    if (source.size() > kMaxYamlBytes) {
      Tell("source_yaml",
           fmt::format("a text of {} bytes, allowed are at most {}", source.size(), kMaxYamlBytes));
    } else if (source.find('\0') != std::string::npos || !IsUtf8(source)) {
      Tell("source_yaml", "not a text file: it holds a NUL byte or is no UTF-8");
    }
  }

  void CheckVariants() {
    if (study_.variants().empty()) {
      return Tell("variants", "an empty list, allowed is a list of at least one {name, set}");
    }
    const int most = kMaxVariants - (WantsHeldout(study_) ? 1 : 0);
    int own = study_.variants_size();
    for (const v1::VariantSpec& variant : study_.variants()) own -= variant.heldout() ? 1 : 0;
    if (own > most || study_.variants_size() > kMaxVariants) {
      return Tell("variants", fmt::format("a list of {}, allowed are at most {}", own, most));
    }
    std::set<std::string> names;
    for (int i = 0; i < study_.variants_size(); ++i) {
      const v1::VariantSpec& variant = study_.variants(i);
      const std::string path = PathOf(i);
      if (!IsFolderName(variant.name())) {
        Tell(path + ".name", WhyNotFolderName(variant.name()));
      } else if (!names.insert(variant.name()).second) {
        Tell(path + ".name",
             Quoted(variant.name()) + " names another variant too, allowed is a name of its own");
      }
      // 0: the study's own.
      if (variant.pairs() != 0) {
        Tell(path + ".pairs", WhyOutOfRange(variant.pairs(), 1, kMaxPairs));
      }
      if (variant.rigs_per_scene() != 0) {
        Tell(path + ".rigs_per_scene",
             WhyOutOfRange(variant.rigs_per_scene(), 1, kMaxRigsPerScene));
      }
      CheckConfig(variant.config(), path + ".config", &findings_);
    }
  }

  // rigs_per_scene against what each variant's scenes have. A config without a number of rigs
  // comes from a program that fills it in later.
  void CheckRigs() {
    for (int i = 0; i < study_.variants_size(); ++i) {
      const v1::VariantSpec& variant = study_.variants(i);
      const v1::RigConfig& rigs = variant.config().rigs();
      const int64_t count = PairsOfScene(rigs);
      if (count < 1 || count > kMaxRigsPerScene) continue;  // Absent, or told already.
      const std::string allowed =
          fmt::format(" has, allowed 1 to rigs.count{}{}",
                      EyesOfLeft(rigs) > 1 ? " x rigs.baselines_m = " : " = ", count);
      const bool own = variant.rigs_per_scene() > 0;
      const int32_t wanted = own ? variant.rigs_per_scene() : study_.rigs_per_scene();
      if (wanted <= count) continue;
      Tell(own ? PathOf(i) + ".rigs_per_scene" : "rigs_per_scene",
           fmt::format("{} is more than {}{}", wanted,
                       own ? "the variant" : "variant " + Quoted(variant.name()), allowed));
    }
  }

  static std::string PathOf(int variant) { return fmt::format("variants[{}]", variant); }

  const v1::StudySpec& study_;
  Findings findings_;
};

}  // namespace

Findings CheckStudy(const v1::StudySpec& study) { return StudyChecker(study).Run(); }

}  // namespace parallax::config_internal
