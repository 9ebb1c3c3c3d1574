#include "worker/layout/anneal/wish.h"

#include <algorithm>

#include "worker/layout/anneal/measures.h"

namespace parallax {

std::string_view NameOf(WishKind kind) {
  switch (kind) {
    case WishKind::kRelation:
      return "relation";
    case WishKind::kFullness:
      return "fullness";
    case WishKind::kAlignment:
      return "alignment";
    case WishKind::kFocus:
      return "focus";
    case WishKind::kAccessibility:
      return "accessibility";
    case WishKind::kSymmetry:
      return "symmetry";
    case WishKind::kClutter:
      return "clutter";
  }
  return "";
}

namespace {
std::vector<std::string> JoinedGroups(const Wish& a, const Wish& b) {
  if (a.groups().empty() || b.groups().empty()) return {};
  std::vector<std::string> groups = a.groups();
  groups.insert(groups.end(), b.groups().begin(), b.groups().end());
  return groups;
}
}  // namespace

Wish operator+(const Wish& a, const Wish& b) {
  return Wish(
      a.name() + ", " + b.name(), a.kind(), JoinedGroups(a, b),
      [a, b](const Arrangement& at, FloorRegion& seen) { return a.Of(at, seen) + b.Of(at, seen); });
}

Wish Worst(const Wish& a, const Wish& b) {
  return Wish(a.name() + " or " + b.name(), a.kind(), JoinedGroups(a, b),
              [a, b](const Arrangement& at, FloorRegion& seen) {
                const double first = a.Of(at, seen), second = b.Of(at, seen);
                return std::max(first, second);
              });
}

Wish If(const std::string& group, const Wish& wish) {
  std::vector<std::string> groups = wish.groups();
  if (!groups.empty()) groups.push_back(group);
  return Wish(wish.name(), wish.kind(), groups,
              [group, wish](const Arrangement& at, FloorRegion& seen) {
                bool any = false;
                ForGroup(at, group, [&](int, const Item&) { any = true; });
                return any ? wish.Of(at, seen) : 0.0;
              });
}

}  // namespace parallax
