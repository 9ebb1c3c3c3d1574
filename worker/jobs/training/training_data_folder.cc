#include "worker/jobs/training/training_data_folder.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "common/base/system/file.h"
#include "worker/dataset/archive/curation_log.h"
#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/export/export.h"
#include "worker/jobs/files/frame_folder.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kMostRepetitions = 20;

double WeightOf(const v1::FrameSet& part) { return part.weight() > 0 ? part.weight() : 1; }

// The shortest text that reads back as the same number.
std::string TextOf(double weight) {
  char text[32];
  for (int digits = 1; digits <= 17; ++digits) {
    std::snprintf(text, sizeof text, "%.*g", digits, weight);
    if (std::strtod(text, nullptr) == weight) break;
  }
  return text;
}

class Maker {
 public:
  Maker(const v1::TrainJob& job, const TrainerContract& contract,
        const TrainingDataOptions& options)
      : job_(job), contract_(contract), options_(options), cache_(options.cache) {}

  absl::StatusOr<TrainingDataFolder> Make() {
    data_.facts = {{"layout", contract_.layout},      {"share", job_.share()},
                   {"mismatched", job_.mismatched()}, {"mismatched_share", MismatchedShare()},
                   {"curated", job_.curated()},       {"parts", Json::array()}};
    if (job_.curated()) RETURN_IF_ERROR(ScoreParts());
    if (contract_.layout == "archive") {
      RETURN_IF_ERROR(MakeArchives());
    } else {
      RETURN_IF_ERROR(MakeExport());
    }
    cache_.Trim();
    RETURN_IF_ERROR(WriteFile(options_.dir + "/manifest.json", data_.facts.dump(2) + "\n"));
    return std::move(data_);
  }

 private:
  absl::Status MakeArchives() {
    for (int i = 0; i < job_.parts_size(); ++i) {
      const v1::FrameSet& part = job_.parts(i);
      const std::string dir = fmt::format("{}/{}/{}", options_.dir, i, part.variant());
      ASSIGN_OR_RETURN(const FrameFolderFacts facts, Bring(i, dir));
      Note(part, facts, 1);
      data_.parts.push_back({dir, TextOf(WeightOf(part))});
    }
    return absl::OkStatus();
  }

  absl::Status MakeExport() {
    const std::string archive = options_.dir + "/archive",
                      exported = options_.dir + "/" + contract_.layout;
    std::vector<FrameFolderFacts> facts;
    std::vector<int64_t> pairs;
    std::vector<double> weights;
    for (int i = 0; i < job_.parts_size(); ++i) {
      ASSIGN_OR_RETURN(facts.emplace_back(), Bring(i, NameIn(archive, i, 0)));
      pairs.push_back(facts.back().pairs);
      weights.push_back(WeightOf(job_.parts(i)));
    }
    const std::vector<int> times = Repetitions(pairs, weights);
    for (int i = 0; i < job_.parts_size(); ++i) {
      for (int again = 1; again < times[static_cast<size_t>(i)]; ++again) {
        RETURN_IF_ERROR(Bring(i, NameIn(archive, i, again)).status());
      }
      Note(job_.parts(i), facts[static_cast<size_t>(i)], times[static_cast<size_t>(i)]);
    }
    ExportOptions export_options;
    export_options.layout = contract_.layout;
    export_options.cancel = options_.cancel;
    RETURN_IF_ERROR(ExportDataset(archive, exported, export_options).status());
    data_.parts.push_back({exported, "1"});
    return absl::OkStatus();
  }

  // Returns the folder of a part, or of one of its repetitions, which no other part has. Its name
  // has no dot, at which readers of webdataset end a sample's key.
  std::string NameIn(const std::string& archive, int part, int again) const {
    const std::string variant = archive + "/" + job_.parts(part).variant();
    std::string name = again == 0 ? variant : fmt::format("{}-{}", variant, again + 1);
    const auto is_parts = [&](const v1::FrameSet& other) {
      return name == archive + "/" + other.variant();
    };
    while (again > 0 && std::any_of(job_.parts().begin(), job_.parts().end(), is_parts)) {
      name += "-again";
    }
    return name;
  }

  // Lets the curator predict all frames that pass the other filters.
  absl::Status ScoreParts() {
    if (options_.curator.predictor == nullptr) {
      return InvalidArgument("a curated training without a network that scores frames");
    }
    data_.facts["curated_by"] = options_.curator.id;
    const std::string work_dir = options_.dir + "/scored";
    for (int i = 0; i < job_.parts_size(); ++i) {
      const std::string dir = fmt::format("{}/{}", work_dir, i);
      ASSIGN_OR_RETURN(shares_.emplace_back(), SharesOf(i, dir));
    }
    std::error_code ignored;
    fs::remove_all(work_dir, ignored);
    return absl::OkStatus();
  }

  absl::StatusOr<std::map<FrameId, double>> SharesOf(int part, const std::string& dir) {
    FrameFolderOptions bring;
    bring.files = FilesForTraining();
    bring.cancel = options_.cancel;
    const std::string& variant = job_.parts(part).variant();
    RETURN_IF_ERROR(
        BringFrames(job_.parts(part), *options_.store, cache_, dir + "/" + variant, bring)
            .status());
    ASSIGN_OR_RETURN(const Dataset dataset, ReadDataset(dir));
    ASSIGN_OR_RETURN(CurationLog log, CurationLog::Open(dataset.variants.at(0).dir));
    const double parts = job_.parts_size();
    const CurateOptions scoring{
        .work_dir = dir, .cancel = options_.cancel, .progress = [&](int64_t done, int64_t total) {
          const double fraction = static_cast<double>(done) / std::max<double>(1, total);
          options_.progress((part + fraction) / parts);
        }};
    RETURN_IF_ERROR(ScoreFrames(dataset.variants.at(0), options_.curator, scoring, log).status());
    return AmbiguousShares(dataset.variants.at(0), {options_.curator.id}, log);
  }

  absl::StatusOr<FrameFolderFacts> Bring(int part, const std::string& dir) {
    FrameFolderOptions bring;
    bring.files = FilesForTraining();
    bring.share = job_.share() > 0 ? job_.share() : 1;
    bring.mismatched = MismatchedShare();
    if (job_.curated()) bring.ambiguous_shares = &shares_[static_cast<size_t>(part)];
    bring.cancel = options_.cancel;
    const double parts = job_.parts_size();
    bring.progress = [&, part, parts](double fraction) {
      options_.progress((part + fraction) / parts);
    };
    return BringFrames(job_.parts(part), *options_.store, cache_, dir, bring);
  }

  double MismatchedShare() const {
    if (!job_.mismatched()) return 0;
    return job_.mismatched_share() > 0 ? job_.mismatched_share() : 1;
  }

  void Note(const v1::FrameSet& part, const FrameFolderFacts& facts, int times) {
    data_.pairs += facts.pairs;
    data_.facts["parts"].push_back({{"variant", part.variant()},
                                    {"weight", WeightOf(part)},
                                    {"pairs", facts.pairs},
                                    {"left_out_by_filters", facts.left_out},
                                    {"mismatched_pairs", facts.mismatched},
                                    {"repeated", times},
                                    {"sha256", facts.sha256}});
  }

  const v1::TrainJob& job_;
  const TrainerContract& contract_;
  const TrainingDataOptions& options_;
  const FrameCache cache_;
  TrainingDataFolder data_;
  std::vector<std::map<FrameId, double>> shares_;  // By part of a curated set.
};

}  // namespace

std::vector<int> Repetitions(const std::vector<int64_t>& pairs,
                             const std::vector<double>& weights) {
  std::vector<double> wanted;  // Draws of a pair of each part.
  for (size_t i = 0; i < pairs.size(); ++i)
    wanted.push_back(weights[i] / static_cast<double>(pairs[i]));
  const double least = *std::min_element(wanted.begin(), wanted.end());
  std::vector<int> times;
  for (const double draws : wanted) {
    times.push_back(std::clamp(static_cast<int>(std::lround(draws / least)), 1, kMostRepetitions));
  }
  return times;
}

absl::StatusOr<TrainingDataFolder> MakeTrainingData(const v1::TrainJob& job,
                                                    const TrainerContract& contract,
                                                    const TrainingDataOptions& options) {
  if (job.parts().empty()) return InvalidArgument("a training without data");
  return Maker(job, contract, options).Make();
}

}  // namespace parallax
