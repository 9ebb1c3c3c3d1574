// What a land's file writes into a recipe.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "common/config/config.h"
#include "common/config/files/land_files.h"
#include "worker/scene/types/nature/rules/biomes.h"
#include "worker/scene/types/nature/rules/recipe.h"

namespace parallax {
namespace {

template <typename List>
bool Has(const List& list, std::string_view word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

bool LandIs(std::string_view word, const v1::Terrain& recipe) {
  constexpr double kSandySlope = 0.12;
  if (word == "dunes" || word == "stony") {
    const bool dunes = std::any_of(
        recipe.cover().begin(), recipe.cover().end(),
        [](const v1::TerrainTerm& term) { return term.kind() == TermKindName(TermKind::kDunes); });
    return dunes == (word == "dunes");
  }
  const bool sandy = recipe.water().slope() < kSandySlope;
  return recipe.has_water() && sandy == (word == "sandy");
}

// Whether season and form of the land are as a condition asks.
bool SuitsLand(const v1::BiomeWhen& when, std::string_view season, const v1::Terrain& recipe) {
  return (when.season().empty() || Has(when.season(), season)) &&
         (when.land().empty() ||
          std::any_of(when.land().begin(), when.land().end(),
                      [&](const std::string& word) { return LandIs(word, recipe); }));
}

// The stream of a land: its name with spaces.
Rng StreamOf(const v1::Biome& biome, const Rng& rng) {
  std::string name = biome.name();
  std::replace(name.begin(), name.end(), '_', ' ');
  return rng.Child(name);
}

// How a layer's numbers differ from those of its kind of tree.
struct TreeAge {
  double per_m2 = 1, spacing = 1, crown = 1;
  bool litter = false;  // Litter lies below it.
};

class RuleWriter {
 public:
  RuleWriter(const v1::Biome& biome, BiomeDraft& draft)
      : biome_(biome), draft_(draft), rng_(StreamOf(biome, draft.rng)) {
    numbers_ = {{"low_m", draft.heights.low_m},
                {"middle_m", draft.heights.middle_m},
                {"high_m", draft.heights.high_m},
                {"relief_m", draft.heights.high_m - draft.heights.low_m},
                {"beach_m", draft.recipe.water().slope() * draft.recipe.water().width_m()}};
    for (const v1::TerrainTerm& term : draft.recipe.cover()) {
      if (term.kind() == TermKindName(TermKind::kGorge)) numbers_["gorge_m"] = term.width_m();
    }
  }

  absl::Status Run() {
    for (const v1::BiomeValue& value : biome_.values()) Take(value);
    if (biome_.has_roof()) RETURN_IF_ERROR(AddRoof(biome_.roof()));
    for (const v1::BiomeGround& rule : biome_.ground()) AddGround(rule);
    if (biome_.has_walk()) *draft_.recipe.mutable_walk() = MaskOf(biome_.walk(), "walk");
    for (const v1::BiomeLayer& layer : biome_.layers()) AddLayer(layer);
    return WithContext(status_, "biome " + biome_.name());
  }

 private:
  double Number(const v1::Quantity& quantity, double absent = 0) {
    if (quantity.has_formula()) {
      const auto value = ValueOfFormula(quantity.formula(), [&](std::string_view name) {
        const auto found = numbers_.find(name);
        return found == numbers_.end() ? std::nullopt : std::optional<double>(found->second);
      });
      if (!value.ok()) status_.Update(value.status());
      return value.ok() ? *value : 0;
    }
    if (!quantity.has_drawn()) return absent;
    if (quantity.drawn().has_constant()) return quantity.drawn().constant();
    return Draw(quantity.drawn(), rng_.Uniform());
  }

  bool Holds(const v1::BiomeWhen& when) const {
    if (!SuitsLand(when, draft_.season, draft_.recipe)) return false;
    return when.chosen().empty() ||
           std::any_of(chosen_.begin(), chosen_.end(),
                       [&](const auto& entry) { return Has(when.chosen(), entry.second); });
  }

  void Take(const v1::BiomeValue& value) {
    if (!Holds(value.when())) return;
    if (!value.has_let()) return Choose(value);
    numbers_[value.let()] = value.has_is()
                                ? Number(value.is())
                                : draft_.heights.At(static_cast<float>(Number(value.height_at())));
  }

  // One word alone draws nothing.
  void Choose(const v1::BiomeValue& value) {
    int which = 0;
    if (value.of_size() > 1 && value.weights().empty()) {
      which = rng_.UniformInt(0, value.of_size() - 1);
    } else if (value.of_size() > 1) {
      const auto& weights = value.weights();
      double left = rng_.Uniform() * std::accumulate(weights.begin(), weights.end(), 0.0);
      while (which + 1 < value.of_size() && left >= weights[which]) left -= weights[which++];
    }
    const std::vector<std::string> words = WordsOf(value.of(which));
    for (int i = 0; i < value.choose_size(); ++i) {
      chosen_[value.choose(i)] = words[static_cast<size_t>(i)];
    }
  }

  // What was chosen, if the word is the name of a choice.
  const std::string& Word(const std::string& word) const {
    const auto found = chosen_.find(word);
    return found == chosen_.end() ? word : found->second;
  }

  void SetRange(bool given, const v1::SoftSpan& span, v1::SoftRange* (v1::GroundMask::*field)(),
                v1::GroundMask& mask) {
    if (!given) return;
    v1::SoftRange made;
    made.set_low(Number(span.low()));
    made.set_high(Number(span.high()));
    made.set_soft(Number(span.soft()));
    if (made.low() != 0 || made.high() != 0) *(mask.*field)() = made;
  }

  v1::GroundMask MaskOf(const v1::GroundPart& part, const std::string& name) {
    using Mask = v1::GroundMask;
    v1::GroundMask mask;
    SetRange(part.has_slope(), part.slope(), &Mask::mutable_slope, mask);
    SetRange(part.has_height_m(), part.height_m(), &Mask::mutable_height_m, mask);
    SetRange(part.has_above_water_m(), part.above_water_m(), &Mask::mutable_above_water_m, mask);
    SetRange(part.has_wetness(), part.wetness(), &Mask::mutable_wetness, mask);
    SetRange(part.has_deposit_m(), part.deposit_m(), &Mask::mutable_deposit_m, mask);
    SetRange(part.has_shade(), part.shade(), &Mask::mutable_shade, mask);
    SetRange(part.has_snow_m(), part.snow_m(), &Mask::mutable_snow_m, mask);
    if (part.has_rows()) {
      mask.set_rows_m(Number(part.rows().spacing_m()));
      mask.set_row_width_m(Number(part.rows().width_m()));
      mask.set_row_direction_rad(Number(part.rows().direction_deg()) * M_PI / 180);
    }
    if (!part.has_patches()) return mask;
    mask.set_noise_m(Number(part.patches().wavelength_m()));
    mask.set_noise_cover(Number(part.patches().cover()));
    mask.set_noise_soft(Number(part.patches().soft()));
    mask.set_noise_seed(draft_.rng.Child("patches").Child(name).Bits32());
    return mask;
  }

  void AddGround(const v1::BiomeGround& ground) {
    if (!Holds(ground.when())) return;
    v1::GroundRule& rule = *draft_.recipe.add_ground();
    const int index = draft_.recipe.ground_size();
    rule.set_material_index(static_cast<uint32_t>(index));
    *rule.mutable_mask() = MaskOf(ground.where(), fmt::format("ground {}", index));
  }

  absl::Status AddRoof(const v1::BiomeRoof& given) {
    ASSIGN_OR_RETURN(const TerrainSpec spec, TerrainSpecOf(draft_.recipe));
    if (spec.cover.empty()) return absl::OkStatus();  // CheckRules names what is wrong.
    const TerrainTerm& gorge = spec.cover.front();
    v1::CaveRoof& roof = *draft_.recipe.mutable_roof();
    roof.set_rise_m(Number(given.rise_m()));
    roof.set_spring_m(Number(given.spring_m()));
    roof.set_reach_m(Number(given.reach_m()));
    roof.set_half_length_m(Number(given.half_length_m()));
    roof.set_object_index(kRoofIndex);
    roof.set_seed(rng_.Bits32());
    // A formula has no bounds: CheckRules refuses kMostSkylights + 1.
    const int holes =
        static_cast<int>(std::max(0.0, std::min(kMostSkylights + 1.0, Number(given.skylights()))));
    for (int i = 0; i < holes; ++i) {
      const double along =
          roof.half_length_m() * (2 * (i + rng_.Uniform(0.25, 0.75)) / holes - 1) * 0.9;
      const Vec2f middle = GorgeMiddle(gorge, static_cast<float>(along));
      const double half = static_cast<double>(PlaceInGorge(gorge, middle).half_m);
      v1::CaveRoof::Skylight& hole = *roof.add_skylights();
      hole.set_x_m(static_cast<double>(middle.x()) + 0.5 * half * rng_.Uniform(-1, 1));
      hole.set_y_m(static_cast<double>(middle.y()) + 0.5 * half * rng_.Uniform(-1, 1));
      hole.set_radius_m(Number(given.skylight_radius_m()));
    }
    return absl::OkStatus();
  }

  void AddLayer(const v1::BiomeLayer& layer) {
    for (const v1::BiomeValue& value : layer.values()) Take(value);
    if (!Holds(layer.when())) return;
    if (layer.has_chance() && !rng_.Bernoulli(layer.chance())) return;
    if (layer.has_class_()) return Scatter(layer, {});
    const std::string& name = Word(layer.has_trees() ? layer.trees() : layer.saplings());
    for (const v1::TreeKind& kind : biome_.trees()) {
      if (kind.name() == name) AddTrees(kind, layer);
    }
  }

  // Grown trees claim the ground; young ones are smaller and stand farther apart.
  void AddTrees(const v1::TreeKind& kind, const v1::BiomeLayer& given) {
    const bool young = given.has_saplings();
    const auto constant = [](double value, v1::Quantity* quantity) {
      quantity->mutable_drawn()->set_constant(value);
    };
    v1::BiomeLayer layer;
    layer.set_name(given.has_name() ? given.name() : (young ? "young " : "") + kind.name());
    layer.set_class_(kind.class_());
    layer.set_shapes(3);
    layer.set_each(true);
    *layer.mutable_per_m2() = kind.per_m2();
    if (given.has_times()) *layer.mutable_times() = given.times();
    *layer.mutable_spacing_m() = kind.spacing_m();
    *layer.mutable_reach_m() = kind.reach_m();
    *layer.mutable_size() = kind.size();
    if (young) {
      constant(120, layer.mutable_reach_m());
      constant(0.14, layer.mutable_size()->mutable_low());
      constant(0.42, layer.mutable_size()->mutable_high());
    }
    constant(young ? 0.14 : 0.24, layer.mutable_sink_m());
    constant(young ? 0.4 : 0.55, layer.mutable_claim_m());
    *layer.mutable_crown_m() = kind.crown_m();
    if (kind.has_snow_m()) *layer.mutable_snow_m() = kind.snow_m();
    *layer.mutable_where() = given.where();
    Scatter(layer,
            young ? TreeAge{.per_m2 = 0.9, .spacing = 1.4, .crown = 0.8} : TreeAge{.litter = true});
  }

  // Equal classes share their prototype.
  uint32_t PrototypeFor(const std::string& asset, bool plants, uint32_t shapes, double snow_m) {
    auto& prototypes = *draft_.recipe.mutable_prototypes();
    for (int i = 0; i < prototypes.size(); ++i) {
      if (prototypes[i].asset_class() == asset && prototypes[i].snow_m() == snow_m) {
        return static_cast<uint32_t>(i);
      }
    }
    v1::Prototype& made = *prototypes.Add();
    made.set_asset_class(asset);
    made.set_seed(draft_.rng.Child("prototype").Child(asset).Seed());
    made.set_shapes(shapes);
    if (asset.find('/') != std::string::npos) made.set_season(draft_.season);
    made.set_role(plants ? v1::OBJECT_ROLE_VEGETATION : v1::OBJECT_ROLE_ROCK);
    if (snow_m > 0) made.set_snow_m(snow_m);
    return static_cast<uint32_t>(prototypes.size() - 1);
  }

  void Scatter(const v1::BiomeLayer& given, const TreeAge& age) {
    const bool plants = given.matter() == v1::BiomeLayer::MATTER_UNSPECIFIED ||
                        given.matter() == v1::BiomeLayer::MATTER_PLANTS;
    const bool bare = draft_.season == "winter" && given.has_winter_class();
    v1::ScatterLayer& layer = *draft_.recipe.add_layers();
    layer.set_name(given.name());
    layer.set_index_each(given.each());
    const double per_m2 = age.per_m2 * (Number(given.per_m2()) * Number(given.times(), 1));
    layer.set_per_m2(std::min(per_m2 * (plants ? draft_.density : 1), kMostPerM2));
    layer.set_spacing_m(age.spacing * Number(given.spacing_m()));
    layer.set_reach_m(Number(given.reach_m(), 40));
    layer.set_size_low(Number(given.size().low(), 0.7));
    layer.set_size_high(Number(given.size().high(), 1.3));
    layer.set_broken(given.matter() == v1::BiomeLayer::MATTER_BROKEN);
    layer.set_upright(Number(given.upright(), 1));
    layer.set_sink_m(Number(given.sink_m(), 0.02));
    layer.set_claim_m(Number(given.claim_m()));
    layer.set_crown_m(age.crown * Number(given.crown_m()));
    layer.set_casts_litter(age.litter);
    layer.set_near_parents_m(Number(given.near_trees_m()));
    layer.set_hangs(given.hangs());
    layer.set_floats(given.floats());
    layer.set_seed(draft_.rng.Child("layer").Child(given.name()).Seed());
    layer.add_prototypes(PrototypeFor(
        Word(bare ? given.winter_class() : given.class_()), plants,
        given.has_shapes() ? static_cast<uint32_t>(given.shapes()) : 4, Number(given.snow_m())));
    layer.add_weights(1);
    v1::GroundMask& mask = *layer.mutable_mask();
    mask = MaskOf(given.where(), given.name());
    if (!draft_.recipe.has_water() || mask.has_above_water_m()) return;
    // Higher than waves run up a beach and than a bank's edge.
    mask.mutable_above_water_m()->set_low(0.4);
    mask.mutable_above_water_m()->set_high(1e4);
    mask.mutable_above_water_m()->set_soft(0.15);
  }

  const v1::Biome& biome_;
  BiomeDraft& draft_;
  Rng rng_;
  std::map<std::string, double, std::less<>> numbers_;  // That formulas know.
  std::map<std::string, std::string> chosen_;
  absl::Status status_;
};

}  // namespace

absl::Status WriteRules(const v1::Biome& biome, BiomeDraft& draft) {
  return RuleWriter(biome, draft).Run();
}

std::vector<std::string> GroundMaterials(const v1::Biome& biome, const v1::Terrain& recipe) {
  std::vector<std::string> materials;
  for (const v1::BiomeGround& rule : biome.ground()) {
    if (SuitsLand(rule.when(), recipe.season(), recipe)) materials.push_back(rule.material());
  }
  return materials;
}

}  // namespace parallax
