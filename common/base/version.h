// Versions of this build: of the programs, of their messages, and of each stage's results.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace parallax {

// A version for each stage, part of the keys of its results. Raise the version of the first stage
// whose results would differ for equal inputs; the stages after it follow, because recipes name the
// versions of layout and scene, and a frame's key covers its recipe.
//
//   layout   rooms and furniture: worker/layout, and worker/assets, whose shapes it places
//   scene    dress: worker/scene, and the catalogue of worker/materials that it chooses from
//   frame    pictures and maps: worker/render, worker/dataset's encodings and statistics, and
//            worker/materials as far as only looks change
//   train    networks: worker/train
//   evaluate scores: worker/evaluate
inline constexpr char kLayoutVersion[] = "27";
inline constexpr char kSceneVersion[] = "27";
inline constexpr char kFrameVersion[] = "28";
inline constexpr char kTrainVersion[] = "1";
inline constexpr char kEvaluateVersion[] = "4";

// The versions as values, so that tests can have others.
struct StageVersions {
  std::string layout = kLayoutVersion;
  std::string scene = kSceneVersion;
  std::string frame = kFrameVersion;
  std::string train = kTrainVersion;
  std::string evaluate = kEvaluateVersion;
};

// Returns the stages and their versions in the order in which data flows through them.
inline std::vector<std::pair<std::string, std::string>> ListVersions(
    const StageVersions& versions) {
  return {{"layout", versions.layout},
          {"scene", versions.scene},
          {"frame", versions.frame},
          {"train", versions.train},
          {"evaluate", versions.evaluate}};
}
// Returns the version of a stage; empty for an unknown name.
inline std::string VersionOf(const StageVersions& versions, std::string_view stage) {
  for (const auto& [name, version] : ListVersions(versions)) {
    if (name == stage) return version;
  }
  return "";
}

// Describes the versions for people and log lines: "layout 17, scene 18, frame 18".
inline std::string DescribeVersions(const StageVersions& versions = {}) {
  return "layout " + versions.layout + ", scene " + versions.scene + ", frame " + versions.frame;
}

// Version of the messages between a coordinator and its workers: raise it whenever one of them
// could misread the other. 2: jobs travel as a kind and bytes. 3: configs carry lands of one's own.
inline constexpr int kWorkProtocol = 3;
// The version of the programs, for people.
extern const char* const kProgramVersion;

}  // namespace parallax
