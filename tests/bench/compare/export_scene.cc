#include "tests/bench/compare/export_scene.h"

#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "common/math/proto.h"
#include "tests/bench/compare/plain_materials.h"
#include "worker/render/camera/camera.h"
#include "worker/render/lights/sky.h"

namespace parallax::bench {
namespace {

using Json = nlohmann::json;

template <typename Vector>
Json Numbers(const Vector& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

template <typename T>
void Put(std::ofstream& file, const std::vector<T>& values) {
  file.write(reinterpret_cast<const char*>(values.data()),
             static_cast<std::streamsize>(values.size() * sizeof(T)));
}

// All triangles of one material and one light, in the world.
struct Batch {
  std::vector<Vec3f> positions, normals;
  std::vector<uint32_t> indices;
  double area = 0;
};

struct BatchKey {
  uint32_t material = 0;
  int light = -1;
  auto operator<=>(const BatchKey&) const = default;
};

void WritePly(const std::string& path, const Batch& batch) {
  std::ofstream file(path, std::ios::binary);
  file << "ply\nformat binary_little_endian 1.0\nelement vertex " << batch.positions.size();
  for (const char* property : {"x", "y", "z", "nx", "ny", "nz"}) {
    file << "\nproperty float " << property;
  }
  file << "\nelement face " << batch.indices.size() / 3
       << "\nproperty list uchar int vertex_indices\nend_header\n";
  std::vector<Vec3f> vertices;
  for (size_t i = 0; i < batch.positions.size(); ++i) {
    vertices.push_back(batch.positions[i]);
    vertices.push_back(batch.normals[i]);
  }
  Put(file, vertices);
  std::string faces;
  for (size_t i = 0; i < batch.indices.size(); i += 3) {
    faces.push_back(3);
    faces.append(reinterpret_cast<const char*>(&batch.indices[i]), 3 * sizeof(uint32_t));
  }
  file << faces;
}

class Exporter {
 public:
  Exporter(const v1::Scene& recipe, const SceneGeometry& geometry, std::string folder)
      : recipe_(recipe), geometry_(geometry), folder_(std::move(folder)) {}

  absl::Status Write() {
    std::filesystem::create_directories(folder_);
    Materials();
    Meshes();
    Lights();
    Portals();
    RETURN_IF_ERROR(Cameras());
    std::ofstream file(folder_ + "/scene.json");
    file << json_.dump(1) << "\n";
    return file ? absl::OkStatus() : Unavailable("cannot write {}", folder_);
  }

 private:
  void Materials() {
    for (const auto& material : geometry_.materials) {
      const SurfaceSample s = PlainSurface(material.get());
      json_["materials"].push_back({{"base_color", Numbers(s.base_color)},
                                    {"metallic", s.metallic},
                                    {"roughness", s.roughness},
                                    {"specular", s.specular},
                                    {"transmission", s.transmission},
                                    {"ior", s.ior},
                                    {"thin_walled", s.thin_walled},
                                    {"clearcoat", s.clearcoat},
                                    {"clearcoat_roughness", s.clearcoat_roughness},
                                    {"sheen", s.sheen},
                                    {"subsurface", s.subsurface}});
    }
  }

  int LightOf(uint32_t object, const std::string& slot) const {
    for (int i = 0; i < recipe_.lights_size(); ++i) {
      const v1::Light& light = recipe_.lights(i);
      if (light.kind() == v1::Light::KIND_MESH && light.object_index() == object &&
          light.slot() == slot) {
        return i;
      }
    }
    return -1;
  }

  void Meshes() {
    std::map<BatchKey, Batch> batches;
    for (const PlacedMesh& placed : geometry_.meshes) {
      const Mesh& mesh = *placed.mesh;
      const Mat3f turn = placed.world_from_object.linear().inverse().transpose();
      std::map<uint32_t, std::map<uint32_t, uint32_t>> moved;  // By slot: old vertex -> new.
      for (const Triangle& t : mesh.triangles) {
        const BatchKey key{placed.material_of_slot[t.slot],
                           LightOf(placed.object_index, mesh.slots[t.slot].name)};
        Batch& batch = batches[key];
        const auto vertex = [&](uint32_t v) {
          const auto [found, fresh] =
              moved[t.slot].try_emplace(v, static_cast<uint32_t>(batch.positions.size()));
          if (fresh) {
            batch.positions.push_back(placed.world_from_object * mesh.positions[v]);
            batch.normals.push_back((turn * mesh.normals[v]).normalized());
          }
          return found->second;
        };
        const uint32_t corner[3] = {vertex(t.a), vertex(t.b), vertex(t.c)};
        const Vec3f a = batch.positions[corner[0]];
        batch.area +=
            0.5 * (batch.positions[corner[1]] - a).cross(batch.positions[corner[2]] - a).norm();
        for (const uint32_t c : corner) batch.indices.push_back(c);
      }
    }
    int index = 0;
    for (const auto& [key, batch] : batches) {
      const std::string name = "mesh_" + std::to_string(index++) + ".ply";
      WritePly(folder_ + "/" + name, batch);
      Json mesh = {{"file", name}, {"material", key.material}, {"emission", nullptr}};
      if (key.light >= 0) {
        const Vec3d power = FromProto(recipe_.lights(key.light).power_w());
        mesh["emission"] = Numbers(Vec3d(power / (M_PI * batch.area)));
      }
      json_["meshes"].push_back(mesh);
    }
  }

  void Lights() {
    json_["points"] = Json::array();
    for (const v1::Light& light : recipe_.lights()) {
      if (light.kind() != v1::Light::KIND_POINT) continue;
      json_["points"].push_back(
          {{"position", Numbers(FromProto(light.position_m()))},
           {"intensity", Numbers(Vec3d(FromProto(light.power_w()) / (4 * M_PI)))}});
    }
    const SkyModel sky(recipe_.sky());
    json_["sun"] = nullptr;
    json_["sky"] = nullptr;
    if (sky.has_sun()) {
      json_["sun"] = {{"direction", Numbers(sky.sun_direction())},
                      {"irradiance", Numbers(Vec3f(sky.SunRadiance() * sky.sun_solid_angle()))},
                      {"radius_rad", std::acos(static_cast<double>(sky.cos_sun()))}};
    }
    if (!sky.has_sky()) return;
    constexpr int kWidth = 2048, kHeight = 1024;
    std::vector<Vec3f> map;
    for (int y = 0; y < kHeight; ++y) {
      const auto theta = static_cast<float>(M_PI * (y + 0.5) / kHeight);
      for (int x = 0; x < kWidth; ++x) {
        map.push_back(sky.Radiance(
            DirectionAt(std::cos(theta), static_cast<float>(2 * M_PI * (x + 0.5) / kWidth))));
      }
    }
    std::ofstream file(folder_ + "/sky.f32", std::ios::binary);
    Put(file, map);
    json_["sky"] = {{"file", "sky.f32"}, {"width", kWidth}, {"height", kHeight}};
  }

  void Portals() {
    json_["portals"] = Json::array();
    if (!recipe_.place().has_house()) return;
    const v1::House& house = recipe_.place().house();
    const v1::Room& room = house.rooms(0);
    const double w = room.width_m(), d = room.depth_m(), h = room.height_m();
    const double t = room.wall_thickness_m();
    const auto add = [&](const Vec3d& corner, const Vec3d& u, const Vec3d& v) {
      json_["portals"].push_back(
          {{"corner", Numbers(corner)}, {"u", Numbers(u)}, {"v", Numbers(v)}});
    };
    for (const v1::Opening& opening : room.openings()) {
      if (opening.kind() != v1::Opening::KIND_WINDOW) continue;
      const double start = opening.center_m() - 0.5 * opening.width_m(), sill = opening.sill_m();
      const Vec3d x(opening.width_m(), 0, 0), y(0, opening.width_m(), 0);
      const Vec3d up(0, 0, opening.height_m());
      // u x v points into the room.
      switch (opening.wall()) {
        case 0:
          add({start, -t, sill}, up, x);
          break;
        case 1:
          add({w + t, start, sill}, up, y);
          break;
        case 2:
          add({start, d + t, sill}, x, up);
          break;
        default:
          add({-t, start, sill}, y, up);
          break;
      }
    }
    if (house.ceiling_removed()) add({0, 0, h}, {0, d, 0}, {w, 0, 0});
  }

  absl::Status Cameras() {
    for (const v1::Rig& rig : recipe_.rigs()) {
      ASSIGN_OR_RETURN(const StereoCamera stereo, StereoCamera::FromRig(rig));
      for (int eye = 0; eye < 2; ++eye) {
        const PinholeCamera& camera = stereo.eyes[eye];
        json_["cameras"].push_back({{"rig", rig.index()},
                                    {"eye", eye},
                                    {"origin", Numbers(camera.origin)},
                                    {"right", Numbers(Vec3d(camera.world_from_camera.col(0)))},
                                    {"down", Numbers(Vec3d(camera.world_from_camera.col(1)))},
                                    {"forward", Numbers(Vec3d(camera.world_from_camera.col(2)))},
                                    {"fx", camera.fx_px},
                                    {"fy", camera.fy_px},
                                    {"cx", camera.cx_px},
                                    {"cy", camera.cy_px},
                                    {"width", camera.width_px},
                                    {"height", camera.height_px}});
      }
    }
    return absl::OkStatus();
  }

  const v1::Scene& recipe_;
  const SceneGeometry& geometry_;
  const std::string folder_;
  Json json_;
};

}  // namespace

absl::Status ExportScene(const v1::Scene& recipe, const SceneGeometry& geometry,
                         const std::string& folder) {
  return Exporter(recipe, geometry, folder).Write();
}

}  // namespace parallax::bench
