#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "common/config/config.h"
#include "common/math/proto.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/dress.h"
#include "worker/scene/solve_scene.h"
#include "worker/scene/types/indoor/house.h"
#include "worker/scene/types/scene_types.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Quick: few things, small pictures.
v1::SolveJob SmallJob(v1::SceneType type) {
  v1::SolveJob job;
  job.set_scene_seed(2);
  *job.mutable_config() = DefaultSceneConfig();
  job.mutable_config()->set_type(type);
  job.mutable_config()->mutable_floating()->mutable_count()->set_constant(2);
  job.mutable_config()->mutable_rigs()->set_count(2);
  return job;
}

TEST(SceneTypes, EachIsFoundByItsTypeAndStandsOnce) {
  std::set<int> types;
  for (const SceneType* type : SceneTypes()) {
    EXPECT_TRUE(types.insert(type->type).second);
    const absl::StatusOr<const SceneType*> found = FindSceneType(type->type);
    ASSERT_TRUE(found.ok()) << found.status();
    EXPECT_EQ(*found, type);
  }
  EXPECT_GE(types.size(), 2u);
}

TEST(SceneTypes, AnUnknownTypeIsAnErrorThatNamesTheKnownOnes) {
  for (const v1::SceneType type : {v1::SCENE_TYPE_UNSPECIFIED, static_cast<v1::SceneType>(99)}) {
    const absl::Status status = FindSceneType(type).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(status.message()), HasSubstr("SCENE_TYPE_INDOOR, SCENE_TYPE_DENSE"));
    EXPECT_EQ(Solve(SmallJob(type), CancelToken()).status().code(),
              absl::StatusCode::kInvalidArgument);
    v1::Scene scene;
    scene.set_type(type);
    scene.mutable_place()->mutable_open_sky();
    EXPECT_EQ(BuildSceneGeometry(scene).status().code(), absl::StatusCode::kInvalidArgument);
  }
}

TEST(SceneTypes, APlaceThatIsNotTheTypesIsAnError) {
  v1::Scene scene;
  scene.set_type(v1::SCENE_TYPE_INDOOR);
  EXPECT_THAT(std::string(TypeOf(scene).status().message()), HasSubstr("nowhere"));
  scene.mutable_place()->mutable_open_sky();
  const absl::Status status = TypeOf(scene).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("open_sky, but"));
  v1::SolveJob job = SmallJob(v1::SCENE_TYPE_INDOOR);
  job.mutable_layout()->mutable_place()->mutable_open_sky();
  EXPECT_EQ(Solve(job, CancelToken()).status().code(), absl::StatusCode::kInvalidArgument);
}

// Properties of every type that the rest of the program relies on.
TEST(SceneTypes, ScenesOfEveryTypeSayWhatTheyAreAndBecomeSolid) {
  for (const SceneType* type : SceneTypes()) {
    SCOPED_TRACE(v1::SceneType_Name(type->type));
    const v1::SolveJob job = SmallJob(type->type);
    const absl::StatusOr<v1::SolveResult> result = Solve(job, CancelToken());
    ASSERT_TRUE(result.ok()) << result.status();
    ASSERT_TRUE(result->has_scene()) << result->rejected().reason();
    const v1::Scene& scene = result->scene();
    EXPECT_EQ(scene.type(), type->type);
    EXPECT_EQ(scene.place().kind_case(), type->place);
    EXPECT_EQ(result->layout().place().kind_case(), type->place);
    EXPECT_EQ(scene.rigs_size(), 2);
    EXPECT_TRUE(BuildSceneGeometry(scene).ok());
    EXPECT_GT(type->costs(job.config()).dress_s, 0);
    const SceneDescription description = type->describe(scene);
    EXPECT_EQ(description.plan.has_value(), !type->surroundings(scene.place()).bounds.isEmpty());
    for (const std::string& line : description.lines) EXPECT_FALSE(line.empty());
  }
}

// A tint darkens the light through a leaf as well as that off it.
TEST(SceneGeometry, ATintIsOfBothSidesOfALeaf) {
  v1::Scene scene = Solve(SmallJob(v1::SCENE_TYPE_DENSE), CancelToken())->scene();
  v1::SceneMaterial& leaf = *scene.add_materials();
  leaf.set_index(static_cast<uint32_t>(scene.materials_size()));
  leaf.set_material_class("FreshNeedle");
  const auto look = [&] {
    const absl::StatusOr<SceneGeometry> geometry = BuildSceneGeometry(scene);
    EXPECT_TRUE(geometry.ok()) << geometry.status();
    return geometry->materials.at(leaf.index())->Evaluate(SurfacePoint());
  };
  const SurfaceSample plain = look();
  ASSERT_GT(plain.transmitted_color.minCoeff(), 0);
  *leaf.mutable_tint() = ToProto(Vec3d(0.5, 0.7, 0.2));
  const SurfaceSample tinted = look();
  const Vec3f tint(0.5f, 0.7f, 0.2f);
  EXPECT_LT((tinted.base_color - plain.base_color.cwiseProduct(tint)).norm(), 1e-6f);
  EXPECT_LT((tinted.transmitted_color - plain.transmitted_color.cwiseProduct(tint)).norm(), 1e-6f);
}

// The maps of objects and materials have 16 bits.
TEST(SceneGeometry, IndicesThatMapsCannotHoldAreRefused) {
  v1::Scene scene = Solve(SmallJob(v1::SCENE_TYPE_DENSE), CancelToken())->scene();
  ASSERT_GT(scene.objects_size(), 0);
  scene.mutable_objects(0)->set_index(65535);
  EXPECT_TRUE(BuildSceneGeometry(scene).ok());
  scene.mutable_objects(0)->set_index(65536);
  const absl::Status status = BuildSceneGeometry(scene).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("has index 65536"));
}

v1::Place TwoRooms() {
  v1::Place place;
  for (const double x : {0.0, 5.0}) {
    v1::Room& room = *place.mutable_house()->add_rooms();
    room.set_kind(x > 0 ? "kitchen" : "office");
    room.set_origin_x_m(x);
    room.set_width_m(4);
    room.set_depth_m(3);
    room.set_height_m(2.5);
    room.set_wall_thickness_m(0.2);
  }
  v1::Opening& window = *place.mutable_house()->mutable_rooms(1)->add_openings();
  window.set_kind(v1::Opening::KIND_WINDOW);
  window.set_wall(1);
  window.set_center_m(1.5);
  window.set_width_m(1);
  window.set_sill_m(0.9);
  window.set_height_m(1.2);
  return place;
}

// A recipe may come from a stranger.
TEST(HouseRecipes, WallsAndRoomsThatDoNotExistAreErrors) {
  v1::Scene scene;
  scene.set_type(v1::SCENE_TYPE_INDOOR);
  *scene.mutable_place() = TwoRooms();
  v1::Room& room = *scene.mutable_place()->mutable_house()->mutable_rooms(1);
  for (int wall = 0; wall < 4; ++wall) room.add_wall_depth_m(0.2);
  EXPECT_TRUE(BuildSceneGeometry(scene).ok());
  for (const int wall : {-1, 4, 500'000'000}) {
    room.mutable_openings(0)->set_wall(wall);
    EXPECT_THAT(std::string(BuildSceneGeometry(scene).status().message()),
                HasSubstr("room \"kitchen\" has an opening in wall " + std::to_string(wall)));
  }
  scene.mutable_place()->mutable_house()->clear_rooms();
  scene.mutable_place()->mutable_house()->mutable_landscape();
  v1::SceneObject& ground = *scene.add_objects();
  ground.set_part("landscape");
  EXPECT_THAT(std::string(BuildSceneGeometry(scene).status().message()),
              HasSubstr("a landscape around a house of no rooms"));
}

TEST(HouseSurroundings, TellRoomsFromWhatIsOutside) {
  const Surroundings around = HouseSurroundings(TwoRooms());
  EXPECT_FALSE(around.IsExterior({1, 1, 1}));
  EXPECT_FALSE(around.IsExterior({6, 1, 1}));
  EXPECT_TRUE(around.IsExterior({4.5f, 1, 1})) << "between the rooms";
  EXPECT_TRUE(around.IsExterior({1, 1, 2.6f}));
  EXPECT_FALSE(Surroundings().IsExterior({1, 1, 1})) << "nothing is exterior under the open sky";
  EXPECT_EQ(around.bounds.min(), Vec3d::Zero());
  EXPECT_EQ(around.bounds.max(), Vec3d(4, 3, 2.5));
}

TEST(HouseSurroundings, OpeningsInTheWallsBelongToTheHouse) {
  v1::Place place = TwoRooms();
  // A door in the masonry between the rooms, which both list.
  v1::Opening door;
  door.set_kind(v1::Opening::KIND_DOOR);
  door.set_wall(1);
  door.set_center_m(1);
  door.set_width_m(0.9);
  door.set_height_m(2);
  door.set_leads_to(2);
  door.set_depth_m(1);
  *place.mutable_house()->mutable_rooms(0)->add_openings() = door;
  door.set_wall(3);
  door.set_leads_to(1);
  door.set_mated(true);
  *place.mutable_house()->mutable_rooms(1)->add_openings() = door;
  const Surroundings around = HouseSurroundings(place);
  EXPECT_FALSE(around.IsExterior({4.5f, 1, 1})) << "a leaf";
  EXPECT_FALSE(around.IsExterior({4.5f, 1, 0.0035f})) << "the threshold";
  EXPECT_FALSE(around.IsExterior({4.5f, 0.56f, 1})) << "the lining";
  EXPECT_TRUE(around.IsExterior({4.5f, 1, 2.1f})) << "above the door";
  EXPECT_TRUE(around.IsExterior({4.5f, 2, 1})) << "beside the door";
  EXPECT_FALSE(around.IsExterior({9.1f, 1.5f, 1})) << "a window's frame";
  EXPECT_FALSE(around.IsExterior({9.1f, 1.5f, 0.9f})) << "a window's sill";
  EXPECT_TRUE(around.IsExterior({9.3f, 1.5f, 1})) << "in front of the window";
}

TEST(HouseSurroundings, LightComesThroughWindowsAndAMissingCeiling) {
  v1::Place place = TwoRooms();
  Surroundings around = HouseSurroundings(place);
  ASSERT_EQ(around.enclosures.size(), 2u);
  EXPECT_TRUE(around.enclosures[0].portals.empty());
  ASSERT_EQ(around.enclosures[1].portals.size(), 1u);
  const SkyPortal& window = around.enclosures[1].portals[0];
  EXPECT_TRUE(window.corner.isApprox(Vec3f(9.2f, 1.0f, 0.9f), 1e-5f)) << "at the outer face";
  EXPECT_EQ(window.normal, Vec3f::UnitX());
  EXPECT_FLOAT_EQ(window.edge_u.cross(window.edge_v).norm(), 1.2f);
  place.mutable_house()->set_ceiling_removed(true);
  around = HouseSurroundings(place);
  ASSERT_EQ(around.enclosures[0].portals.size(), 1u);
  EXPECT_EQ(around.enclosures[0].portals[0].normal, Vec3f::UnitZ());
  EXPECT_EQ(around.enclosures[1].portals.size(), 1u) << "only the first room's ceiling goes";
}

TEST(RemoveObjects, TakesTheirLightsAlongAndKeepsIndices) {
  v1::Scene recipe;
  for (uint32_t i = 1; i <= 4; ++i) {
    recipe.add_objects()->set_index(i);
    v1::Light& light = *recipe.add_lights();
    light.set_kind(i == 4 ? v1::Light::KIND_POINT : v1::Light::KIND_MESH);
    light.set_object_index(i == 4 ? 2 : i);
    light.set_name(std::to_string(i));
  }
  RemoveObjects([](const v1::SceneObject& object) { return object.index() % 2 == 0; }, recipe);
  std::vector<uint32_t> left;
  for (const auto& object : recipe.objects()) left.push_back(object.index());
  EXPECT_THAT(left, ElementsAre(1, 3));
  std::vector<std::string> lights;
  for (const auto& light : recipe.lights()) lights.push_back(light.name());
  EXPECT_THAT(lights, ElementsAre("1", "3", "4")) << "a point light belongs to no object";
}

}  // namespace
}  // namespace parallax
