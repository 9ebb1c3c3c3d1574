#include "tests/worker/render/test_scenes.h"

#include <cmath>

#include "common/math/proto.h"

namespace parallax::test {

SurfaceSample DiffuseSample(const Vec3f& color) {
  SurfaceSample s;
  s.base_color = color;
  s.specular = 0;
  s.roughness = 1;
  return s;
}

SurfaceSample CancellingMaterial::EvaluatePoint(const SurfacePoint& /*point*/) const {
  if (--left_ == 0) {
    asked_ = Clock::System().Steady();
    cancel_.Cancel();
  }
  return DiffuseSample(Vec3f::Constant(0.5f));
}

uint32_t TestScene::AddMaterial(std::shared_ptr<const Material> material) {
  geometry.materials.push_back(std::move(material));
  return static_cast<uint32_t>(geometry.materials.size() - 1);
}

uint32_t TestScene::AddMesh(std::shared_ptr<const Mesh> mesh, uint32_t material,
                            const Eigen::Affine3f& world_from_object) {
  PlacedMesh placed;
  placed.mesh = std::move(mesh);
  placed.world_from_object = world_from_object;
  placed.object_index = static_cast<uint32_t>(geometry.meshes.size() + 1);
  placed.material_of_slot.assign(placed.mesh->slots.size(), material);
  geometry.meshes.push_back(placed);
  v1::SceneObject* object = recipe.add_objects();
  object->set_index(placed.object_index);
  return placed.object_index;
}

void TestScene::AddPointLight(const Vec3d& position, double radius_m, double power_w) {
  v1::Light* light = recipe.add_lights();
  light->set_kind(v1::Light::KIND_POINT);
  *light->mutable_position_m() = ToProto(position);
  light->set_radius_m(radius_m);
  *light->mutable_power_w() = ToProto(Vec3d::Constant(power_w));
}

void TestScene::AddMeshLight(uint32_t object, double power_w) {
  v1::Light* light = recipe.add_lights();
  light->set_kind(v1::Light::KIND_MESH);
  light->set_object_index(object);
  light->set_slot("surface");
  *light->mutable_power_w() = ToProto(Vec3d::Constant(power_w));
}

std::vector<bool> MoversOfEvery(int every, const TestScene& test) {
  std::vector<bool> movers;
  for (size_t i = 0; every > 0 && i < test.geometry.meshes.size(); ++i) {
    movers.push_back(i % static_cast<size_t>(every) == 0);
  }
  return movers;
}

namespace {

void AddQuad(Mesh* mesh, const Vec3f& corner, const Vec3f& u, const Vec3f& v) {
  const auto first = static_cast<uint32_t>(mesh->positions.size());
  const Vec3f normal = u.cross(v).normalized();
  const float su = u.norm(), sv = v.norm();
  const Vec2f at[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (const Vec2f& p : at) {
    mesh->positions.push_back(corner + p.x() * u + p.y() * v);
    mesh->normals.push_back(normal);
    mesh->texture.push_back(Vec3f(p.x() * su, p.y() * sv, 0));
    mesh->uv.push_back(p);
  }
  mesh->triangles.push_back({first, first + 1, first + 2, 0});
  mesh->triangles.push_back({first, first + 2, first + 3, 0});
}

Mesh OneSlotMesh() {
  Mesh mesh;
  mesh.slots.push_back({"surface", {}, false});
  return mesh;
}

}  // namespace

std::shared_ptr<const Mesh> MakeQuad(const Vec3f& corner, const Vec3f& u, const Vec3f& v) {
  auto mesh = std::make_shared<Mesh>(OneSlotMesh());
  AddQuad(mesh.get(), corner, u, v);
  return mesh;
}

std::shared_ptr<const Mesh> MakeSphere(const Vec3f& center, float radius, int rings) {
  auto mesh = std::make_shared<Mesh>(OneSlotMesh());
  const int segments = 2 * rings;
  for (int r = 0; r <= rings; ++r) {
    const double theta = M_PI * r / rings;
    for (int s = 0; s < segments; ++s) {
      const double phi = 2 * M_PI * s / segments;
      const Vec3f n =
          Vec3d(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta))
              .cast<float>();
      mesh->positions.push_back(center + radius * n);
      mesh->normals.push_back(n.normalized());
      mesh->texture.push_back(radius * n);
      mesh->uv.push_back(Vec2f::Zero());
    }
  }
  const auto at = [&](int r, int s) { return static_cast<uint32_t>(r * segments + s % segments); };
  for (int r = 0; r < rings; ++r) {
    for (int s = 0; s < segments; ++s) {
      if (r > 0) mesh->triangles.push_back({at(r, s), at(r + 1, s), at(r, s + 1), 0});
      if (r + 1 < rings)
        mesh->triangles.push_back({at(r, s + 1), at(r + 1, s), at(r + 1, s + 1), 0});
    }
  }
  return mesh;
}

std::shared_ptr<const Mesh> MakeBox(const Vec3f& low, const Vec3f& high, bool inwards) {
  auto mesh = std::make_shared<Mesh>(OneSlotMesh());
  const Vec3f d = high - low;
  const Vec3f x(d.x(), 0, 0), y(0, d.y(), 0), z(0, 0, d.z());
  const auto face = [&](const Vec3f& corner, const Vec3f& u, const Vec3f& v) {
    inwards ? AddQuad(mesh.get(), corner, v, u) : AddQuad(mesh.get(), corner, u, v);
  };
  face(low, y, x);
  face(low + z, x, y);
  face(low, x, z);
  face(low + y, z, x);
  face(low, z, y);
  face(low + x, y, z);
  return mesh;
}

v1::Rig MakeRig(const Vec3d& position, const Vec3d& forward, int width_px, int height_px,
                double focal_px, double baseline_m) {
  const Vec3d z = forward.normalized();
  const Vec3d x = z.cross(Vec3d::UnitZ()).normalized();
  Eigen::Matrix3d world_from_camera;
  world_from_camera << x, z.cross(x), z;
  Pose pose;
  pose.translation = position;
  pose.rotation = Eigen::Quaterniond(world_from_camera);
  v1::Rig rig;
  *rig.mutable_world_from_left() = ToProto(pose);
  rig.set_baseline_m(baseline_m);
  rig.set_fx_px(focal_px);
  rig.set_fy_px(focal_px);
  rig.set_cx_px(0.5 * width_px);
  rig.set_cy_px(0.5 * height_px);
  rig.set_width_px(width_px);
  rig.set_height_px(height_px);
  return rig;
}

TestScene MakeFloor(float albedo) {
  TestScene test;
  const uint32_t grey = test.AddMaterial(DiffuseSample(Vec3f::Constant(albedo)));
  test.AddMesh(MakeQuad({-5, -5, 0}, {10, 0, 0}, {0, 10, 0}), grey);
  return test;
}

TestScene MakeBoxRoom() {
  TestScene scene;
  const uint32_t white = scene.AddMaterial(DiffuseSample({0.75f, 0.75f, 0.72f}));
  const uint32_t red = scene.AddMaterial(DiffuseSample({0.6f, 0.12f, 0.1f}));
  const uint32_t green = scene.AddMaterial(DiffuseSample({0.15f, 0.5f, 0.15f}));
  const uint32_t blue = scene.AddMaterial(DiffuseSample({0.2f, 0.3f, 0.7f}));
  scene.AddMesh(MakeQuad({0, 0, 0}, {4, 0, 0}, {0, 4, 0}), white);
  scene.AddMesh(MakeQuad({0, 0, 3}, {0, 4, 0}, {4, 0, 0}), white);
  scene.AddMesh(MakeQuad({0, 4, 0}, {4, 0, 0}, {0, 0, 3}), white);
  scene.AddMesh(MakeQuad({0, 0, 0}, {0, 0, 3}, {4, 0, 0}), white);
  scene.AddMesh(MakeQuad({0, 0, 0}, {0, 4, 0}, {0, 0, 3}), red);
  scene.AddMesh(MakeQuad({4, 0, 0}, {0, 0, 3}, {0, 4, 0}), green);
  scene.AddMesh(MakeBox({0.6f, 2.4f, 0}, {1.6f, 3.4f, 1.6f}), white);
  scene.AddMesh(MakeBox({2.4f, 1.6f, 0}, {3.2f, 2.4f, 0.8f}), blue);
  scene.AddMesh(MakeSphere({2.8f, 2.0f, 1.1f}, 0.3f), red);
  const uint32_t lamp = scene.AddMesh(MakeQuad({1.5f, 1.5f, 2.98f}, {0, 1, 0}, {1, 0, 0}), white);
  scene.AddMeshLight(lamp, 100);
  return scene;
}

v1::Rig BoxRoomRig(int width_px, int height_px) {
  return MakeRig({2, 0.3, 1.5}, {0, 1, -0.1}, width_px, height_px, 0.6 * width_px, 0.2);
}

v1::RenderConfig MakeConfig(int samples, int bounces, bool denoise, const std::string& profile) {
  v1::RenderConfig config;
  config.set_profile(profile);
  config.set_samples_per_pixel(samples);
  config.set_max_bounces(bounces);
  config.set_denoise(denoise ? v1::RenderConfig::DENOISE_ON : v1::RenderConfig::DENOISE_OFF);
  return config;
}

double MeanSquare(const ImageRgb8& a, const ImageRgb8& b) {
  double sum = 0;
  for (size_t i = 0; i < a.values().size(); ++i) {
    const double d = double{1} * a.values()[i] - b.values()[i];
    sum += d * d;
  }
  return sum / static_cast<double>(a.values().size());
}

}  // namespace parallax::test
