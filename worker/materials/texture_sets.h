// Sets of pictures that describe a surface, as libraries of materials give them: files whose names
// differ in one word, which says what they show ("brick_albedo.png", "brick_roughness.png").
// Thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "worker/materials/material.h"
#include "worker/materials/picture_folder.h"

namespace parallax {

// In front of the names of everything that is the user's.
inline constexpr std::string_view kOwnPrefix = "own:";

struct TextureSet {
  std::string name;   // "own:brick"
  uint64_t seed = 0;  // From its pictures' contents; recipes name a material by name and seed.
};

struct TextureFolder {
  std::vector<TextureSet> sets;  // In order of their names; at least one.
  std::string sha256;            // Over the names and contents of all of their pictures.
};

// The sets in `dir` and the folders below it. This process knows their places from now on, so that
// MakeOwnTexture finds them. The last of a name's words (case does not count) that is one of these
// says what a picture shows; names without any are passed over:
//   albedo, basecolor, color, colour, col, diffuse, diff      needed
//   roughness, rough     metallic, metalness, metal
//   normal, normalgl, nor, nrm, norm, normaldx                dx: y points down
// Errors: kNotFound when no set is there; kInvalidArgument naming a set without its albedo; those
// of ReadContentFolder.
absl::StatusOr<TextureFolder> ReadTextureFolder(const std::string& dir);

// Opens every picture. Errors: kInvalidArgument naming the first that can't be read.
absl::Status CheckTextureSet(const TextureSet& set);

// Laid in tiles of kPbrTile_m. Errors: kNotFound for a set of no folder that this process has read;
// kDataLoss for one whose pictures have changed since; those of reading pictures.
absl::StatusOr<std::unique_ptr<const Material>> MakeOwnTexture(std::string_view name,
                                                               uint64_t seed);

}  // namespace parallax
