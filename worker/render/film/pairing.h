// Which pairs a left eye makes (rigs.baselines_m), and what is kept of it from one to the next.
#pragma once

#include <string>
#include <vector>

#include "common/math/sequence.h"
#include "worker/render/camera/stereo_frame.h"

namespace parallax {

// The pairs of a rig's left eye.
struct Pairing {
  v1::Rig leader;                 // The first of them; names the samples of the left picture.
  std::vector<double> baselines;  // All rigs' baselines, over the leader's.
  size_t partner = 0;             // Which of them the rig is.

  bool shared() const { return baselines.size() > 1; }
};

// A left eye, kept for the next rig that shares it. The picture of a shared left eye
// depends on no right one: it is the same in whichever order, and by however many jobs, its rigs
// are rendered.
struct KeptLeft {
  std::string eye;    // LeftEyeKey.
  View view;          // Without what depends on the right eye.
  ImageU8 ambiguous;  // Film's.
  float exposure = 1, clamp = 0;
};

// Returns a key that is equal for rigs whose left eyes see the same picture.
std::string LeftEyeKey(const v1::Rig& rig, const Pairing& pairing);

// The rigs of a scene among each other. Constant after construction.
class RigBook {
 public:
  explicit RigBook(const v1::Scene& scene)
      : rigs_(scene.rigs().begin(), scene.rigs().end()), places_(PlacesOf(scene)) {}

  const std::vector<v1::Rig>& rigs() const { return rigs_; }
  // Returns how a rig shares its left eye with others. A rig that is not of the scene shares
  // nothing.
  Pairing PairingOf(const v1::Rig& rig) const;
  // Returns the next rig on the camera path or, with `forward` false, the previous one; nullptr if
  // none exists.
  const v1::Rig* Neighbour(const v1::Rig& rig, bool forward) const;

 private:
  const RigPlace* PlaceOf(const v1::Rig& rig) const;

  std::vector<v1::Rig> rigs_;
  std::vector<RigPlace> places_;  // Parallel to rigs_.
};

}  // namespace parallax
