// plants: things of the catalogue side by side on the ground, at eye level and at full size, under
// sun and sky; and how far the picture is from a reference.
#include <cmath>

#include "common/image/io.h"
#include "common/math/proto.h"
#include "tests/bench/render/image_error.h"
#include "tests/preview/preview.h"
#include "worker/assets/detail.h"
#include "worker/catalogue/sheet_scene.h"
#include "worker/render/film/exposure.h"
#include "worker/render/renderer.h"

namespace parallax::preview {
namespace {

constexpr double kFocalWidths = 1.3;  // Focal length over the picture's width: 42 degrees.

struct Options {
  std::string out, profile = "default", ground = "ForestFloor";
  std::vector<std::string> things;
  std::vector<double> sun = {30, 45};  // Azimuth, elevation; degrees.
  std::vector<int> size = {1280, 720};
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

absl::StatusOr<SheetRow> PlaceRow(const Options& options) {
  SceneInProgress scene;
  scene.seed = SceneSeed{5};
  SetSun(options, scene.recipe);
  double width_m = 0, height_m = 0;
  std::vector<std::shared_ptr<const Mesh>> meshes;
  for (const std::string& thing : options.things) {
    const size_t colon = thing.find(':');
    const std::string name = thing.substr(0, colon);
    const uint64_t seed = colon == std::string::npos ? 1 : std::stoull(thing.substr(colon + 1));
    ASSIGN_OR_RETURN(Asset asset,
                     MakeAsset(name, seed, static_cast<float>(1e-3 * options.edge_mm)));
    std::printf("%s: %zu triangles\n", thing.c_str(), asset.mesh.triangles.size());
    const Box3f box = asset.mesh.Bounds();
    height_m = std::max(height_m, static_cast<double>(box.max().z()));
    Pose pose;
    pose.translation.x() = width_m - static_cast<double>(box.min().x());
    width_m += 1.08 * static_cast<double>(box.sizes().x());
    *AddObject(scene.recipe, name, seed, "floating").mutable_world_from_object() = ToProto(pose);
    meshes.push_back(std::make_shared<const Mesh>(std::move(asset.mesh)));
  }
  ASSIGN_OR_RETURN(SheetRow row, DressRow(scene));
  for (size_t i = 0; i < meshes.size(); ++i) row.geometry.meshes[i].mesh = meshes[i];
  ASSIGN_OR_RETURN(const uint32_t ground, AddMaterial(row, options.ground, 3));
  const Vec3d target(0.5 * width_m, 0, 0.5 * height_m);
  AddFloor(row, ground, target, static_cast<float>(60 * std::max(width_m, height_m)));
  for (auto& material : row.geometry.materials) {
    if (options.opaque && material) material = std::make_shared<const Opaque>(material);
  }
  const int w = options.size[0], h = options.size[1];
  const double focal_px = kFocalWidths * w;
  const double distance =
      1.08 * std::max(width_m * focal_px / w, height_m * focal_px / h) / options.zoom;
  const ViewFrame view(Vec3d(0, -1, options.above));
  v1::Rig rig = view.RigAt(target - distance * view.forward, focal_px, w, h);
  rig.set_baseline_m(0.02 * distance);
  row.rigs = {rig};
  return row;
}

absl::StatusOr<StereoFrame> Draw(const SheetRow& row, const v1::RenderConfig& config) {
  ASSIGN_OR_RETURN(const auto renderer, Renderer::Create(row.recipe, row.geometry, config));
  return renderer->RenderRig(row.rigs[0], CancelToken(), {});
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
  ASSIGN_OR_RETURN(const SheetRow row, PlaceRow(options));
  v1::RenderConfig config;
  config.set_profile(options.profile);
  if (options.spp > 0) config.set_samples_per_pixel(options.spp);
  if (options.cache_off) config.set_cache(v1::RenderConfig::CACHE_OFF);
  ASSIGN_OR_RETURN(const StereoFrame frame, Draw(row, config));
  RETURN_IF_ERROR(WritePng(options.out, frame.left.color));
  std::printf("trace %.2f s, cache %.2f s, denoise %.2f s, %.1f M rays, mean radiance %.4f\n",
              frame.trace_s, frame.cache_s, frame.denoise_s, 1e-6 * static_cast<double>(frame.rays),
              MeanLuminance(frame.left.radiance));
  if (options.reference_spp <= 0) return absl::OkStatus();
  config.set_profile("reference");
  config.set_samples_per_pixel(options.reference_spp);
  config.clear_cache();
  ASSIGN_OR_RETURN(const StereoFrame reference, Draw(row, config));
  const ImageRgb8 wanted = ToSrgb(reference.left.radiance, frame.exposure);
  RETURN_IF_ERROR(WritePng(options.out + ".reference.png", wanted));
  ASSIGN_OR_RETURN(const bench::ImageError error, bench::CompareImages(frame.left.color, wanted));
  std::printf("reference: %.2f dB, FLIP %.4f, radiance %.4f of it\n", error.psnr_db, error.flip,
              MeanLuminance(frame.left.radiance) / MeanLuminance(reference.left.radiance));
  return absl::OkStatus();
}

}  // namespace

Action Plants(CLI::App& command) {
  const auto o = std::make_shared<Options>();
  command.add_option("OUT", o->out, "PNG to write")->required();
  command.add_option("THING", o->things, "CLASS or CLASS:SEED")->required();
  command.add_option("--size", o->size, "WxH")->delimiter('x')->expected(2);
  command.add_option("--profile", o->profile);
  command.add_option("--spp", o->spp);
  command.add_option("--reference-spp", o->reference_spp, "Also renders a reference; compares");
  command
      .add_option("--sun", o->sun, "Azimuth, elevation, degrees; azimuth 180: behind the things")
      ->delimiter(',')
      ->expected(2);
  command.add_option("--edge-mm", o->edge_mm, "0: the class's own detail");
  command.add_option("--zoom", o->zoom);
  command.add_option("--above", o->above, "Slope of the view downwards");
  command.add_option("--ground", o->ground, "Material");
  command.add_flag("--opaque", o->opaque, "No light comes through leaves");
  command.add_flag("--no-cache", o->cache_off);
  return [o] { return Run(*o); };
}

}  // namespace parallax::preview
