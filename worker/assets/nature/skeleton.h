// The woody frame of a tree: nodes joined to their parents, grown towards points in the crown by
// space colonisation, thickened by the pipe model, and cut into limbs.
//
// Source: Runions, Lane, Prusinkiewicz, "Modeling trees with a space colonization algorithm", 2007;
// Shinozaki et al., "A quantitative analysis of plant form: the pipe model theory", 1964.
#pragma once

#include <functional>
#include <vector>

#include "common/base/rng.h"
#include "worker/assets/kernel/shape_noise.h"
#include "worker/assets/nature/limb.h"

namespace parallax {

// A point of the woody frame.
struct TreeNode {
  Vec3f at = Vec3f::Zero();
  int parent = -1;  // Always an earlier node.
  float tips = 0;   // Ends of twigs that it carries; set by Thicken.
  float radius = 0;
};

// Options of space colonisation.
struct ColoniseOptions {
  float step_m = 0.2f;
  float kill_m = 0.4f;            // A point is reached when a node is so near.
  float reach_m = 1e9f;           // Points farther away attract no node.
  Vec3f tropism = Vec3f::Zero();  // Added to the unit direction of each step.
  float jitter = 0.15f;
  int first_node = 0;  // Nodes before it do not grow.
  int max_nodes = 6000;
};

// The tree of nodes.
class Skeleton {
 public:
  int Add(const Vec3f& at, int parent);
  const std::vector<TreeNode>& nodes() const { return nodes_; }
  // Grows nodes, each towards the mean direction of the points to which it is nearest, until all
  // points are reached or too far.
  void Colonise(std::vector<Vec3f> points, const ColoniseOptions& options, Rng& rng);

  // Rounds off the corners of limbs; nodes below `fixed` stay.
  void Smooth(int rounds, int fixed);
  // Moves every node by `move`; nodes below `fixed` stay.
  void Displace(const std::function<Vec3f(const Vec3f&)>& move, int fixed);

  // Sets radii from `tip_m` at the ends to `trunk_m` at the foot: r^e is the sum of the children's,
  // with the exponent e in [1.6, 3] that achieves this.
  void Thicken(float trunk_m, float tip_m);

  // Each limb: nodes from the one on its parent limb (the trunk: the foot) to its end, following
  // the thickest child.
  std::vector<std::vector<int>> Limbs() const;

  bool IsTip(int node) const { return nodes_[static_cast<size_t>(node)].tips <= 1.0f; }
  Vec3f Heading(int node) const;  // Unit, from the parent.

 private:
  std::vector<int> MainChild() const;

  std::vector<TreeNode> nodes_;
};

}  // namespace parallax
