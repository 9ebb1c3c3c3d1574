#include "coordinator/client/views/ground_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "coordinator/client/views/scene_text.h"
#include "worker/scene/types/indoor/house.h"

namespace parallax::client {
namespace {

using ::testing::HasSubstr;

v1::Scene SmallRoom() {
  v1::Scene scene;
  scene.set_generator_version("1");
  scene.set_type(v1::SCENE_TYPE_INDOOR);
  v1::Room& room = *scene.mutable_place()->mutable_house()->add_rooms();
  room.set_kind("office");
  room.set_width_m(4);
  room.set_depth_m(4);
  room.set_height_m(2.5);
  v1::Opening* door = room.add_openings();
  door->set_kind(v1::Opening::KIND_DOOR);
  door->set_wall(0);
  door->set_center_m(1);
  door->set_width_m(0.9);
  v1::Opening* window = room.add_openings();
  window->set_kind(v1::Opening::KIND_WINDOW);
  window->set_wall(1);
  window->set_center_m(3);
  window->set_width_m(0.9);
  return scene;
}

// A camera that looks along (x, y) of the world, upright: z forward, y down.
void AddRig(v1::Scene& scene, double tx, double ty, double angle) {
  v1::Rig* rig = scene.add_rigs();
  v1::Transform& pose = *rig->mutable_world_from_left();
  pose.set_tx(tx);
  pose.set_ty(ty);
  pose.set_tz(1.5);
  pose.set_scale(1);
  // Looking along +y: a turn of -90 degrees about x; then a turn about z.
  const double half = (angle - M_PI / 2) / 2;
  const double s = std::sqrt(0.5);
  pose.set_qw(std::cos(half) * s);
  pose.set_qx(-std::cos(half) * s);
  pose.set_qy(-std::sin(half) * s);
  pose.set_qz(std::sin(half) * s);
}

TEST(GroundPlan, DrawsWallsOpeningsFurnitureAndRigs) {
  v1::Scene scene = SmallRoom();
  AddRig(scene, 2.1, 2.1, 0);          // East.
  AddRig(scene, 0.1, 3.9, -M_PI / 2);  // South.
  const std::vector<Footprint> footprints = {{0, 0, 1.9, 0.9, 0.7, 'A'},
                                             {0, 0, 0.9, 0.9, 1.0, 'B'}};
  const SceneDescription description = DescribeHouse(scene);
  ASSERT_TRUE(description.plan.has_value());
  const std::vector<std::string> lines =
      DrawGroundPlan(*description.plan, scene, footprints, {.columns = 8});
  const std::vector<std::string> wanted = {
      "##########",  //
      "#v       =",  //
      "#    >   =",  //
      "#        #",  //
      "#BBAA    #",  //
      "##DD######",
  };
  EXPECT_EQ(lines, wanted);
}

TEST(GroundPlan, StandsWhereThePlaceStands) {
  v1::Scene scene = SmallRoom();
  AddRig(scene, 2.1, 2.1, 0);
  GroundPlan plan = *DescribeHouse(scene).plan;
  const auto lines = DrawGroundPlan(plan, scene, {{1, 1, 1.9, 1.9, 0.7, 'A'}}, {.columns = 8});
  plan.extent.translate(Vec3d(-7, 5, 1));
  scene.mutable_rigs(0)->mutable_world_from_left()->set_tx(2.1 - 7);
  scene.mutable_rigs(0)->mutable_world_from_left()->set_ty(2.1 + 5);
  EXPECT_EQ(DrawGroundPlan(plan, scene, {{-6, 6, -5.1, 6.9, 1.7, 'A'}}, {.columns = 8}), lines);
}

TEST(SceneText, ListsWhatTheRecipeHolds) {
  v1::Scene scene = SmallRoom();
  AddRig(scene, 2, 2, 0);
  v1::SceneObject* chair = scene.add_objects();
  chair->set_index(3);
  chair->set_name("Chair_3");
  chair->set_role(v1::OBJECT_ROLE_FURNITURE);
  chair->set_relation("on_floor");
  chair->add_materials()->set_material_index(9);
  v1::SceneMaterial* wood = scene.add_materials();
  wood->set_index(9);
  wood->set_name("Wood_9");
  v1::SolveReport& report = *scene.mutable_report();
  report.set_steps(60);
  report.set_initial_loss(10);
  report.set_final_loss(0.5);
  for (const double loss : {10.0, 5.0, 0.5}) report.add_loss_curve(loss);
  v1::SolveReport::Constraint* constraint = report.add_constraints();
  constraint->set_name("no_overlap");
  constraint->set_hard(true);
  std::ostringstream stream;
  Terminal terminal;
  terminal.stream = &stream;
  PrintScene(terminal, scene, DescribeHouse(scene), {{3, {1, 1, 0, 1.5, 1.5, 0.9}}});
  const std::string text = stream.str();
  for (const char* wanted :
       {"office 4.00 x 4.00 x 2.50 m", "Chair_3", "on_floor", "1.25 1.25 0.45", "0.50 0.50 0.90",
        "Wood_9", "60 steps", "#-_", "no_overlap  hard         ok", "Rigs (1)"}) {
    EXPECT_THAT(text, HasSubstr(wanted));
  }
}

}  // namespace
}  // namespace parallax::client
