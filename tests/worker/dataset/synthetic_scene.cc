#include "tests/worker/dataset/synthetic_scene.h"

#include <array>
#include <cmath>
#include <limits>

#include "common/math/sequence.h"
#include "worker/render/film/exposure.h"
#include "worker/render/truth/optical_flow.h"

namespace parallax {
namespace {

constexpr double kFloorZ = 0.0, kWallY = 5.0, kWallTop = 3.2;

struct Hit {
  double distance = std::numeric_limits<double>::infinity();
  Vec3d point = Vec3d::Zero();
  Vec3d normal = Vec3d::Zero();
  uint16_t object = 0;
  uint16_t material = 0;
};

// Balls are the objects from index 3; position and radius from the transform.
Hit Trace(const v1::Scene& scene, const Vec3d& origin, const Vec3d& direction) {
  Hit hit;
  const auto offer = [&](double distance, const Vec3d& normal, int object, int material) {
    if (distance <= 1e-6 || distance >= hit.distance) return;
    hit = {distance, origin + distance * direction, normal, static_cast<uint16_t>(object),
           static_cast<uint16_t>(material)};
  };
  if (direction.z() < 0) offer((kFloorZ - origin.z()) / direction.z(), Vec3d::UnitZ(), 1, 1);
  if (direction.y() > 0) {
    const double distance = (kWallY - origin.y()) / direction.y();
    if (origin.z() + distance * direction.z() < kWallTop) offer(distance, -Vec3d::UnitY(), 2, 2);
  }
  for (int i = 2; i < scene.objects_size(); ++i) {
    const v1::Transform& t = scene.objects(i).world_from_object();
    const Vec3d center(t.tx(), t.ty(), t.tz());
    const Vec3d offset = origin - center;
    const double b = offset.dot(direction), a = direction.squaredNorm();
    const double root = b * b - a * (offset.squaredNorm() - t.scale() * t.scale());
    if (root < 0) continue;
    const double distance = (-b - std::sqrt(root)) / a;
    const Vec3d normal = (offset + distance * direction) / t.scale();
    offer(distance, normal, static_cast<int>(scene.objects(i).index()),
          static_cast<int>(scene.objects(i).materials(0).material_index()));
  }
  return hit;
}

// Everything where it stands at that time.
v1::Scene SceneAt(const v1::Scene& scene, double time_s) {
  v1::Scene then = scene;
  for (v1::SceneObject& object : *then.mutable_objects()) {
    *object.mutable_world_from_object() = ToProto(PoseAt(object, time_s));
  }
  return then;
}

// Smooth enough that bilinear warping is exact to a step or two.
Vec3d ColorAt(const Hit& hit) {
  if (hit.object == 0) return {120, 160, 220};
  const Vec3d p = hit.point * 4;
  const double wave = 0.5 + 0.25 * (std::sin(p.x() + 0.7 * p.z()) + std::sin(0.9 * p.y() + p.z()));
  const Vec3d tint(60.0 + 37 * (hit.material * 5 % 4), 60.0 + 31 * (hit.material * 3 % 5),
                   70.0 + 29 * (hit.material * 7 % 6));
  return tint * (0.35 + 0.65 * wave);
}

View RenderEye(const v1::Scene& scene, const v1::Rig& rig, double offset_m, double baseline_m) {
  const int width = rig.width_px(), height = rig.height_px();
  View view{.color = ImageRgb8(width, height),
            .radiance = {},
            .depth_m = ImageF(width, height),
            .disparity_px = ImageF(width, height),
            .occlusion = ImageU8(width, height),
            .objects = ImageU16(width, height),
            .materials = ImageU16(width, height),
            .normals = ImageF3(width, height),
            .masks = ImageU8(width, height),
            .forward = {},
            .backward = {}};
  const Pose world_from_left = FromProto(rig.world_from_left());
  const Vec3d eye = world_from_left * Vec3d(offset_m, 0, 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Vec3d ray((x + 0.5 - rig.cx_px()) / rig.fx_px(), (y + 0.5 - rig.cy_px()) / rig.fy_px(),
                      1);
      const Hit hit = Trace(scene, eye, world_from_left.rotation * ray);
      const Vec3d color = ColorAt(hit);
      for (int c = 0; c < 3; ++c) {
        view.color(x, y, c) = static_cast<uint8_t>(std::lround(std::clamp(color[c], 0.0, 255.0)));
      }
      if (hit.object == 0) {
        view.masks(x, y) = kMaskSky;
        continue;
      }
      const auto depth = static_cast<float>(hit.distance);  // The ray has z = 1.
      view.depth_m(x, y) = depth;
      view.disparity_px(x, y) = static_cast<float>(rig.fx_px() * baseline_m) / depth;
      view.objects(x, y) = hit.object;
      view.materials(x, y) = hit.material;
      const Vec3d normal = world_from_left.rotation.conjugate() * hit.normal;
      for (int c = 0; c < 3; ++c) view.normals(x, y, c) = static_cast<float>(normal[c]);
    }
  }
  return view;
}

// `sign`: -1 from left to right, +1 from right to left.
void FillOcclusion(View& view, const View& other, int sign) {
  for (int y = 0; y < view.depth_m.height(); ++y) {
    for (int x = 0; x < view.depth_m.width(); ++x) {
      const float depth = view.depth_m(x, y);
      if (depth <= 0) continue;
      const int at = static_cast<int>(std::floor(
          static_cast<float>(x) + 0.5f + static_cast<float>(sign) * view.disparity_px(x, y)));
      const bool outside = at < 0 || at >= other.depth_m.width();
      if (outside || std::abs(other.depth_m(at, y) - depth) > 0.01f * depth) {
        view.occlusion(x, y) = 255;
      }
    }
  }
}

}  // namespace

v1::Scene MakeSyntheticScene(int rigs, int width_px, int height_px) {
  v1::Scene scene;
  scene.set_generator_version("1");
  scene.set_scene_seed(18446744073709551557u);
  scene.set_type(v1::SCENE_TYPE_INDOOR);
  scene.mutable_place()->mutable_house()->add_rooms()->set_kind("office");
  const auto add_material = [&](const std::string& name, const std::string& material_class) {
    auto* material = scene.add_materials();
    material->set_index(static_cast<uint32_t>(scene.materials_size()));
    material->set_name(name);
    material->set_material_class(material_class);
    material->set_seed(100 + material->index());
    return material->index();
  };
  const auto add_object = [&](const std::string& name, const std::string& asset_class,
                              const std::string& part) {
    auto* object = scene.add_objects();
    object->set_index(static_cast<uint32_t>(scene.objects_size()));
    object->set_name(name);
    object->set_asset_class(asset_class);
    object->set_part(part);
    object->set_seed(200 + object->index());
    object->mutable_world_from_object()->set_qw(1);
    object->mutable_world_from_object()->set_scale(1);
    return object;
  };
  add_object("floor", "Floor", "floor")
      ->add_materials()
      ->set_material_index(add_material("Tile_1", "Tile"));
  add_object("walls", "Wall", "walls")
      ->add_materials()
      ->set_material_index(add_material("Brick_2", "Brick"));
  constexpr double kBalls[][4] = {
      {-0.8, 3.0, 0.5, 0.5}, {0.5, 2.2, 0.9, 0.3}, {1.2, 4.0, 0.8, 0.8}, {-0.2, 4.2, 2.0, 0.4}};
  for (const auto& ball : kBalls) {
    const std::string number = std::to_string(scene.objects_size() + 1);
    auto* object = add_object("Ball_" + number, "Ball", "");
    object->add_materials()->set_material_index(add_material("Plastic_" + number, "Plastic"));
    object->mutable_world_from_object()->set_tx(ball[0]);
    object->mutable_world_from_object()->set_ty(ball[1]);
    object->mutable_world_from_object()->set_tz(ball[2]);
    object->mutable_world_from_object()->set_scale(ball[3]);
  }
  for (int i = 0; i < rigs; ++i) {
    auto* rig = scene.add_rigs();
    rig->set_index(static_cast<uint32_t>(i));
    // Looks along +y (camera z), x right, camera y down.
    Pose pose{.translation = {0.15 * i - 0.1, -0.3 - 0.2 * i, 1.4}};
    Eigen::Matrix3d rotation;
    rotation.col(0) = Vec3d::UnitX();
    rotation.col(1) = -Vec3d::UnitZ();
    rotation.col(2) = Vec3d::UnitY();
    pose.rotation = Eigen::Quaterniond(rotation);
    *rig->mutable_world_from_left() = ToProto(pose);
    rig->set_baseline_m(0.1 + 0.1 * i);
    rig->set_width_px(width_px);
    rig->set_height_px(height_px);
    rig->set_fx_px(0.7 * width_px);
    rig->set_fy_px(0.7 * width_px);
    rig->set_cx_px(width_px / 2.0);
    rig->set_cy_px(height_px / 2.0);
  }
  return scene;
}

void MakeSequence(v1::Scene& scene) {
  for (int i = 0; i < scene.rigs_size(); ++i) {
    scene.mutable_rigs(i)->set_path(1);
    scene.mutable_rigs(i)->set_time_s(0.1 * i);
    scene.mutable_rigs(i)->set_baseline_m(scene.rigs(0).baseline_m());
  }
  v1::RigidMotion& drift = *scene.mutable_objects(2)->mutable_motion();
  drift.mutable_velocity_mps()->set_x(0.6);
  drift.mutable_velocity_mps()->set_z(0.2);
  v1::RigidMotion& turn = *scene.mutable_objects(3)->mutable_motion();
  turn.mutable_velocity_mps()->set_y(0.5);
  turn.mutable_spin_rps()->set_z(0.4);
}

void GiveFlow(const v1::Scene& scene, const v1::Rig& rig, StereoFrame& frame) {
  const std::vector<RigPlace> places = PlacesOf(scene);
  const RigPlace& place = places[rig.index()];
  const StereoCamera now = StereoCamera::FromRig(rig).value();
  View* views[2] = {&frame.left, &frame.right};
  for (const auto maps : {&View::forward, &View::backward}) {
    const int other = maps == &View::forward ? place.next : place.previous;
    for (int eye = 0; eye < 2; ++eye) {
      FlowMaps& flow = views[eye]->*maps;
      if (other < 0) {
        FillNoFlow(now.eyes[eye], &flow);
        continue;
      }
      const v1::Rig& then = scene.rigs(other);
      const StereoCamera cameras = StereoCamera::FromRig(then).value();
      FlowTarget target{cameras.eyes[eye], cameras.eyes[eye].fx_px * then.baseline_m(), {}};
      for (const v1::SceneObject& object : scene.objects()) {
        const Pose moved = PoseAt(object, then.time_s()) * PoseAt(object, rig.time_s()).Inverse();
        target.then_from_now[object.index()] =
            Eigen::Translation3d(moved.translation) * moved.rotation;
      }
      FillFlow(*views[eye], now.eyes[eye], target, &flow);
      const v1::Scene later = SceneAt(scene, then.time_s());
      for (int y = 0; y < rig.height_px(); ++y) {
        for (int x = 0; x < rig.width_px(); ++x) {
          if (flow.occlusion(x, y) != kFlowVisible) continue;
          const PinholeCamera& camera = cameras.eyes[eye];
          const Vec3d ray = camera.DirectionAt(x + 0.5 + double{flow.flow(x, y, 0)},
                                               y + 0.5 + double{flow.flow(x, y, 1)});
          const double depth = Trace(later, camera.origin, camera.world_from_camera * ray).distance;
          const double d = double{views[eye]->disparity_px(x, y)} + double{flow.flow(x, y, 2)};
          const double own = d > 0 ? target.focal_times_baseline / d : 1e30;
          if (depth < 0.99 * own) flow.occlusion(x, y) = kFlowOccluded;
        }
      }
    }
  }
}

void GiveLight(StereoFrame& frame) {
  std::array<float, 256> light{};
  for (int level = 0; level < 256; ++level) {
    float low = 0, high = 8;  // The curve rises: halve the interval.
    for (int i = 0; i < 40; ++i) {
      const float middle = 0.5f * (low + high);
      (DisplayLevel(middle) < static_cast<float>(level) ? low : high) = middle;
    }
    light[static_cast<size_t>(level)] = low;
  }
  for (View* view : {&frame.left, &frame.right}) {
    view->radiance = ImageF3(view->color.width(), view->color.height());
    for (size_t i = 0; i < view->color.values().size(); ++i) {
      view->radiance.values()[i] = light[view->color.values()[i]] / frame.exposure;
    }
  }
}

void GiveLayers(const v1::Rig& rig, StereoFrame& frame) {
  constexpr uint16_t kWall = 2, kFirstBall = 3;
  const double focal_times_baseline = rig.fx_px() * rig.baseline_m();
  for (const std::string eye : {"left", "right"}) {
    const View& view = eye == "left" ? frame.left : frame.right;
    const int width = view.depth_m.width(), height = view.depth_m.height();
    ImageU8 count(width, height);
    ImageF depth(width, height), disparity(width, height);
    ImageU16 objects(width, height), materials(width, height);
    for (size_t i = 0; i < count.pixels(); ++i) {
      count.values()[i] = view.depth_m.values()[i] > 0 ? 1 : 0;
      if (view.objects.values()[i] < kFirstBall) continue;
      frame.clear_materials[view.materials.values()[i]] = Clearness::kThinGlass;
      count.values()[i] = 2;
      depth.values()[i] = view.depth_m.values()[i] + 0.5f;
      disparity.values()[i] = static_cast<float>(focal_times_baseline / double{depth.values()[i]});
      objects.values()[i] = materials.values()[i] = kWall;
    }
    frame.more["layers_" + eye + ".png"] = count;
    frame.more["depth2_" + eye + ".exr"] = depth;
    frame.more["disparity2_" + eye + ".exr"] = disparity;
    frame.more["objects2_" + eye + ".png"] = objects;
    frame.more["materials2_" + eye + ".png"] = materials;
  }
}

StereoFrame RenderSyntheticFrame(const v1::Scene& all, const v1::Rig& rig) {
  const v1::Scene scene = SceneAt(all, rig.time_s());
  StereoFrame frame;
  frame.left = RenderEye(scene, rig, 0, rig.baseline_m());
  frame.right = RenderEye(scene, rig, rig.baseline_m(), rig.baseline_m());
  FillOcclusion(frame.left, frame.right, -1);
  FillOcclusion(frame.right, frame.left, +1);
  frame.exposure = 0.75f;
  frame.trace_s = 0.5;
  frame.denoise_s = 0.25;
  frame.truth_s = 0.125;
  return frame;
}

}  // namespace parallax
