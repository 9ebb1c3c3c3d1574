#include "coordinator/client/command.h"

#include <cerrno>
#include <nlohmann/json.hpp>

namespace parallax::client {

bool Session::OutputIsClosed() const { return out().write_error && out().write_error() == EPIPE; }

absl::StatusOr<std::unique_ptr<Connection>> Session::Connect() const {
  ASSIGN_OR_RETURN(const RpcSecurity security,
                   MakeRpcSecurity(options.insecure, options.tls_dir, *environment.clock));
  return Connection::Open(options.coordinator, security);
}

absl::StatusOr<std::unique_ptr<Connection>> Session::ConnectInPlaceOf(
    const std::string& what) const {
  if (what.find('/') != std::string::npos) return NotFound("{}: no such folder", what);
  absl::StatusOr<std::unique_ptr<Connection>> connection = Connect();
  if (connection.ok()) return connection;
  return MakeError(
      connection.status().code(),
      what + ": no such folder here, and " + std::string(ToStd(connection.status().message())));
}

ExitCode Session::PrintJson(const nlohmann::ordered_json& json, bool one_line) const {
  // Text from outside may not be UTF-8: shown with a replacement character rather than not at all.
  *out().stream << json.dump(one_line ? -1 : 2, ' ', false,
                             nlohmann::ordered_json::error_handler_t::replace)
                << "\n"
                << std::flush;
  return kExitOk;
}

void Session::PrintError(const std::string& message) const {
  *err().stream << err().Paint(Tone::kBad, "error:") << " " << message << "\n" << std::flush;
}

void Session::PrintNote(const std::string& message) const {
  *err().stream << err().Paint(Tone::kWarning, "note:") << " " << message << "\n" << std::flush;
}

absl::Status Session::Confirm(const std::string& what, bool yes) const {
  if (yes) return absl::OkStatus();
  std::istream* answers = environment.answers;
  if (answers != nullptr && err().interactive) {
    *err().stream << what << "; continue? [y/N] " << std::flush;
    std::string answer;
    std::getline(*answers, answer);
    if (answer == "y" || answer == "Y" || answer == "yes") return absl::OkStatus();
  }
  return FailedPrecondition("{}; --yes continues anyway", what);
}

CLI::App* Registry::AddCommand(CLI::App& parent, const std::string& name,
                               const std::string& description, const std::string& footer) {
  CLI::App* command = parent.add_subcommand(name, description);
  command->footer(footer);
  command->group(&parent == &app ? kLocalCommands : "Commands");
  return command;
}

void Registry::SetAction(CLI::App* command, Action action) {
  command->callback([command, this_chosen = &chosen, action = std::move(action)] {
    // CLI11 calls back a given subcommand before its parent, whose action must not replace it.
    if (command->get_subcommands().empty()) *this_chosen = action;
  });
}

std::string AsDecimal(std::string text) {
  const size_t sign = text.starts_with('-') || text.starts_with('+') ? 1 : 0;
  if (text.find_first_not_of("0123456789", sign) != std::string::npos) return text;
  while (text.size() > sign + 1 && text[sign] == '0') text.erase(sign, 1);
  return text;
}

void ReadNumbersAsDecimal(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    const std::string type = option->get_type_name();
    if (type.starts_with("INT") || type.starts_with("UINT")) option->transform(AsDecimal);
  }
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) {
    ReadNumbersAsDecimal(*command);
  }
}

void Registry::AddJsonOption(CLI::App* command) {
  command->add_flag("--json", options.json, "JSON on standard output, for scripts");
}

void Registry::AddConnectionOptions(CLI::App* command) {
  AddJsonOption(command);
  AddOption(command, "--coordinator", "ADDR", options.coordinator,
            "HOST:PORT or unix:/PATH (default $PARALLAX_COORDINATOR or 127.0.0.1:7070)")
      ->group("Connection");
  AddOption(command, "--tls", "DIR", options.tls_dir,
            "Folder with your certificate, as `coordinator init` makes it (default "
            "$PARALLAX_TLS)")
      ->group("Connection");
  command->add_flag("--insecure", options.insecure, "Reach another machine without encryption")
      ->group("Connection");
}

}  // namespace parallax::client
