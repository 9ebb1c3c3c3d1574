#include "worker/scene/types/nature/walk/arena.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "worker/scene/types/nature/ground/views.h"

namespace parallax {
namespace {

constexpr float kNear_m = 55, kReach_m = 170, kArenaRoofCell_m = 0.5f;

// A thing that is made solid.
struct Solid {
  ShapeKey shape;
  Eigen::Affine3f place;
};

// Adds things, in their order. Trees of boxes over meshes are made once each, on several threads.
absl::Status AddThings(const v1::Terrain& recipe, const std::vector<Solid>& things,
                       RayScene& scene) {
  std::map<ShapeKey, size_t> numbers;
  std::vector<ShapeKey> shapes;
  for (const Solid& thing : things) {
    if (numbers.try_emplace(thing.shape, shapes.size()).second) shapes.push_back(thing.shape);
  }
  ASSIGN_OR_RETURN(const auto meshes, MeshesOf(recipe, shapes));
  std::vector<std::shared_ptr<const TriangleTree>> trees(shapes.size());
  tbb::parallel_for(size_t{0}, trees.size(),
                    [&](size_t i) { trees[i] = std::make_shared<const TriangleTree>(*meshes[i]); });
  for (const Solid& thing : things) scene.Add(trees[numbers[thing.shape]], thing.place);
  return absl::OkStatus();
}

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
  std::vector<Solid> solids;
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
      solids.push_back({{layer.prototypes(thing.prototype), thing.shape,
                         near ? PlantDetail::kMid : PlantDetail::kFar},
                        place});
    }
  }
  RETURN_IF_ERROR(AddThings(recipe, solids, *solid));
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
  std::vector<ShapeKey> far = expansion.shapes;
  for (ShapeKey& key : far) key.detail = PlantDetail::kFar;
  ASSIGN_OR_RETURN(const auto meshes, MeshesOf(recipe, far));
  std::vector<Box3f> boxes;
  for (const auto& mesh : meshes) boxes.push_back(mesh->Bounds());
  std::vector<Solid> solids;
  for (const Instance& instance : expansion.instances) {
    const Box3f box = TransformBox(instance.Affine(), boxes[instance.prototype]);
    const float radius = 0.55f * box.diagonal().norm();
    if (!way.IsWithin(box.center().head<2>(), within_m + radius)) continue;
    solids.push_back({expansion.shapes[instance.prototype], instance.Affine()});
  }
  RETURN_IF_ERROR(AddThings(recipe, solids, *solid));
  solid->Commit();
  return solid;
}

}  // namespace parallax
