// Sets of pictures that describe a surface, as in libraries of materials: files whose names differ
// in one word that tells their content ("brick_albedo.png", "brick_roughness.png"). Thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "worker/materials/kernel/material.h"
#include "worker/materials/pictures/picture_folder.h"

namespace parallax {

// Prefix of the names of all user content.
inline constexpr std::string_view kOwnPrefix = "own:";

// A set of pictures that make one material.
struct TextureSet {
  std::string name;   // "own:brick"
  uint64_t seed = 0;  // From its pictures' contents; recipes name a material by name and seed.
  std::vector<std::string> maps;      // "colour brick_albedo.png"
  std::vector<std::string> left_out;  // Pictures of the set that are not read, and why.
};

// All sets of a folder.
struct TextureFolder {
  std::vector<TextureSet> sets;       // In order of their names; at least one.
  std::string sha256;                 // Over the names and contents of all of their pictures.
  std::vector<std::string> left_out;  // Pictures of no set, and why.
};

// Finds the sets in `dir` and the folders below it, and keeps their paths in this process for
// MakeOwnTexture. A picture's content is told by the last word or two of its name (ignoring case),
// or the last before sizes, numbers and formats, as in "brick_nor_gl_1k", "brick_Base_Color":
//   albedo, basecolor, color, colour, col, diffuse, diff      needed
//   roughness, rough     metallic, metalness, metal
//   arm, orm             occlusion, roughness and metal in one; where there is no roughness
//   normal, nor, nrm, norm; with gl, ogl, opengl: y up, as alone; with dx, directx: y down
//   T_brick_D, _BC, _R, _M, _N, _ORM                          as Unreal has them: y down
// Others are left out: other maps (ao, disp, height, spec, opacity...) and names that say nothing.
// An EXR counts where no PNG or JPEG shows the same.
// Errors: kNotFound when no set is there; kInvalidArgument naming a set without its albedo; those
// of ReadContentFolder.
absl::StatusOr<TextureFolder> ReadTextureFolder(const std::string& dir);

// Opens every picture. Errors: kInvalidArgument naming the first that can't be read, or an EXR with
// a value that is no number.
absl::Status CheckTextureSet(const TextureSet& set);

// Makes the material, in tiles of kPbrTile_m. Errors: kNotFound for a set of no folder that this
// process has read; kDataLoss when its pictures have changed since; those of reading pictures.
absl::StatusOr<std::unique_ptr<const Material>> MakeOwnTexture(std::string_view name,
                                                               uint64_t seed);

}  // namespace parallax
