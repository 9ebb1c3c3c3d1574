// preview: a small pair of each variant of a study, before anything is paid for.
#include <fmt/format.h>

#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>

#include "common/base/seconds.h"
#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/config/config.h"
#include "common/image/io.h"
#include "coordinator/client/command.h"
#include "coordinator/client/content/own_folders.h"
#include "coordinator/client/interrupt.h"
#include "coordinator/client/preview/preview_page.h"
#include "coordinator/client/preview/study_preview.h"
#include "coordinator/client/preview/watch_loop.h"
#include "coordinator/client/views/text.h"
#include "coordinator/client/views/text_table.h"
#include "coordinator/view/json_list.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kLineEvery_s = 10;  // Time between lines of progress.

struct PreviewCommandOptions {
  PreviewOptions preview;
  std::string out;
  bool watch = false;
  bool page = false;
  std::string page_listen = "127.0.0.1:0";
};

std::string SharePercent(double share) { return fmt::format("{:.1f} %", 100 * share); }

Json VariantJson(const PreviewRow& row) {
  Json json = {{"name", row.name}, {"note", row.note}};
  if (!row.pair) return json;
  const PreviewPair& pair = *row.pair;
  const DisparityFigures& figures = pair.disparities;
  json.update(Json{{"width_px", pair.rig.width_px()},
                   {"height_px", pair.rig.height_px()},
                   {"baseline_m", pair.rig.baseline_m()},
                   {"disparity_min_px", figures.min_px},
                   {"disparity_max_px", figures.max_px},
                   {"disparity_mean_px", figures.mean_px},
                   {"disparity_median_px", figures.median_px},
                   {"share_below_1px", figures.share_below_1px},
                   {"share_beyond_192px", figures.share_beyond_192px},
                   {"share_no_surface", figures.share_no_surface}});
  if (pair.raw_left.empty()) return json;
  json["raw"] = {{"rows_apart_mean_px", pair.rows.raw_mean_px},
                 {"rows_apart_max_px", pair.rows.raw_max_px},
                 {"rectified_rows_apart_max_px", pair.rows.rectified_max_px}};
  return json;
}

ImageRgb8 SheetOf(const std::string& file, const Preview& preview) {
  PreviewText text;
  const size_t variants = preview.rows.size();
  text.title =
      preview.name + (variants == 1 ? ": its first pair"
                                    : fmt::format(": the first pair of {} variants", variants));
  text.below_title = fmt::format(
      "{}, seed {}; drawn smaller, in profile preview; figures in pixels of its own size",
      fs::path(file).filename().string(), preview.seed);
  if (!preview.left_out.empty()) {
    text.last_line =
        fmt::format("not shown (--variants chooses): {}", fmt::join(preview.left_out, ", "));
  }
  return DrawPreviewSheet(text, preview.rows);
}

std::string AbsolutePath(const std::string& path) { return fs::absolute(path).lexically_normal(); }

// Makes previews and tells of them, until the work is done or the user ends it.
class PreviewRun {
 public:
  PreviewRun(const PreviewCommandOptions& options, Session& session)
      : options_(options),
        session_(session),
        part_(options.out + ".part"),
        files_({AbsolutePath(options.out), AbsolutePath(part_)}) {}

  absl::StatusOr<ExitCode> Run() {
    RETURN_IF_ERROR(IsStudy(options_.preview.file).status());  // A name that nobody knows.
    if (options_.page) {
      ASSIGN_OR_RETURN(page_, PreviewPage::Start(options_.page_listen, options_.preview.file));
      if (!session_.options.json) *session_.out().stream << page_->link() << "\n" << std::flush;
    }
    InterruptScope interrupts;
    files_.Watch({options_.preview.file});
    const bool ended = RunWatchLoop(
        {.work = [this](const CancelToken& cancel) { Work(cancel); },
         .wait = [&](std::chrono::milliseconds time) { return interrupts.WaitFor(time); },
         .busy = [this] { TellBusy(); },
         .again = options_.watch},
        files_);
    if (options_.watch) return kExitOk;  // Its only end.
    if (ended && !result_.ok()) return Cancelled("no sheet was made");
    RETURN_IF_ERROR(result_);
    return kExitOk;
  }

 private:
  void Work(const CancelToken& cancel) {
    Begin();
    PreviewWatcher watcher;
    watcher.cancel = cancel;
    watcher.stage = [this](const std::string& stage) {
      const std::lock_guard lock(mutex_);
      stage_ = stage;
    };
    watcher.files = [this](std::vector<std::string> paths) {
      paths.push_back(options_.preview.file);
      files_.Watch(paths);
    };
    absl::Status status = [&]() -> absl::Status {
      ASSIGN_OR_RETURN(const Preview preview, maker_.Make(options_.preview, watcher));
      return Finish(preview);
    }();
    const std::lock_guard lock(mutex_);
    stage_.clear();
    result_ = status;
    // Begun anew, or ended: nobody waits for the error.
    if (status.ok() || cancel.cancelled()) return;
    const std::string error(ToStd(status.message()));
    if (page_) page_->Tell({.text = "mend it and save", .error = error});
    if (options_.watch) session_.PrintError(error);
  }

  void Begin() {
    const std::lock_guard lock(mutex_);
    begun_ = std::chrono::steady_clock::now();
    next_line_s_ = kLineEvery_s;
    stage_ = "reading";
    if (page_) page_->Tell({.making = true, .text = "is made"});
  }

  // Writes the sheet and tells of it.
  absl::Status Finish(const Preview& preview) {
    ASSIGN_OR_RETURN(std::string png, EncodePng(SheetOf(options_.preview.file, preview)));
    // A reader of the file sees the old sheet or the new one, never half of one.
    RETURN_IF_ERROR(WriteFile(part_, png));
    std::error_code error;
    fs::rename(part_, options_.out, error);
    if (error) return ErrnoError(error.value(), "write " + options_.out);
    const double seconds = SecondsSince(begun_);
    const std::lock_guard lock(mutex_);
    if (page_) {
      page_->Show(std::move(png));
      page_->Tell({.text = fmt::format("made at {} in {:.1f} s, saved as {}", Now().substr(11),
                                       seconds, options_.out)});
    }
    Print(preview, seconds);
    return absl::OkStatus();
  }

  std::string Now() const { return FormatUnixTime(session_.environment.clock->UnixSeconds()); }

  void Print(const Preview& preview, double seconds) {
    if (session_.options.json) return PrintAsJson(preview, seconds);
    const Terminal& out = session_.out();
    Table table({"variant", Right("disparity px"), Right("mean"), Right("median"),
                 Right("below 1 px"), Right("beyond 192 px"), Right("no surface"), ""});
    for (const PreviewRow& row : preview.rows) {
      if (!row.pair) {
        table.AddRow({row.name, "-", "-", "-", "-", "-", "-", row.note});
        continue;
      }
      const DisparityFigures& figures = row.pair->disparities;
      table.AddRow({row.name, fmt::format("{:.1f} to {:.1f}", figures.min_px, figures.max_px),
                    fmt::format("{:.1f}", figures.mean_px),
                    fmt::format("{:.1f}", figures.median_px), SharePercent(figures.share_below_1px),
                    SharePercent(figures.share_beyond_192px),
                    SharePercent(figures.share_no_surface), row.note});
    }
    table.Print(out);
    *out.stream << options_.out << "\n" << std::flush;
    std::ostream& err = *session_.err().stream;
    err << Plural(static_cast<int64_t>(preview.rows.size()), "variant") << " in "
        << FormatDuration(seconds);
    if (!preview.left_out.empty()) {
      err << "; not shown: " << fmt::format("{}", fmt::join(preview.left_out, ", "));
    }
    if (options_.watch) {
      err << "; made anew when " << options_.preview.file
          << " or a file that it names is saved, until Ctrl-C";
    }
    err << "\n" << std::flush;
  }

  void PrintAsJson(const Preview& preview, double seconds) {
    const DisparityScale scale = ScaleOf(preview.rows);
    session_.PrintJson({{"file", options_.preview.file},
                        {"name", preview.name},
                        {"seed", preview.seed},
                        {"sheet", options_.out},
                        {"page", page_ ? Json(page_->link()) : Json()},
                        {"seconds", seconds},
                        {"scale_px", {scale.low_px, scale.high_px}},
                        {"variants", JsonList(preview.rows, VariantJson)},
                        {"left_out", preview.left_out}},
                       /*one_line=*/options_.watch);
  }

  // A line now and then while the user waits for long.
  void TellBusy() {
    const std::lock_guard lock(mutex_);
    const double seconds = SecondsSince(begun_);
    if (stage_.empty() || seconds < next_line_s_) return;
    next_line_s_ = seconds + kLineEvery_s;
    session_.PrintNote(fmt::format("{}, {:.0f} s so far", stage_, seconds));
  }

  const PreviewCommandOptions& options_;
  Session& session_;
  const std::string part_;
  WatchedFiles files_;
  std::unique_ptr<PreviewPage> page_;
  StudyPreview maker_;
  std::mutex mutex_;
  // Guarded by mutex_; the session's streams as well, while the work is done.
  std::string stage_ = "reading";
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  double next_line_s_ = kLineEvery_s;
  absl::Status result_;
};

// Errors: what would only come out when the sheet is made.
absl::Status CheckSheetFile(const std::string& out) {
  const fs::path path(out);
  if (path.extension() != ".png") {
    return InvalidArgument("--out: {} is no name of a picture, allowed is one that ends with .png",
                           out);
  }
  std::error_code error;
  if (fs::is_directory(path, error)) {
    return InvalidArgument("--out: {} is a folder, allowed is a file", out);
  }
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error)) {
    return NotFound("--out: {}: no such folder", folder.string());
  }
  return absl::OkStatus();
}

absl::StatusOr<ExitCode> RunPreview(PreviewCommandOptions options, Session& session) {
  if (options.out.empty()) {
    options.out = fs::path(options.preview.file).stem().string() + "-preview.png";
  }
  RETURN_IF_ERROR(CheckSheetFile(options.out));
  options.watch = options.watch || options.page;
  return PreviewRun(options, session).Run();
}

}  // namespace

void RegisterPreview(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "preview", "See a small pair of each variant of a study, in seconds",
      "A sheet with a row for each variant: left, right, disparity in colours, and what it says:\n"
      "range, mean, shares of pixels below 1 px and beyond the 192 px of trainers; of raw cameras\n"
      "also the raw pair with rows of the rectified one. The pair is the first that the study "
      "will\n"
      "have; only the pictures are smaller. Figures are in pixels of the study's own size.\n"
      "\n"
      "Examples:\n"
      "  parallax preview my-study.yaml\n"
      "  parallax preview table1-small --variants default,baseline-wide --out wide.png\n"
      "  parallax preview my-study.yaml --watch     the sheet follows each save of the file\n"
      "  parallax preview my-study.yaml --page      so does a page in the browser\n");
  auto options = std::make_shared<PreviewCommandOptions>();
  command
      ->add_option("FILE", options->preview.file,
                   "Study or scene file, or the name of a built-in one")
      ->required();
  AddOption(command, "-o,--out", "PNG", options->out,
            "The sheet (default: FILE's name with -preview.png, in this folder)");
  AddOption(command, "--variants", "NAMES", options->preview.variants,
            "Variants to show, with commas between them (default: the first 8)")
      ->delimiter(',');
  command->add_option("--seed", options->preview.seed, "Another seed: other scenes")
      ->check(WhyNotSeed);
  command->add_flag("--watch", options->watch,
                    "Make the sheet anew whenever the file, or one that it names, is saved; Ctrl-C "
                    "ends it");
  command->add_flag("--page", options->page,
                    "Show it in the browser, too: prints a link; with --watch");
  AddOption(command, "--page-listen", "HOST:PORT", options->page_listen,
            "Address of the page (default 127.0.0.1 and any free port)");
  AddFollowLinksOption(*command);
  registry.AddJsonOption(command);
  registry.SetAction(command,
                     [options](Session& session) { return RunPreview(*options, session); });
}

}  // namespace parallax::client
