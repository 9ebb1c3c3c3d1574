// view: what is in a dataset, as a picture.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "coordinator/client/commands/command.h"
#include "coordinator/client/text.h"
#include "worker/dataset/contact_sheet.h"

namespace parallax::client {
namespace {

struct ViewOptions {
  std::string dir;
  std::string out;
  int rows = 8;
};

absl::StatusOr<ExitCode> View(const ViewOptions& options, Session& session) {
  std::error_code error;
  if (!std::filesystem::is_directory(options.dir, error)) {
    return MakeError(absl::StatusCode::kNotFound, options.dir + ": no such folder");
  }
  const std::string out = options.out.empty() ? options.dir + "/contact_sheet.png" : options.out;
  ContactSheetOptions sheet;
  sheet.max_frames = options.rows;
  ASSIGN_OR_RETURN(const ContactSheetResult result, MakeContactSheet(options.dir, out, sheet));
  if (session.options.json) {
    session.PrintJson({{"contact_sheet", result.sheet_png},
                       {"histograms", result.histogram_png},
                       {"rows", result.frames},
                       {"frames_found", result.frames_found},
                       {"warp_median_difference", result.warp_median_difference}});
    return kExitOk;
  }
  std::ostream& out_stream = *session.out().stream;
  out_stream << result.sheet_png << "\n" << result.histogram_png << "\n";
  *session.err().stream << FormatCount(result.frames) << " of "
                        << Plural(result.frames_found, "pair") << " shown";
  if (result.warp_median_difference >= 0) {
    *session.err().stream << "; right warped onto left differs by "
                          << FormatNumber(result.warp_median_difference) << "/255 in the median";
  }
  *session.err().stream << "\n";
  return kExitOk;
}

}  // namespace

void RegisterView(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "view", "Draw a contact sheet and histograms of a dataset",
      "One row a pair: left, right, disparity, depth and the index maps; beside it a page of\n"
      "histograms. Any folder above frame folders will do.\n"
      "\n"
      "Examples:\n"
      "  parallax view out/quickstart\n"
      "  parallax view out/baseline/narrow --rows 20 --out narrow.png\n");
  command->group(kLocalCommands);
  auto options = std::make_shared<ViewOptions>();
  command->add_option("DIR", options->dir, "A dataset, or a part of one")->required();
  command->add_option("-o,--out", options->out, "The picture (default: DIR/contact_sheet.png)")
      ->type_name("PNG");
  command->add_option("--rows", options->rows, "Pairs shown, spread evenly (default 8)")
      ->check(CLI::Range(1, 200));
  registry.AddJsonOption(command);
  registry.SetAction(command, [options](Session& session) { return View(*options, session); });
}

}  // namespace parallax::client
