// The STUDY argument of `run` and `submit` with its overrides, and what it resolves to. Pure but
// for reading files.
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

// Adds the positional and options to a command; `options` outlives parsing.
void AddStudyOptions(CLI::App& command, StudyOptions& options);

// For workers of `run`, whose picture root is "/": makes `picture_dir`, a folder as the user names
// it, a path below that. Errors: kNotFound.
absl::Status TakePicturesFromHere(StudyOptions& options);

// The study with overrides applied and checked anew.
// Errors: those of LoadStudy; kInvalidArgument for both `pairs` and `scenes`, or values out of
// range.
absl::StatusOr<v1::StudySpec> ResolveStudy(const StudyOptions& options);

// Sets the hash of each variant's folders (pictures_sha256, textures_sha256, hdris_sha256,
// include_sha256) to their content below "/", and checks that content. Variants whose folders
// cannot be seen there keep the hashes that they have. Errors: kFailedPrecondition when the content
// is not what the study names; kInvalidArgument when it can't be seen and the study does not say
// what it is; those of ContentHashes.
absl::Status HashContent(v1::StudySpec& study);

// "3 variants x 5,000 pairs", or what they come to where variants differ in size.
std::string DescribeSize(const v1::StudySpec& study);

// Equal for studies that ask for the same pairs of the same data by the same versions of the
// stages; `source_yaml` and priority don't count.
std::string IdempotencyKey(const v1::StudySpec& study);

}  // namespace parallax::client
