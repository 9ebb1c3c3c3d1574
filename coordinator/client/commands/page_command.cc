// page: a link to the coordinator's page for the browser, with the rights of a certificate.
#include <nlohmann/json.hpp>

#include "common/base/status.h"
#include "common/rpc/certificate.h"
#include "coordinator/client/command.h"
#include "coordinator/http/page_link.h"

namespace parallax::client {
namespace {

constexpr int kPagePort = 7080;

// Returns the given address, or the usual port on the coordinator's host.
absl::StatusOr<std::string> PageAddress(const std::string& told, const std::string& coordinator) {
  if (!told.empty()) return told;
  ASSIGN_OR_RETURN(RpcAddress address, ParseRpcAddress(coordinator));
  if (address.is_unix()) {
    return InvalidArgument("a Unix socket says nothing of the page; tell its --http HOST:PORT");
  }
  address.port = kPagePort;
  return address.ToString();
}

absl::StatusOr<ExitCode> Page(const std::string& told, Session& session) {
  ASSIGN_OR_RETURN(const std::string address, PageAddress(told, session.options.coordinator));
  std::string link = "http://" + address + "/";
  if (!session.options.tls_dir.empty()) {
    ASSIGN_OR_RETURN(const auto identity,
                     LoadTlsIdentity(session.options.tls_dir, Clock::System()));
    ASSIGN_OR_RETURN(link, AskForPageLink(address, *identity));
  }
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
      "With --tls the link opens one session with the certificate's role, once, within ten\n"
      "minutes. Without, the page of this machine needs none.\n"
      "\n"
      "Examples:\n"
      "  parallax page\n"
      "  parallax page --coordinator farm.example.org:7070 --tls operator-olga\n"
      "  xdg-open \"$(parallax page --http farm.example.org:7080 --tls submitter-ada)\"\n");
  command->group(kCoordinatorCommands);
  registry.AddConnectionOptions(command);
  auto told = std::make_shared<std::string>();
  command
      ->add_option("--http", *told,
                   "The coordinator's --http address (default: port 7080 of its host)")
      ->type_name("HOST:PORT");
  registry.SetAction(command, [told](Session& session) { return Page(*told, session); });
}

}  // namespace parallax::client
