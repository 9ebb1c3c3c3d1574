// The common part of all commands. Each command's file registers its subcommand and an action,
// which the program runs if the user gives that subcommand.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <type_traits>

#include "common/base/status.h"
#include "coordinator/client/app.h"
#include "coordinator/client/connection.h"
#include "coordinator/client/exit_code.h"

namespace parallax::client {

// Options that many commands have; each command adds those that it uses.
struct CommonOptions {
  std::string coordinator = kDefaultCoordinator;
  bool insecure = false;
  std::string tls_dir;
  bool json = false;
};

// The outside of a running command: its environment, and helpers to write and connect.
struct Session {
  Environment& environment;
  const CommonOptions& options;

  const Terminal& out() const { return environment.out; }
  const Terminal& err() const { return environment.err; }
  // Returns whether a write to standard output has found that nobody reads it any more, as behind
  // `| head`. Commands that follow something end then, with kExitInterrupted.
  bool OutputIsClosed() const;
  // Connects to the coordinator of the options. Errors: those of MakeRpcSecurity and
  // Connection::Open.
  absl::StatusOr<std::unique_ptr<Connection>> Connect() const;
  // Connects to look for a study named `what`, because there is no such folder. Errors: kNotFound
  // for a path; those of Connect, which say so.
  absl::StatusOr<std::unique_ptr<Connection>> ConnectInPlaceOf(const std::string& what) const;
  // Writes a JSON document to standard output, indented unless `one_line`. Returns kExitOk.
  ExitCode PrintJson(const nlohmann::ordered_json& json, bool one_line = false) const;
  // Write "error: ..." or "note: ..." to standard error.
  void PrintError(const std::string& message) const;
  void PrintNote(const std::string& message) const;
  // Asks the user whether to go on although `what`. `yes` (the option --yes) answers beforehand.
  // Errors: kFailedPrecondition unless the user agrees.
  absl::Status Confirm(const std::string& what, bool yes) const;
};

// Runs a command. An error is printed, and its exit code is that of ExitCodeOf.
using Action = std::function<absl::StatusOr<ExitCode>(Session&)>;

// Headings of `parallax --help`.
inline constexpr char kLocalCommands[] = "On this machine";
inline constexpr char kCoordinatorCommands[] = "With a coordinator";

// The register of commands.
struct Registry {
  CLI::App& app;
  CommonOptions& options;
  Action& chosen;

  // Adds a command below `parent`, among the local ones if that is the program. `footer` is shown
  // at the end of its --help.
  CLI::App* AddCommand(CLI::App& parent, const std::string& name, const std::string& description,
                       const std::string& footer = "");
  // Sets the action that runs if the command is given.
  void SetAction(CLI::App* command, Action action);
  void AddJsonOption(CLI::App* command);
  void AddConnectionOptions(CLI::App* command);  // And --json.
};

// Returns a whole number without zeros in front, which CLI11 takes for octal: "010" as "10". Other
// texts are returned as they are.
std::string AsDecimal(std::string text);
// Lets all options of `app` and its commands read whole numbers so, where AddOption does not.
void ReadNumbersAsDecimal(CLI::App& app);

template <typename Value>
inline constexpr bool kIsWhole = std::is_integral_v<Value> && !std::is_same_v<Value, bool>;
template <typename Value>
inline constexpr bool kIsWhole<std::optional<Value>> = kIsWhole<Value>;

// Adds an option whose value is called `type` in the help. `value` outlives the command.
template <typename Value>
CLI::Option* AddOption(CLI::App* command, const char* names, const char* type, Value& value,
                       const std::string& description) {
  CLI::Option* const option = command->add_option(names, value, description)->type_name(type);
  if constexpr (kIsWhole<Value>) option->transform(AsDecimal);
  return option;
}

// Register the commands of these names; each has a file of its own in this folder.
void RegisterRun(Registry& registry);
void RegisterSubmit(Registry& registry);
void RegisterStatus(Registry& registry);
void RegisterWatch(Registry& registry);
void RegisterJobs(Registry& registry);
void RegisterLogs(Registry& registry);
void RegisterWorkers(Registry& registry);
void RegisterSteer(Registry& registry);  // cancel, pause, resume, comment, priority...
void RegisterLimits(Registry& registry);
void RegisterAudit(Registry& registry);
void RegisterPage(Registry& registry);
void RegisterFetch(Registry& registry);
void RegisterStream(Registry& registry);
void RegisterSearch(Registry& registry);
void RegisterView(Registry& registry);
void RegisterPlan(Registry& registry);
void RegisterPreview(Registry& registry);
void RegisterExport(Registry& registry);
void RegisterVerify(Registry& registry);
void RegisterScene(Registry& registry);   // scene show, scene export
void RegisterConfig(Registry& registry);  // config check, config show, config list
void RegisterOwnFiles(Registry& registry, CLI::App& config);  // config biome, config room

// Prints a recipe as text: plan, objects, lights, rigs, solver. Errors: those of TypeOf.
absl::Status PrintRecipe(const v1::Scene& scene, Session& session);

}  // namespace parallax::client
