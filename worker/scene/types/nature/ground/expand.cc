#include "worker/scene/types/nature/ground/expand.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <map>
#include <mutex>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "worker/scene/types/nature/ground/prototypes.h"
#include "worker/scene/types/nature/ground/views.h"
#include "worker/scene/types/nature/rules/plot.h"
#include "worker/scene/types/nature/rules/recipe.h"

namespace parallax {
namespace {

// Everything stands this far around the walk, seen or not: for shadows and bounced light.
constexpr float kNearDisc_m = 14, kCasterDisc_m = 55;
constexpr float kRoofCell_m = 0.2f;
constexpr double kFarthestEye_m = 28'000;  // From the origin: there the ground's mesh ends.
constexpr size_t kAtATime = 1 << 17;       // Things whose poses are made together.
// Water's waves are no finer than this asks for.
constexpr float kEyesAboveWater_m = 0.5f;
// Land that is seen through a house's windows: everything is as coarse as if it were so many times
// farther away, and the ground has fewer triangles.
constexpr float kBehindWindows = 2.5f;
constexpr int kTrianglesBehindWindows = 120'000;
constexpr float kLawn_m = 0.6f;           // Nothing stands nearer to a house.
constexpr uint32_t kMostIndices = 9'000;  // A layer's; things beyond share the last.

// FNV-1a over 64 bits a step.
class Hasher {
 public:
  void Add(uint64_t word) { hash_ = (hash_ ^ word) * 0x100000001b3u ^ (hash_ >> 29); }
  uint64_t hash() const { return hash_; }

 private:
  uint64_t hash_ = 0xcbf29ce484222325u;
};

float DiscOf(const v1::ScatterLayer& layer) {
  return std::min(static_cast<float>(layer.reach_m()),
                  layer.crown_m() > 0 ? kCasterDisc_m : kNearDisc_m);
}

// Whether the walk is kept clear of the layer by the choice of the walk: its things are not
// dropped.
bool IsSolid(const v1::ScatterLayer& layer) { return layer.index_each(); }

class Expander {
 public:
  Expander(const v1::Terrain& recipe, const Views& views, Expansion& out)
      : recipe_(recipe),
        views_(views),
        way_(views, static_cast<float>(recipe.clearance_baseline_m())),
        tube_m_(std::max(kLeastTube_m, static_cast<float>(recipe.clearance_m()))),
        out_(out) {}

  absl::Status Run() {
    std::vector<TileSet> tiles;
    for (const v1::ScatterLayer& layer : recipe_.layers()) {
      tiles.push_back(views_.Tiles(DiscOf(layer), static_cast<float>(layer.reach_m())));
    }
    ASSIGN_OR_RETURN(const auto things, Scatter(recipe_, *out_.terrain).Place(tiles));
    std::vector<std::vector<Kept>> kept;
    for (int layer = 0; layer < recipe_.layers_size(); ++layer) {
      ASSIGN_OR_RETURN(kept.emplace_back(),
                       KeptOf(recipe_.layers(layer), things[static_cast<size_t>(layer)]));
      RETURN_IF_ERROR(CheckWanted(kept));
    }
    RETURN_IF_ERROR(ThinToBudget(kept));
    for (int layer = 0; layer < recipe_.layers_size(); ++layer) {
      Add(layer, kept[static_cast<size_t>(layer)]);
    }
    if (out_.water) HashHeights(*out_.water);
    HashHeights(out_.ground.mesh());
    if (out_.roof) HashHeights(out_.roof->mesh());
    out_.hash = hasher_.hash();
    return absl::OkStatus();
  }

 private:
  struct Kept {
    bool wanted = false;
    PlantDetail detail = PlantDetail::kNear;
    Standing thing;
    Eigen::Matrix<float, 3, 4> place;
  };

  // Returns the things of a layer that the views want, in their order.
  absl::StatusOr<std::vector<Kept>> KeptOf(const v1::ScatterLayer& layer,
                                           const std::vector<Standing>& things) const {
    ASSIGN_OR_RETURN(const std::vector<std::vector<Box3f>> boxes, BoxesOf(layer));
    std::vector<Kept> all, some;
    for (size_t first = 0; first < things.size(); first += kAtATime) {
      some.assign(std::min(kAtATime, things.size() - first), Kept());
      tbb::parallel_for(size_t{0}, some.size(),
                        [&](size_t i) { some[i] = Keep(layer, things[first + i], boxes); });
      std::copy_if(some.begin(), some.end(), std::back_inserter(all),
                   [](const Kept& kept) { return kept.wanted; });
    }
    return all;
  }

  static absl::Status CheckWanted(const std::vector<std::vector<Kept>>& kept) {
    size_t wanted = 0;
    for (const std::vector<Kept>& layer : kept) wanted += layer.size();
    if (wanted <= kMostWanted) return absl::OkStatus();
    return OutOfRange("terrain: the views want more than {} things, allowed are {}", wanted,
                      kMostWanted);
  }

  // Keeps the number of instances within kMostInstances: things without an index each are thinned
  // evenly, to those of the lowest ranks.
  absl::Status ThinToBudget(std::vector<std::vector<Kept>>& kept) const {
    size_t single = 0;
    std::vector<uint16_t> ranks;
    for (size_t layer = 0; layer < kept.size(); ++layer) {
      if (IsSolid(recipe_.layers(static_cast<int>(layer)))) {
        single += kept[layer].size();
        continue;
      }
      for (const Kept& small : kept[layer]) ranks.push_back(PlaceInLine(small.thing));
    }
    if (single > kMostInstances) {
      return OutOfRange("terrain: {} things have an index each, allowed are {} instances", single,
                        kMostInstances);
    }
    const size_t room = kMostInstances - single;
    if (ranks.size() <= room) return absl::OkStatus();
    const auto last = ranks.begin() + static_cast<std::ptrdiff_t>(room);
    std::nth_element(ranks.begin(), last, ranks.end());
    for (size_t layer = 0; layer < kept.size(); ++layer) {
      if (IsSolid(recipe_.layers(static_cast<int>(layer)))) continue;
      std::erase_if(kept[layer],
                    [&](const Kept& small) { return PlaceInLine(small.thing) >= *last; });
    }
    return absl::OkStatus();
  }

  // The rank's upper 16 bits, used only for thinning. Keep uses the lower 16.
  static uint16_t PlaceInLine(const Standing& thing) {
    return static_cast<uint16_t>(thing.rank >> 16);
  }

  void Add(int index, const std::vector<Kept>& kept) {
    const v1::ScatterLayer& layer = recipe_.layers(index);
    uint32_t count = 0;
    for (const Kept& one : kept) {
      const uint32_t prototype = layer.prototypes(one.thing.prototype);
      Instance instance;
      instance.world_from_object = one.place;
      instance.prototype = ShapeIndex({prototype, one.thing.shape, one.detail});
      instance.object_index =
          (layer.index_each() ? std::min(count, kMostIndices - 1) : one.thing.prototype);
      Hash(index, one.thing, instance);
      out_.instances.push_back(instance);
      ++count;
    }
    out_.of_layer.push_back(count);
    out_.indices.push_back(layer.index_each() ? std::min(count, kMostIndices)
                                              : static_cast<uint32_t>(layer.prototypes_size()));
  }

  // How large the small things of a layer are, for the tube.
  absl::StatusOr<std::vector<std::vector<Box3f>>> BoxesOf(const v1::ScatterLayer& layer) const {
    std::vector<std::vector<Box3f>> boxes;
    if (IsSolid(layer)) return boxes;
    for (const uint32_t index : layer.prototypes()) {
      const v1::Prototype& prototype = recipe_.prototypes(static_cast<int>(index));
      std::vector<Box3f>& own = boxes.emplace_back();
      for (uint32_t shape = 0; shape < prototype.shapes(); ++shape) {
        ASSIGN_OR_RETURN(const auto mesh, PrototypeMesh(prototype, shape, PlantDetail::kFar));
        own.push_back(mesh->Bounds());
      }
    }
    return boxes;
  }

  Kept Keep(const v1::ScatterLayer& layer, const Standing& thing,
            const std::vector<std::vector<Box3f>>& boxes) const {
    Kept kept;
    kept.thing = thing;
    const Vec2f p = thing.position();
    const float radius = static_cast<float>(layer.crown_m()) * thing.scale() + 0.5f;
    const auto reach = static_cast<float>(layer.reach_m());
    kept.wanted = views_.Wants(p, radius, DiscOf(layer), reach) && LeavesPlotFree(layer, p, radius);
    if (!kept.wanted) return kept;
    const float distance = views_.Distance(p);
    // Small things thin out towards their reach instead of ending at a line.
    if (!IsSolid(layer)) {
      const float gone = std::clamp((distance / reach - 0.6f) / 0.4f, 0.0f, 1.0f);
      kept.wanted = static_cast<float>(thing.rank & 0xffff) * 0x1p-16f >= gone;
      if (!kept.wanted) return kept;
    }
    kept.detail = DetailAt(layer, recipe_.has_plot() ? kBehindWindows * distance : distance,
                           views_.focal_px());
    if (layer.hangs()) {
      const auto place = PlaceUnder(layer, thing, *out_.roof);
      kept.wanted = place.has_value();
      if (!place) return kept;
      kept.place = *place;
    } else {
      kept.place = PlaceOf(layer, thing, out_.ground, *out_.terrain);
    }
    if (!boxes.empty()) {
      const Box3f& box = boxes[thing.prototype][thing.shape];
      const Vec3f middle = kept.place.leftCols<3>() * box.center() + kept.place.col(3);
      kept.wanted = !way_.Meets(middle, 0.5f * thing.scale() * box.diagonal().norm(), tube_m_);
    }
    return kept;
  }

  bool LeavesPlotFree(const v1::ScatterLayer& layer, const Vec2f& p, float radius_m) const {
    if (!recipe_.has_plot()) return true;
    const auto clearing = static_cast<float>(IsSolid(layer) ? recipe_.plot().clearing_m() : 0);
    return FromPlot(recipe_.plot(), p) > std::max(kLawn_m, clearing) + radius_m;
  }

  uint32_t ShapeIndex(const ShapeKey& key) {
    const auto [found, added] = shape_index_.try_emplace(key, out_.shapes.size());
    if (added) out_.shapes.push_back(key);
    return found->second;
  }

  void Hash(int layer, const Standing& thing, const Instance& instance) {
    const auto millimetres = std::lround(1000.0f * instance.world_from_object(2, 3));
    hasher_.Add(static_cast<uint64_t>(static_cast<uint32_t>(thing.x_mm)) << 32 |
                static_cast<uint32_t>(thing.y_mm));
    hasher_.Add(static_cast<uint64_t>(millimetres));
    hasher_.Add(static_cast<uint64_t>(thing.turn) << 48 | static_cast<uint64_t>(thing.size) << 32 |
                static_cast<uint64_t>(layer) << 24 | static_cast<uint64_t>(thing.prototype) << 16 |
                static_cast<uint64_t>(thing.shape) << 8 |
                static_cast<uint64_t>(out_.shapes[instance.prototype].detail));
  }

  void HashHeights(const Mesh& mesh) {
    hasher_.Add(mesh.triangles.size());
    for (const Vec3f& p : mesh.positions) {
      hasher_.Add(static_cast<uint64_t>(std::lround(1000.0f * p.z())));
    }
  }

  const v1::Terrain& recipe_;
  const Views& views_;
  const EyeWay way_;
  const float tube_m_;  // Nothing that can be dropped comes so near to an eye.
  Expansion& out_;
  std::map<ShapeKey, uint32_t> shape_index_;
  Hasher hasher_;
};

// All that an expansion depends on.
std::string KeyOf(v1::Terrain recipe, const google::protobuf::RepeatedPtrField<v1::Rig>& rigs) {
  recipe.clear_ground();
  recipe.clear_expansion_hash();
  recipe.clear_instances();
  if (recipe.has_water()) recipe.mutable_water()->clear_material_index();
  for (v1::Prototype& prototype : *recipe.mutable_prototypes()) prototype.clear_materials();
  for (v1::ScatterLayer& layer : *recipe.mutable_layers()) {
    layer.clear_first_object_index();
    layer.clear_indices();
  }
  std::string key = recipe.SerializeAsString();
  for (const v1::Rig& rig : rigs) key += rig.SerializeAsString();
  return key;
}

GroundMesh MakeGround(const v1::Terrain& recipe, const Terrain& terrain, const Views& views) {
  GroundMeshOptions options;
  options.views = views.Cones(terrain);
  options.focal_px = views.focal_px();
  if (!recipe.has_plot()) return {terrain, options};
  for (size_t i = 0; i < options.views.size(); ++i) {
    const double above = double{views.eyes()[i].left.z()} - recipe.plot().level_m();
    options.views[i].eye_height_m = std::max(0.2f, static_cast<float>(above));
  }
  options.most_triangles = kTrianglesBehindWindows;
  return {GroundWithPlot(recipe.plot(), terrain), options};
}

std::shared_ptr<const Mesh> MakeWater(const Terrain& terrain, const Views& views) {
  if (terrain.water() == nullptr) return nullptr;
  GroundMeshOptions options;
  options.views = views.Cones(terrain);
  for (ViewCone& view : options.views) view.eye_height_m += kEyesAboveWater_m;
  options.focal_px = views.focal_px();
  options.most_triangles = 320'000;
  return std::make_shared<const Mesh>(GroundMesh(WaterOf(terrain), options).mesh());
}

absl::Status CheckEyes(const google::protobuf::RepeatedPtrField<v1::Rig>& rigs) {
  for (const v1::Rig& rig : rigs) {
    const v1::Transform& eye = rig.world_from_left();
    for (const double at : {eye.tx(), eye.ty(), eye.tz()}) {
      if (std::abs(at) <= kFarthestEye_m) continue;  // False for NaN.
      return InvalidArgument(
          "terrain: rig {} stands at ({:f}, {:f}, {:f}), allowed is {} m at most", rig.index(),
          eye.tx(), eye.ty(), eye.tz(), kFarthestEye_m);
    }
  }
  return absl::OkStatus();
}

// How far flat objects may rise above the ground.
constexpr float kMostDaylight_m = 0.002f;

// The largest height of a base's rim above the ground.
float Daylight(const GroundMesh& ground, const Mat3f& rotation, const Vec3f& middle, float radius) {
  constexpr int kPoints = 8;
  float highest = 0;
  for (int i = 0; i < kPoints; ++i) {
    const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / kPoints;
    const Vec3f at =
        middle + rotation * Vec3f(radius * std::cos(angle), radius * std::sin(angle), 0);
    highest = std::max(highest, at.z() - ground.HeightAt(at.head<2>()));
  }
  return highest;
}

}  // namespace

PlantDetail DetailAt(const v1::ScatterLayer& layer, float distance_m, float focal_px) {
  // In metres for the paper's lens, whose pixel is 1/2000 of the distance.
  const bool tall = layer.crown_m() > 0;
  const float near = tall ? 60 : 9, mid = tall ? 200 : 28, far = tall ? 520 : 60;
  const float distance = distance_m * 2000 / std::max(focal_px, 300.0f);
  if (distance < near) return PlantDetail::kNear;
  if (distance < mid) return PlantDetail::kMid;
  return distance < far ? PlantDetail::kFar : PlantDetail::kShell;
}

Eigen::Matrix<float, 3, 4> PlaceOf(const v1::ScatterLayer& layer, const Standing& thing,
                                   const GroundMesh& ground, const Terrain& terrain) {
  const Vec2f p = thing.position();
  const float scale = thing.scale(),
              base = std::max(0.08f, 0.5f * static_cast<float>(layer.claim_m()) * scale);
  const float e = std::max(0.15f, base);
  const float middle = ground.HeightAt(p);
  const float east = ground.HeightAt(p + Vec2f(e, 0)), west = ground.HeightAt(p - Vec2f(e, 0));
  const float north = ground.HeightAt(p + Vec2f(0, e)), south = ground.HeightAt(p - Vec2f(0, e));
  const Vec3f normal = Vec3f(west - east, south - north, 2 * e).normalized();
  const auto upright = static_cast<float>(layer.upright());
  Vec3f up = (normal + upright * (Vec3f::UnitZ() - normal)).normalized();
  // The foot is as deep as the ground falls below the base; what lies along the slope stays on it.
  const float lowest = std::min({middle, east, west, north, south});
  float z = middle + upright * (lowest - middle) - static_cast<float>(layer.sink_m()) * scale;
  if (layer.floats() && terrain.water() != nullptr) {
    const float level = terrain.water()->Level(p) - static_cast<float>(layer.sink_m()) * scale;
    if (level > z) {
      z = level;
      up = Vec3f::UnitZ();
    }
  }
  const float turn = 2 * std::numbers::pi_v<float> * static_cast<float>(thing.turn) / 65536.0f;
  const Mat3f rotation = (Eigen::Quaternionf::FromTwoVectors(Vec3f::UnitZ(), up) *
                          Eigen::Quaternionf(Eigen::AngleAxisf(turn, Vec3f::UnitZ())))
                             .toRotationMatrix();
  if (!layer.floats()) {
    const float rim = scale * std::max(0.02f, 0.5f * static_cast<float>(layer.claim_m()));
    z -= std::max(0.0f, Daylight(ground, rotation, {p.x(), p.y(), z}, rim) - kMostDaylight_m);
  }
  z = static_cast<float>(std::floor(1000.0f * z)) / 1000.0f;
  Eigen::Matrix<float, 3, 4> place;
  place.leftCols<3>() = scale * rotation;
  place.col(3) = Vec3f(p.x(), p.y(), z);
  return place;
}

std::optional<Eigen::Matrix<float, 3, 4>> PlaceUnder(const v1::ScatterLayer& layer,
                                                     const Standing& thing, const CaveRoof& roof) {
  const Vec2f p = thing.position();
  const float scale = thing.scale();
  const float e = std::max(0.1f, 0.5f * static_cast<float>(layer.claim_m()) * scale);
  float highest = -1e9f;
  for (const Vec2f& at : {p, Vec2f(p + Vec2f(e, 0)), Vec2f(p - Vec2f(e, 0)), Vec2f(p + Vec2f(0, e)),
                          Vec2f(p - Vec2f(0, e))}) {
    const std::optional<float> ceiling = roof.CeilingAt(at);
    if (!ceiling) return std::nullopt;
    highest = std::max(highest, *ceiling);
  }
  const float z = std::floor(1000.0f * (highest + static_cast<float>(layer.sink_m()) * scale));
  const float turn = 2 * std::numbers::pi_v<float> * static_cast<float>(thing.turn) / 65536.0f;
  Eigen::Matrix<float, 3, 4> place;
  place.leftCols<3>() = scale * Eigen::AngleAxisf(turn, Vec3f::UnitZ()).toRotationMatrix();
  place.col(3) = Vec3f(p.x(), p.y(), z / 1000.0f);
  return place;
}

std::shared_ptr<const CaveRoof> RoofOf(const v1::Terrain& recipe, const Terrain& terrain,
                                       float cell_m) {
  return recipe.has_roof() ? std::make_shared<const CaveRoof>(recipe, terrain, cell_m) : nullptr;
}

absl::StatusOr<std::shared_ptr<const Expansion>> ExpandTerrain(
    const v1::Terrain& recipe, const google::protobuf::RepeatedPtrField<v1::Rig>& rigs) {
  if (rigs.empty()) {
    return InvalidArgument("terrain: a landscape without rigs");
  }
  RETURN_IF_ERROR(CheckEyes(rigs));
  RETURN_IF_ERROR(CheckRules(recipe));
  std::string key = KeyOf(recipe, rigs);
  static std::mutex& mutex = *new std::mutex;
  static std::string& newest_key = *new std::string;
  static std::shared_ptr<const Expansion>& newest = *new std::shared_ptr<const Expansion>;
  {
    std::lock_guard<std::mutex> lock(mutex);
    if (newest && newest_key == key) return newest;
  }
  ASSIGN_OR_RETURN(std::shared_ptr<const Terrain> terrain, TerrainOf(recipe));
  const Views views(rigs);
  std::optional<GroundMesh> ground;
  std::shared_ptr<const Mesh> water;
  tbb::parallel_invoke([&] { ground.emplace(MakeGround(recipe, *terrain, views)); },
                       [&] { water = MakeWater(*terrain, views); });
  auto made = std::make_shared<Expansion>(Expansion{terrain, *std::move(ground), std::move(water),
                                                    RoofOf(recipe, *terrain, kRoofCell_m)});
  RETURN_IF_ERROR(Expander(recipe, views, *made).Run());
  std::lock_guard<std::mutex> lock(mutex);
  newest_key = std::move(key);
  newest = made;
  return newest;
}

absl::StatusOr<std::vector<std::shared_ptr<const Mesh>>> MeshesOf(
    const v1::Terrain& recipe, const std::vector<ShapeKey>& shapes) {
  std::vector<std::shared_ptr<const Mesh>> meshes(shapes.size());
  std::vector<absl::Status> made(shapes.size());
  tbb::parallel_for(size_t{0}, shapes.size(), [&](size_t i) {
    const v1::Prototype& prototype = recipe.prototypes(static_cast<int>(shapes[i].prototype));
    auto mesh = PrototypeMesh(prototype, shapes[i].shape, shapes[i].detail);
    made[i] = mesh.status();
    if (mesh.ok()) meshes[i] = *std::move(mesh);
  });
  for (const absl::Status& status : made) RETURN_IF_ERROR(status);
  return meshes;
}

void NumberLayers(const Expansion& expansion, uint32_t first, v1::Terrain& recipe) {
  for (int i = 0; i < recipe.layers_size(); ++i) {
    v1::ScatterLayer& layer = *recipe.mutable_layers(i);
    layer.set_first_object_index(first);
    layer.set_indices(expansion.indices[static_cast<size_t>(i)]);
    first += layer.indices();
  }
}

}  // namespace parallax
