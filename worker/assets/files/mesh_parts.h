// A mesh as its file has it, before it is placed in the asset frame: what the readers of .glb, .obj
// and .ply return, and what they share.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "common/math/types.h"
#include "worker/materials/pictures/pbr_material.h"

namespace parallax {

inline constexpr int64_t kMostTrianglesOfAFile = 2'000'000;

// A material of a file, and the maps that it shows.
struct FileMaterial {
  std::string name;                  // The file's; "" for none.
  std::optional<PbrPictures> looks;  // nullopt where the file describes none.
  std::vector<std::string> maps;     // "colour wood.png", "normal 512 x 512"
};

// Triangles with one material, in the file's axes and unit. Per-vertex arrays have one length.
struct MeshPart {
  std::vector<Vec3d> positions;
  std::vector<Vec3f> normals;  // Empty: none, or one for each position, of any length.
  std::vector<Vec2f> uv;       // Empty: none. v goes up.
  std::vector<std::array<uint32_t, 3>> triangles;
  size_t material = 0;  // In MeshParts::materials.
  // The distance between neighbouring positions that its file can tell, where it may be too large.
  double step = 0;
};

struct MeshParts {
  std::vector<MeshPart> parts;
  std::vector<FileMaterial> materials;  // Each for parts with uv, or for parts without.
  std::vector<std::string> left_out;    // Parts that are not used, and why.
  // Edges of less than this angle are smooth where there are no normals. Below 0: none is.
  double crease_deg = 40;
};

// Reads a .glb (binary glTF 2.0): y up, facing +z. Skins stand in their rest pose, morph targets
// have their default weights. `path` is the file's, whose content is `bytes`: pictures and
// materials lie beside it. Errors: kInvalidArgument saying what is wrong and what is wanted,
// without the file's name.   Source: Khronos, "glTF 2.0 specification".
absl::StatusOr<MeshParts> ReadGlb(std::string_view bytes, const std::string& path);
// Reads an .obj with its .mtl files: y up, facing +z. Errors: as ReadGlb.   Source: Wavefront,
// "Object files", "The .mtl file format".
absl::StatusOr<MeshParts> ReadObj(std::string_view bytes, const std::string& path);
// Reads a .ply: z up, facing -y. Errors: as ReadGlb.   Source: Greg Turk, "The PLY Polygon File
// Format".
absl::StatusOr<MeshParts> ReadPly(std::string_view bytes, const std::string& path);

// ---- Files beside a mesh

// Returns the name, relative to `folder`, of the file below it that a mesh calls `name`: the same
// name; or what it means to other systems ("maps\a.png", "a%20b.png", blanks and quotes around it);
// or one in which only the case of letters differs, if there is exactly one. Errors:
// kInvalidArgument for a name that leads elsewhere; kNotFound for a file that is not there.
absl::StatusOr<std::string> FindBeside(const std::string& folder, const std::string& name);
// Reads such a picture, for a mesh or a file of materials in `folder`. Errors: kInvalidArgument
// that names it: as FindBeside, or not named .png, .jpg or .jpeg, or not to be decoded.
absl::StatusOr<ImageRgb8> ReadBeside(const std::string& folder, const std::string& name);
// Decodes a picture called `name` and halves it until no side is longer than materials show.
// Errors: kInvalidArgument that names it.
absl::StatusOr<ImageRgb8> DecodeShrunk(std::string_view bytes, const std::string& name);

// ---- Geometry

// The distance between neighbouring numbers of 32 bits at the farthest position.
double FloatStep(const std::vector<Vec3d>& positions);

// A number for each vertex, the same for those at the same place.
std::vector<uint32_t> PlacesOf(const std::vector<Vec3d>& positions);

// Gives a part normals: vertices are split at edges of `crease_deg` and more; below 0: at all.
// Normals that a file has but that have no direction become those of their triangles.
void AddNormals(MeshPart& part, double crease_deg);

// Splits a polygon into triangles of its corners, which may be concave. `corners` are indices into
// `positions`; one of more than 5,000 corners is taken for convex.
void AddPolygon(const std::vector<Vec3d>& positions, const std::vector<uint32_t>& corners,
                std::vector<std::array<uint32_t, 3>>& triangles);

}  // namespace parallax
