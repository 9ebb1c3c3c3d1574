#include "worker/scene/palettes.h"

#include <fmt/core.h>

#include <algorithm>
#include <string_view>

namespace parallax {
namespace {

// Number of members of a family that a room's objects share: people buy in sets.
int PaletteSize(const std::string& family) {
  static const std::map<std::string, int> sizes = {
      {"wood", 3},        {"metal", 3},  {"paint", 3},           {"glass", 2},
      {"plastic", 4},     {"fabric", 4}, {"ApplianceEnamel", 2}, {"HousingPlastic", 2},
      {"BrushedMetal", 2}};
  const auto found = sizes.find(family);
  return found == sizes.end() ? 6 : found->second;
}

bool Names(const std::string& slot, std::string_view word) {
  return slot.find(word) != std::string::npos;
}

}  // namespace

bool Prints(const MaterialSlot& slot) {
  return std::find(slot.families.begin(), slot.families.end(), "picture") != slot.families.end();
}

MaterialClasses PrintsFor(const std::string& slot) {
  MaterialClasses classes = MaterialsOfFamily("picture");
  const auto keep = [&](std::string_view word) {
    std::erase_if(classes, [&](const MaterialClass* c) { return !Names(c->name, word); });
  };
  if (Names(slot, "cover")) {
    keep("BookCover");
  } else if (Names(slot, "label") || Names(slot, "front")) {
    keep("ProductLabel");
  } else if (Names(slot, "screen")) {
    keep("ScreenPicture");
  } else if (Names(slot, "page")) {
    keep("PrintedPage");
  } else {
    std::erase_if(classes, [](const MaterialClass* c) {
      return !Names(c->name, "Paint") && !Names(c->name, "Botanical") && !Names(c->name, "Poster");
    });
  }
  return classes.empty() ? MaterialsOfFamily("picture") : classes;
}

uint32_t Palettes::IndexOf(const std::string& name, uint64_t seed, const FolderFile& picture) {
  auto [entry, is_new] = index_.try_emplace({name + ":" + picture.name, seed}, 0);
  if (is_new) {
    v1::SceneMaterial& added = *recipe_.add_materials();
    added.set_index(static_cast<uint32_t>(recipe_.materials_size()));
    added.set_name(fmt::format("{}_{}", name, added.index()));
    added.set_material_class(name);
    added.set_seed(seed);
    if (!picture.name.empty()) {
      added.set_picture_file(picture.name);
      added.set_picture_sha256(picture.sha256);
    }
    entry->second = added.index();
  }
  return entry->second;
}

uint32_t Palettes::FromPalette(const MaterialClasses& classes, const std::string& palette, int size,
                               Rng where) {
  const uint64_t member = static_cast<uint64_t>(where.UniformInt(0, size - 1));
  Rng draw = root_.Child("palette/" + palette, member);
  const MaterialClass& material = *draw.Pick(classes);
  return IndexOf(material.name, draw.Seed());
}

uint32_t Palettes::FromFamilies(const MaterialSlot& slot, Rng where, const std::string& palette,
                                int size) {
  MaterialClasses chosen;
  std::string family;
  for (const std::string& name : slot.families) {
    MaterialClasses classes = name == "picture" ? PrintsFor(slot.name) : MaterialsOfFamily(name);
    // A slot that names a family leaves special classes alone unless it names one itself.
    const bool exact = classes.size() == 1 && classes[0]->family != name;
    if (!exact && !Prints(slot)) {
      std::erase_if(
          classes, [](const MaterialClass* c) { return !c->tags.any_object || c->tags.weathered; });
    }
    if (classes.empty()) continue;
    if (!chosen.empty() && where.Bernoulli(0.7)) continue;
    const bool keep = chosen.empty();
    chosen = classes;
    family = name;
    if (!keep || where.Bernoulli(0.65)) break;
  }
  if (chosen.empty()) {
    chosen = MaterialsOfFamily("plastic");
    family = "plastic";
  }
  return FromPalette(chosen, palette.empty() ? family : palette,
                     size > 0 ? size : PaletteSize(family), where);
}

}  // namespace parallax
