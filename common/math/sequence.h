// Sequences: which rigs follow each other on a way, and where moving objects stand at their times.
// Free functions, pure.
#pragma once

#include <vector>

#include "common/math/proto.h"

namespace parallax {

// Returns the pose of `object` at `time_s` after the first frame. It turns about its own origin,
// which moves along a line. Scenes without motion are the same at all times.
inline Pose PoseAt(const v1::SceneObject& object, double time_s) {
  Pose pose = FromProto(object.world_from_object());
  if (!object.has_motion()) return pose;
  const Vec3d spin = FromProto(object.motion().spin_rps());
  pose.translation += time_s * FromProto(object.motion().velocity_mps());
  if (const double rate = spin.norm(); rate > 0) {
    pose.rotation = Eigen::AngleAxisd(rate * time_s, spin / rate) * pose.rotation.normalized();
  }
  return pose;
}

inline bool HasMotion(const v1::Scene& scene) {
  for (const v1::SceneObject& object : scene.objects()) {
    if (object.has_motion()) return true;
  }
  return false;
}

// The place of a rig among the others of its scene. Places in Scene.rigs; -1: none exists.
struct RigPlace {
  int left = -1;  // The first rig with the same left eye: itself, unless it shares one.
  int previous = -1, next = -1;  // On its way, with the right eye of the same place among those
                                 // that share a left eye. None for single views.
};

// Returns the places of all rigs in their sequences, in order of `scene.rigs`.
inline std::vector<RigPlace> PlacesOf(const v1::Scene& scene) {
  std::vector<RigPlace> places(static_cast<size_t>(scene.rigs_size()));
  int before = -1;  // The first rig of the left eye before.
  for (int i = 0; i < scene.rigs_size(); ++i) {
    const bool shares = i > 0 && scene.rigs(i).shares_left();
    RigPlace& place = places[static_cast<size_t>(i)];
    if (!shares && i > 0) before = places[static_cast<size_t>(i) - 1].left;
    place.left = shares ? places[static_cast<size_t>(i) - 1].left : i;
    const int other = before + (i - place.left);
    if (before < 0 || other >= place.left || scene.rigs(i).path() == 0 ||
        scene.rigs(other).path() != scene.rigs(i).path()) {
      continue;
    }
    place.previous = other;
    places[static_cast<size_t>(other)].next = i;
  }
  return places;
}

}  // namespace parallax
