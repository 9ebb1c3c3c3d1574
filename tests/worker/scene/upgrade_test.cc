// Recipes that earlier releases wrote: the files in data/ say by which generator.
#include "worker/scene/upgrade.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "common/base/system/file.h"
#include "common/config/config.h"
#include "worker/layout/plan/room_shell.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/solve_scene.h"
#include "worker/scene/types/scene_types.h"

#pragma GCC diagnostic ignored "-Wdeprecated-declarations"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string Bytes(const std::string& name) {
  const absl::StatusOr<std::string> bytes = ReadFile(PARALLAX_SCENE_DATA "/" + name);
  EXPECT_TRUE(bytes.ok()) << bytes.status();
  return *bytes;
}

template <typename Message>
Message Raw(const std::string& name) {
  Message message;
  EXPECT_TRUE(message.ParseFromString(Bytes(name)));
  return message;
}

std::vector<std::string> NamesOf(const v1::House& house) {
  std::vector<std::string> names;
  for (const v1::Room& room : house.rooms()) names.push_back(room.name());
  return names;
}

// Each object is in the room that its legacy field named.
template <typename Recipe>
void ExpectSameRooms(const Recipe& before, const Recipe& after) {
  ASSERT_EQ(before.objects_size(), after.objects_size());
  std::set<int> rooms;
  for (int i = 0; i < before.objects_size(); ++i) {
    const int room = RoomIndexOf(after.place().house(), after.objects(i).index());
    EXPECT_EQ(static_cast<uint32_t>(room), before.objects(i).legacy_room_index());
    EXPECT_EQ(after.objects(i).legacy_room_index(), 0u);
    EXPECT_EQ(after.objects(i).part(), before.objects(i).part());
    rooms.insert(room);
  }
  EXPECT_EQ(rooms.size(), 3u);
}

TEST(UpgradeScene, AHouseOfGenerator17IsAHouse) {
  const v1::Scene before = Raw<v1::Scene>("house_generator_17.pb");
  ASSERT_TRUE(before.has_legacy_room());
  ASSERT_FALSE(before.has_place());
  const absl::StatusOr<v1::Scene> scene =
      ParseScene(Bytes("house_generator_17.pb"), "house_generator_17.pb");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_THAT(NamesOf(scene->place().house()), ElementsAre("office_0", "hallway_0", "kitchen_0"));
  EXPECT_TRUE(scene->place().house().ceiling_removed());
  EXPECT_FALSE(scene->has_legacy_room());
  EXPECT_FALSE(scene->legacy_ceiling_removed());
  EXPECT_EQ(scene->legacy_rooms_size(), 0);
  ExpectSameRooms(before, *scene);

  const absl::StatusOr<SceneGeometry> geometry = BuildSceneGeometry(*scene);
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_EQ(geometry->meshes.size(), static_cast<size_t>(scene->objects_size()));
  EXPECT_EQ(geometry->surroundings.enclosures.size(), 3u);
  EXPECT_GT(geometry->surroundings.interiors.size(), 3u) << "rooms and openings";
}

TEST(UpgradeScene, ADenseSceneOfGenerator17StandsUnderTheOpenSky) {
  const v1::Scene before = Raw<v1::Scene>("dense_generator_17.pb");
  ASSERT_FALSE(before.has_place());
  v1::Scene after = before;
  ASSERT_TRUE(UpgradeScene(after).ok());
  EXPECT_TRUE(after.place().has_open_sky());
  EXPECT_TRUE(BuildSceneGeometry(after).ok());
  after.clear_place();
  EXPECT_EQ(after.SerializeAsString(), before.SerializeAsString()) << "nothing else changes";
}

TEST(UpgradeScene, ARecipeOfThisReleaseStaysAsItIs) {
  v1::Scene scene = Raw<v1::Scene>("house_generator_17.pb");
  ASSERT_TRUE(UpgradeScene(scene).ok());
  const std::string bytes = scene.SerializeAsString();
  ASSERT_TRUE(UpgradeScene(scene).ok());
  EXPECT_EQ(scene.SerializeAsString(), bytes);
}

TEST(UpgradeScene, PartsWithoutAClassGetTheOneThatTheyAreShownAs) {
  v1::Scene scene;
  scene.mutable_legacy_room()->set_width_m(4);
  for (const char* part : {"floor", "ceiling", "walls", "skirting", "door_0", "window_12"}) {
    scene.add_objects()->set_part(part);
  }
  scene.add_objects()->set_part("door_1");
  scene.mutable_objects(6)->set_asset_class("PanelDoor");
  ASSERT_TRUE(UpgradeScene(scene).ok());
  std::vector<std::string> classes;
  for (const v1::SceneObject& object : scene.objects()) classes.push_back(object.asset_class());
  EXPECT_THAT(classes,
              ElementsAre("Floor", "Ceiling", "Wall", "Skirting", "Door", "Window", "PanelDoor"));
}

TEST(UpgradeScene, AnObjectOfAMissingRoomIsAnError) {
  v1::Scene scene = Raw<v1::Scene>("house_generator_17.pb");
  scene.mutable_objects(0)->set_legacy_room_index(7);
  const absl::Status status = UpgradeScene(scene);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr(scene.objects(0).name()));
}

TEST(ParseScene, BytesThatAreNoRecipeNameTheFile) {
  for (const std::string bytes : {"", "hello", "\x0a\xff"}) {
    const absl::Status status = ParseScene(bytes, "some.pb").status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(status.message()), HasSubstr("some.pb"));
  }
}

TEST(UpgradeLayout, ALayoutOfGenerator17CanStillBeDressed) {
  const v1::Layout before = Raw<v1::Layout>("house_layout_generator_17.pb");
  v1::Layout after = before;
  ASSERT_TRUE(UpgradeLayout(after).ok());
  EXPECT_THAT(NamesOf(after.place().house()), ElementsAre("office_0", "hallway_0", "kitchen_0"));
  ExpectSameRooms(before, after);

  v1::SolveJob job;
  job.set_scene_seed(3);
  *job.mutable_config() = DefaultSceneConfig();
  job.mutable_config()->mutable_rigs()->set_count(1);
  *job.mutable_layout() = before;
  const absl::StatusOr<v1::SolveResult> result = Solve(job, CancelToken());
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_TRUE(result->has_scene()) << result->rejected().reason();
  EXPECT_EQ(NamesOf(result->scene().place().house()), NamesOf(after.place().house()));
}

}  // namespace
}  // namespace parallax
