#include "tests/bench/render/demo_room.h"

#include <cmath>

#include "common/base/rng.h"
#include "common/math/proto.h"
#include "worker/assets/asset.h"
#include "worker/scene/types/indoor/house.h"

namespace parallax::bench {
namespace {

using test::MakeBox;
using test::MakeSphere;
using test::TestScene;

class RoomMaker {
 public:
  explicit RoomMaker(uint64_t seed) : rng_(SceneSeed{seed}, "demo") {}

  TestScene Make() {
    Walls();
    Furniture();
    Lamps();
    return std::move(room_);
  }

 private:
  uint32_t MaterialOf(const std::string& class_name) {
    auto made = MakeMaterial(class_name, rng_.Seed());
    return made.ok() ? room_.AddMaterial(std::shared_ptr<const Material>(*std::move(made))) : 0;
  }
  uint32_t AnyMaterial() {
    while (true) {
      const MaterialClass& choice = rng_.Pick(MaterialCatalogue());
      if (choice.tags.any_object && !choice.tags.needs_uv) return MaterialOf(choice.name);
    }
  }

  void Walls() {
    const float w = 5, d = 4.5f, h = 2.7f, t = 0.2f;
    const uint32_t paint = MaterialOf("WallPaint");
    const auto wall = [&](const Vec3f& low, const Vec3f& high) {
      room_.AddMesh(MakeBox(low, high), paint);
    };
    room_.AddMesh(MakeBox({-t, -t, -t}, {w + t, d + t, 0}), MaterialOf("WoodPlanks"));
    room_.AddMesh(MakeBox({-t, -t, h}, {w + t, d + t, h + t}), MaterialOf("CeilingPaint"));
    wall({-t, -t, 0}, {w + t, 0, h});
    wall({-t, d, 0}, {w + t, d + t, h});
    wall({-t, 0, 0}, {0, d, h});
    // East, with a window.
    const float y0 = 1.2f, y1 = 3.0f, z0 = 0.9f, z1 = 2.2f;
    wall({w, 0, 0}, {w + t, y0, h});
    wall({w, y1, 0}, {w + t, d, h});
    wall({w, y0, 0}, {w + t, y1, z0});
    wall({w, y0, z1}, {w + t, y1, h});
    v1::Room* room = room_.recipe.mutable_place()->mutable_house()->add_rooms();
    room->set_width_m(w);
    room->set_depth_m(d);
    room->set_height_m(h);
    room->set_wall_thickness_m(t);
    v1::Opening* opening = room->add_openings();
    opening->set_kind(v1::Opening::KIND_WINDOW);
    opening->set_wall(1);
    opening->set_center_m((y0 + y1) / 2);
    opening->set_width_m(y1 - y0);
    opening->set_sill_m(z0);
    opening->set_height_m(z1 - z0);
    room_.geometry.surroundings = HouseSurroundings(room_.recipe.place());
    v1::Sky* sky = room_.recipe.mutable_sky();
    sky->set_strength(1);
    *sky->mutable_tint() = ToProto(Vec3d::Ones());
    sky->set_sun_strength(0.6);
    sky->set_sun_elevation_rad(0.6);
    sky->set_sun_azimuth_rad(0.5);
  }

  void Furniture() {
    std::vector<AssetClass> indoors = AssetCatalogue();
    std::erase_if(indoors, [](const AssetClass& c) { return c.placement == Placement::kGround; });
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        Eigen::Affine3f place = Eigen::Affine3f::Identity();
        place.translate(Vec3f(0.7f + 1.15f * static_cast<float>(column),
                              1.4f + 1.1f * static_cast<float>(row), 0));
        place.rotate(Eigen::AngleAxisf(static_cast<float>(rng_.Uniform(0, 6.28)), Vec3f::UnitZ()));
        const int kind = rng_.UniformInt(0, 3);
        if (kind <= 1) {
          const AssetClass& choice = rng_.Pick(indoors);
          auto asset = MakeAsset(choice.name, rng_.Seed());
          if (!asset.ok()) continue;
          auto mesh = std::make_shared<Mesh>(std::move(asset->mesh));
          const uint32_t object = room_.AddMesh(mesh, 0, place);
          for (uint32_t& m : room_.geometry.meshes[object - 1].material_of_slot) m = AnyMaterial();
        } else if (kind == 2) {
          room_.AddMesh(MakeBox({-0.3f, -0.3f, 0}, {0.3f, 0.3f, 0.6f}), AnyMaterial(), place);
        } else {
          room_.AddMesh(MakeSphere({0, 0, 0.35f}, 0.35f), AnyMaterial(), place);
        }
        // Something that floats above.
        place.translate(Vec3f(0.2f, 0.1f, static_cast<float>(rng_.Uniform(1.2, 2.0))));
        if (rng_.Bernoulli(0.4))
          room_.AddMesh(MakeSphere(Vec3f::Zero(), 0.22f), AnyMaterial(), place);
      }
    }
  }

  void Lamps() {
    const uint32_t bulb = MaterialOf("LampBulb");
    for (const double x : {1.5, 3.5}) {
      const uint32_t lamp =
          room_.AddMesh(MakeSphere(Vec3d(x, 2.2, 2.45).cast<float>(), 0.09f, 12), bulb);
      room_.AddMeshLight(lamp, 60);
    }
    room_.AddPointLight({0.5, 0.6, 2.0}, 0.06, 120);
  }

  Rng rng_;
  TestScene room_;
};

}  // namespace

test::TestScene MakeDemoRoom(uint64_t seed) {
  TestScene room = RoomMaker(seed).Make();
  room.recipe.set_scene_seed(seed);
  const auto add = [&](const Vec3d& position, const Vec3d& forward) {
    v1::Rig rig = test::MakeRig(position, forward, 1280, 720, 800, 0.15);
    rig.set_index(static_cast<uint32_t>(room.recipe.rigs_size()));
    *room.recipe.add_rigs() = rig;
  };
  add({0.5, 0.3, 1.5}, {0.7, 1, -0.2});
  add({4.6, 0.3, 1.6}, {-0.7, 1, -0.3});
  add({0.3, 2.2, 1.4}, {1, 0.05, -0.15});
  return room;
}

}  // namespace parallax::bench
