#include "worker/train/network/checkpoint.h"

#include <torch/serialize.h>

#include <cerrno>
#include <cstdio>
#include <sstream>

#include "common/base/system/file.h"

namespace parallax {
namespace {

absl::Status Broken(const std::string& path, const std::string& why) {
  return DataLoss("{}: not a checkpoint of this trainer ({})", path, why);
}

}  // namespace

absl::Status WriteCheckpoint(const std::string& path, const StereoNetwork& network,
                             const Checkpoint& checkpoint) {
  torch::serialize::OutputArchive archive;
  archive.write("step", c10::IValue(checkpoint.step));
  archive.write("settings", c10::IValue(checkpoint.settings.dump()));
  archive.write("layout", c10::IValue(LayoutOf(network)));
  archive.write("weights", checkpoint.state.weights);
  archive.write("average", checkpoint.state.average);
  archive.write("mean", checkpoint.state.mean);
  archive.write("square", checkpoint.state.square);
  std::ostringstream bytes;
  archive.save_to(bytes);
  const std::string fresh = path + ".new";
  RETURN_IF_ERROR(WriteFile(fresh, bytes.str(), /*sync=*/true));
  if (std::rename(fresh.c_str(), path.c_str()) != 0) return ErrnoError(errno, "rename " + fresh);
  return absl::OkStatus();
}

absl::StatusOr<Checkpoint> ReadCheckpoint(const std::string& path, const StereoNetwork& network) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  Checkpoint checkpoint;
  c10::IValue step, settings, layout;
  try {
    torch::serialize::InputArchive archive;
    archive.load_from(bytes.data(), bytes.size());
    archive.read("step", step);
    archive.read("settings", settings);
    archive.read("layout", layout);
    archive.read("weights", checkpoint.state.weights);
    archive.read("average", checkpoint.state.average);
    archive.read("mean", checkpoint.state.mean);
    archive.read("square", checkpoint.state.square);
    checkpoint.step = step.toInt();
    checkpoint.settings = nlohmann::ordered_json::parse(settings.toStringRef());
    if (layout.toStringRef() != LayoutOf(network))
      return Broken(path, "its network has other layers");
  } catch (const std::exception& error) {
    const std::string text = error.what();
    return Broken(path, text.substr(0, text.find('\n')));
  }
  return checkpoint;
}

}  // namespace parallax
