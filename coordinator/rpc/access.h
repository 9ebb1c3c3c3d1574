// The roles that may call each RPC, in one closed table: callers with a certificate are refused
// every RPC without a row.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "common/rpc/endpoint.h"

namespace parallax {

// Returns the roles that may call `method`, for example "/parallax.v1.Coordinator/Submit"; nothing
// if it has no row.
std::optional<std::vector<Role>> RolesOf(std::string_view method);

// Checks whether a caller may call a method: the gate of the coordinator's server (RpcGate).
// Errors: kPermissionDenied, which says which roles may call it and what to ask the operator for.
absl::Status CheckAccess(const RpcCaller& caller, std::string_view method);

}  // namespace parallax
