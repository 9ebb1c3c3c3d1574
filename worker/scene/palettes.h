// Materials of one scene: a room's objects share small palettes of each family, as people buy in
// sets. Private to worker/scene.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/base/rng.h"
#include "parallax/v1/scene.pb.h"
#include "worker/geometry/mesh.h"
#include "worker/materials/kernel/material.h"
#include "worker/materials/pictures/picture_folder.h"

namespace parallax {

using MaterialClasses = std::vector<const MaterialClass*>;

// Returns whether the slot shows a printed picture.
bool Prints(const MaterialSlot& slot);
// Materials to print on a slot of this name: covers on books, labels on cans, paintings in frames.
MaterialClasses PrintsFor(const std::string& slot);

// Gives each material that is drawn one entry of the recipe, in order of first use.
class Palettes {
 public:
  // Adds entries to `recipe`, which must outlive it; palettes draw from addresses below `root`.
  Palettes(v1::Scene& recipe, const Rng& root) : recipe_(recipe), root_(root) {}

  const Rng& root() const { return root_; }

  // Returns the SceneMaterial.index of an entry, which is added if it is new. `picture` is for the
  // class UserPicture, else empty.
  uint32_t IndexOf(const std::string& name, uint64_t seed, const FolderFile& picture = {});

  // Picks one of the `size` members of a palette of this scene. `where` draws which; the member
  // draws its class among `classes` (not empty) and its seed.
  uint32_t FromPalette(const MaterialClasses& classes, const std::string& palette, int size,
                       Rng where);

  // Draws from the families that the slot names: mostly the first, now and then a later one. An
  // empty `palette` is the family's own; size 0 is the family's usual number.
  uint32_t FromFamilies(const MaterialSlot& slot, Rng where, const std::string& palette, int size);

 private:
  v1::Scene& recipe_;
  const Rng root_;
  std::map<std::pair<std::string, uint64_t>, uint32_t> index_;
};

}  // namespace parallax
