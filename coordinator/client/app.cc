#include "coordinator/client/app.h"

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "common/base/completion.h"
#include "common/base/usage_error.h"
#include "common/base/version.h"
#include "coordinator/client/command.h"
#include "coordinator/client/commands/catalogue_command.h"
#include "coordinator/client/commands/evaluate_command.h"
#include "coordinator/client/commands/farm_command.h"
#include "coordinator/client/views/help_formatter.h"
#include "worker/materials/pictures/user_picture.h"

namespace parallax::client {
namespace {

constexpr char kDescription[] =
    "parallax: stereo-matching training data from procedural scenes, with perfect ground truth";

constexpr char kExamples[] =
    "Examples:\n"
    "  parallax run quickstart --out out/quickstart   a small dataset, nothing to set up\n"
    "  parallax view out/quickstart                   its contact sheet\n"
    "\n"
    "  coordinator serve --db farm.db --store store   a farm: one coordinator,\n"
    "  worker --role all --coordinator HOST:7070      any number of workers\n"
    "  parallax submit baseline --pairs 1000          a study for it\n"
    "  parallax watch baseline                        bars, rate and time left\n"
    "  parallax fetch baseline --out out/baseline     the dataset on disk\n"
    "\n"
    "`parallax COMMAND --help` describes a command.\n"
    "\n";

void RegisterAll(Registry& registry) {
  RegisterRun(registry);
  RegisterPlan(registry);
  RegisterPreview(registry);
  RegisterView(registry);
  RegisterExport(registry);
  RegisterVerify(registry);
  RegisterCurate(registry);
  RegisterEvaluate(registry);
  RegisterPredict(registry);
  RegisterTable(registry);
  RegisterScene(registry);
  RegisterCatalogue(registry);
  RegisterConfig(registry);
  AddCompletion(registry.app)->group(kLocalCommands);
  RegisterSubmit(registry);
  RegisterWatch(registry);
  RegisterStatus(registry);
  RegisterJobs(registry);
  RegisterLogs(registry);
  RegisterWorkers(registry);
  RegisterFarm(registry);
  RegisterSteer(registry);
  RegisterLimits(registry);
  RegisterFetch(registry);
  RegisterStream(registry);
  RegisterSearch(registry);
  RegisterAudit(registry);
  RegisterPage(registry);
}

int Report(const absl::Status& status, const Session& session) {
  std::string message(ToStd(status.message()));
  while (!message.empty() && message.back() == '\n') message.pop_back();
  if (absl::IsCancelled(status)) {
    // The user stopped it, which is not an error.
    *session.err().stream << session.err().Paint(Tone::kWarning, "stopped:") << " " << message
                          << "\n";
  } else {
    session.PrintError(message.empty() ? status.ToString() : message);
  }
  return ExitCodeOf(status);
}

// Returns the program's exit status, which tells of output that did not arrive. Who reads no more
// of it, such as `head`, knows.
int EndOutput(int exit_code, const Session& session) {
  if (session.out().stream->flush()) return exit_code;
  const int cause = session.out().write_error ? session.out().write_error() : 0;
  if (cause == EPIPE) return exit_code;
  session.PrintError(std::string("standard output: ") +
                     (cause != 0 ? std::strerror(cause) : "can't be written"));
  return exit_code == kExitOk ? kExitDisk : exit_code;
}

int RunChosen(const std::vector<std::string>& arguments, Environment& environment,
              CommonOptions& options, Session& session) {
  Action chosen;

  CLI::App app(kDescription, "parallax");
  app.formatter(MakeHelpFormatter());
  app.set_help_flag("-h,--help", "Show this help");
  app.set_version_flag("--version", std::string("parallax ") + kProgramVersion, "Show the version");
  app.footer(std::string(kExamples) + kExitCodeHelp);
  app.require_subcommand(0, 1);
  Registry registry{app, options, chosen};
  RegisterAll(registry);
  ReadNumbersAsDecimal(app);

  try {
    // CLI11 takes the arguments from the back.
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::CallForHelp&) {
    *environment.out.stream << ChosenCommand(&app)->help() << std::flush;
    return kExitOk;
  } catch (const CLI::CallForVersion& version) {
    *environment.out.stream << version.what() << "\n" << std::flush;
    return kExitOk;
  } catch (const CLI::ParseError& error) {
    session.PrintError(ExplainUsage(app, error, arguments));
    return kExitUsage;
  }
  if (!chosen) {
    *environment.err.stream << app.help() << std::flush;
    return kExitUsage;
  }
  const absl::StatusOr<ExitCode> result = chosen(session);
  environment.out.stream->flush();
  return result.ok() ? *result : Report(result.status(), session);
}

}  // namespace

int RunClient(const std::vector<std::string>& arguments, Environment& environment) {
  SetPictureRoot("/");  // This program reads what its user may read.
  CommonOptions options;
  // Not through CLI11: it would read the variable for every command that has the option, and so
  // once more after the option of the command given.
  if (const char* address = std::getenv("PARALLAX_COORDINATOR");
      address != nullptr && *address != '\0') {
    options.coordinator = address;
  }
  if (const char* dir = std::getenv("PARALLAX_TLS"); dir != nullptr) options.tls_dir = dir;
  Session session{environment, options};
  return EndOutput(RunChosen(arguments, environment, options, session), session);
}

}  // namespace parallax::client
