// Which roles may call which RPC. One table, closed: an RPC without a row is refused to everybody
// who shows a certificate.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "common/rpc/endpoint.h"

namespace parallax {

// `method` is "/parallax.v1.Coordinator/Submit". nullopt: no such row.
std::optional<std::vector<Role>> RolesOf(std::string_view method);

// The gate of the coordinator's server. Errors: kPermissionDenied saying who may, and what to ask
// for.
absl::Status CheckAccess(const RpcCaller& caller, std::string_view method);

}  // namespace parallax
