// The roles of a farm's parties. A certificate carries its owner's role (see certificate.h), and a
// table has the roles that may call each RPC (coordinator/rpc/access.h).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace parallax {

enum class Role {
  kWorker,     // Does jobs.
  kSubmitter,  // Submits studies, steers its own, reads all.
  kOperator,   // Steers all studies and workers, reads all and the audit table.
  kReadOnly,   // Reads studies and fetches results.
};

inline constexpr std::array<Role, 4> kAllRoles = {Role::kWorker, Role::kSubmitter, Role::kOperator,
                                                  Role::kReadOnly};

// Returns the name of a role as certificates and options have it.
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

// Returns the role of that name; nothing for an unknown name.
constexpr std::optional<Role> ParseRole(std::string_view name) {
  for (Role role : kAllRoles) {
    if (RoleName(role) == name) return role;
  }
  return std::nullopt;
}

}  // namespace parallax
