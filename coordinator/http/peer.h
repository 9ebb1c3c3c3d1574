// The TLS side of the page: a server that asks for client certificates but takes callers without,
// and who a certificate says that its caller is. OpenSSL's and the HTTP library's types stay here
// and in http_server.cc.
#pragma once

#include <optional>
#include <string>

#include "common/rpc/endpoint.h"

struct ssl_st;
struct ssl_ctx_st;

namespace parallax {

// Certificate, key and authority of the TLS folder `dir`. False if one of them can't be used.
bool SetUpTls(const std::string& dir, ssl_ctx_st& context);

// Nothing for a caller without a certificate. One that our authority did not sign can't connect.
std::optional<RpcCaller> CallerOf(const ssl_st* connection);

}  // namespace parallax
