#include "coordinator/http/page_link.h"

#include <fmt/core.h>
#include <httplib.h>

#include <nlohmann/json.hpp>

#include "common/rpc/address.h"

namespace parallax {
namespace {

constexpr int kTimeout_s = 10;

// A text of a JSON reply. Errors: kUnavailable without one, or the page's own words.
absl::StatusOr<std::string> TextOf(const httplib::Result& answer, const char* name,
                                   const std::string& address) {
  if (!answer) {
    return Unavailable(
        "no page at https://{}/: {} (is it the coordinator's --http address, and is the "
        "certificate of the same farm?)",
        address, httplib::to_string(answer.error()));
  }
  const auto json = nlohmann::json::parse(answer->body, nullptr, /*allow_exceptions=*/false);
  if (answer->status == 200 && json.is_object()) {
    const auto found = json.find(name);
    if (found != json.end() && found->is_string()) return found->get<std::string>();
  }
  std::string why = fmt::format("status {}", answer->status);
  if (json.is_object() && json.contains("error")) why = json["error"].value("message", why);
  return FailedPrecondition("the page at https://{}/ gives no link: {}", address, why);
}

}  // namespace

absl::StatusOr<std::string> AskForPageLink(const std::string& address,
                                           const TlsIdentity& identity) {
  ASSIGN_OR_RETURN(const RpcAddress parsed, ParseRpcAddress(address));
  if (parsed.is_unix() || parsed.port == 0) {
    return InvalidArgument("the page is at HOST:PORT, not at {}", address);
  }
  httplib::SSLClient client(parsed.host, parsed.port, identity.dir + "/tls.crt",
                            identity.dir + "/tls.key");
  client.set_ca_cert_path((identity.dir + "/ca.crt").c_str());
  client.enable_server_certificate_verification(true);
  client.set_connection_timeout(kTimeout_s);
  client.set_read_timeout(kTimeout_s);
  ASSIGN_OR_RETURN(const std::string csrf, TextOf(client.Get("/api/v1/me"), "csrf", address));
  ASSIGN_OR_RETURN(
      const std::string code,
      TextOf(client.Post("/api/v1/links", {{"X-Parallax-Csrf", csrf}}, "{}", "application/json"),
             "code", address));
  return "https://" + parsed.ToString() + "/#code=" + code;
}

}  // namespace parallax
