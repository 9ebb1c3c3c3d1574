// The STUDY argument of `run` and `submit` with its overrides, and the study that they resolve to.
// Pure functions, except that they read files.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"

namespace parallax::client {

struct StudyOptions {
  std::string study;  // A file, or a built-in study's name.
  std::optional<int64_t> pairs;
  std::optional<int64_t> scenes;
  std::optional<int> rigs;
  std::optional<uint64_t> seed;
  std::optional<int> samples;
  std::optional<std::string> profile;
  std::optional<std::string> picture_dir;
  std::optional<int> width;
  std::optional<int> height;
  std::optional<std::string> name;
  std::optional<int> priority;
  bool takes_endless = false;  // The command takes endless studies.
  bool takes_search = false;   // The command takes studies with a search.
};

// Adds the argument and the options to a command. `options` must live until parsing has ended.
void AddStudyOptions(CLI::App& command, StudyOptions& options);

// Loads the study, applies the overrides and checks the result. Errors: those of LoadStudy;
// kInvalidArgument if both `pairs` and `scenes` are given, for values out of range, and for an
// endless study that neither the command nor `pairs` or `scenes` takes, or a search that the
// command does not take.
absl::StatusOr<v1::StudySpec> ResolveStudy(const StudyOptions& options);

// Returns the absolute path of a folder or file that a resolved study names.
std::string FromRoot(const std::string& dir);

// The workers that read the folders of a study: the children of `run`, whose picture root is "/",
// or those of a coordinator.
enum class FolderReaders { kOfRun, kOfFarm };

// Hashes and checks the content of each variant's folders and of own benchmarks, and sets
// pictures_sha256, textures_sha256, hdris_sha256, include_sha256 and sha256. What is not on this
// machine keeps its hash. Content that takes much memory raises the study's memory_mb, with a note,
// so that its jobs go to workers that can hold it. Errors: kFailedPrecondition if the content
// differs from the study's hash; kInvalidArgument if a folder is not here and the study has no hash
// for it, with what to write for these readers; those of ContentHashes.
absl::Status HashContent(v1::StudySpec& study, FolderReaders readers);

// Returns "3 variants x 5,000 pairs", or the sum if variants differ in size.
std::string DescribeSize(const v1::StudySpec& study);

// Returns a key that is equal for studies that ask for the same pairs by the same versions of the
// stages. `source_yaml`, `notify` and priority do not matter.
std::string IdempotencyKey(const v1::StudySpec& study);

}  // namespace parallax::client
