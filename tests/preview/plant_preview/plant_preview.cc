// Renders things of the catalogue side by side on the ground, at eye level and at full size, under
// sun and sky; says how far the picture is from a reference.
//   plant_preview OUT.png CLASS[:SEED]... [--size 1280x720] [--spp 16] [--profile default]
//     [--sun 30,45] [--edge-mm 0] [--opaque] [--reference-spp N] [--ground ForestFloor]
// The sun's azimuth is in degrees from behind the camera: 0 lights the plants' near side, 180 is
// behind them.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>

#include "common/base/status.h"
#include "common/image/io.h"
#include "common/math/proto.h"
#include "tests/bench/render/image_error.h"
#include "worker/assets/detail.h"
#include "worker/render/film/exposure.h"
#include "worker/render/renderer.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/choose_materials.h"

namespace parallax {
namespace {

constexpr double kFocalWidths = 1.3;  // Focal length over the picture's width: 42 degrees.

struct Options {
  std::string out, profile = "default", size = "1280x720", ground = "ForestFloor";
  std::vector<std::string> things;
  std::vector<double> sun = {30, 45};  // Azimuth, elevation; degrees.
  int spp = 0, reference_spp = 0;
  double edge_mm = 0, zoom = 1, above = 0.2;
  bool opaque = false, cache_off = false;
};

// A leaf as it was before light came through.
class Opaque final : public Material {
 public:
  explicit Opaque(std::shared_ptr<const Material> all) : all_(std::move(all)) {}
  SurfaceSample8 Evaluate(const SurfacePoint8& points) const override {
    SurfaceSample8 sample = all_->Evaluate(points);
    sample.transmitted_color = Vec3x8::Zero();
    return sample;
  }
  Float8 Height(const SurfacePoint8& points) const override { return all_->Height(points); }
  Dual8 Relief(const SurfacePoint8& points, const Tangents8& tangents) const override {
    return all_->Relief(points, tangents);
  }

 private:
  std::shared_ptr<const Material> all_;
};

struct Row {
  v1::Scene recipe;
  SceneGeometry geometry;
  double width_m = 0, height_m = 0;
};

void SetSun(const Options& options, v1::Scene& recipe) {
  recipe.set_type(v1::SCENE_TYPE_DENSE);
  recipe.mutable_place()->mutable_open_sky();
  v1::Sky& sky = *recipe.mutable_sky();
  sky.set_strength(1);
  *sky.mutable_tint() = ToProto(Vec3d(1, 1, 1));
  // The camera looks along +y.
  sky.set_sun_azimuth_rad((options.sun[0] - 90) * M_PI / 180);
  sky.set_sun_elevation_rad(options.sun[1] * M_PI / 180);
  sky.set_sun_strength(1);
}

absl::Status AddGround(const Options& options, Row& row) {
  ASSIGN_OR_RETURN(auto material, MakeMaterial(options.ground, 3));
  row.geometry.materials.push_back(std::move(material));
  Mesh ground;
  ground.slots.push_back({"ground", {}, false});
  const auto far = static_cast<float>(60 * std::max(row.width_m, row.height_m));
  for (const Vec2f& c : {Vec2f(-1, -1), Vec2f(1, -1), Vec2f(1, 1), Vec2f(-1, 1)}) {
    const Vec3f p(far * c.x(), far * c.y(), 0);
    ground.positions.push_back(p);
    ground.normals.push_back(Vec3f::UnitZ());
    ground.texture.push_back(p);
    ground.uv.push_back(Vec2f::Zero());
  }
  ground.triangles = {{0, 1, 2, 0}, {0, 2, 3, 0}};
  v1::SceneObject& object = *row.recipe.add_objects();
  object.set_index(static_cast<uint32_t>(row.recipe.objects_size()));
  PlacedMesh placed;
  placed.mesh = std::make_shared<const Mesh>(std::move(ground));
  placed.material_of_slot = {static_cast<uint32_t>(row.geometry.materials.size() - 1)};
  placed.object_index = object.index();
  row.geometry.meshes.push_back(std::move(placed));
  return absl::OkStatus();
}

absl::StatusOr<Row> PlaceRow(const Options& options) {
  SceneInProgress scene;
  scene.seed = SceneSeed{5};
  SetSun(options, scene.recipe);
  Row row;
  std::vector<std::shared_ptr<const Mesh>> meshes;
  for (const std::string& thing : options.things) {
    const size_t colon = thing.find(':');
    const std::string name = thing.substr(0, colon);
    const uint64_t seed = colon == std::string::npos ? 1 : std::stoull(thing.substr(colon + 1));
    ASSIGN_OR_RETURN(Asset asset,
                     MakeAsset(name, seed, static_cast<float>(1e-3 * options.edge_mm)));
    std::printf("%s: %zu triangles\n", thing.c_str(), asset.mesh.triangles.size());
    const Box3f box = asset.mesh.Bounds();
    row.height_m = std::max(row.height_m, static_cast<double>(box.max().z()));
    v1::SceneObject& object = *scene.recipe.add_objects();
    object.set_index(static_cast<uint32_t>(scene.recipe.objects_size()));
    object.set_name(thing);
    object.set_asset_class(name);
    object.set_seed(seed);
    object.set_role(v1::OBJECT_ROLE_FLOATING);
    object.set_relation("floating");
    Pose pose;
    pose.translation.x() = row.width_m - static_cast<double>(box.min().x());
    row.width_m += 1.08 * static_cast<double>(box.sizes().x());
    *object.mutable_world_from_object() = ToProto(pose);
    meshes.push_back(std::make_shared<const Mesh>(std::move(asset.mesh)));
  }
  v1::MaterialConfig materials;
  materials.set_mode(v1::MaterialConfig::MODE_ALL);
  materials.set_replace_probability(0);
  RETURN_IF_ERROR(ChooseMaterials(materials, nullptr, scene));
  row.recipe = scene.recipe;
  ASSIGN_OR_RETURN(row.geometry, BuildSceneGeometry(row.recipe));
  for (size_t i = 0; i < meshes.size(); ++i) row.geometry.meshes[i].mesh = meshes[i];
  RETURN_IF_ERROR(AddGround(options, row));
  for (auto& material : row.geometry.materials) {
    if (options.opaque && material) material = std::make_shared<const Opaque>(material);
  }
  return row;
}

absl::StatusOr<v1::Rig> LookAt(const Options& options, const Row& row) {
  int width = 0, height = 0;
  if (std::sscanf(options.size.c_str(), "%dx%d", &width, &height) != 2) {
    return InvalidArgument("--size: WxH");
  }
  const double fx = kFocalWidths * width;
  const double fits = std::max(row.width_m * fx / width, row.height_m * fx / height) * 1.08;
  const double distance = fits / options.zoom;
  const Vec3d target(0.5 * row.width_m, 0, 0.5 * row.height_m);
  const Vec3d forward = Vec3d(0, 1, -options.above).normalized(), right = Vec3d::UnitX();
  Eigen::Matrix3d world_from_camera;
  world_from_camera << right, -right.cross(forward), forward;
  Pose pose;
  pose.translation = target - distance * forward;
  pose.rotation = Eigen::Quaterniond(world_from_camera);
  v1::Rig rig;
  *rig.mutable_world_from_left() = ToProto(pose);
  rig.set_baseline_m(0.02 * distance);
  rig.set_fx_px(fx);
  rig.set_fy_px(fx);
  rig.set_cx_px(0.5 * width);
  rig.set_cy_px(0.5 * height);
  rig.set_width_px(width);
  rig.set_height_px(height);
  return rig;
}

absl::StatusOr<StereoFrame> Render(const Row& row, const v1::RenderConfig& config) {
  ASSIGN_OR_RETURN(const auto renderer, Renderer::Create(row.recipe, row.geometry, config));
  return renderer->RenderRig(row.recipe.rigs(0), CancelToken(), {});
}

double MeanLuminance(const ImageF3& radiance) {
  double sum = 0;
  const auto& values = radiance.values();
  for (size_t i = 0; i + 2 < values.size(); i += 3) {
    sum += 0.2126 * static_cast<double>(values[i]) + 0.7152 * static_cast<double>(values[i + 1]) +
           0.0722 * static_cast<double>(values[i + 2]);
  }
  return sum / static_cast<double>(values.size() / 3);
}

absl::Status Run(const Options& options) {
  ASSIGN_OR_RETURN(Row row, PlaceRow(options));
  ASSIGN_OR_RETURN(*row.recipe.add_rigs(), LookAt(options, row));
  v1::RenderConfig config;
  config.set_profile(options.profile);
  if (options.spp > 0) config.set_samples_per_pixel(options.spp);
  if (options.cache_off) config.set_cache(v1::RenderConfig::CACHE_OFF);
  ASSIGN_OR_RETURN(const StereoFrame frame, Render(row, config));
  RETURN_IF_ERROR(WritePng(options.out, frame.left.color));
  std::printf("trace %.2f s, cache %.2f s, denoise %.2f s, %.1f M rays, mean radiance %.4f\n",
              frame.trace_s, frame.cache_s, frame.denoise_s, 1e-6 * static_cast<double>(frame.rays),
              MeanLuminance(frame.left.radiance));
  if (options.reference_spp <= 0) return absl::OkStatus();
  config.set_profile("reference");
  config.set_samples_per_pixel(options.reference_spp);
  config.clear_cache();
  ASSIGN_OR_RETURN(const StereoFrame reference, Render(row, config));
  const ImageRgb8 wanted = ToSrgb(reference.left.radiance, frame.exposure);
  RETURN_IF_ERROR(WritePng(options.out + ".reference.png", wanted));
  ASSIGN_OR_RETURN(const bench::ImageError error, bench::CompareImages(frame.left.color, wanted));
  std::printf("reference: %.2f dB, FLIP %.4f, radiance %.4f of it\n", error.psnr_db, error.flip,
              MeanLuminance(frame.left.radiance) / MeanLuminance(reference.left.radiance));
  return absl::OkStatus();
}

int Main(int argc, char** argv) {
  CLI::App app("Plants as the renderer shows them");
  Options o;
  app.add_option("OUT", o.out)->required();
  app.add_option("THING", o.things)->required();
  app.add_option("--size", o.size);
  app.add_option("--profile", o.profile);
  app.add_option("--spp", o.spp);
  app.add_option("--reference-spp", o.reference_spp);
  app.add_option("--sun", o.sun)->delimiter(',')->expected(2);
  app.add_option("--edge-mm", o.edge_mm);
  app.add_option("--zoom", o.zoom);
  app.add_option("--above", o.above, "Slope of the view downwards");
  app.add_option("--ground", o.ground);
  app.add_flag("--opaque", o.opaque);
  app.add_flag("--no-cache", o.cache_off);
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = Run(o);
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return status.ok() ? 0 : 1;
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) { return parallax::Main(argc, argv); }
