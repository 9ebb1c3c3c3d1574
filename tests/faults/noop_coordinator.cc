// `coordinator serve` with the kind `noop`: each study's noop jobs wait for its pairs and for each
// other.
#include <CLI/CLI.hpp>
#include <iostream>

#include "common/base/system/log.h"
#include "coordinator/serve.h"
#include "tests/noop/noop_kind.h"

namespace parallax {
namespace {

int Main(int argc, char** argv) {
  const NoopKind noop(NoopKind::AfterPairs);
  const KindRegistry kinds = KindRegistry::Builtin().With(noop);
  ServeOptions options;
  options.kinds = &kinds;
  CLI::App app("A coordinator for tests, with jobs that wait for others.");
  app.require_subcommand(1);
  CLI::App* serve = app.add_subcommand("serve", "Serve until SIGTERM");
  serve->add_option("--db", options.db, "Database file")->required();
  serve->add_option("--store", options.store, "Folder of the results")->required();
  serve->add_option("--listen", options.listen, "gRPC address");
  serve->add_option("--http", options.http, "HTTP address");
  serve->add_option("--lease-s", options.lease_s, "Seconds without a heartbeat");
  serve->add_option("--reconnect-s", options.reconnect_grace_s, "Seconds to come back");
  CLI11_PARSE(app, argc, argv);
  InitLogging({.level = LogLevel::kInfo, .program = "coordinator"});
  const ProgramError error = Serve(options);
  if (error.status.ok()) return kExitOk;
  std::cerr << "coordinator: " << ToStd(error.status.message()) << std::endl;
  return error.exit;
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) { return parallax::Main(argc, argv); }
