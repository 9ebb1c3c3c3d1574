// view: what is in a dataset, as a picture.
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/base/status.h"
#include "coordinator/client/command.h"
#include "coordinator/client/connection.h"
#include "coordinator/client/interrupt.h"
#include "coordinator/client/runs/embedded_coordinator.h"
#include "coordinator/client/runs/shared_store.h"
#include "coordinator/client/views/text.h"
#include "worker/dataset/sheets/contact_sheet.h"
#include "worker/dataset/sheets/variant_sheet.h"

namespace parallax::client {
namespace {

struct ViewOptions {
  std::string dir;
  std::string out;
  int rows = 0;  // 0: eight, or three with `variants`.
  bool variants = false;
  bool page = false;
  std::string page_listen = "127.0.0.1:0";
};

absl::StatusOr<ExitCode> ViewVariants(const ViewOptions& options, Session& session) {
  const std::string out = options.out.empty() ? options.dir + "/variants.png" : options.out;
  VariantSheetOptions sheet;
  if (options.rows > 0) sheet.max_pairs = options.rows;
  ASSIGN_OR_RETURN(const VariantSheetResult result, MakeVariantSheet(options.dir, out, sheet));
  if (session.options.json) {
    return session.PrintJson({{"variant_sheet", result.sheet_png},
                              {"variants", result.variants},
                              {"pairs", result.pairs},
                              {"pairs_common", result.pairs_common},
                              {"full_scale_px", result.full_scale_px}});
  }
  *session.out().stream << result.sheet_png << "\n";
  *session.err().stream << FormatCount(result.pairs) << " of "
                        << Plural(result.pairs_common, "pair") << " that all of "
                        << Plural(static_cast<int64_t>(result.variants.size()), "variant")
                        << " have\n";
  return kExitOk;
}

void PrintPage(const std::string& link, const char* note, Session& session) {
  if (session.options.json) {
    session.PrintJson({{"page", link}});
  } else {
    *session.out().stream << link << "\n" << std::flush;
  }
  session.PrintNote(note);
}

// The page over a run's folder: the run's own while it runs, else one of this process.
absl::StatusOr<ExitCode> ViewPage(const ViewOptions& options, Session& session) {
  // Database and store may be in a folder that several datasets share.
  const std::string work_dir =
      StoreOf((std::filesystem::absolute(options.dir) / ".parallax").string());
  if (const auto address = AddressOfRun(work_dir); address.ok()) {
    ASSIGN_OR_RETURN(const auto connection, Connection::Open(*address));
    ASSIGN_OR_RETURN(const std::string link, connection->OpenPage());
    PrintPage(link, "the run that writes this folder serves the page, until it ends", session);
    return kExitOk;
  }
  InterruptScope interrupts;
  ASSIGN_OR_RETURN(const auto coordinator, EmbeddedCoordinator::StartToView(work_dir));
  ASSIGN_OR_RETURN(const std::string link, coordinator->ServePage(options.page_listen));
  PrintPage(link, "works once, and the page is read-only; Ctrl-C ends it", session);
  while (!interrupts.WaitFor(std::chrono::hours(1))) {
  }
  return kExitOk;
}

absl::StatusOr<ExitCode> View(const ViewOptions& options, Session& session) {
  std::error_code error;
  if (!std::filesystem::is_directory(options.dir, error)) {
    return NotFound("{}: no such folder", options.dir);
  }
  if (options.page) return ViewPage(options, session);
  if (options.variants) return ViewVariants(options, session);
  const std::string out = options.out.empty() ? options.dir + "/contact_sheet.png" : options.out;
  ContactSheetOptions sheet;
  if (options.rows > 0) sheet.max_frames = options.rows;
  ASSIGN_OR_RETURN(const ContactSheetResult result, MakeContactSheet(options.dir, out, sheet));
  if (session.options.json) {
    return session.PrintJson({{"contact_sheet", result.sheet_png},
                              {"histograms", result.histogram_png},
                              {"rows", result.frames},
                              {"frames_found", result.frames_found},
                              {"warp_median_difference", result.warp_median_difference}});
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
      registry.app, "view", "Show a dataset: a contact sheet and histograms, or the web page",
      "One row a pair: left, right, disparity, occlusion, objects, materials and normals, as far "
      "as\n"
      "they were written; beside it a page of histograms. Any folder above frame folders will do.\n"
      "\n"
      "Examples:\n"
      "  parallax view out/quickstart\n"
      "  parallax view out/baseline/narrow --rows 20 --out narrow.png\n"
      "  parallax view out/table1 --variants       the same pair of each variant side by side\n"
      "  parallax view out/table1 --page           in the browser: pairs, jobs, logs, results\n");
  auto options = std::make_shared<ViewOptions>();
  command->add_option("DIR", options->dir, "A dataset, or a part of one")->required();
  AddOption(command, "-o,--out", "PNG", options->out,
            "The picture (default: DIR/contact_sheet.png)");
  command
      ->add_option("--rows", options->rows,
                   "Pairs shown, spread evenly (default 8, with --variants 3)")
      ->check(CLI::Range(1, 200));
  command->add_flag("--variants", options->variants,
                    "The same pairs of all variants side by side (DIR/variants.png)");
  command->add_flag(
      "--page", options->page,
      "Serve the web page over a folder of `run`, finished or running; writes nothing "
      "there");
  AddOption(command, "--page-listen", "HOST:PORT", options->page_listen,
            "Address of the page (default 127.0.0.1 and any free port)");
  registry.AddJsonOption(command);
  registry.SetAction(command, [options](Session& session) { return View(*options, session); });
}

}  // namespace parallax::client
