#include "worker/dataset/archive/study_change.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <sstream>

#include "common/config/config.h"
#include "common/config/stages.h"
#include "common/config/training_plan.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScoreFolders[] = {"scores", "curves", "sheets"};

// A text that is equal for variants with equal pairs. Filters, sensors and places are left out:
// frames are judged and exposed anew.
std::string VariantText(const v1::StudySpec& study, const v1::VariantSpec& variant) {
  v1::StudySpec alone;
  v1::VariantSpec& kept = *alone.add_variants() = variant;
  kept.clear_pairs();
  kept.set_seed(SeedOf(study, variant));
  if (kept.rigs_per_scene() == 0) kept.set_rigs_per_scene(study.rigs_per_scene());
  *kept.mutable_config() = FieldsOf(variant.config(), [](v1::FieldRule::Stage stage) {
    return stage != v1::FieldRule::FINISH && stage != v1::FieldRule::SENSOR &&
           stage != v1::FieldRule::PLACE;
  });
  return StudyToYaml(alone);
}

int64_t PairsIn(const v1::StudySpec& study, const v1::VariantSpec& variant) {
  return variant.pairs() > 0 ? variant.pairs() : study.pairs();
}

using Texts = std::map<std::string, std::string>;

Texts VariantTexts(const v1::StudySpec& study) {
  Texts texts;
  for (const v1::VariantSpec& variant : study.variants()) {
    texts[variant.name()] = VariantText(study, variant);
  }
  return texts;
}

// By training set: its settings and data.
Texts SetTexts(const v1::StudySpec& study) {
  Texts texts;
  v1::TrainSpec settings = study.train();
  settings.clear_seeds();
  settings.clear_variants();
  settings.clear_mixtures();
  settings.clear_only_mixtures();
  settings.clear_needs();
  for (const v1::Mixture& set : TrainingSetsOf(study)) {
    std::string& text = texts[set.name()];
    text = MessageToYaml(settings) + MessageToYaml(set);
    for (const v1::Mixture::Part& part : set.parts()) {
      for (const v1::VariantSpec& variant : study.variants()) {
        if (variant.name() != part.variant()) continue;
        // With filters and sensor: they choose and make what is trained on.
        text += fmt::format("pairs: {}\n", PairsIn(study, variant)) + VariantText(study, variant) +
                MessageToYaml(variant.config().filters()) +
                MessageToYaml(variant.config().sensor());
      }
    }
  }
  for (const std::string& baseline : study.evaluate().baselines()) texts[baseline] = "baseline";
  return texts;
}

// By benchmark: how it is scored.
Texts BenchmarkTexts(const v1::StudySpec& study) {
  Texts texts;
  const v1::EvaluateSpec& evaluate = study.evaluate();
  const std::string settings = fmt::format("{} {}\n", evaluate.max_pairs(), evaluate.checkpoints());
  for (const std::string& name : evaluate.benchmarks()) texts[name] = settings;
  for (const v1::OwnBenchmark& own : evaluate.own_benchmarks()) {
    texts[own.name()] = settings + own.sha256();
  }
  for (const v1::VariantSpec& variant : study.variants()) {
    if (!variant.heldout()) continue;
    std::string& text = texts[kHeldoutName];
    text = settings + fmt::format("{}\n", PairsIn(study, variant)) + VariantText(study, variant) +
           MessageToYaml(variant.config().filters()) + MessageToYaml(variant.config().sensor());
    for (const std::string& group : evaluate.group_by()) text += group + "\n";
  }
  return texts;
}

bool Serves(const Texts& before, const Texts& now, const std::string& name) {
  const auto old = before.find(name), current = now.find(name);
  return old != before.end() && current != now.end() && old->second == current->second;
}

// Returns ": baseline_m: 0.1 is baseline_m: 0.2 now" of the first line that differs.
std::string FirstDifference(const std::string& before, const std::string& now) {
  std::istringstream there(before), here(now);
  const auto next = [](std::istream& in) {
    std::string line;
    if (!std::getline(in, line)) return std::string("nothing");
    return line.substr(std::min(line.find_first_not_of(' '), line.size()));
  };
  while (there || here) {
    const std::string old_line = next(there), new_line = next(here);
    if (old_line != new_line) return fmt::format(" (was \"{}\", is \"{}\")", old_line, new_line);
  }
  return "";
}

// The names that a file of scores begins with: its benchmark and its set.
std::optional<std::pair<std::string, std::string>> NamesOfScores(const std::string& file) {
  const size_t first = file.find('.'), second = file.find('.', first + 1);
  if (first == std::string::npos || second == std::string::npos) return std::nullopt;
  return std::make_pair(file.substr(0, first), file.substr(first + 1, second - first - 1));
}

// Scores are found when they are put aside: a pattern "scores/*.narrow.*" stands for them.
std::string ScoresOf(const std::string& benchmark, const std::string& set) {
  return benchmark + "." + set + ".";
}

// Adds the files that a path of a part stands for.
std::vector<std::string> FilesOf(const std::string& out_dir, const std::string& path) {
  std::error_code error;
  if (!path.ends_with('.')) {
    return fs::exists(out_dir + "/" + path, error) ? std::vector{path} : std::vector<std::string>{};
  }
  std::vector<std::string> files;
  const auto wanted = NamesOfScores(path);
  for (const char* folder : kScoreFolders) {
    for (const auto& entry : fs::directory_iterator(out_dir + "/" + folder, error)) {
      const std::string name = entry.path().filename();
      const auto names = NamesOfScores(name);
      if (!names || !wanted) continue;
      if ((wanted->first == "*" || wanted->first == names->first) &&
          (wanted->second == "*" || wanted->second == names->second)) {
        files.push_back(std::string(folder) + "/" + name);
      }
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

absl::StatusOr<std::string> NewFolder(const std::string& dir) {
  std::error_code error;
  fs::create_directories(dir, error);
  for (int number = 1; !error; ++number) {
    const std::string path = fmt::format("{}/{:03}", dir, number);
    if (fs::create_directory(path, error)) return path;
  }
  return ErrnoError(error.value(), "make a folder in " + dir);
}

}  // namespace

std::vector<DroppedPart> PartsDropped(const v1::StudySpec& before, const v1::StudySpec& now) {
  std::vector<DroppedPart> parts;
  const Texts old_variants = VariantTexts(before), variants = VariantTexts(now);
  for (const auto& [name, text] : old_variants) {
    if (Serves(old_variants, variants, name)) continue;
    const auto current = variants.find(name);
    parts.push_back({"variant " + name +
                         (current == variants.end()
                              ? ": no longer in the study"
                              : ": other settings" + FirstDifference(text, current->second)),
                     {name}});
  }
  const Texts old_sets = SetTexts(before), sets = SetTexts(now);
  for (const auto& [name, text] : old_sets) {
    if (Serves(old_sets, sets, name)) continue;
    const auto current = sets.find(name);
    parts.push_back({"training and scores of " + name +
                         (current == sets.end() ? ": no longer in the study"
                                                : ": other data or settings" +
                                                      FirstDifference(text, current->second)),
                     {"training/" + name, ScoresOf("*", name)}});
  }
  const Texts old_benchmarks = BenchmarkTexts(before), benchmarks = BenchmarkTexts(now);
  for (const auto& [name, text] : old_benchmarks) {
    if (Serves(old_benchmarks, benchmarks, name)) continue;
    parts.push_back({"scores on " + name +
                         (benchmarks.count(name) == 0 ? ": no longer in the study"
                                                      : ": other pairs or settings"),
                     {ScoresOf(name, "*")}});
  }
  return parts;
}

absl::StatusOr<std::vector<std::string>> PutAside(const std::string& out_dir,
                                                  const std::vector<DroppedPart>& parts) {
  std::vector<std::string> told;
  std::string aside;
  for (const DroppedPart& part : parts) {
    std::vector<std::string> files;
    for (const std::string& path : part.paths) {
      for (const std::string& file : FilesOf(out_dir, path)) files.push_back(file);
    }
    if (files.empty()) continue;
    std::error_code error;
    if (aside.empty()) {
      ASSIGN_OR_RETURN(aside, NewFolder(out_dir + "/.parallax/aside"));
      for (const char* name : {"study.yaml", "study.lock.yaml"}) {
        fs::copy_file(out_dir + "/" + name, aside + "/" + name, error);
      }
    }
    for (const std::string& file : files) {
      const fs::path to = fs::path(aside) / file;
      fs::create_directories(to.parent_path(), error);
      fs::rename(out_dir + "/" + file, to, error);
      if (error) return ErrnoError(error.value(), "move " + out_dir + "/" + file + " aside");
    }
    told.push_back(part.what + ": what was made is kept in " + aside);
  }
  return told;
}

}  // namespace parallax
