#include "worker/dataset/frame/frame_json.h"

#include "common/base/version.h"
#include "common/config/frame_maps.h"
#include "common/math/raw_rig.h"
#include "common/math/sequence.h"
#include "common/math/stereo.h"
#include "worker/scene/types/scene_types.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

Json RowsOf(const v1::Transform& transform) {
  Json rows = Json::array();
  for (const auto& row : MatrixOf(transform)) rows.push_back(row);
  return rows;
}

// Readers that keep JSON's numbers as doubles or signed integers would round or refuse a seed.
std::string SeedText(uint64_t seed) { return std::to_string(seed); }

// Trailing empty bins are left out.
Json TrimmedHistogramJson(const Histogram& histogram, const char* width_key) {
  std::vector<int64_t> counts = histogram.counts;
  while (!counts.empty() && counts.back() == 0) counts.pop_back();
  return {{width_key, histogram.bin_width}, {"counts", counts}};
}

// A camera before rectification, with its distortion in OpenCV's order.
Json RawJson(const v1::RawCamera& given) {
  const RawIntrinsics raw = FromProto(given);
  using Model = LensDistortion::Model;
  Json rows = Json::array();
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d row = raw.rectified_from_raw.row(i);
    rows.push_back({row[0], row[1], row[2]});
  }
  return {{"fx", raw.k.fx_px},
          {"fy", raw.k.fy_px},
          {"cx", raw.k.cx_px},
          {"cy", raw.k.cy_px},
          {"width", raw.width_px},
          {"height", raw.height_px},
          {"lens", raw.lens.model == Model::kNone           ? "none"
                   : raw.lens.model == Model::kBrownConrady ? "brown_conrady"
                                                            : "kannala_brandt"},
          {"distortion", std::vector<double>(given.distortion().begin(), given.distortion().end())},
          {"rectified_from_raw", rows}};
}

// The motion of a rig on its path, in the frame of its left eye: from the frame before to the one
// after, as far as there are any.
Json MotionJson(const v1::Scene& scene, const v1::Rig& rig, const RigPlace& place) {
  const v1::Rig& from = place.previous < 0 ? rig : scene.rigs(place.previous);
  const v1::Rig& to = place.next < 0 ? rig : scene.rigs(place.next);
  const double passes_s = to.time_s() - from.time_s();
  Vec3d velocity = Vec3d::Zero(), turn = Vec3d::Zero();
  if (passes_s > 0) {
    const Pose before = FromProto(from.world_from_left()), after = FromProto(to.world_from_left());
    const Eigen::Quaterniond left_from_world =
        FromProto(rig.world_from_left()).rotation.conjugate();
    const Eigen::AngleAxisd turned(after.rotation * before.rotation.conjugate());
    velocity = left_from_world * (after.translation - before.translation) / passes_s;
    turn = left_from_world * turned.axis() * (turned.angle() / passes_s);
  }
  return {{"velocity_m_s", {velocity.x(), velocity.y(), velocity.z()}},
          {"turn_rad_s", {turn.x(), turn.y(), turn.z()}}};
}

// Adds facts on the other frames of the scene: whose left eye it has, which way it belongs to,
// where things stand that move.
void AddNeighbours(const v1::Scene& scene, const v1::Rig& rig, Json* json) {
  const std::vector<RigPlace> places = PlacesOf(scene);
  for (int i = 0; i < scene.rigs_size(); ++i) {
    if (scene.rigs(i).index() != rig.index()) continue;
    const RigPlace& place = places[static_cast<size_t>(i)];
    const bool shared =
        place.left != i || (i + 1 < scene.rigs_size() && scene.rigs(i + 1).shares_left());
    if (shared) (*json)["left_rig"] = scene.rigs(place.left).index();
    if (rig.path() == 0) break;
    const auto number = [&](int other) {
      return other < 0 ? Json() : Json(scene.rigs(other).index());
    };
    (*json)["sequence"] = {{"path", rig.path()},
                           {"time_s", rig.time_s()},
                           {"previous", number(place.previous)},
                           {"next", number(place.next)}};
    (*json)["motion"] = MotionJson(scene, rig, place);
    break;
  }
  if (!HasMotion(scene)) return;
  Json moving = Json::object();
  for (const v1::SceneObject& object : scene.objects()) {
    if (!object.has_motion()) continue;
    moving[std::to_string(object.index())] = RowsOf(ToProto(PoseAt(object, rig.time_s())));
  }
  (*json)["moving"] = moving;
}

// `projector` is absent where none exists.
Json InfraredJson(const v1::Rig& rig, double exposure) {
  Json json = {{"exposure", exposure}};
  if (!rig.has_projector()) return json;
  const v1::Projector& projector = rig.projector();
  json["projector"] = {{"place_m", projector.place_m()},
                       {"power_w", projector.power_w()},
                       {"dots", projector.dots()},
                       {"horizontal_fov_rad", projector.horizontal_fov_rad()},
                       {"vertical_fov_rad", projector.vertical_fov_rad()},
                       {"dot_rad", projector.dot_rad()},
                       {"seed", SeedText(projector.seed())}};
  return json;
}

const char* ClearText(Clearness clear) {
  return clear == Clearness::kThinGlass    ? "thin_glass"
         : clear == Clearness::kSolidGlass ? "solid_glass"
                                           : "water";
}

// The inner spaces of the place: which layers are exterior.
Json LayersJson(const StereoFrame& frame) {
  Json interiors = Json::array();
  for (const Box3f& box : frame.interiors) {
    interiors.push_back({{box.min().x(), box.min().y(), box.min().z()},
                         {box.max().x(), box.max().y(), box.max().z()}});
  }
  return {{"interiors_m", interiors}};
}

}  // namespace

std::string FrameJsonText(const Json& json) {
  std::string text = "{\n";
  bool first = true;
  for (const auto& [key, value] : json.items()) {
    text += (first ? "" : ",\n") + Json(key).dump() + ": ";
    first = false;
    if ((key != "objects" && key != "materials") || value.empty()) {
      text += value.dump();
      continue;
    }
    text += "{";
    bool first_entry = true;
    for (const auto& [index, entry] : value.items()) {
      text += (first_entry ? "\n  " : ",\n  ") + Json(index).dump() + ": " + entry.dump();
      first_entry = false;
    }
    text += "\n}";
  }
  return text + "\n}\n";
}

std::array<std::array<double, 4>, 4> MatrixOf(const v1::Transform& transform) {
  const Pose pose = FromProto(transform);
  const Eigen::Matrix3d rotation = pose.scale * pose.rotation.toRotationMatrix();
  std::array<std::array<double, 4>, 4> rows{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      rows[static_cast<size_t>(i)][static_cast<size_t>(j)] = rotation(i, j);
    rows[static_cast<size_t>(i)][3] = pose.translation[i];
  }
  rows[3][3] = 1;
  return rows;
}

absl::StatusOr<std::string> FrameJson(const v1::Scene& scene, const v1::Rig& rig,
                                      const StereoFrame& frame, const FrameStatistics& statistics,
                                      const v1::RenderConfig& render) {
  ASSIGN_OR_RETURN(const SceneType* type, TypeOf(scene));
  Json json;
  json["intrinsics"] = {{"fx", rig.fx_px()},       {"fy", rig.fy_px()},
                        {"cx", rig.cx_px()},       {"cy", rig.cy_px()},
                        {"width", rig.width_px()}, {"height", rig.height_px()}};
  json["baseline_m"] = rig.baseline_m();
  json["world_from_left"] = RowsOf(rig.world_from_left());
  json["world_from_right"] = RowsOf(ToProto(WorldFromEye(rig, 1)));
  if (HasMap(render, "raw")) {
    json["raw"] = {{"left", RawJson(rig.raw_left())}, {"right", RawJson(rig.raw_right())}};
  }
  AddNeighbours(scene, rig, &json);
  json["near_m"] = statistics.min_depth_m;
  json["far_m"] = statistics.max_depth_m;
  json["exposure"] = double{frame.exposure};
  if (HasMap(render, "infrared")) {
    json["infrared"] = InfraredJson(rig, double{frame.infrared_exposure});
  }
  if (HasMap(render, "layers")) json["layers"] = LayersJson(frame);
  json["rig"] = rig.index();
  json["room"] = type->describe(scene).kind;
  json["seeds"] = {{"scene", SeedText(scene.scene_seed())}};
  json["versions"] = {{"generator", scene.generator_version()},
                      {"program", kProgramVersion},
                      {"layout", scene.layout_version()},
                      {"scene", scene.generator_version()},
                      {"frame", kFrameVersion}};
  json["maps"] = std::vector<std::string>(render.maps().begin(), render.maps().end());

  Json objects = Json::object(), materials = Json::object();
  const auto list = [&](const v1::SceneObject& object) {
    objects[std::to_string(object.index())] = {
        {"class", ClassOf(object)}, {"name", object.name()}, {"seed", SeedText(object.seed())}};
  };
  for (const v1::SceneObject& object : scene.objects()) list(object);
  // Landscapes have thousands: those that are seen.
  for (const uint32_t index : statistics.objects_seen) {
    if (!type->grown) break;
    if (const auto object = type->grown(scene, index)) list(*object);
  }
  for (const v1::SceneMaterial& material : scene.materials()) {
    Json& entry = materials[std::to_string(material.index())];
    entry = {{"class", material.material_class()},
             {"name", material.name()},
             {"seed", SeedText(material.seed())}};
    const auto clear = frame.clear_materials.find(material.index());
    if (clear != frame.clear_materials.end()) entry["clear"] = ClearText(clear->second);
  }
  json["objects"] = objects;
  json["materials"] = materials;

  json["statistics"] = StatisticsByName(statistics);
  json["object_pixels"] = statistics.object_pixels;
  json["material_pixels"] = statistics.material_pixels;
  json["disparity_histogram"] = TrimmedHistogramJson(statistics.disparity, "bin_px");
  json["depth_histogram"] = TrimmedHistogramJson(statistics.depth, "bin_m");
  return FrameJsonText(json);
}

}  // namespace parallax
