// Procedural materials: from a point of a surface to the parameters of its BSDF.
//
// A material is drawn once for each recipe entry (class + seed) and is then constant and
// thread-safe. It is a solid texture: evaluated at `texture_m` (metres; x along the grain of the
// part), so it needs no unwrapping. Eight points are evaluated together, in vector lanes.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/rng.h"
#include "common/base/status.h"
#include "common/math/lanes.h"
#include "worker/materials/kernel/dual.h"

namespace parallax {

// The point of a surface at which a material is evaluated.
struct SurfacePoint {
  Vec3f texture_m = Vec3f::Zero();  // Mesh::texture, interpolated, times the object's scale.
  Vec3f normal = Vec3f::UnitZ();    // Object frame, unit: distinguishes tops from sides.
  Vec2f uv = Vec2f::Zero();         // For printed pictures.
  // Width of the ray's footprint here; much finer detail is averaged.
  float footprint_m = 0;
  // Unit normal of the triangle in texture space: cross product of the edges of its three
  // Mesh::texture points. Flat patterns (weaves, tiles, bricks, wallpaper) are laid on the texture
  // plane across its longest axis. If zero, `normal` replaces it, which is right for parts whose
  // texture is not turned against the object.
  Vec3f texture_normal = Vec3f::Zero();
  // The footprint in units of uv; 0 = unknown: pictures count as half a metre wide.
  float footprint_uv = 0;
};

// The parameters of the principled BSDF at one point. Colours are linear Rec. 709.
struct SurfaceSample {
  Vec3f base_color = Vec3f::Constant(0.5f);  // [0, 1]
  float metallic = 0;                        // [0, 1]
  float roughness = 0.5f;                    // [0, 1]; GGX alpha = roughness^2
  float specular = 0.5f;   // Dielectric reflectance; 0.5 is 4 % at normal incidence.
  float transmission = 0;  // [0, 1]; refracts with `ior` (thin_walled: passes straight through).
  float ior = 1.5f;
  bool thin_walled = false;
  float clearcoat = 0;  // [0, 1]
  float clearcoat_roughness = 0.1f;
  float sheen = 0;       // [0, 1]
  float subsurface = 0;  // [0, 1]; part of the base's light that is scattered inside.
  // [0, 1], with base_color at most 1: light that an open sheet (MaterialSlot::sheet) scatters
  // through to its other side, as a leaf does. Ignored on solids.
  Vec3f transmitted_color = Vec3f::Zero();
  float opacity = 1;               // [0, 1]; 0 = a hole.
  Vec3f emission = Vec3f::Zero();  // Radiance, W / (m^2 sr).
};

// Eight points. Lanes from `count` on hold a copy of another.
struct SurfacePoint8 {
  using Real = Float8;  // The number type of formulas over these points.

  Vec3x8 texture_m, normal;
  Float8 u, v;
  Float8 footprint_m;
  Vec3x8 texture_normal;
  Float8 footprint_uv;
  int count = 0;

  SurfacePoint8() = default;
  // Packs one to eight points.
  explicit SurfacePoint8(std::span<const SurfacePoint> points);
  SurfacePoint Get(int lane) const;
};

// Derivatives of eight points' texture coordinates along two directions on their surfaces.
struct Tangents8 {
  Vec3x8 texture[2];  // Metres per metre.
  Float8 u[2], v[2];  // uv per metre.
};

// The parameters at eight points.
struct SurfaceSample8 {
  Vec3x8 base_color = Vec3x8::All(Splat(0.5f));
  Float8 metallic = Splat(0);
  Float8 roughness = Splat(0.5f);
  Float8 specular = Splat(0.5f);
  Float8 transmission = Splat(0);
  Float8 ior = Splat(1.5f);
  Float8 clearcoat = Splat(0);
  Float8 clearcoat_roughness = Splat(0.1f);
  Float8 sheen = Splat(0);
  Float8 subsurface = Splat(0);
  Vec3x8 transmitted_color = Vec3x8::Zero();
  Float8 opacity = Splat(1);
  Vec3x8 emission = Vec3x8::Zero();
  Mask8 thin_walled = {};

  void Set(int lane, const SurfaceSample& sample);
  SurfaceSample Get(int lane) const;
};

// A drawn material. Constant; thread-safe.
class Material {
 public:
  virtual ~Material() = default;
  // Properties at eight points; lanes are independent of each other.
  virtual SurfaceSample8 Evaluate(const SurfacePoint8& points) const = 0;
  // Returns the height of the relief above the mesh, metres: a few tenths of a millimetre to a few
  // millimetres, of rock some centimetres. The renderer bends the shading normal by its gradient. 0
  // everywhere: smooth.
  virtual Float8 Height(const SurfacePoint8& points) const {
    (void)points;
    return Splat(0);
  }
  // Returns the height with its derivatives along both directions, metres per metre, which bend the
  // normals. The default takes differences over half a footprint; `Carved` (surface.h) is exact.
  virtual Dual8 Relief(const SurfacePoint8& points, const Tangents8& tangents) const;
  // Returns the widest footprint, metres, that sees the relief; wider ones average it away.
  virtual float widest_relief_m() const { return 0.1f; }

  // Returns the same at one point.
  SurfaceSample Evaluate(const SurfacePoint& point) const {
    return Evaluate(SurfacePoint8({&point, 1})).Get(0);
  }
  float Height(const SurfacePoint& point) const { return Height(SurfacePoint8({&point, 1}))[0]; }
};

// A material that evaluates each point by itself, such as pictures drawn stroke by stroke.
class PointMaterial : public Material {
 public:
  SurfaceSample8 Evaluate(const SurfacePoint8& points) const final;
  Float8 Height(const SurfacePoint8& points) const final;

 protected:
  virtual SurfaceSample EvaluatePoint(const SurfacePoint& point) const = 0;
  virtual float HeightOfPoint(const SurfacePoint& point) const {
    (void)point;
    return 0.0f;
  }
};

// The uses of a class; plain data for the code that chooses materials.
struct MaterialTags {
  bool diffuse = false;         // Dull and opaque: the study's "one diffuse material".
  bool metal_or_glass = false;  // The study's "only metal and glass".
  bool walls = false;           // Suits a room's walls...
  bool floor = false;           // ...its floor...
  bool ceiling = false;         // ...its ceiling.
  // May replace the material of any object; false: only for slots that ask for it.
  bool any_object = true;
  bool needs_uv = false;   // Prints over uv in [0, 1]^2; elsewhere it has one colour.
  bool weathered = false;  // Rust and the like: on indoor things only where a slot names the class,
                           // or as a replacement.
  bool smooth = false;     // Without detail on purpose (mirror, clear glass, plain grey).
};

// One entry of the catalogue. `sample` draws the parameters: the same stream gives the same
// material.
struct MaterialClass {
  std::string name;    // "OakWood", "WovenFabric"...
  std::string family;  // "wood", "fabric", "metal", "glass", "plastic", "ceramic", "stone",
                       // "paint", "paper", "picture"...
  std::function<std::unique_ptr<const Material>(Rng&)> sample;
  MaterialTags tags;
};

// Returns every class in order of name; built once, thread-safe, lives for the program.
const std::vector<MaterialClass>& MaterialCatalogue();

// Returns the class of that name; nullptr if none exists.
const MaterialClass* FindMaterialClass(std::string_view name);

// Returns the classes of a family in order of name, or the one class of that name, ignoring case
// ("Wood", "wood", "OakWood"). Empty if none exists.
std::vector<const MaterialClass*> MaterialsOfFamily(std::string_view family_or_class);

// Returns the classes with a tag, in order of name: MaterialsTagged(&MaterialTags::walls).
std::vector<const MaterialClass*> MaterialsTagged(bool MaterialTags::*tag);

// Returns every family once, in order of name.
std::vector<std::string> MaterialFamilies();

// Makes the material of a class and seed, as recipes name it.
// Errors: kNotFound naming the class and the nearest known name.
absl::StatusOr<std::unique_ptr<const Material>> MakeMaterial(std::string_view class_name,
                                                             uint64_t seed);

}  // namespace parallax
