#include "worker/scene/floating/floating_choice.h"

#include <algorithm>

#include "common/config/config.h"
#include "worker/scene/floating/place_floating.h"

namespace parallax {
namespace {

constexpr char kAllOwn[] = "own";

bool NamesOwn(const std::string& name) { return name == kAllOwn || IsOwnClass(name); }

// The config without own classes, for FloatingClasses.
v1::SceneConfig WithoutOwn(const v1::SceneConfig& config) {
  v1::SceneConfig rest = config;
  rest.mutable_floating()->clear_classes();
  for (const std::string& name : config.floating().classes()) {
    if (!NamesOwn(name)) rest.mutable_floating()->add_classes(name);
  }
  return rest;
}

// The catalogue's classes that a weight's name stands for.
absl::StatusOr<std::vector<std::string>> MembersOf(const std::string& name) {
  v1::SceneConfig alone;
  alone.mutable_floating()->add_classes(name);
  return FloatingClasses(alone);
}

}  // namespace

absl::StatusOr<FloatingChoice> FloatingChoice::Of(const v1::SceneConfig& config,
                                                  const OwnContent& own) {
  const auto& names = config.floating().classes();
  FloatingChoice choice;
  for (const OwnMesh& mesh : own.meshes) choice.meshes_[mesh.asset_class].push_back(mesh.seed);
  const bool all_own =
      names.empty() || std::find(names.begin(), names.end(), kAllOwn) != names.end();
  for (const auto& [name, seeds] : choice.meshes_) {
    if (all_own || std::find(names.begin(), names.end(), name) != names.end()) {
      choice.own_.push_back({name, 1});
    }
  }
  for (const std::string& name : names) {
    if (NamesOwn(name) &&
        (choice.meshes_.empty() || (name != kAllOwn && !choice.meshes_.contains(name)))) {
      return InvalidArgument("floating.classes: assets.include has no mesh of \"{}\"", name);
    }
  }
  if (names.empty() || !std::all_of(names.begin(), names.end(), NamesOwn)) {
    ASSIGN_OR_RETURN(const std::vector<std::string> classes, FloatingClasses(WithoutOwn(config)));
    for (const std::string& name : classes) choice.catalogue_.push_back({name, 1});
  }
  for (const v1::ClassWeight& weight : config.assets().weights()) {
    const std::string& name = weight.class_();
    const bool of_own = NamesOwn(name);
    std::vector<std::string> members = {name};
    if (!of_own) {
      ASSIGN_OR_RETURN(members, MembersOf(name));
    }
    for (Class& entry : of_own ? choice.own_ : choice.catalogue_) {
      const bool named =
          name == kAllOwn || std::find(members.begin(), members.end(), entry.name) != members.end();
      if (named) entry.weight = weight.weight();
    }
  }
  for (std::vector<Class>* classes : {&choice.catalogue_, &choice.own_}) {
    const bool some =
        std::any_of(classes->begin(), classes->end(), [](const Class& c) { return c.weight > 0; });
    if (!some) classes->clear();
  }
  if (choice.catalogue_.empty() && choice.own_.empty()) {
    return InvalidArgument(
        "assets.weights: every class that may float weighs 0, wanted one above it");
  }
  choice.own_p_ = choice.own_.empty()         ? 0
                  : choice.catalogue_.empty() ? 1
                                              : config.assets().include_p();
  return choice;
}

const std::string& FloatingChoice::Pick(const std::vector<Class>& classes, Rng rng) {
  const bool alike =
      std::all_of(classes.begin(), classes.end(), [](const Class& c) { return c.weight == 1; });
  if (alike) return rng.Pick(classes).name;
  double total = 0;
  for (const Class& entry : classes) total += entry.weight;
  double left = rng.Uniform() * total;
  const Class* last = nullptr;
  for (const Class& entry : classes) {
    if (!(entry.weight > 0)) continue;
    last = &entry;
    if (left < entry.weight) break;
    left -= entry.weight;
  }
  return last->name;
}

FloatingSize FloatingSize::Draw(const v1::FloatingConfig& config, const Rng& stream) {
  return {parallax::Draw(config.size_m(), stream.Child("size").Uniform()),
          parallax::Draw(config.size_added_m(), stream.Child("size added").Uniform())};
}

FloatingChoice::Model FloatingChoice::Draw(const Rng& stream) const {
  if (own_p_ > 0 && stream.Child("own").Bernoulli(own_p_)) {
    const std::string& name = Pick(own_, stream.Child("own class"));
    return {name, stream.Child("own mesh").Pick(meshes_.at(name))};
  }
  const std::string& name = Pick(catalogue_, stream.Child("class"));
  return {name, stream.Child("asset").Seed()};
}

}  // namespace parallax
