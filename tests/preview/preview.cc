// Draws what is made, to be looked at at full size; `preview COMMAND --help` lists the options.
#include "tests/preview/preview.h"

#include <cstdio>

#include "common/base/system/log.h"

namespace parallax::preview {
namespace {

struct Command {
  const char *name, *about;
  Action (*add)(CLI::App&);
};

constexpr Command kCommands[] = {
    {"assets", "Classes in one flat colour a slot; magenta is seen from behind", Assets},
    {"materials", "Materials on a ball, a board and a chair, and close by", Materials},
    {"plants", "Things side by side on the ground under the sun, and their error", Plants},
    {"rooms", "Solved rooms: from above without a ceiling, and from a corner", Rooms},
    {"terrain", "Landforms from above: the region and the site", Terrain},
    {"render", "Rigs of a scene with their maps, timing and error", Render},
    {"frames", "A study solved, rendered and archived in this process", Frames}};

int Main(int argc, char** argv) {
  CLI::App app("Draws what is made, to be looked at");
  app.require_subcommand(1);
  absl::Status status;
  for (const Command& command : kCommands) {
    CLI::App* sub = app.add_subcommand(command.name, command.about);
    sub->callback([action = command.add(*sub), &status] { status = action(); });
  }
  InitLogging({.program = "preview"});
  CLI11_PARSE(app, argc, argv);
  if (status.ok()) return 0;
  std::fprintf(stderr, "preview: %s\n", std::string(status.message()).c_str());
  return 1;
}

}  // namespace
}  // namespace parallax::preview

int main(int argc, char** argv) { return parallax::preview::Main(argc, argv); }
