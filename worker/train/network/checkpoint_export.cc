#include "worker/train/network/checkpoint_export.h"

#include <torch/csrc/jit/api/module.h>
#include <torch/csrc/jit/frontend/tracer.h>

#include <algorithm>
#include <sstream>

#include "common/store/store.h"
#include "worker/train/network/checkpoint.h"

namespace parallax {
namespace {

// The network's forward pass on an empty pair, recorded as the method `forward` of a module.
torch::jit::Module Traced(StereoNetwork& network, int64_t max_disparity, int height, int width) {
  torch::jit::Module module("StereoNetwork");
  for (auto& item : network.named_parameters()) {
    std::string name = item.key();
    std::replace(name.begin(), name.end(), '.', '_');
    module.register_parameter(name, item.value().set_requires_grad(false), false);
  }
  const torch::NoGradGuard no_grad;  // Else convolutions would be in bfloat16.
  const torch::Tensor empty = torch::zeros({1, 3, height, width});
  const auto forward = [&](torch::jit::Stack inputs) -> torch::jit::Stack {
    return {network.Forward(inputs[0].toTensor(), inputs[1].toTensor(), max_disparity).disparity};
  };
  const auto state = torch::jit::tracer::trace({empty, empty.clone()}, forward,
                                               [](const torch::autograd::Variable&) { return ""; },
                                               true, false, &module, {"left", "right"})
                         .first;
  const c10::QualifiedName name(*module.type()->name(), "forward");
  module.type()->addMethod(
      module._ivalue()->compilation_unit()->create_function(name, state->graph));
  return module;
}

}  // namespace

absl::Status ExportTorchScript(const std::string& path, const std::string& out, int height,
                               int width) {
  if (height <= 0 || width <= 0 || height % kSizeMultiple != 0 || width % kSizeMultiple != 0) {
    return InvalidArgument("the size is {}x{}, but must be multiples of 32", height, width);
  }
  StereoNetwork network;
  ASSIGN_OR_RETURN(const Checkpoint checkpoint, ReadCheckpoint(path, network));
  SetWeights(network, checkpoint.state.average);
  network.UsePlainOperations();
  std::ostringstream bytes;
  try {
    Traced(network, checkpoint.settings.value("max_disparity", 192), height, width).save(bytes);
  } catch (const std::exception& error) {
    const std::string text = error.what();
    return Internal("tracing: {}", text.substr(0, text.find('\n')));
  }
  return WriteFileAtomically(out, bytes.str());
}

absl::Status ExportWeights(const std::string& checkpoint, const std::string& path) {
  const StereoNetwork network;
  ASSIGN_OR_RETURN(Checkpoint exported, ReadCheckpoint(checkpoint, network));
  OptimiserState& state = exported.state;
  state.weights = state.mean = state.square = torch::empty({0});
  return WriteCheckpoint(path, network, exported);
}

}  // namespace parallax
