// What a party of a farm may be. A certificate carries its role (see certificate.h); each RPC has
// the roles that may call it (coordinator/rpc/access.h).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace parallax {

enum class Role {
  kWorker,     // Does jobs.
  kSubmitter,  // Submits studies, steers its own, reads.
  kOperator,   // Steers all studies, reads all, the audit too.
  kReadOnly,   // Looks and fetches.
};

inline constexpr std::array<Role, 4> kAllRoles = {Role::kWorker, Role::kSubmitter, Role::kOperator,
                                                  Role::kReadOnly};

constexpr std::string_view RoleName(Role role) {
  switch (role) {
    case Role::kWorker:
      return "worker";
    case Role::kSubmitter:
      return "submitter";
    case Role::kOperator:
      return "operator";
    case Role::kReadOnly:
      return "read-only";
  }
  return "";
}

constexpr std::optional<Role> ParseRole(std::string_view name) {
  for (Role role : kAllRoles) {
    if (RoleName(role) == name) return role;
  }
  return std::nullopt;
}

}  // namespace parallax
