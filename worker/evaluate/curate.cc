#include "worker/evaluate/curate.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>

#include "common/image/io.h"
#include "worker/evaluate/benchmarks/frame_truth.h"
#include "worker/evaluate/evaluation.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

// Predicted by one process: starting a network takes about as long as a pair.
constexpr size_t kBlock = 32;
constexpr double kBadPx = 2;

std::string NameOf(const DatasetFrame& frame) {
  return fmt::format("{:06}_{:03}", frame.scene, frame.rig);
}

absl::StatusOr<CurationScore> ScoreFrame(const DatasetFrame& frame, const std::string& prediction) {
  const absl::StatusOr<ImageF> predicted = ReadPfm(prediction);
  if (!predicted.ok()) {
    return MakeError(predicted.status().code(), fmt::format("{}: its prediction: {}", frame.dir,
                                                            predicted.status().message()));
  }
  ASSIGN_OR_RETURN(PairTruth truth, ReadFrameTruth(frame.dir));
  truth.regions.clear();
  truth.groups.clear();
  ASSIGN_OR_RETURN(const Scores scores, ScorePair(NameOf(frame), *predicted, truth));
  const ErrorTally& all = scores.regions.at("all");
  return CurationScore{.pixels = all.pixels, .bad = all.bad[BadAt(kBadPx).threshold]};
}

std::vector<PredictionTask> MakeTasks(const std::vector<const DatasetFrame*>& frames, size_t begin,
                                      size_t end, const std::string& work_dir) {
  std::vector<PredictionTask> tasks;
  for (size_t i = begin; i < end; ++i) {
    tasks.push_back({.name = NameOf(*frames[i]),
                     .left = frames[i]->dir + "/left.png",
                     .right = frames[i]->dir + "/right.png",
                     .output = PredictionPath(work_dir, NameOf(*frames[i]))});
    std::error_code error;
    fs::remove(tasks.back().output, error);  // A curation that was killed may have left one.
  }
  return tasks;
}

}  // namespace

absl::StatusOr<int64_t> ScoreFrames(const DatasetVariant& variant, const CurationNetwork& network,
                                    const CurateOptions& options, CurationLog& log) {
  std::vector<const DatasetFrame*> frames;
  for (const DatasetFrame& frame : variant.frames) {
    if (!log.Find(frame, network.id)) frames.push_back(&frame);
  }
  const auto total = static_cast<int64_t>(variant.frames.size());
  const int64_t known = total - static_cast<int64_t>(frames.size());
  options.progress(known, total);
  for (size_t begin = 0; begin < frames.size(); begin += kBlock) {
    if (options.cancel.cancelled()) return Cancelled("while frames were scored");
    const size_t end = std::min(begin + kBlock, frames.size());
    const int64_t before = known + static_cast<int64_t>(begin);
    const std::vector<PredictionTask> tasks = MakeTasks(frames, begin, end, options.work_dir);
    RETURN_IF_ERROR(network.predictor->Predict(
        tasks, {.work_dir = options.work_dir,
                .cancel = options.cancel,
                .clock = options.clock,
                .progress = [&](int done) { options.progress(before + done, total); }}));
    std::vector<CurationLog::Entry> entries;
    for (size_t i = begin; i < end; ++i) {
      ASSIGN_OR_RETURN(const CurationScore score, ScoreFrame(*frames[i], tasks[i - begin].output));
      entries.push_back({frames[i], score});
      std::error_code error;
      fs::remove(tasks[i - begin].output, error);
    }
    RETURN_IF_ERROR(log.Add(network.id, entries));
    options.progress(known + static_cast<int64_t>(end), total);
  }
  return total - known;
}

std::map<FrameId, double> AmbiguousShares(const DatasetVariant& variant,
                                          const std::vector<std::string>& network_ids,
                                          const CurationLog& log) {
  std::map<FrameId, double> shares;
  for (const DatasetFrame& frame : variant.frames) {
    double sum = 0;
    bool whole = !network_ids.empty();
    for (const std::string& id : network_ids) {
      const std::optional<CurationScore> score = log.Find(frame, id);
      whole = whole && score && score->pixels > 0;
      if (whole) sum += static_cast<double>(score->bad) / static_cast<double>(score->pixels);
    }
    if (whole) shares[{frame.scene, frame.rig}] = sum / static_cast<double>(network_ids.size());
  }
  return shares;
}

}  // namespace parallax
