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
};

// Adds the argument and the options to a command. `options` must live until parsing has ended.
void AddStudyOptions(CLI::App& command, StudyOptions& options);

// Turns `picture_dir`, as the user wrote it, into a path below "/", the picture root of `run`'s
// workers. Errors: kNotFound if there is no such folder.
absl::Status TakePicturesFromHere(StudyOptions& options);

// Loads the study, applies the overrides and checks the result. Errors: those of LoadStudy;
// kInvalidArgument if both `pairs` and `scenes` are given, or for values out of range.
absl::StatusOr<v1::StudySpec> ResolveStudy(const StudyOptions& options);

// Returns the absolute path of a folder that a config names, for workers whose picture root is "/",
// such as those of `run`.
std::string FromRoot(const std::string& dir);

// The workers that read the folders of a study: the children of `run`, whose picture root is "/",
// or those of a coordinator.
enum class FolderReaders { kOfRun, kOfFarm };

// Hashes and checks the content of each variant's folders below "/", and sets pictures_sha256,
// textures_sha256, hdris_sha256 and include_sha256. Variants whose folders are not on this machine
// keep their hashes. Errors: kFailedPrecondition if the content differs from the study's hash;
// kInvalidArgument if a folder is not here and the study has no hash for it, with what to write for
// these readers; those of ContentHashes.
absl::Status HashContent(v1::StudySpec& study, FolderReaders readers);

// Checks that `run` may train with the study's trainer. `allowed` is its option --allow-trainers
// (names with commas between them; empty: builtin), `trainers_dir` its --trainers, `file` names the
// study. Errors: kInvalidArgument with file and line of the study's field.
absl::Status CheckTrainer(const v1::StudySpec& study, const std::string& file,
                          const std::string& allowed, const std::string& trainers_dir);

// The file that a machine with an NVIDIA GPU has.
inline constexpr char kGpuDevice[] = "/dev/nvidia0";

// Checks that this machine has a GPU if the study's trainings or evaluations need one, which `run`
// could never serve otherwise. `file` names the study. Errors: kInvalidArgument with file and line
// of the study's field if there is no `device`.
absl::Status CheckGpu(const v1::StudySpec& study, const std::string& file,
                      const std::string& device = kGpuDevice);

// Returns "3 variants x 5,000 pairs", or the sum if variants differ in size.
std::string DescribeSize(const v1::StudySpec& study);

// Returns a key that is equal for studies that ask for the same pairs by the same versions of the
// stages. `source_yaml` and priority do not matter.
std::string IdempotencyKey(const v1::StudySpec& study);

}  // namespace parallax::client
