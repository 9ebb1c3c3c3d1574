// Checks `train` and `evaluate` of a study: names, numbers, and variants that they refer to.
#include <fmt/core.h>

#include <algorithm>
#include <set>

#include "common/base/edit_distance.h"
#include "common/base/names.h"
#include "common/config/catalogue_names.h"
#include "common/config/check/checks.h"
#include "common/config/check/field_rules.h"
#include "common/config/check/limits.h"
#include "common/config/defaults.h"
#include "common/config/frame_maps.h"
#include "common/config/training_plan.h"

namespace parallax::config_internal {
namespace {

constexpr int kCropMultiple = 32;  // The embedded trainer's network halves its input five times.
constexpr int kCropWidth = 384, kCropHeight = 192;  // The embedded trainer's own crop, pixels.
// Truth, and which of it is sky or the exterior of rooms, on which nothing is trained or scored.
constexpr const char* kMapsOfTruth[] = {"disparity", "masks"};

std::string ItemOf(const std::string& list, int index) {
  return fmt::format("{}[{}]", list, index);
}

class TrainChecker {
 public:
  TrainChecker(const v1::StudySpec& study, Findings* findings)
      : given_(study), study_(Resolved(study)), findings_(findings) {}

  void Run() {
    for (const v1::VariantSpec& variant : given_.variants()) {
      if (!variant.heldout()) variants_.push_back(variant.name());
    }
    CheckHeldout();
    CheckFolders();
    const size_t before = findings_->size();
    if (given_.has_train()) CheckFields(given_.train(), "train", findings_);
    if (given_.has_evaluate()) CheckFields(given_.evaluate(), "evaluate", findings_);
    if (findings_->size() > before) return;  // Each value by itself first.
    if (given_.has_train()) CheckTrain();
    if (given_.has_evaluate()) CheckEvaluate();
    if (findings_->size() > before) return;
    CheckNumbers();
    CheckPictures();
  }

 private:
  // Returns the study without its held-out variant, which may be there already.
  static v1::StudySpec Resolved(const v1::StudySpec& study) {
    v1::StudySpec resolved;
    resolved.set_seed(study.seed());
    resolved.set_pairs(study.pairs());
    if (study.has_train()) *resolved.mutable_train() = study.train();
    if (study.has_evaluate()) *resolved.mutable_evaluate() = study.evaluate();
    ResolveTraining(&resolved);
    for (const v1::VariantSpec& variant : study.variants()) {
      v1::VariantSpec& kept = *resolved.add_variants();
      kept.set_name(variant.name());
      kept.set_pairs(variant.pairs());
      kept.set_heldout(variant.heldout());
    }
    return resolved;
  }

  void Tell(const std::string& path, std::string what) {
    if (!what.empty()) findings_->push_back({path, std::move(what)});
  }

  bool IsVariant(const std::string& name) const {
    return std::find(variants_.begin(), variants_.end(), name) != variants_.end();
  }
  std::string WhyNotVariant(const std::string& name) const {
    if (IsVariant(name)) return "";
    return Quoted(name) + " is no variant of the study" + NearestHint(name, variants_) +
           " (allowed: " + Shown(variants_) + ")";
  }
  // A long list of names is of no use in a message.
  static std::string Shown(std::vector<std::string> names) {
    constexpr size_t kMostShown = 30;
    const bool cut = names.size() > kMostShown;
    if (cut) names.resize(kMostShown);
    return JoinNames(names) + (cut ? ", ..." : "");
  }

  // ---- The variant that is held out. It comes with a resolved study, and no other has its name.
  void CheckHeldout() {
    int found = 0;
    for (int i = 0; i < given_.variants_size(); ++i) {
      const v1::VariantSpec& variant = given_.variants(i);
      const std::string path = ItemOf("variants", i);
      if (variant.heldout() != (variant.name() == kHeldoutName)) {
        Tell(path + ".name",
             Quoted(variant.name()) +
                 (variant.heldout() ? " is held out, which only \"heldout\" can be"
                                    : " is reserved for the pairs of evaluate.heldout_pairs, "
                                      "allowed is another name"));
        continue;
      }
      if (!variant.heldout()) continue;
      if (++found > 1) continue;  // Equal names are reported already.
      const int64_t wanted = study_.evaluate().heldout_pairs();
      if (variant.pairs() != wanted) {
        Tell(path + ".pairs",
             fmt::format(
                 "{} pairs are held out, allowed are as many as evaluate.heldout_pairs says: {}",
                 variant.pairs(), wanted));
      }
      for (const v1::VariantSpec& other : given_.variants()) {
        if (other.heldout() || SeedOf(given_, other) != SeedOf(given_, variant)) continue;
        Tell(path + ".seed",
             fmt::format(
                 "{} is the seed of variant {} too, allowed is one that no variant trains on",
                 SeedOf(given_, variant), Quoted(other.name())));
        break;
      }
    }
  }

  // Networks and scores lie beside the variants' folders.
  void CheckFolders() {
    if (!given_.has_train() && !given_.has_evaluate()) return;
    for (int i = 0; i < given_.variants_size(); ++i) {
      const std::string& name = given_.variants(i).name();
      if (std::find(std::begin(kResultFolders), std::end(kResultFolders), name) ==
          std::end(kResultFolders)) {
        continue;
      }
      Tell(ItemOf("variants", i) + ".name",
           Quoted(name) +
               " is reserved for the results of a study that trains or evaluates, "
               "allowed is another name");
    }
  }

  // ---- Trainings
  void CheckTrain() {
    const v1::TrainSpec& train = study_.train();
    if (train.steps() > 0 && train.minutes() > 0) {
      Tell("train.minutes", "both steps and minutes, allowed is one: steps follow from minutes");
    }
    if ((train.width_px() > 0) != (train.height_px() > 0)) {
      Tell(train.width_px() > 0 ? "train.width_px" : "train.height_px",
           "one side of a crop alone, allowed are both or neither");
    }
    if (train.trainer() == "builtin") {
      CheckCrop("train.width_px", train.width_px());
      CheckCrop("train.height_px", train.height_px());
    }
    CheckTags("train.needs.tags", train.needs());
    CheckChosenVariants();
    std::set<std::string> names(variants_.begin(), variants_.end());
    for (int i = 0; i < train.mixtures_size(); ++i) {
      CheckMixture(train.mixtures(i), ItemOf("train.mixtures", i), &names);
    }
    if (train.only_mixtures() && train.mixtures().empty()) {
      Tell("train.only_mixtures", "nothing to train: there are no mixtures");
    }
  }

  void CheckCrop(const std::string& path, int size) {
    if (size % kCropMultiple == 0) return;
    Tell(path, fmt::format("{} px, allowed for the trainer builtin are multiples of {}", size,
                           kCropMultiple));
  }

  void CheckChosenVariants() {
    const v1::TrainSpec& train = study_.train();
    std::set<std::string> seen;
    for (int i = 0; i < train.variants_size(); ++i) {
      const std::string& name = train.variants(i);
      const std::string path = ItemOf("train.variants", i);
      Tell(path, WhyNotVariant(name));
      if (!seen.insert(name).second) {
        Tell(path, Quoted(name) + " is there already, allowed is each variant once");
      }
    }
    if (train.only_mixtures() && !train.variants().empty()) {
      Tell("train.variants", "a list beside only_mixtures, allowed is one of them");
    }
  }

  void CheckMixture(const v1::Mixture& mixture, const std::string& path,
                    std::set<std::string>* names) {
    const std::string& name = mixture.name();
    if (!IsFolderName(name)) {
      Tell(path + ".name", WhyNotFolderName(name));
    } else if (name == kHeldoutName) {
      Tell(path + ".name", Quoted(name) + " is reserved, allowed is another name");
    } else if (!names->insert(name).second) {
      Tell(path + ".name", Quoted(name) + " names another " +
                               (IsVariant(name) ? "variant" : "mixture") +
                               " too, allowed is a name of its own");
    }
    if (mixture.share() <= 0) {
      Tell(path + ".share", "0, allowed is more: of no pairs nothing can be learnt");
    }
    // A resolved study has the default everywhere.
    if (!mixture.mismatched() && mixture.mismatched_share() != 1) {
      Tell(path + ".mismatched_share",
           fmt::format("{} has no effect without mismatched: true, allowed are both or neither",
                       mixture.mismatched_share()));
    } else if (mixture.mismatched_share() <= 0) {
      Tell(path + ".mismatched_share", "0, allowed is more, or no mismatched");
    }
    if (mixture.parts().empty()) {
      return Tell(path + ".parts",
                  "an empty list, allowed is a list of at least one {variant, "
                  "weight}");
    }
    std::set<std::string> seen;
    double sum = 0;
    for (int i = 0; i < mixture.parts_size(); ++i) {
      const v1::Mixture::Part& part = mixture.parts(i);
      const std::string part_path = ItemOf(path + ".parts", i) + ".variant";
      Tell(part_path, WhyNotVariant(part.variant()));
      if (!seen.insert(part.variant()).second) {
        Tell(part_path, Quoted(part.variant()) + " is there already, allowed is each variant once");
      }
      sum += part.weight();
    }
    if (sum <= 0) Tell(path + ".parts", "all weights are 0, allowed is one above 0 at least");
    if (mixture.curated()) CheckCurated(mixture, path);
  }

  // A network must be there that scores the frames, and a threshold that some can pass.
  void CheckCurated(const v1::Mixture& mixture, const std::string& path) {
    v1::Mixture set = mixture;
    if (set.truth().empty()) set.set_truth(study_.train().truth());
    if (PlainTwinOf(set, TrainingSetsOf(study_)) < 0) {
      Tell(path + ".curated",
           "true, but no training set has the same parts without curation, allowed is a set beside "
           "one whose networks can score its frames");
    }
    for (int i = 0; i < mixture.parts_size(); ++i) {
      const std::string& name = mixture.parts(i).variant();
      for (const v1::VariantSpec& variant : given_.variants()) {
        const v1::FilterConfig& filters = variant.config().filters();
        if (variant.name() != name) continue;
        if (filters.has_max_ambiguous_share() && filters.max_ambiguous_share() < 1) continue;
        Tell(ItemOf(path + ".parts", i) + ".variant",
             Quoted(name) +
                 " has filters.max_ambiguous_share 1, so no frame would be left out, allowed "
                 "in a curated set is less (FoundationStereo's authors take 0.6)");
      }
    }
  }

  void CheckTags(const std::string& path, const v1::JobNeeds& needs) {
    if (needs.tags_size() > kMaxTags) {
      return Tell(path,
                  fmt::format("a list of {}, allowed are at most {}", needs.tags_size(), kMaxTags));
    }
    for (int i = 0; i < needs.tags_size(); ++i) {
      if (!IsName(needs.tags(i))) Tell(ItemOf(path, i), WhyNotName(needs.tags(i)));
    }
  }

  // ---- Evaluations
  void CheckEvaluate() {
    const v1::EvaluateSpec& evaluate = study_.evaluate();
    CheckOnce("evaluate.benchmarks", evaluate.benchmarks(), "benchmark");
    CheckOnce("evaluate.baselines", evaluate.baselines(), "baseline");
    CheckOnce("evaluate.group_by", evaluate.group_by(), "group");
    CheckOwnBenchmarks();
    if (evaluate.benchmarks().empty() && evaluate.own_benchmarks().empty() &&
        evaluate.heldout_pairs() == 0) {
      Tell("evaluate.benchmarks",
           "an empty list, allowed is at least one benchmark, or heldout_pairs");
    }
    if (!given_.has_train() && evaluate.baselines().empty()) {
      Tell("evaluate.baselines",
           "nothing to evaluate: the study has no train and the list is empty");
    }
    CheckHeldoutVariant();
    CheckReference();
    CheckTags("evaluate.needs.tags", evaluate.needs());
    const int64_t steps = study_.train().steps();
    if (steps > 0 && evaluate.checkpoints() > steps) {
      Tell("evaluate.checkpoints",
           fmt::format("{} are more than the training's steps, allowed 1 to {}",
                       evaluate.checkpoints(), steps));
    }
  }

  template <typename List>
  void CheckOnce(const std::string& path, const List& names, const std::string& what) {
    std::set<std::string> seen;
    for (int i = 0; i < names.size(); ++i) {
      if (seen.insert(names[i]).second) continue;
      Tell(ItemOf(path, i),
           Quoted(names[i]) + " is there already, allowed is each " + what + " once");
    }
  }

  void CheckOwnBenchmarks() {
    std::set<std::string> names(BenchmarkNames().begin(), BenchmarkNames().end());
    names.insert(kHeldoutName);
    for (int i = 0; i < study_.evaluate().own_benchmarks_size(); ++i) {
      const v1::OwnBenchmark& own = study_.evaluate().own_benchmarks(i);
      const std::string path = ItemOf("evaluate.own_benchmarks", i);
      if (!IsFolderName(own.name())) {
        Tell(path + ".name", WhyNotFolderName(own.name()));
      } else if (!names.insert(own.name()).second) {
        Tell(path + ".name",
             Quoted(own.name()) + " names another benchmark too, allowed is a name of its own");
      }
      if (own.list().empty() == own.folder().empty()) {
        Tell(path, own.list().empty() ? "neither list nor folder, allowed is one of them"
                                      : "both list and folder, allowed is one of them");
      }
    }
  }

  void CheckHeldoutVariant() {
    const std::string& name = study_.evaluate().heldout_variant();
    if (name.empty()) return;
    Tell("evaluate.heldout_variant", WhyNotVariant(name));
    if (!WantsHeldout(study_)) {
      Tell("evaluate.heldout_variant",
           "no effect without heldout_pairs, allowed are both or neither");
    }
  }

  void CheckReference() {
    const std::string& name = study_.evaluate().reference();
    if (name.empty()) return;
    std::vector<std::string> sets;
    for (const v1::Mixture& set : TrainingSetsOf(study_)) sets.push_back(set.name());
    if (std::find(sets.begin(), sets.end(), name) != sets.end()) return;
    Tell("evaluate.reference", Quoted(name) + " is no training set of the study" +
                                   NearestHint(name, sets) +
                                   (sets.empty() ? "" : " (allowed: " + Shown(sets) + ")"));
  }

  // ---- What it comes to
  void CheckNumbers() {
    const std::vector<v1::Mixture> sets = TrainingSetsOf(study_);
    const int64_t trainings = static_cast<int64_t>(sets.size()) * study_.train().seeds();
    if (trainings > kMaxTrainings) {
      Tell("train.seeds",
           fmt::format(
               "{} training sets with {} seeds each are {} trainings, allowed are at most {}",
               sets.size(), study_.train().seeds(), trainings, kMaxTrainings));
    }
    for (const v1::Mixture& set : sets) {
      int64_t pairs = 0;
      for (const v1::Mixture::Part& part : set.parts()) pairs += PairsOf(part.variant());
      if (pairs <= kMaxTrainingPairs) continue;
      Tell("train", fmt::format("training set {} has {} pairs, allowed are at most {}",
                                Quoted(set.name()), pairs, kMaxTrainingPairs));
    }
    const v1::EvaluateSpec& evaluate = study_.evaluate();
    const int64_t benchmarks = evaluate.benchmarks_size() + evaluate.own_benchmarks_size() +
                               (WantsHeldout(study_) ? 1 : 0);
    const int64_t evaluations =
        (trainings * evaluate.checkpoints() + evaluate.baselines_size()) * benchmarks;
    if (evaluations > kMaxEvaluations) {
      Tell("evaluate",
           fmt::format("{} evaluations, allowed are at most {}", evaluations, kMaxEvaluations));
    }
  }

  // ---- What is rendered for it
  void CheckPictures() {
    std::set<std::string> trained, scored, behind;
    for (const v1::Mixture& set : TrainingSetsOf(study_)) {
      for (const v1::Mixture::Part& part : set.parts()) {
        trained.insert(part.variant());
        if (set.truth() == "behind") behind.insert(part.variant());
      }
    }
    if (WantsHeldout(study_)) {
      const std::string& named = study_.evaluate().heldout_variant();
      const std::string source = named.empty() && !variants_.empty() ? variants_[0] : named;
      scored.insert(source);
      if (TruthOfHeldout(study_) == "behind") behind.insert(source);
    }
    for (int i = 0; i < given_.variants_size(); ++i) {
      const v1::VariantSpec& variant = given_.variants(i);
      const std::string path = ItemOf("variants", i) + ".config.";
      const bool is_trained = trained.count(variant.name()) > 0;
      if (is_trained) CheckSize(variant.config().rigs(), path + "rigs.");
      if (is_trained || variant.heldout() || scored.count(variant.name()) > 0) {
        CheckMaps(variant.config(), path + "render.maps");
      }
      if (behind.count(variant.name()) > 0 && !HasMap(variant.config().render(), "layers")) {
        Tell(path + "render.maps", "without layers, which `truth: behind` is made of");
      }
    }
  }

  // Pictures without a size have the default one, which is checked where defaults are filled in.
  void CheckSize(const v1::RigConfig& rigs, const std::string& path) {
    const v1::TrainSpec& train = study_.train();
    if (train.trainer() != "builtin") return;
    const auto check = [&](const char* field, bool is_set, int size, int crop) {
      if (!is_set || size >= crop) return;
      Tell(path + field,
           fmt::format("{} px, allowed for the trainer builtin are {} or more, the size of its "
                       "crops (train.{})",
                       size, crop, field));
    };
    check("width_px", rigs.has_width_px(), rigs.width_px(),
          train.width_px() > 0 ? train.width_px() : kCropWidth);
    check("height_px", rigs.has_height_px(), rigs.height_px(),
          train.height_px() > 0 ? train.height_px() : kCropHeight);
  }

  void CheckMaps(const v1::SceneConfig& config, const std::string& path) {
    if (!config.has_render()) return;  // All defaults.
    std::vector<std::string> missing;
    for (const char* map : kMapsOfTruth) {
      if (!HasMap(config.render(), map)) missing.push_back(map);
    }
    if (missing.empty()) return;
    Tell(path,
         fmt::format("without {}, which networks are trained and scored on", JoinNames(missing)));
  }

  int64_t PairsOf(const std::string& name) const {
    for (const v1::VariantSpec& variant : study_.variants()) {
      if (variant.name() == name) return variant.pairs() > 0 ? variant.pairs() : study_.pairs();
    }
    return 0;
  }

  const v1::StudySpec& given_;
  const v1::StudySpec study_;          // With defaults.
  std::vector<std::string> variants_;  // Names of variants that may be trained on.
  Findings* findings_;
};

}  // namespace

void CheckTraining(const v1::StudySpec& study, Findings* findings) {
  TrainChecker(study, findings).Run();
}

}  // namespace parallax::config_internal
