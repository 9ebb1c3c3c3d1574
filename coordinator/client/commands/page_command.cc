// page: a link to the coordinator's page for the browser, with the rights of a certificate.
#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/status.h"
#include "common/rpc/endpoint.h"
#include "coordinator/client/command.h"

namespace parallax::client {
namespace {

// Replaces host and port of a link: the coordinator listens on any address, or behind a tunnel.
absl::StatusOr<std::string> WithAddress(const std::string& link, const std::string& address) {
  const size_t begin = link.find("://");
  const size_t end = begin == std::string::npos ? begin : link.find('/', begin + 3);
  if (end == std::string::npos) return Internal("the coordinator's link is {}", link);
  return link.substr(0, begin + 3) + address + link.substr(end);
}

// Returns the address in a link.
absl::StatusOr<RpcAddress> AddressIn(const std::string& link) {
  const size_t begin = link.find("://") + 3;
  return ParseRpcAddress(link.substr(begin, link.find('/', begin) - begin));
}

// The address of the option --http; nothing if it is not given.
absl::StatusOr<std::optional<RpcAddress>> ParseGiven(const std::string& given) {
  if (given.empty()) return std::nullopt;
  if (given.find("://") != std::string::npos) {
    return InvalidArgument("--http: '{}', wanted is HOST:PORT without a scheme", given);
  }
  ASSIGN_OR_RETURN(const RpcAddress address, ParseRpcAddress(given));
  if (address.is_unix() || address.port == 0) {
    return InvalidArgument("--http: the page is at HOST:PORT, not at {}", given);
  }
  return address;
}

// The link as this machine can open it. A coordinator that listens on all addresses names none.
absl::StatusOr<std::string> Reachable(const std::string& link,
                                      const std::optional<RpcAddress>& given,
                                      const RpcAddress& coordinator, Session& session) {
  if (given) return WithAddress(link, given->ToString());
  ASSIGN_OR_RETURN(RpcAddress page, AddressIn(link));
  const bool any = page.host == "0.0.0.0" || page.host == "::";
  if (any && !coordinator.is_unix()) {
    page.host = coordinator.host;
    return WithAddress(link, page.ToString());
  }
  if (page.is_local() && !coordinator.is_local()) {
    session.PrintNote(
        fmt::format("the page listens on the coordinator's machine only; from here: "
                    "ssh -L {}:{} {}",
                    page.port, page.ToString(), coordinator.host));
  }
  return link;
}

absl::StatusOr<ExitCode> Page(const std::string& http, Session& session) {
  ASSIGN_OR_RETURN(const std::optional<RpcAddress> given, ParseGiven(http));
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  ASSIGN_OR_RETURN(const std::string url, connection->OpenPage());
  ASSIGN_OR_RETURN(const RpcAddress coordinator, ParseRpcAddress(session.options.coordinator));
  ASSIGN_OR_RETURN(const std::string link, Reachable(url, given, coordinator, session));
  if (session.options.json) {
    session.PrintJson({{"link", link}});
  } else {
    *session.out().stream << link << "\n";
  }
  return kExitOk;
}

}  // namespace

void RegisterPage(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "page", "A link to the coordinator's page, for the browser",
      "The link opens one session with the rights of your certificate, once, within a day; also\n"
      "where the page listens on the coordinator's machine only, without certificates.\n"
      "\n"
      "Examples:\n"
      "  parallax page\n"
      "  parallax page --coordinator farm.example.org:7070 --tls operator-olga\n"
      "  xdg-open \"$(parallax page --http farm.example.org:7080 --tls submitter-ada)\"\n");
  command->group(kCoordinatorCommands);
  registry.AddConnectionOptions(command);
  auto told = std::make_shared<std::string>();
  AddOption(command, "--http", "HOST:PORT", *told,
            "Address in the link, where you reach the page otherwise (a tunnel, another name)");
  registry.SetAction(command, [told](Session& session) { return Page(*told, session); });
}

}  // namespace parallax::client
