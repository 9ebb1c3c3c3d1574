#include "worker/scene/types/nature/walk/arena.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "worker/scene/types/nature/ground/prototypes.h"
#include "worker/scene/types/nature/ground/views.h"

namespace parallax {
namespace {

constexpr float kNear_m = 55, kReach_m = 170, kArenaRoofCell_m = 0.5f;

// Trees of boxes over meshes, made once each.
class Trees {
 public:
  explicit Trees(const v1::Terrain& recipe) : recipe_(recipe) {}

  absl::StatusOr<std::shared_ptr<const TriangleTree>> Of(const ShapeKey& key) {
    std::shared_ptr<const TriangleTree>& tree = made_[key];
    if (tree) return tree;
    ASSIGN_OR_RETURN(
        const auto mesh,
        PrototypeMesh(recipe_.prototypes(static_cast<int>(key.prototype)), key.shape, key.detail));
    tree = std::make_shared<const TriangleTree>(*mesh);
    return tree;
  }

 private:
  const v1::Terrain& recipe_;
  std::map<ShapeKey, std::shared_ptr<const TriangleTree>> made_;
};

GroundMeshOptions CoarseMesh(const Vec2f& middle) {
  GroundMeshOptions options;
  options.views = {{middle, 2.0f, 0.0f, std::numbers::pi_v<float>}};
  options.focal_px = 250;
  options.out_of_view = 1;
  options.least_edge_m = 0.4f;
  options.most_triangles = 60'000;
  return options;
}

TileSet TilesWithin(const Vec2f& middle, float radius_m) {
  TileSet tiles;
  const Vec2f around = Vec2f::Constant(radius_m);
  const Tile first = TileAt(middle - around), last = TileAt(middle + around);
  for (int32_t y = first.first; y <= last.first; ++y) {
    for (int32_t x = first.second; x <= last.second; ++x) {
      if (std::sqrt(BoxOf({y, x}).squaredExteriorDistance(middle)) < radius_m) tiles.insert({y, x});
    }
  }
  return tiles;
}

}  // namespace

absl::StatusOr<std::unique_ptr<RayScene>> MakeArena(const v1::Terrain& recipe,
                                                    const Terrain& terrain, const Vec2f& middle) {
  auto solid = std::make_unique<RayScene>();
  const GroundMesh ground(terrain, CoarseMesh(middle));
  solid->Add(ground.mesh(), Eigen::Affine3f::Identity());
  if (terrain.water() != nullptr) {
    const GroundMesh water(WaterOf(terrain), CoarseMesh(middle));
    solid->Add(water.mesh(), Eigen::Affine3f::Identity());
  }
  const auto roof = RoofOf(recipe, terrain, kArenaRoofCell_m);
  if (roof) solid->Add(roof->mesh(), Eigen::Affine3f::Identity());
  std::vector<TileSet> tiles;
  for (const v1::ScatterLayer& layer : recipe.layers()) {
    const float radius = std::min(static_cast<float>(layer.reach_m()), kReach_m);
    tiles.push_back(layer.index_each() ? TilesWithin(middle, radius) : TileSet());
  }
  ASSIGN_OR_RETURN(const auto things, Scatter(recipe, terrain).Place(tiles));
  Trees trees(recipe);
  for (int index = 0; index < recipe.layers_size(); ++index) {
    const v1::ScatterLayer& layer = recipe.layers(index);
    for (const Standing& thing : things[static_cast<size_t>(index)]) {
      const bool near = (thing.position() - middle).norm() < kNear_m;
      Eigen::Affine3f place = Eigen::Affine3f::Identity();
      if (layer.hangs()) {
        const auto under = PlaceUnder(layer, thing, *roof);
        if (!under) continue;
        place.matrix().topRows<3>() = *under;
      } else {
        place.matrix().topRows<3>() = PlaceOf(layer, thing, ground, terrain);
      }
      ASSIGN_OR_RETURN(const auto tree, trees.Of({layer.prototypes(thing.prototype), thing.shape,
                                                  near ? PlantDetail::kMid : PlantDetail::kFar}));
      solid->Add(tree, place);
    }
  }
  solid->Commit();
  return solid;
}

absl::StatusOr<std::unique_ptr<RayScene>> MakeNearby(
    const v1::Terrain& recipe, const Expansion& expansion,
    const google::protobuf::RepeatedPtrField<v1::Rig>& rigs, float within_m, float baseline_m) {
  const EyeWay way{Views(rigs), baseline_m};
  auto solid = std::make_unique<RayScene>();
  for (const Mesh* sheet : {&expansion.ground.mesh(), expansion.water.get()}) {
    if (sheet == nullptr) continue;
    Mesh near = *sheet;
    std::erase_if(near.triangles, [&](const Triangle& t) {
      const Vec3f& corner = near.positions[t.a];
      const float radius =
          std::max((corner - near.positions[t.b]).norm(), (corner - near.positions[t.c]).norm());
      return !way.IsWithin(corner.head<2>(), within_m + radius);
    });
    solid->Add(near, Eigen::Affine3f::Identity());
  }
  if (expansion.roof) solid->Add(expansion.roof->mesh(), Eigen::Affine3f::Identity());
  // A mesh's box hardly depends on its level of detail.
  std::vector<Box3f> boxes;
  for (const ShapeKey& key : expansion.shapes) {
    ASSIGN_OR_RETURN(const auto mesh,
                     PrototypeMesh(recipe.prototypes(static_cast<int>(key.prototype)), key.shape,
                                   PlantDetail::kFar));
    boxes.push_back(mesh->Bounds());
  }
  Trees trees(recipe);
  for (const Instance& instance : expansion.instances) {
    const Box3f box = TransformBox(instance.Affine(), boxes[instance.prototype]);
    const float radius = 0.55f * box.diagonal().norm();
    if (!way.IsWithin(box.center().head<2>(), within_m + radius)) continue;
    ASSIGN_OR_RETURN(const auto tree, trees.Of(expansion.shapes[instance.prototype]));
    solid->Add(tree, instance.Affine());
  }
  solid->Commit();
  return solid;
}

}  // namespace parallax
