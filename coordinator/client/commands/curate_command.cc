// curate: which pairs of a dataset trained networks can't match.
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "common/base/seconds.h"
#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/base/system/installation.h"
#include "common/config/config.h"
#include "coordinator/client/cancellable.h"
#include "coordinator/client/commands/evaluate_command.h"
#include "coordinator/client/content/predictor_choice.h"
#include "coordinator/client/content/trained_networks.h"
#include "coordinator/client/runs/out_dir.h"
#include "coordinator/client/views/text.h"
#include "worker/dataset/archive/judge_archive.h"
#include "worker/evaluate/curate.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct CurateCommandOptions {
  std::string dir;
  std::vector<std::string> checkpoints, variants;
  std::optional<double> max_share;
  PredictorChoice predictor;  // Without `what`.
};

// One variant to curate.
struct Task {
  DatasetVariant variant;
  v1::VariantSpec spec;               // With the filters to judge by.
  std::vector<std::string> networks;  // Paths.
};

// One call of the command.
class Curation {
 public:
  Curation(const CurateCommandOptions& options, Session& session)
      : options_(options), session_(session) {}

  absl::StatusOr<ExitCode> Run() {
    ASSIGN_OR_RETURN(Dataset dataset, ReadDataset(options_.dir));
    RETURN_IF_ERROR(RequireIndices(dataset));
    const bool is_variant = dataset.variants.size() == 1 && dataset.variants[0].dir == dataset.dir;
    root_ = is_variant ? fs::path(dataset.dir).parent_path().string() : dataset.dir;
    ASSIGN_OR_RETURN(const std::string lock, ReadFile(root_ + "/study.lock.yaml"));
    ASSIGN_OR_RETURN(study_, ParseStudy(lock, root_ + "/study.lock.yaml"));
    ASSIGN_OR_RETURN(std::vector<DatasetVariant> variants,
                     ChooseVariants(std::move(dataset), options_.variants));
    RETURN_IF_ERROR(MakeTasks(std::move(variants)));
    RETURN_IF_ERROR(OpenNetworks());
    ASSIGN_OR_RETURN(const std::unique_ptr<OutDir> held, OutDir::Open(root_));
    work_dir_ = held->work_dir() + "/curate";
    RETURN_IF_ERROR(MakeFolders(work_dir_));
    const absl::Status status = CurateAll();
    std::error_code error;
    fs::remove_all(work_dir_, error);
    RETURN_IF_ERROR(status);
    if (session_.options.json) {
      session_.PrintJson(
          {{"dir", options_.dir}, {"networks", NetworksJson()}, {"variants", json_}});
    }
    return kExitOk;
  }

 private:
  absl::Status MakeTasks(std::vector<DatasetVariant> variants) {
    for (DatasetVariant& variant : variants) {
      const auto spec = std::find_if(
          study_.variants().begin(), study_.variants().end(),
          [&](const v1::VariantSpec& candidate) { return candidate.name() == variant.name; });
      if (spec == study_.variants().end()) {
        return FailedPrecondition("{}/study.lock.yaml has no variant '{}'", root_, variant.name);
      }
      // Held-out pairs judge networks: to leave out those that networks miss would flatter all.
      if (spec->heldout() && options_.variants.empty()) continue;
      Task task{.variant = std::move(variant), .spec = *spec};
      if (options_.max_share) {
        task.spec.mutable_config()->mutable_filters()->set_max_ambiguous_share(*options_.max_share);
      }
      ASSIGN_OR_RETURN(task.networks, NetworksOf(task.variant.name));
      tasks_.push_back(std::move(task));
    }
    return absl::OkStatus();
  }

  // Returns the paths of those that were named; else of the study's own, else of the one that comes
  // with Parallax.
  absl::StatusOr<std::vector<std::string>> NetworksOf(const std::string& variant) {
    std::vector<std::string> networks = options_.checkpoints;
    for (std::string& path : networks) {
      if (path != kShippedNetwork) continue;
      ASSIGN_OR_RETURN(path, FindNetwork());
    }
    if (!networks.empty()) return networks;
    const auto own = NetworksFor(root_, study_, variant);
    if (own.ok()) return own;
    const absl::StatusOr<std::string> shipped = FindNetwork();
    if (!shipped.ok())
      return WithContext(shipped.status(), std::string(ToStd(own.status().message())));
    session_.PrintNote(variant + ": " + root_ +
                       "/training has no network that was trained on it; the one that comes with "
                       "Parallax scores it");
    return std::vector<std::string>{*shipped};
  }

  absl::Status OpenNetworks() {
    for (const Task& task : tasks_) {
      for (const std::string& path : task.networks) {
        if (networks_.count(path) > 0) continue;
        std::error_code error;
        if (!fs::is_regular_file(path, error)) {
          return NotFound("--checkpoint {}: no such file", path);
        }
        PredictorChoice choice = options_.predictor;
        choice.what = path;
        ASSIGN_OR_RETURN(networks_[path], ChoosePredictor(choice));
      }
    }
    return absl::OkStatus();
  }

  // The same network under two names counts once.
  std::vector<std::string> IdsOf(const Task& task) const {
    std::set<std::string> ids;
    for (const std::string& path : task.networks) ids.insert(networks_.at(path).run.checkpoint);
    return {ids.begin(), ids.end()};
  }

  absl::Status CurateAll() {
    for (const Task& task : tasks_)
      total_ += Frames(task) * static_cast<int64_t>(IdsOf(task).size());
    const CancellableScope cancellable;
    start_ = session_.environment.clock->Steady();
    for (const Task& task : tasks_) RETURN_IF_ERROR(CurateOne(task, cancellable.token()));
    return absl::OkStatus();
  }

  static int64_t Frames(const Task& task) {
    return static_cast<int64_t>(task.variant.frames.size());
  }

  absl::Status CurateOne(const Task& task, const CancelToken& cancel) {
    ASSIGN_OR_RETURN(CurationLog log, CurationLog::Open(task.variant.dir));
    const std::vector<std::string> ids = IdsOf(task);
    int64_t scored = 0;
    for (const std::string& id : ids) {
      const auto known = [&](const auto& network) { return network.second.run.checkpoint == id; };
      const auto network = std::find_if(networks_.begin(), networks_.end(), known);
      const CurateOptions options{
          .work_dir = work_dir_,
          .cancel = cancel,
          .clock = session_.environment.clock,
          .progress = [&](int64_t done, int64_t) { ShowProgress(task.variant.name, done); }};
      absl::StatusOr<int64_t> now = ScoreFrames(
          task.variant, {.id = id, .predictor = network->second.predictor.get()}, options, log);
      ClearProgress();
      if (absl::IsCancelled(now.status())) return Cancelled("stopped; the same command resumes");
      RETURN_IF_ERROR(now.status());
      done_ += Frames(task);
      scored += *now;
    }
    const std::map<FrameId, double> shares = AmbiguousShares(task.variant, ids, log);
    ASSIGN_OR_RETURN(const JudgedVariant judged,
                     JudgeVariant(task.variant.dir, study_, task.spec, shares));
    Report(task, judged, shares, scored);
    return absl::OkStatus();
  }

  // Frames that were known count as work that took no time: the estimate starts with the others.
  void ShowProgress(const std::string& variant, int64_t done) {
    if (!session_.err().interactive) return;
    const int64_t all = done_ + done;
    if (first_ < 0) first_ = all;
    const double elapsed_s = SecondsBetween(start_, session_.environment.clock->Steady());
    *session_.err().stream << "\r\033[K" << variant << ": " << FormatCount(all) << " of "
                           << FormatCount(total_) << " scored";
    if (all > first_) {
      const double left = static_cast<double>(total_ - all) / static_cast<double>(all - first_);
      *session_.err().stream << ", " << FormatDuration(elapsed_s * left) << " left";
    }
    *session_.err().stream << std::flush;
  }
  void ClearProgress() {
    if (session_.err().interactive) *session_.err().stream << "\r\033[K" << std::flush;
  }

  void Report(const Task& task, const JudgedVariant& judged,
              const std::map<FrameId, double>& shares, int64_t scored) {
    const v1::FilterConfig& filters = task.spec.config().filters();
    const double most = filters.has_max_ambiguous_share() ? filters.max_ambiguous_share() : 1;
    double sum = 0;
    for (const auto& [key, share] : shares) sum += share;
    const double mean = shares.empty() ? 0 : sum / static_cast<double>(shares.size());
    json_.push_back({{"name", task.variant.name},
                     {"pairs", judged.frames},
                     {"scored_now", scored},
                     {"mean_share", mean},
                     {"max_share", most},
                     {"ambiguous", judged.ambiguous},
                     {"passed", judged.passed}});
    if (session_.options.json) return;
    const std::string networks = Plural(static_cast<int64_t>(IdsOf(task).size()), "network");
    *session_.out().stream << session_.out().Paint(Tone::kBold, task.variant.name) << ": "
                           << networks << " missed " << FormatNumber(100 * mean)
                           << " % of the pixels by more than 2 px; "
                           << FormatCount(judged.ambiguous) << " of "
                           << Plural(judged.frames, "pair") << " ambiguous (above "
                           << FormatNumber(100 * most) << " %), " << FormatCount(judged.passed)
                           << " pass all filters\n";
    if (most >= 1) {
      session_.PrintNote(
          "filters.max_ambiguous_share is 1, so no pair is ambiguous; --max-share "
          "0.6 would take FoundationStereo's threshold");
    }
  }

  Json NetworksJson() const {
    Json list = Json::array();
    for (const auto& [path, network] : networks_) {
      list.push_back({{"file", path}, {"sha256", network.run.checkpoint}});
    }
    return list;
  }

  const CurateCommandOptions& options_;
  Session& session_;
  std::string root_, work_dir_;
  v1::StudySpec study_;
  std::vector<Task> tasks_;
  std::map<std::string, ChosenPredictor> networks_;  // By path.
  Json json_ = Json::array();
  int64_t total_ = 0, done_ = 0;  // Predictions: each network looks at each frame once.
  int64_t first_ = -1;            // `done_` when progress was shown first.
  SteadyTime start_;
};

}  // namespace

void RegisterCurate(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "curate", "Find the pairs of a dataset that trained networks can't match",
      "Each pair is predicted by each network; its score is the share of left pixels with truth\n"
      "(sky and the exterior of rooms left out) that are off by more than 2 px, averaged over the\n"
      "networks. Scores go to VARIANT/curation.jsonl and to index.jsonl; a pair above\n"
      "filters.max_ambiguous_share gets the verdict `ambiguous` and then counts as filtered out, "
      "in\n"
      "exports, readers and trainings. Nothing is rendered. Scores are kept: another --max-share\n"
      "takes seconds, and an interrupted command resumes. --max-share holds until the study is\n"
      "run, fetched or curated again without it; to keep it, write it into the study file.\n"
      "\n"
      "Examples:\n"
      "  parallax curate out/table1                     with the networks of its own trainings\n"
      "  parallax curate out/quickstart --checkpoint network\n"
      "  parallax curate out/quickstart --checkpoint runs/wide/final.pt --max-share 0.6\n"
      "  parallax curate out/mix --variant 'm-*' --checkpoint a.pt --checkpoint b.pt --json\n");
  auto options = std::make_shared<CurateCommandOptions>();
  command->add_option("DIR", options->dir, "A dataset of `run` or `fetch`, or one of its variants")
      ->required();
  AddOption(
      command, "--checkpoint", "FILE", options->checkpoints,
      "A network of the built-in trainer, or `network`, which comes with Parallax unless "
      "$PARALLAX_NETWORK names another; may be repeated (default: those that the study trained "
      "on the variant, in DIR/training, else `network`)");
  AddOption(command, "--max-share", "SHARE", options->max_share,
            "Instead of filters.max_ambiguous_share, from 0 to 1; 1: none is ambiguous")
      ->check(CLI::Range(0.0, 1.0));
  AddOption(command, "--variant", "NAME", options->variants,
            "Only this variant; may be repeated, and end in * (default: all but held-out "
            "ones)");
  command->add_option("--threads", options->predictor.threads, "CPU threads (default: all)")
      ->check(CLI::Range(1, 1024));
  AddOption(command, "--trainer-program", "FILE", options->predictor.trainer_program,
            "Predicts from a checkpoint (default: `trainer` beside this program, or "
            "$PARALLAX_TRAINER)");
  command
      ->add_option("--pair-s", options->predictor.pair_s,
                   "Time limit of a prediction in seconds (default 120)")
      ->check(CLI::Range(0.1, 1e6));
  registry.AddJsonOption(command);
  registry.SetAction(command, [options](Session& session) {
    Curation curation(*options, session);
    return curation.Run();
  });
}

}  // namespace parallax::client
