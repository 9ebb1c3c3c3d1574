#include "tests/bench/compare/plain_materials.h"

#include <cmath>
#include <map>

#include "tests/worker/render/test_scenes.h"

namespace parallax::bench {
namespace {

constexpr size_t kPoints = 256;  // Points of a material that its constant averages.

struct Sum {
  SurfaceSample total;
  int count = 0, thin = 0;

  Sum() {
    total.base_color.setZero();
    total.metallic = total.roughness = total.specular = total.transmission = total.ior = 0;
    total.clearcoat = total.clearcoat_roughness = total.sheen = total.subsurface = 0;
  }
  void Add(const SurfaceSample& s) {
    total.base_color += s.base_color;
    total.emission += s.emission;
    total.metallic += s.metallic;
    total.roughness += s.roughness;
    total.specular += s.specular;
    total.transmission += s.transmission;
    total.ior += s.ior;
    total.clearcoat += s.clearcoat;
    total.clearcoat_roughness += s.clearcoat_roughness;
    total.sheen += s.sheen;
    total.subsurface += s.subsurface;
    thin += s.thin_walled;
    ++count;
  }
  SurfaceSample Mean() const {
    SurfaceSample s = total;
    const float scale = 1.0f / static_cast<float>(std::max(count, 1));
    s.base_color *= scale;
    s.emission *= scale;
    for (float* value : {&s.metallic, &s.roughness, &s.specular, &s.transmission, &s.ior,
                         &s.clearcoat, &s.clearcoat_roughness, &s.sheen, &s.subsurface}) {
      *value *= scale;
    }
    s.thin_walled = 2 * thin > count;
    return s;
  }
};

SurfaceSample Shared(const SurfaceSample& s, bool only_lambert) {
  SurfaceSample plain = test::DiffuseSample(s.base_color);
  if (s.metallic > 0.5f && !only_lambert) {
    // Smoother ones throw caustics that thousands of samples don't settle.
    plain.base_color.setOnes();
    plain.metallic = 1;
    plain.roughness = std::clamp(s.roughness, 0.2f, 0.31f);
  } else if (s.transmission > 0.5f && (s.thin_walled || !only_lambert)) {
    plain.base_color.setOnes();
    plain.transmission = 1;
    plain.roughness = 0;
    plain.ior = 1.5f;
    plain.thin_walled = s.thin_walled;
  }
  return plain;
}

Mesh WithFlatFaces(const Mesh& mesh) {
  Mesh flat;
  flat.slots = mesh.slots;
  for (const Triangle& t : mesh.triangles) {
    const uint32_t corners[3] = {t.a, t.b, t.c};
    const auto first = static_cast<uint32_t>(flat.positions.size());
    const Vec3f cross = (mesh.positions[t.b] - mesh.positions[t.a])
                            .cross(mesh.positions[t.c] - mesh.positions[t.a]);
    const float length = cross.norm();
    for (const uint32_t v : corners) {
      flat.positions.push_back(mesh.positions[v]);
      flat.normals.push_back(length > 0.0f ? Vec3f(cross / length) : mesh.normals[v]);
      flat.texture.push_back(mesh.texture[v]);
      flat.uv.push_back(mesh.uv[v]);
    }
    flat.triangles.push_back({first, first + 1, first + 2, t.slot});
  }
  return flat;
}

}  // namespace

absl::StatusOr<Flavour> ParseFlavour(const std::string& name) {
  if (name == "principled") return Flavour::kPrincipled;
  if (name == "shared") return Flavour::kShared;
  if (name == "lambert") return Flavour::kLambert;
  return InvalidArgument("flavour \"{}\"; allowed: principled, shared, lambert", name);
}

void MakePlain(Flavour flavour, SceneGeometry* geometry) {
  std::map<uint32_t, Sum> sums;
  for (const PlacedMesh& placed : geometry->meshes) {
    const Mesh& mesh = *placed.mesh;
    const size_t stride = std::max<size_t>(1, mesh.triangles.size() / kPoints);
    for (size_t t = 0; t < mesh.triangles.size(); t += stride) {
      const Triangle& triangle = mesh.triangles[t];
      if (triangle.slot >= placed.material_of_slot.size()) continue;
      const uint32_t index = placed.material_of_slot[triangle.slot];
      const Material* material = geometry->materials[index].get();
      if (!material) continue;
      SurfacePoint point;
      point.texture_m = mesh.texture[triangle.a];
      point.normal = mesh.normals[triangle.a];
      point.uv = mesh.uv[triangle.a];
      point.footprint_m = 0.02f;
      sums[index].Add(material->Evaluate(point));
    }
  }
  for (uint32_t m = 1; m < geometry->materials.size(); ++m) {
    if (!geometry->materials[m]) continue;
    SurfaceSample plain = sums.count(m) ? sums[m].Mean() : SurfaceSample();
    if (flavour != Flavour::kPrincipled) plain = Shared(plain, flavour == Flavour::kLambert);
    geometry->materials[m] = std::make_shared<test::ConstantMaterial>(plain);
  }
  if (flavour == Flavour::kPrincipled) return;
  std::map<const Mesh*, std::shared_ptr<const Mesh>> flat;
  for (PlacedMesh& placed : geometry->meshes) {
    auto& copy = flat[placed.mesh.get()];
    if (!copy) copy = std::make_shared<const Mesh>(WithFlatFaces(*placed.mesh));
    placed.mesh = copy;
  }
}

SurfaceSample PlainSurface(const Material* material) {
  return material ? material->Evaluate(SurfacePoint()) : SurfaceSample();
}

}  // namespace parallax::bench
