#include "worker/assets/nature/skeleton.h"

#include <algorithm>
#include <cmath>

#include "worker/assets/parts.h"

namespace parallax {
namespace {

// A point in the crown and the node nearest to it.
struct Lure {
  Vec3f at;
  int nearest = -1;
  float distance2 = 1e18f;
};

void LookAtNew(std::vector<Lure>& lures, const std::vector<TreeNode>& nodes, int first) {
  for (Lure& lure : lures) {
    for (int i = first; i < static_cast<int>(nodes.size()); ++i) {
      const float d2 = (lure.at - nodes[static_cast<size_t>(i)].at).squaredNorm();
      if (d2 < lure.distance2) lure.nearest = i, lure.distance2 = d2;
    }
  }
}

}  // namespace

int Skeleton::Add(const Vec3f& at, int parent) {
  nodes_.push_back({at, parent});
  return static_cast<int>(nodes_.size() - 1);
}

void Skeleton::Colonise(std::vector<Vec3f> points, const ColoniseOptions& options, Rng& rng) {
  std::vector<Lure> lures;
  for (const Vec3f& p : points) lures.push_back({p});
  LookAtNew(lures, nodes_, options.first_node);
  const float reach2 = options.reach_m * options.reach_m, kill2 = options.kill_m * options.kill_m;
  for (int round = 0; round < 400 && !lures.empty(); ++round) {
    std::erase_if(lures, [&](const Lure& lure) { return lure.distance2 < kill2; });
    std::vector<std::pair<int, Vec3f>> pulls;
    for (const Lure& lure : lures) {
      if (lure.distance2 > reach2) continue;
      const Vec3f to = lure.at - nodes_[static_cast<size_t>(lure.nearest)].at;
      pulls.emplace_back(lure.nearest, to / std::sqrt(lure.distance2));
    }
    if (pulls.empty()) return;
    std::stable_sort(pulls.begin(), pulls.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    const int before = static_cast<int>(nodes_.size());
    for (size_t i = 0; i < pulls.size();) {
      const int from = pulls[i].first;
      Vec3f sum = Vec3f::Zero();
      for (; i < pulls.size() && pulls[i].first == from; ++i) sum += pulls[i].second;
      const Vec3f wander{Draw(rng, -1, 1), Draw(rng, -1, 1), Draw(rng, -1, 1)};
      const Vec3f way = sum.stableNormalized() + options.tropism + options.jitter * wander;
      Add(nodes_[static_cast<size_t>(from)].at + options.step_m * way.stableNormalized(), from);
    }
    if (static_cast<int>(nodes_.size()) > options.max_nodes) return;
    LookAtNew(lures, nodes_, before);
  }
}

std::vector<int> Skeleton::MainChild() const {
  std::vector<int> main(nodes_.size(), -1);
  for (int i = 1; i < static_cast<int>(nodes_.size()); ++i) {
    const int parent = nodes_[static_cast<size_t>(i)].parent;
    if (parent < 0) continue;
    int& best = main[static_cast<size_t>(parent)];
    const auto weight = [&](int k) { return nodes_[static_cast<size_t>(k)].tips; };
    if (best < 0 || weight(i) > weight(best)) best = i;
  }
  return main;
}

void Skeleton::Smooth(int rounds, int fixed) {
  const std::vector<int> main = MainChild();
  for (int round = 0; round < rounds; ++round) {
    std::vector<Vec3f> moved;
    for (const TreeNode& node : nodes_) moved.push_back(node.at);
    for (size_t i = static_cast<size_t>(std::max(1, fixed)); i < nodes_.size(); ++i) {
      if (main[i] < 0) continue;
      moved[i] = 0.5f * nodes_[i].at + 0.25f * nodes_[static_cast<size_t>(nodes_[i].parent)].at +
                 0.25f * nodes_[static_cast<size_t>(main[i])].at;
    }
    for (size_t i = 0; i < nodes_.size(); ++i) nodes_[i].at = moved[i];
  }
}

void Skeleton::Displace(const std::function<Vec3f(const Vec3f&)>& move, int fixed) {
  for (size_t i = static_cast<size_t>(fixed); i < nodes_.size(); ++i) {
    nodes_[i].at += move(nodes_[i].at);
  }
}

void Skeleton::Thicken(float trunk_m, float tip_m) {
  for (TreeNode& node : nodes_) node.tips = 0;
  for (size_t i = nodes_.size(); i-- > 0;) {
    TreeNode& node = nodes_[i];
    if (node.tips == 0) node.tips = 1;
    if (node.parent >= 0) nodes_[static_cast<size_t>(node.parent)].tips += node.tips;
  }
  const float exponent = std::clamp(
      std::log(std::max(2.0f, nodes_[0].tips)) / std::log(std::max(1.1f, trunk_m / tip_m)), 1.6f,
      3.0f);
  const float foot = std::pow(nodes_[0].tips, 1 / exponent);
  for (TreeNode& node : nodes_) {
    const float share = std::pow(node.tips, 1 / exponent);
    node.radius = tip_m + (trunk_m - tip_m) * (share - 1) / std::max(1e-3f, foot - 1);
  }
}

std::vector<std::vector<int>> Skeleton::Limbs() const {
  const std::vector<int> main = MainChild();
  std::vector<std::vector<int>> limbs;
  for (int i = 0; i < static_cast<int>(nodes_.size()); ++i) {
    const int parent = nodes_[static_cast<size_t>(i)].parent;
    if (parent >= 0 && main[static_cast<size_t>(parent)] == i) continue;
    std::vector<int> limb;
    if (parent >= 0) limb.push_back(parent);
    for (int k = i; k >= 0; k = main[static_cast<size_t>(k)]) limb.push_back(k);
    if (limb.size() >= 2) limbs.push_back(std::move(limb));
  }
  return limbs;
}

Vec3f Skeleton::Heading(int node) const {
  const TreeNode& n = nodes_[static_cast<size_t>(node)];
  if (n.parent < 0) return Vec3f::UnitZ();
  return (n.at - nodes_[static_cast<size_t>(n.parent)].at).stableNormalized();
}

}  // namespace parallax
