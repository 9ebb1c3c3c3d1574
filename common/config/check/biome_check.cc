#include "common/config/check/biome_check.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "common/base/edit_distance.h"
#include "common/base/names.h"
#include "common/config/catalogue_names.h"
#include "common/config/check/field_rules.h"
#include "common/config/config.h"
#include "common/config/files/land_files.h"

namespace parallax::config_internal {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

constexpr int kMostLayers = 64, kMostGround = 12;

bool Among(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

Support SupportIn(const v1::Quantity& quantity) { return SupportOf(quantity.drawn()); }

// Goes through a land in the order in which it is drawn, so that a name counts from where it is
// given.
class BiomeChecker {
 public:
  BiomeChecker(const v1::Biome& biome, std::string path, Findings& findings)
      : biome_(biome),
        path_(std::move(path)),
        findings_(findings),
        numbers_(std::begin(kSiteNames), std::end(kSiteNames)) {}

  void Run() {
    if (!IsName(biome_.name())) Tell(At("name"), WhyNotName(biome_.name()));
    if (biome_.landform().empty()) Tell(path_, "no landform, allowed is one, such as plain");
    CheckWater();
    for (int i = 0; i < biome_.values_size(); ++i) {
      CheckValue(biome_.values(i), At(fmt::format("values[{}]", i)));
    }
    CheckRoof();
    CheckGround();
    if (biome_.has_walk()) CheckParts(biome_.walk(), At("walk"));
    CheckTrees();
    if (biome_.layers_size() > kMostLayers) {
      Tell(At("layers"),
           fmt::format("a list of {}, allowed are at most {}", biome_.layers_size(), kMostLayers));
    }
    for (int i = 0; i < biome_.layers_size(); ++i) {
      CheckLayer(biome_.layers(i), At(fmt::format("layers[{}]", i)));
    }
  }

 private:
  std::string At(const std::string& field) const { return Dotted(path_, field); }
  void Tell(const std::string& path, std::string what) {
    if (!what.empty()) findings_.push_back({path, std::move(what)});
  }

  void CheckWater() {
    const auto check = [&](const char* field, int size) {
      if (size == 0 || size == 3) return;
      Tell(At(std::string("water.") + field),
           fmt::format("a list of {}, allowed is [red, green, blue]", size));
    };
    check("clear_color", biome_.water().clear_color_size());
    check("murky_color", biome_.water().murky_color_size());
  }

  void CheckRoof() {
    if (!biome_.has_roof()) return;
    if (biome_.landform() != "cave" && biome_.landform() != "canyon") {
      Tell(At("roof"), "given, but the landform is " + biome_.landform() +
                           ", allowed with those that are a gorge: cave, canyon");
    }
    NeedAll(biome_.roof(), At("roof"));
    CheckParts(biome_.roof(), At("roof"));
  }

  void CheckGround() {
    if (biome_.ground().empty() || biome_.ground_size() > kMostGround) {
      Tell(
          biome_.ground().empty() ? path_ : At("ground"),
          fmt::format("{} rules of the ground, allowed are 1 to {}, of which the last is bare rock",
                      biome_.ground_size(), kMostGround));
    }
    for (int i = 0; i < biome_.ground_size(); ++i) {
      const v1::BiomeGround& rule = biome_.ground(i);
      const std::string place = At(fmt::format("ground[{}]", i));
      if (rule.material().empty()) Tell(place, "no material, allowed is one, such as Soil");
      if (i == 0 && (rule.has_where() || rule.has_when())) {
        Tell(place,
             "the first rule of the ground, allowed is one that covers everything, without "
             "where and when");
      }
      if (!rule.when().chosen().empty()) {
        Tell(place + ".when.chosen", "asked of the ground, allowed there are season and land");
      }
      CheckParts(rule, place);
    }
  }

  void CheckTrees() {
    for (int i = 0; i < biome_.trees_size(); ++i) {
      const v1::TreeKind& kind = biome_.trees(i);
      const std::string place = At(fmt::format("trees[{}]", i));
      NeedAll(kind, place, {"snow_m"});
      if (kind.has_class_()) {
        Tell(place + ".class", WhyNotKnown(kind.class_(), TreeNames(), JoinNames(TreeNames())));
      }
      if (Among(trees_, kind.name())) {
        Tell(place + ".name", Quoted(kind.name()) + " is there already, allowed is another name");
      }
      trees_.push_back(kind.name());
      CheckParts(kind, place);
    }
  }

  void CheckLayer(const v1::BiomeLayer& layer, const std::string& path) {
    for (int i = 0; i < layer.values_size(); ++i) {
      CheckValue(layer.values(i), fmt::format("{}.values[{}]", path, i));
    }
    const int kinds = layer.has_class_() + layer.has_trees() + layer.has_saplings();
    if (kinds != 1) {
      Tell(path, fmt::format("{} of class, trees and saplings, allowed is one of them", kinds));
    } else if (layer.has_class_()) {
      CheckNeeded(layer, path);
      CheckWord(layer.class_(), path + ".class", Classes(),
                "a class that `parallax catalogue` "
                "lists, a tree with its species, such as Conifer/pine, or a choice");
    } else {
      CheckTreeLayer(layer, path);
    }
    if (layer.has_winter_class()) {
      CheckWord(layer.winter_class(), path + ".winter_class", Classes(),
                "a class that `parallax catalogue` lists");
    }
    if (layer.hangs() && !biome_.has_roof()) {
      Tell(path + ".hangs", "given, but there is no roof, allowed with one");
    }
    CheckParts(layer, path);
  }

  void CheckNeeded(const v1::BiomeLayer& layer, const std::string& path) {
    if (layer.name().empty()) Tell(path, "no name, allowed is one, such as bushes");
    if (!layer.has_per_m2())
      Tell(path, "no per_m2, allowed is the number of things a square metre");
  }

  void CheckTreeLayer(const v1::BiomeLayer& layer, const std::string& path) {
    CheckWord(layer.has_trees() ? layer.trees() : layer.saplings(),
              path + (layer.has_trees() ? ".trees" : ".saplings"), trees_,
              trees_.empty() ? "none, as the file has no trees" : JoinNames(trees_));
    static const std::set<std::string> kOfTrees = {"name",  "trees", "saplings", "times",
                                                   "where", "when",  "chance",   "values"};
    std::vector<const FieldDescriptor*> fields;
    layer.GetReflection()->ListFields(layer, &fields);
    for (const FieldDescriptor* field : fields) {
      if (kOfTrees.contains(field->name())) continue;
      Tell(Dotted(path, field->name()),
           "given, but the kind of tree says it, allowed beside trees and saplings are name, "
           "times, where, when, chance and values");
    }
  }

  static std::vector<std::string> Classes() {
    std::vector<std::string> names = AssetClassNames();
    names.insert(names.end(), TreeNames().begin(), TreeNames().end());
    return names;
  }

  // Checks a name that is among `known`, or a choice all of whose words are.
  void CheckWord(const std::string& word, const std::string& path,
                 const std::vector<std::string>& known, const std::string& allowed) {
    const auto choice = choices_.find(word);
    if (choice == choices_.end()) {
      std::vector<std::string> all = known;
      for (const auto& [name, words] : choices_) all.push_back(name);
      return Tell(path, WhyNotKnown(word, all, allowed));
    }
    for (const std::string& one : choice->second) Tell(path, WhyNotKnown(one, known, allowed));
  }

  void CheckValue(const v1::BiomeValue& value, const std::string& path) {
    const bool number = value.has_let();
    if (number == !value.choose().empty()) {
      return Tell(path, "allowed is one of {let, is}, {let, height_at} and {choose, of}");
    }
    if (value.has_when()) CheckWhen(value.when(), path + ".when");
    if (!number) return CheckChoice(value, path);
    if (value.has_is() == value.has_height_at() || !value.of().empty()) {
      return Tell(path, "allowed beside let is one of is and height_at");
    }
    CheckParts(value, path);
    if (Among({std::begin(kSiteNames), std::end(kSiteNames)}, value.let())) {
      Tell(path + ".let", Quoted(value.let()) + " is a name of every land, allowed is another");
    }
    numbers_.push_back(value.let());
  }

  void CheckChoice(const v1::BiomeValue& value, const std::string& path) {
    if (value.of().empty()) return Tell(path, "nothing to choose from, allowed is of: [a, b, ...]");
    const auto& weights = value.weights();
    if (!weights.empty() && (weights.size() != value.of_size() ||
                             !(std::accumulate(weights.begin(), weights.end(), 0.0) > 0))) {
      Tell(path + ".weights", fmt::format("{} weights, allowed are as many as in `of`, {}, one "
                                          "above 0 at least",
                                          weights.size(), value.of_size()));
    }
    for (int i = 0; i < value.of_size(); ++i) {
      const std::vector<std::string> words = WordsOf(value.of(i));
      if (static_cast<int>(words.size()) != value.choose_size()) {
        Tell(fmt::format("{}.of[{}]", path, i),
             fmt::format("{} words, allowed are {}, with + between", words.size(),
                         value.choose_size()));
        continue;
      }
      for (size_t k = 0; k < words.size(); ++k) {
        choices_[value.choose(static_cast<int>(k))].push_back(words[k]);
        words_.push_back(words[k]);
      }
    }
  }

  void CheckWhen(const v1::BiomeWhen& when, const std::string& path) {
    for (int i = 0; i < when.chosen_size(); ++i) {
      Tell(fmt::format("{}.chosen[{}]", path, i),
           WhyNotKnown(when.chosen(i), words_,
                       words_.empty() ? "none, as nothing was chosen before" : JoinNames(words_)));
    }
  }

  // Checks the conditions, formulas and ranges of a message and of its groups.
  void CheckParts(const Message& message, const std::string& path) {
    std::vector<const FieldDescriptor*> fields;
    message.GetReflection()->ListFields(message, &fields);
    for (const FieldDescriptor* field : fields) {
      if (field->is_repeated() || field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
      const Message& part = message.GetReflection()->GetMessage(message, field);
      const std::string place = Dotted(path, field->name());
      if (const auto* quantity = dynamic_cast<const v1::Quantity*>(&part)) {
        if (quantity->has_formula()) CheckFormula(quantity->formula(), place);
        continue;
      }
      if (const auto* when = dynamic_cast<const v1::BiomeWhen*>(&part)) CheckWhen(*when, place);
      if (const auto* span = dynamic_cast<const v1::SoftSpan*>(&part)) {
        CheckOrder(span->low(), span->high(), place);
      }
      if (const auto* size = dynamic_cast<const v1::SizeSpan*>(&part)) {
        CheckOrder(size->low(), size->high(), place);
      }
      if (dynamic_cast<const v1::GroundRows*>(&part)) NeedAll(part, place, {"direction_deg"});
      CheckParts(part, place);
    }
  }

  void CheckOrder(const v1::Quantity& low, const v1::Quantity& high, const std::string& path) {
    if (low.has_formula() || high.has_formula()) return;
    if (SupportIn(low).low <= SupportIn(high).high) return;
    Tell(path, fmt::format("low {} is above high {}, allowed is the lower one first",
                           NumberText(SupportIn(low).low), NumberText(SupportIn(high).high)));
  }

  void CheckFormula(const std::string& formula, const std::string& path) {
    const auto value = ValueOfFormula(formula, [&](std::string_view name) {
      const bool known = Among(numbers_, std::string(name));
      return known ? std::optional<double>(1) : std::nullopt;
    });
    if (value.ok()) return;
    const std::string why(ToStd(value.status().message()));
    Tell(path,
         absl::IsNotFound(value.status()) ? WhyNotKnown(why, numbers_, JoinNames(numbers_)) : why);
  }

  // Tells of the fields of a message that are not set, but for those in `free`.
  void NeedAll(const Message& message, const std::string& path,
               const std::vector<std::string>& free = {}) {
    for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
      const FieldDescriptor& field = *message.GetDescriptor()->field(i);
      if (Among(free, field.name()) || message.GetReflection()->HasField(message, &field)) continue;
      Tell(path, "no " + field.name() + ", allowed is with all of " +
                     JoinNames(FieldNames(*message.GetDescriptor())));
    }
  }

  const v1::Biome& biome_;
  const std::string path_;
  Findings& findings_;
  std::vector<std::string> numbers_;                         // That formulas know.
  std::map<std::string, std::vector<std::string>> choices_;  // Name, and what it can be.
  std::vector<std::string> words_;                           // All that choices can give.
  std::vector<std::string> trees_;
};

}  // namespace

void CheckBiome(const v1::Biome& biome, const std::string& path, Findings* findings) {
  BiomeChecker(biome, path, *findings).Run();
}

}  // namespace parallax::config_internal
