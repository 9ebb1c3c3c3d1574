// Checks `search` of a study: its space, by making scene configs of all ends and choices, its
// benchmarks, and its rungs.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "common/base/names.h"
#include "common/config/check/checks.h"
#include "common/config/check/field_rules.h"
#include "common/config/check/limits.h"
#include "common/config/search/search_space.h"
#include "common/config/search/search_values.h"
#include "common/config/training_plan.h"
#include "common/config/yaml/yaml_document.h"

namespace parallax::config_internal {
namespace {

using google::protobuf::FieldDescriptor;
using SearchValues = google::protobuf::RepeatedPtrField<v1::SearchValue>;

constexpr size_t kMostSearchNameBytes = 50;
constexpr int kMostFields = 100;
constexpr int kMostRungs = 10;
// The fields of a search have together at most this number of choices, because each choice is
// tried.
constexpr int kMostChoices = 10'000;

// Fields or groups that count only where another field has one of some values.
struct CountsWhere {
  const char* field;
  const char* needs;
  const char* values;  // Apart by spaces.
};
constexpr CountsWhere kCountsWhere[] = {
    {"room", "type", "indoor"},
    {"furniture", "type", "indoor"},
    {"solver", "type", "indoor"},
    {"floating", "type", "indoor dense"},
    {"nature", "type", "nature"},  // Landscapes around houses read none of it.
    {"materials.replace_probability", "materials.mode", "all"},
    {"materials.replace_per", "materials.mode", "all"},
    {"materials.replacements", "materials.mode", "all"},
    {"materials.metal_and_glass", "materials.mode", "all"},
    {"materials.diffuse_material", "materials.mode", "one_diffuse"},
    {"lighting.point_lights", "lighting.mode", "augmented"},
    {"lighting.ceiling_removed_p", "lighting.mode", "augmented"},
    {"lighting.ceiling_dimmed_p", "lighting.mode", "augmented"},
    {"lighting.lamps_colored_p", "lighting.mode", "augmented"},
    {"lighting.lamps_dimmed_p", "lighting.mode", "augmented"}};
// Fields that say which files are written.
constexpr const char* kOnlyFiles[] = {"render.maps", "render.keep_hdr"};

bool IsAtOrBelow(const std::string& path, const std::string& group) {
  return path == group || path.starts_with(group + ".");
}

std::string TextOfEnum(const v1::SceneConfig& config, const std::string& path) {
  const google::protobuf::Message* message = &config;
  std::istringstream names(path);
  for (std::string name; std::getline(names, name, '.');) {
    const FieldDescriptor& field = *message->GetDescriptor()->FindFieldByName(name);
    if (field.enum_type() != nullptr) {
      return EnumText(*message->GetReflection()->GetEnum(*message, &field));
    }
    message = &message->GetReflection()->GetMessage(*message, &field);
  }
  return "";
}

class SearchChecker {
 public:
  SearchChecker(const v1::StudySpec& study, Findings* findings)
      : study_(study), search_(study.search()), findings_(*findings) {}

  void Run() {
    CheckStudyAround();
    const size_t before = findings_.size();
    CheckFields(search_, "search", &findings_);
    if (findings_.size() > before) return;  // Each value by itself first.
    if (!IsName(search_.sampler()) && search_.has_sampler()) {
      Tell("search.sampler", WhyNotName(search_.sampler()));
    }
    CheckBenchmarks();
    CheckRungs();
    CheckSize();
    CheckSpace();
  }

 private:
  void Tell(const std::string& path, std::string what) {
    if (!what.empty()) findings_.push_back({path, std::move(what)});
  }

  // ---- The study that has a search
  void CheckStudyAround() {
    if (study_.name().size() > kMostSearchNameBytes) {
      Tell("study", fmt::format("{} letters, allowed in a study with a search are at most {}: its "
                                "rungs have the name and a number",
                                study_.name().size(), kMostSearchNameBytes));
    }
    if (study_.has_stream()) {
      Tell("search", "beside `pairs: endless`, allowed is one of them");
    }
    std::vector<std::string> own;
    for (const v1::VariantSpec& variant : study_.variants()) {
      if (!variant.heldout()) own.push_back(variant.name());
    }
    if (!own.empty() && own != std::vector<std::string>{kDefaultVariant}) {
      Tell("variants", "beside a search, allowed is none: base and set are its only variant");
    }
    if (!study_.has_train()) {
      Tell("train", "missing, allowed in a search are its trainings: {steps: 2000, seeds: 2}");
    }
    if (!study_.has_evaluate()) {
      Tell("evaluate", "missing, allowed in a search are its benchmarks: {benchmarks: [shipped]}");
    }
    const v1::TrainSpec& train = study_.train();
    for (const char* field : {"variants", "mixtures"}) {
      const FieldDescriptor& named = *train.GetDescriptor()->FindFieldByName(field);
      if (train.GetReflection()->FieldSize(train, &named) == 0) continue;
      Tell(std::string("train.") + field,
           "given, allowed in a search is none: each trial is a training set");
    }
    if (study_.has_train() && train.steps() == 0 && train.minutes() == 0) {
      Tell("train",
           "neither steps nor minutes, allowed in a search is one of them: its rungs "
           "train for a share of it");
    }
    if (search_.points_per_core_s() > 0 && study_.evaluate().decides() == "log") {
      Tell("search.points_per_core_s",
           fmt::format("{} beside evaluate.decides: log, whose differences are no points, allowed "
                       "is 0",
                       search_.points_per_core_s()));
    }
  }

  // ---- Benchmarks
  std::vector<std::string> KnownBenchmarks() const {
    const v1::EvaluateSpec& evaluate = study_.evaluate();
    std::vector<std::string> known(evaluate.benchmarks().begin(), evaluate.benchmarks().end());
    for (const v1::OwnBenchmark& own : evaluate.own_benchmarks()) known.push_back(own.name());
    if (WantsHeldout(study_)) known.push_back(kHeldoutName);
    return known;
  }

  template <typename List>
  void CheckNames(const std::string& path, const List& names) {
    const std::vector<std::string> known = KnownBenchmarks();
    for (int i = 0; i < names.size(); ++i) {
      const std::string place = fmt::format("{}[{}]", path, i);
      std::string why = WhyNotKnown(names[i], known, JoinNames(known));
      if (why.empty() && std::count(names.begin(), names.begin() + i, names[i]) > 0) {
        why = Quoted(names[i]) + " is there already, allowed is each benchmark once";
      }
      Tell(place, std::move(why));
    }
  }

  void CheckBenchmarks() {
    if (!study_.has_evaluate()) return;
    const auto& searched = search_.benchmarks();
    const auto& confirmed = search_.confirm().benchmarks();
    CheckNames("search.benchmarks", searched);
    CheckNames("search.confirm.benchmarks", confirmed);
    for (int i = 0; i < confirmed.size(); ++i) {
      if (std::count(searched.begin(), searched.end(), confirmed[i]) == 0) continue;
      Tell(fmt::format("search.confirm.benchmarks[{}]", i),
           Quoted(confirmed[i]) +
               " is searched on, too, allowed are benchmarks that the search "
               "does not see, or none: then it has fresh seeds only");
    }
    std::vector<std::string> known = KnownBenchmarks();
    if (WantsHeldout(study_)) known.pop_back();  // Searched on only where it is named.
    if (searched.empty() && !confirmed.empty() &&
        std::all_of(known.begin(), known.end(), [&](const std::string& name) {
          return std::count(confirmed.begin(), confirmed.end(), name) > 0;
        })) {
      Tell("search.confirm.benchmarks",
           "all benchmarks, so that none is left for the search, allowed are some of them");
    }
  }

  // ---- Rungs
  int SeedsOf(const v1::SearchRung& rung) const {
    return rung.seeds() > 0 ? rung.seeds() : std::max(1, study_.train().seeds());
  }
  static double PairsOf(const v1::SearchRung& rung) { return rung.has_pairs() ? rung.pairs() : 1; }
  static double StepsOf(const v1::SearchRung& rung) { return rung.has_steps() ? rung.steps() : 1; }

  void CheckRungs() {
    const auto& rungs = search_.rungs();
    if (rungs.size() > kMostRungs) {
      return Tell("search.rungs",
                  fmt::format("a list of {}, allowed are at most {}", rungs.size(), kMostRungs));
    }
    for (int i = 0; i + 1 < rungs.size(); ++i) {
      const std::string next = fmt::format("search.rungs[{}]", i + 1);
      const size_t before = findings_.size();
      const auto grows = [&](const char* field, double value, double after) {
        if (after >= value) return;
        Tell(next + "." + field,
             fmt::format("{} is less than the {} of the rung before, allowed is as much or more",
                         NumberText(after), NumberText(value)));
      };
      grows("pairs", PairsOf(rungs[i]), PairsOf(rungs[i + 1]));
      grows("steps", StepsOf(rungs[i]), StepsOf(rungs[i + 1]));
      grows("seeds", SeedsOf(rungs[i]), SeedsOf(rungs[i + 1]));
      if (findings_.size() == before && PairsOf(rungs[i]) == PairsOf(rungs[i + 1]) &&
          StepsOf(rungs[i]) == StepsOf(rungs[i + 1]) &&
          SeedsOf(rungs[i]) == SeedsOf(rungs[i + 1])) {
        Tell(next, "as the rung before, allowed are more pairs, steps or seeds");
      }
    }
    if (rungs.empty()) return;
    const v1::SearchRung& last = rungs[rungs.size() - 1];
    const std::string place = fmt::format("search.rungs[{}]", rungs.size() - 1);
    const auto is_whole = [&](const char* field, double share) {
      if (share == 1) return;
      Tell(place + "." + field,
           fmt::format("{}, allowed in the last rung is 1: it has the study's own pairs and steps",
                       NumberText(share)));
    };
    is_whole("pairs", PairsOf(last));
    is_whole("steps", StepsOf(last));
  }

  // A rung is a study of the default and all trials.
  void CheckSize() {
    const int64_t variants = int64_t{1} + (search_.has_trials() ? search_.trials() : 16);
    const int64_t most = kMaxVariants - (WantsHeldout(study_) ? 1 : 0);
    const auto tell = [&](int64_t seen, int64_t allowed, const char* what) {
      if (seen <= allowed) return;
      Tell("search.trials", fmt::format("with the default {} {} in a rung, allowed are at most {}",
                                        seen, what, allowed));
    };
    tell(variants, most, "variants");
    int seeds = SeedsOf({});
    for (const v1::SearchRung& rung : search_.rungs()) seeds = std::max(seeds, SeedsOf(rung));
    tell(variants * seeds, kMaxTrainings, "trainings");
    tell(variants * seeds * static_cast<int64_t>(KnownBenchmarks().size()), kMaxEvaluations,
         "evaluations");
    if (study_.variants().empty()) return;
    tell(variants * static_cast<int64_t>(study_.variants(0).ByteSizeLong()),
         static_cast<int64_t>(kMaxStudyBytes), "bytes");
  }

  // ---- The space
  void CheckSpace() {
    if (search_.space().empty() || search_.space_size() > kMostFields) {
      return Tell("search.space",
                  search_.space().empty()
                      ? "empty, allowed are fields and what they may be: floating.count: {range: "
                        "[0, 40]}"
                      : fmt::format("{} fields, allowed are at most {}", search_.space_size(),
                                    kMostFields));
    }
    int64_t choices = 0;
    for (const v1::SearchField& field : search_.space()) choices += field.choices_size();
    if (choices > kMostChoices) {
      return Tell("search.space",
                  fmt::format("{} choices in all, allowed are at most {}", choices, kMostChoices));
    }
    const size_t before = findings_.size();
    for (int i = 0; i < search_.space_size(); ++i) CheckField(i);
    if (findings_.size() > before || study_.variants().empty()) return;
    base_ = study_.variants(0).config();
    if (!WithSearchValues(base_, {}).ok()) return;  // Told of the variant.
    for (int i = 0; i < search_.space_size(); ++i) CheckEffect(i);
    if (findings_.size() > before) return;
    for (int i = 0; i < search_.space_size(); ++i) TryValues(i);
  }

  static std::string PlaceOf(int field) { return fmt::format("search.space[{}]", field); }

  // What a field may be, apart from what scenes make of it.
  void CheckField(int index) {
    const v1::SearchField& field = search_.space(index);
    const std::string place = PlaceOf(index);
    std::string why;
    const FieldDescriptor* const named = FindSearchField(field.path(), &why);
    if (named == nullptr) return Tell(place + ".path", std::move(why));
    for (int i = 0; i < index; ++i) {
      const std::string& other = search_.space(i).path();
      if (!IsAtOrBelow(field.path(), other) && !IsAtOrBelow(other, field.path())) continue;
      Tell(place + ".path", other == field.path()
                                ? "given twice, allowed once"
                                : "overlaps " + other + ", allowed is one of them");
    }
    const bool is_range = field.has_low() || field.has_high();
    if (is_range == !field.choices().empty()) {
      return Tell(place, is_range ? "both range and choice, allowed is one of them"
                                  : "neither range nor choice, allowed is one of them");
    }
    if (is_range) {
      CheckRange(field, *named, place);
    } else {
      CheckChoices(field, place);
    }
    CheckConditions(index);
  }

  void CheckRange(const v1::SearchField& field, const FieldDescriptor& named,
                  const std::string& place) {
    if (!IsNumber(named)) {
      return Tell(place + ".low",
                  "a range of a field that holds no number, allowed is {choice: "
                  "[...]}");
    }
    if (field.integer() != IsWhole(named)) {
      return Tell(place + ".integer", field.integer() ? "true, but the field may be any number"
                                                      : "false, but the field is a whole number");
    }
    const double low = field.low(), high = field.high();
    if (!field.has_low() || !field.has_high() || low >= high) {
      return Tell(place + ".low", fmt::format("[{}, {}], allowed is [low, high] with low < high",
                                              NumberText(low), NumberText(high)));
    }
    for (const double end : {low, high}) {
      if (!field.integer() || end == std::floor(end)) continue;
      Tell(place + (end == low ? ".low" : ".high"),
           NumberText(end) + " is not a whole number, as the field's values are");
    }
    if (field.log() && low <= 0) {
      Tell(place + ".log",
           fmt::format("true, but the range begins at {}, allowed above 0", NumberText(low)));
    }
  }

  void CheckChoices(const v1::SearchField& field, const std::string& place) {
    if (field.log()) Tell(place + ".log", "true, but there is no range, allowed with one");
    if (field.choices_size() < 2 || field.choices_size() > kMaxListItems) {
      return Tell(place + ".choices",
                  fmt::format("a list of {}, allowed are 2 to {} values to choose from",
                              field.choices_size(), kMaxListItems));
    }
    for (int i = 0; i < field.choices_size(); ++i) {
      const std::string item = fmt::format("{}.choices[{}]", place, i);
      const std::string& text = field.choices(i);
      ConfigErrors errors;
      const auto node = ParseYaml(text, "", errors);
      if (!errors.empty() || !node || FlowText(*node) != text) {
        Tell(item, Quoted(text) + " is not YAML as a list on one line has it");
      } else if (HasAlias(text)) {
        Tell(item, Quoted(text) + " repeats a part of itself (*), allowed is to write all of it");
      } else if (std::count(field.choices().begin(), field.choices().begin() + i, text) > 0) {
        Tell(item, text + " is there already, allowed is each value once");
      }
    }
  }

  void CheckConditions(int index) {
    const v1::SearchField& field = search_.space(index);
    for (int i = 0; i < field.when_size(); ++i) {
      const v1::SearchCondition& condition = field.when(i);
      const std::string place = fmt::format("{}.when[{}]", PlaceOf(index), i);
      const v1::SearchField* const of = FieldBefore(index, condition.path());
      if (of == nullptr || of->choices().empty()) {
        Tell(place + ".path", of == nullptr
                                  ? "no field of the space before this one, allowed is one of those"
                                  : "a field with a range, allowed is one with choices");
        continue;
      }
      const std::vector<std::string> choices(of->choices().begin(), of->choices().end());
      if (condition.values().empty()) {
        Tell(place + ".values", "an empty list, allowed are some of " + JoinNames(choices));
      }
      for (int j = 0; j < condition.values_size(); ++j) {
        Tell(fmt::format("{}.values[{}]", place, j),
             WhyNotKnown(condition.values(j), choices, JoinNames(choices)));
      }
    }
  }

  const v1::SearchField* FieldBefore(int index, const std::string& path) const {
    for (int i = 0; i < index; ++i) {
      if (search_.space(i).path() == path) return &search_.space(i);
    }
    return nullptr;
  }

  // Adds values under which the field is varied: the first of each of its conditions.
  void AddContext(int index, SearchValues& values) const {
    for (const v1::SearchCondition& condition : search_.space(index).when()) {
      const auto is_there = [&](const v1::SearchValue& value) {
        return value.path() == condition.path();
      };
      if (std::any_of(values.begin(), values.end(), is_there)) continue;
      v1::SearchValue& value = *values.Add();
      value.set_path(condition.path());
      value.set_yaml(condition.values(0));
      for (int i = 0; i < index; ++i) {
        if (search_.space(i).path() == condition.path()) AddContext(i, values);
      }
    }
  }
  SearchValues ContextOf(int index) const {
    SearchValues values;
    AddContext(index, values);
    return values;
  }

  // Finds fields on which no pair of a trial depends.
  void CheckEffect(int index) {
    const std::string& path = search_.space(index).path();
    const std::string place = PlaceOf(index) + ".path";
    std::string ignored;
    const FieldDescriptor& named = *FindSearchField(path, &ignored);
    const bool names_files =
        (RuleOf(named).stage() == v1::FieldRule::PLACE && RuleOf(named).allowed().empty()) ||
        path.ends_with("_sha256");
    if (names_files) {
      return Tell(place,
                  "says where files are, and trials are made elsewhere, allowed are other "
                  "fields");
    }
    for (const char* only : kOnlyFiles) {
      if (path != only) continue;
      return Tell(place,
                  "says which files are written, and no training depends on it, allowed are "
                  "other fields");
    }
    const auto config = WithSearchValues(base_, ContextOf(index));
    if (!config.ok()) return;  // TryValues tells.
    for (const CountsWhere& rule : kCountsWhere) {
      if (IsAtOrBelow(path, rule.field)) CheckCounts(index, rule, *config);
    }
  }

  bool IsVaried(const std::string& path) const {
    return std::any_of(
        search_.space().begin(), search_.space().end(),
        [&](const v1::SearchField& field) { return IsAtOrBelow(path, field.path()); });
  }

  void CheckCounts(int index, const CountsWhere& rule, const v1::SceneConfig& config) {
    std::istringstream words(rule.values);
    std::vector<std::string> values;
    for (std::string word; words >> word;) values.push_back(word);
    const std::string seen = TextOfEnum(config, rule.needs);
    if (std::count(values.begin(), values.end(), seen) > 0) return;
    // A field that is varied too, and not bound here, may have any of its values.
    const auto& when = search_.space(index).when();
    const bool is_bound = std::any_of(when.begin(), when.end(), [&](const auto& condition) {
      return condition.path() == rule.needs;
    });
    if (IsVaried(rule.needs) && !is_bound) return;
    Tell(PlaceOf(index) + ".path",
         fmt::format("no picture depends on it where {} is {}, allowed where it is {}", rule.needs,
                     seen, fmt::join(values, " or ")));
  }

  // Makes a config of each choice or both ends.
  void TryValues(int index) {
    const v1::SearchField& field = search_.space(index);
    for (int i = 0; i < field.choices_size(); ++i) {
      Try(index, field.choices(i), fmt::format(".choices[{}]", i));
    }
    if (!field.choices().empty()) return;
    Try(index, SearchNumberText(field, field.low()), ".low");
    Try(index, SearchNumberText(field, field.high()), ".high");
  }

  void Try(int index, const std::string& yaml, const std::string& member) {
    SearchValues values = ContextOf(index);
    v1::SearchValue& value = *values.Add();
    value.set_path(search_.space(index).path());
    value.set_yaml(yaml);
    const auto config = WithSearchValues(base_, values);
    if (!config.ok()) {
      return TellOfTry(index, member, yaml, std::string(ToStd(config.status().message())));
    }
    v1::StudySpec trial = study_;
    trial.clear_search();
    *trial.mutable_variants(0)->mutable_config() = *config;
    // The pairs that are held out are as the default.
    const Findings found = CheckStudy(trial);
    for (const Finding& finding : found) {
      const std::string own = "variants[0].config.";
      if (std::any_of(findings_.begin(), findings_.end(),
                      [&](const Finding& told) { return told.what == finding.what; })) {
        continue;
      }
      const std::string path =
          finding.path.starts_with(own) ? finding.path.substr(own.size()) : finding.path;
      TellOfTry(index, member, yaml, path + ": " + finding.what);
    }
  }

  // `why` has lines "path: what"; the first is told.
  void TellOfTry(int index, const std::string& member, const std::string& yaml, std::string why) {
    why = why.substr(0, why.find('\n'));
    const std::string own = search_.space(index).path() + ": ";
    Tell(PlaceOf(index) + member,
         why.starts_with(own) ? why.substr(own.size()) : "with " + yaml + ": " + why);
  }

  const v1::StudySpec& study_;
  const v1::SearchSpec& search_;
  Findings& findings_;
  v1::SceneConfig base_;
};

}  // namespace

void CheckSearch(const v1::StudySpec& study, Findings* findings) {
  if (study.has_search()) SearchChecker(study, findings).Run();
}

}  // namespace parallax::config_internal
