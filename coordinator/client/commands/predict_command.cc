// predict: the disparities of one pair.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/base/status.h"
#include "common/base/system/temporary_folder.h"
#include "common/image/io.h"
#include "common/store/store.h"
#include "coordinator/client/cancellable.h"
#include "coordinator/client/commands/evaluate_command.h"
#include "coordinator/client/content/predictor_choice.h"
#include "coordinator/client/views/text.h"
#include "worker/dataset/sheets/drawing.h"
#include "worker/evaluate/disparity_files.h"
#include "worker/evaluate/prediction_sheet.h"
#include "worker/evaluate/prepared_pair.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;

struct PredictOptions {
  PredictorChoice predictor;       // Without `what`.
  std::vector<std::string> words;  // The predictor, if it is named, and both pictures.
  std::string out, picture;
};

absl::Status WriteOutput(const std::string& path, const ImageF& disparity_px) {
  const std::string extension = fs::path(path).extension();
  const bool pfm = extension == ".pfm";
  float largest_px = 0;
  for (const float d : disparity_px.values()) {
    if (std::isfinite(d)) largest_px = std::max(largest_px, d);
  }
  if (!pfm && largest_px * 256 > 65535) {
    return InvalidArgument(
        "--out {}: disparities up to {:.4g} px, a PNG x256 holds 255.99: write a .pfm", path,
        largest_px);
  }
  ASSIGN_OR_RETURN(const std::string bytes,
                   pfm ? EncodePfm(disparity_px) : EncodeDisparityPng(disparity_px));
  return WriteFileAtomically(path, bytes);
}

absl::StatusOr<ImageF> PredictOne(const PredictOptions& options, Predictor& predictor,
                                  const Session& session) {
  ASSIGN_OR_RETURN(const TemporaryFolder work, TemporaryFolder::Make("predict"));
  const std::string &right = options.words.back(), &left = options.words.end()[-2];
  ASSIGN_OR_RETURN(const PreparedPair pair,
                   PreparePair({.name = "pair", .left = left, .right = right},
                               work.path() + "/pair", PairCheck::kPictures));
  for (const std::string& note : pair.notes) session.PrintNote(note);
  const PredictionTask task = {
      .name = "pair", .left = pair.left, .right = pair.right, .output = work.path() + "/pair.pfm"};
  const CancellableScope cancellable;
  RETURN_IF_ERROR(predictor.Predict({task}, {.work_dir = work.path(),
                                             .cancel = cancellable.token(),
                                             .clock = session.environment.clock}));
  return ReadPfm(task.output);
}

absl::StatusOr<ExitCode> Predict(const PredictOptions& options, Session& session) {
  const std::string extension = fs::path(options.out).extension();
  if (extension != ".pfm" && extension != ".png") {
    return InvalidArgument("--out {}: wanted a .pfm or a .png", options.out);
  }
  PredictorChoice choice = options.predictor;
  choice.what = options.words.size() == 3 ? options.words[0] : kShippedNetwork;
  ASSIGN_OR_RETURN(const ChosenPredictor chosen, ChoosePredictor(choice));
  ASSIGN_OR_RETURN(const ImageF disparity_px, PredictOne(options, *chosen.predictor, session));
  RETURN_IF_ERROR(WriteOutput(options.out, disparity_px));
  const double full_scale_px = ColorScale(disparity_px);
  if (!options.picture.empty()) {
    RETURN_IF_ERROR(WritePng(options.picture, ColorPrediction(disparity_px, full_scale_px), 3));
  }
  if (session.options.json) {
    return session.PrintJson({{"out", options.out},
                              {"picture", options.picture},
                              {"width_px", disparity_px.width()},
                              {"height_px", disparity_px.height()},
                              {"disparity_98_percent_px", full_scale_px}});
  }
  *session.out().stream << options.out << "\n";
  if (!options.picture.empty()) *session.out().stream << options.picture << "\n";
  *session.err().stream << disparity_px.width() << "x" << disparity_px.height()
                        << ", 98 % of the disparities are below " << FormatNumber(full_scale_px)
                        << " px\n";
  return kExitOk;
}

}  // namespace

void RegisterPredict(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "predict", "Predict the disparities of a pair of rectified pictures",
      "PREDICTOR is `network` (default), which comes with Parallax unless $PARALLAX_NETWORK names\n"
      "another; `sgbm` (OpenCV's matcher); or a checkpoint of the built-in trainer. The output\n"
      "holds disparities of the left picture in pixels: a PFM as float32, a PNG as 16 bits x256\n"
      "with 0 for none, refused beyond 255.99 px.\n"
      "\n"
      "Examples:\n"
      "  parallax predict left.png right.png --out disparity.pfm\n"
      "  parallax predict default-1.pt left.png right.png --out disparity.pfm\n"
      "  parallax predict sgbm left.png right.png --out disparity.png --picture colours.png\n");
  auto options = std::make_shared<PredictOptions>();
  command
      ->add_option("[PREDICTOR] LEFT RIGHT", options->words,
                   "A checkpoint, sgbm or network (default); the left picture; the right picture")
      ->required()
      ->expected(2, 3);
  AddOption(command, "-o,--out", "FILE", options->out, "The disparities: .pfm or .png")->required();
  AddOption(command, "--picture", "PNG", options->picture,
            "The disparities in colours, for people");
  AddOption(command, "--trainer-program", "FILE", options->predictor.trainer_program,
            "Predicts from a checkpoint (default: `trainer` beside this program, or "
            "$PARALLAX_TRAINER)");
  command->add_option("--pair-s", options->predictor.pair_s, "Time limit in seconds (default 120)")
      ->check(CLI::Range(0.1, 1e6));
  registry.AddJsonOption(command);
  registry.SetAction(command, [options](Session& session) { return Predict(*options, session); });
}

}  // namespace parallax::client
