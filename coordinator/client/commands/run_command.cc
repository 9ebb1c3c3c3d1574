// run: from a study to a dataset on this machine, with nothing to set up.
#include <algorithm>
#include <filesystem>
#include <istream>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/system/cores.h"
#include "coordinator/client/command.h"
#include "coordinator/client/content/machine_check.h"
#include "coordinator/client/content/ship_content.h"
#include "coordinator/client/content/study_options.h"
#include "coordinator/client/runs/embedded_run.h"
#include "coordinator/client/runs/out_dir.h"
#include "coordinator/client/runs/shared_store.h"
#include "coordinator/client/views/study_table.h"
#include "coordinator/client/views/study_view.h"
#include "coordinator/client/views/text.h"
#include "worker/dataset/sheets/contact_sheet.h"

namespace parallax::client {
namespace {

struct RunOptions {
  StudyOptions study;
  std::string out;
  std::string store;
  int workers = 0;  // 0: as many as suit this machine.
  MachineOptions machine;
  bool page = false;
  std::string page_listen = "127.0.0.1:0";
  bool yes = false;
};

// Rendering one job uses all cores by itself; a second worker fills the gaps that solving, building
// and writing leave, and on large machines more do.
int DefaultWorkers() {
  const int cores = UsableCores();
  return cores == 1 ? 1 : std::max(2, cores / 8);
}

absl::Status ConfirmSpace(const v1::StudySpec& study, const OutDir& out, const RunOptions& options,
                          const Session& session) {
  const int64_t free = out.FreeBytes();
  const int64_t needed = EstimateMissingBytes(study, out.path());
  if (free < 0 || needed < free) return absl::OkStatus();
  return session.Confirm("the study needs about " + FormatBytes(static_cast<double>(needed)) +
                             ", but only " + FormatBytes(static_cast<double>(free)) +
                             " are free on the disk of " + out.path(),
                         options.yes);
}

void PrintOpening(const v1::StudySpec& study, const OutDir& out, int workers,
                  const Session& session) {
  *session.err().stream << session.err().Paint(Tone::kBold, study.name()) << ": "
                        << DescribeSize(study) << " -> " << out.path() << " ("
                        << Plural(workers, "worker") << ", " << Plural(UsableCores(), "core")
                        << ")\n"
                        << std::flush;
}

// The contact sheet is optional: if it can't be drawn, there is a note and no failure.
void DrawSheet(RunReport& report, const Session& session) {
  const std::string path = report.out_dir + "/contact_sheet.png";
  std::error_code error;
  if (report.frames_in_dataset == 0) return;
  if (report.pairs_rendered == 0 && std::filesystem::exists(path, error)) {
    report.contact_sheet = path;
    report.histograms = report.out_dir + "/contact_sheet_histograms.png";
    return;
  }
  const absl::StatusOr<ContactSheetResult> sheet = MakeContactSheet(report.out_dir, path);
  if (!sheet.ok()) {
    session.PrintNote("no contact sheet: " + FirstLine(ToStd(sheet.status().message())));
    return;
  }
  report.contact_sheet = sheet->sheet_png;
  report.histograms = sheet->histogram_png;
  report.warp_median_difference = sheet->warp_median_difference;
}

absl::StatusOr<ExitCode> Run(const RunOptions& options, Session& session) {
  EmbeddedRunOptions run_options;
  ASSIGN_OR_RETURN(run_options.study, ResolveStudy(options.study));
  RETURN_IF_ERROR(CheckMachine(run_options.study, options.study.study, options.machine));
  RETURN_IF_ERROR(HashContent(run_options.study, FolderReaders::kOfRun));
  NameOwnCopies(run_options.study);
  run_options.machine = options.machine;
  if (options.page) run_options.page = options.page_listen;
  run_options.workers = options.workers > 0 ? options.workers : DefaultWorkers();
  RETURN_IF_ERROR(CheckNotInDataset(options.out));
  if (HoldsForeignFiles(options.out)) {
    RETURN_IF_ERROR(session.Confirm(options.out + " holds files that are no dataset", options.yes));
  }
  ASSIGN_OR_RETURN(const auto out, OutDir::Open(options.out));
  RETURN_IF_ERROR(ConfirmSpace(run_options.study, *out, options, session));
  ASSIGN_OR_RETURN(run_options.store_dir, ChooseStore(options.store, out->work_dir()));
  std::optional<FolderLock> store_lock;
  if (run_options.store_dir != out->work_dir()) {
    RETURN_IF_ERROR(CheckFreeSpaceOf(run_options.store_dir));
    ASSIGN_OR_RETURN(FolderLock taken,
                     FolderLock::Take(run_options.store_dir, run_options.store_dir,
                                      "or choose another --store"));
    store_lock.emplace(std::move(taken));
  }
  RunReport report;
  {
    ASSIGN_OR_RETURN(const auto run, EmbeddedRun::Open(run_options, *out, session.environment));
    PrintOpening(run_options.study, *out, run_options.workers, session);
    if (store_lock) session.PrintNote("pairs are shared by " + run_options.store_dir);
    for (const std::string& text : run->set_aside()) session.PrintNote(text);
    if (!run->page_link().empty()) {
      *session.err().stream << "page: " << run->page_link() << " (works once)\n" << std::flush;
    }
    ASSIGN_OR_RETURN(report, run->Work());
    report.set_aside = run->set_aside();
  }
  DrawSheet(report, session);
  ASSIGN_OR_RETURN(report.table,
                   WriteStudyTable(report.out_dir, run_options.study, report.score_files));
  if (session.options.json) {
    session.PrintJson(RunReportJson(report));
  } else {
    PrintRunReport(session.out(), report);
  }
  if (report.study.state() == v1::STUDY_STATE_SUCCEEDED) return kExitOk;
  for (const std::string& line : ProblemLines(session.err(), report.study, 5)) {
    *session.err().stream << line << "\n";
  }
  session.PrintError("the study " + StateName(report.study.state()) + "; worker logs are in " +
                     out->work_dir() + "/logs, the same command tries failed jobs again");
  return kExitFailed;
}

}  // namespace

void RegisterRun(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "run", "Make a dataset on this machine, with nothing to set up",
      "A coordinator runs inside this command and workers beside it; nothing listens on a port\n"
      "unless --page is given.\n"
      "Pairs appear in DIR as they are finished. Ctrl-C stops after the pairs that are being\n"
      "rendered; the same command resumes. The study may grow or change: the command adds missing\n"
      "pairs, variants, seeds, mixtures and benchmarks, renders variants with new settings again,\n"
      "and makes nothing twice. Data that the study no longer uses goes to DIR/.parallax/aside.\n"
      "A study that trains networks ends with its table: DIR/training, DIR/scores, DIR/table.txt.\n"
      "DIR/.parallax has the worker logs and what a resumed run needs.\n"
      "\n"
      "Examples:\n"
      "  parallax run quickstart --out out/quickstart\n"
      "  parallax run baseline --out out/baseline --pairs 100 --profile high\n"
      "  parallax run table1-small --out out/table1 --page\n"
      "  parallax run my.yaml --out out/my --store ~/pairs    shared with other datasets\n"
      "  parallax run my.yaml --out /data/my --width 640 --height 480 --json > report.json\n");
  auto options = std::make_shared<RunOptions>();
  AddStudyOptions(*command, options->study);
  AddOption(command, "-o,--out", "DIR", options->out, "The dataset folder")->required();
  AddOption(command, "--store", "DIR", options->store,
            "Folder that datasets share, so that one uses the pairs of the others (default:\n"
            "where the dataset began, else $PARALLAX_STORE, else parallax/store in\n"
            "$XDG_CACHE_HOME or ~/.cache if you made that folder, else in DIR/.parallax)");
  command
      ->add_option("--workers", options->workers,
                   "Worker processes (default: 2, more on large machines); each uses all cores")
      ->check(CLI::Range(1, 256));
  AddMachineOptions(*command, options->machine);
  command->add_flag("--page", options->page,
                    "Serve the web page during the run; prints a link that works once");
  AddOption(command, "--page-listen", "HOST:PORT", options->page_listen,
            "Address of the page (default 127.0.0.1 and any free port)");
  command->add_flag("-y,--yes", options->yes,
                    "Do not ask about foreign files in DIR or little disk space");
  registry.AddJsonOption(command);
  registry.SetAction(command, [options](Session& session) { return Run(*options, session); });
}

}  // namespace parallax::client
