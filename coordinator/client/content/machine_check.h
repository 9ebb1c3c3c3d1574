// Checks that this machine has all that `run` needs to render, train and score a study, before any
// work is done.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/client/command.h"
#include "parallax/v1/study.pb.h"

namespace parallax::client {

// The options that say what this machine has.
struct MachineOptions {
  std::string allow_trainers;  // Names with commas between them; empty: builtin.
  std::string trainers_dir;    // Folder with NAME.yaml of each trainer beside the built-in one.
  std::string benchmarks_dir;  // Folder of the real sets.
};

// Adds the options --benchmarks, --allow-trainers and --trainers to a command. `options` must live
// until parsing has ended.
void AddMachineOptions(CLI::App& command, MachineOptions& options);

// The file that a machine with an NVIDIA GPU has.
inline constexpr char kGpuDevice[] = "/dev/nvidia0";

// Returns what this machine lacks for the study, a text for each thing: file and line of the
// study's field, what is missing, and what to do about it. `file` is the study's file or built-in
// name. Looks for the programs, the trainer with its files and its permission, a GPU (`gpu`) where
// one is needed, and the files of each benchmark.
std::vector<std::string> WhatIsMissing(const v1::StudySpec& study, const std::string& file,
                                       const MachineOptions& options,
                                       const std::string& gpu = kGpuDevice);

// Errors: kInvalidArgument with what WhatIsMissing returns, a line each.
absl::Status CheckMachine(const v1::StudySpec& study, const std::string& file,
                          const MachineOptions& options);

// Prints a note for each thing that this machine lacks for the study: `run` would refuse it; a farm
// may have it.
void PrintMissing(const v1::StudySpec& study, const std::vector<std::string>& missing,
                  const Session& session);

}  // namespace parallax::client
