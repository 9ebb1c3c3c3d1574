#include <ATen/Parallel.h>
#include <torch/script.h>
#include <torch/version.h>

#include <new>
#include <sstream>
#include <utility>

#include "worker/train/network/network_backend.h"

namespace parallax {
namespace {

using torch::Tensor;

std::string FirstLine(const std::exception& error) {
  const std::string text = error.what();
  return text.substr(0, text.find('\n'));
}

// The last line of the text in which torch tells what went wrong in a script: the first ones tell
// where.
std::string Reason(const std::exception& error) {
  std::istringstream lines(error.what());
  std::string reason;
  for (std::string line; std::getline(lines, line);) {
    if (line.find("Error: ") != std::string::npos) reason = line;
  }
  return reason.empty() ? FirstLine(error) : reason;
}

// Appends all tensors of a tensor, a tuple, a list or a dictionary, in their order.
void Collect(const torch::IValue& value, std::vector<Tensor>& tensors) {
  if (value.isTensor()) tensors.push_back(value.toTensor());
  if (value.isTuple()) {
    for (const torch::IValue& one : value.toTupleRef().elements()) Collect(one, tensors);
  }
  if (value.isList()) {
    for (const torch::IValue& one : value.toListRef()) Collect(one, tensors);
  }
  if (value.isGenericDict()) {
    for (const auto& entry : value.toGenericDict()) Collect(entry.value(), tensors);
  }
}

class TorchScriptBackend : public NetworkBackend {
 public:
  TorchScriptBackend(torch::jit::Module module, const std::vector<std::string>& names)
      : module_(std::move(module)),
        inputs_(static_cast<int>(names.size())),
        right_first_(names.size() == 2 && RightComesFirst(names[0], names[1])) {}

  int inputs() const override { return inputs_; }
  cv::Size size() const override { return {}; }

  absl::StatusOr<NetworkOutput> Run(const std::vector<cv::Mat>& inputs, int output) override {
    const torch::NoGradGuard no_grad;
    std::vector<Tensor> tensors;
    try {
      std::vector<torch::IValue> values;
      for (const cv::Mat& input : inputs) {
        values.emplace_back(torch::from_blob(
            input.data, {1, input.size[1], input.size[2], input.size[3]}, torch::kFloat));
      }
      if (right_first_) std::swap(values[0], values[1]);
      Collect(module_.forward(values), tensors);
      ASSIGN_OR_RETURN(const size_t number, OutputNumber(output, tensors.size()));
      const Tensor given = tensors[number].to(torch::kFloat).contiguous();
      const float* const values_of = given.data_ptr<float>();
      return NetworkOutput{given.sizes().vec(), {values_of, values_of + given.numel()}};
    } catch (const std::bad_alloc&) {
      return ResourceExhausted("no memory for the network");
    } catch (const std::exception& error) {
      const std::string reason = Reason(error);
      const bool memory = reason.find("can't allocate memory") != std::string::npos;
      return memory ? ResourceExhausted("{}", reason) : Internal("the network failed: {}", reason);
    }
  }

 private:
  torch::jit::Module module_;
  int inputs_;
  bool right_first_;
};

// The names of the arguments of forward that have no default.
std::vector<std::string> InputsOf(const torch::jit::Module& module) {
  std::vector<std::string> names;
  for (const c10::Argument& argument :
       module.get_method("forward").function().getSchema().arguments()) {
    if (argument.name() != "self" && !argument.default_value()) names.push_back(argument.name());
  }
  return names;
}

}  // namespace

absl::StatusOr<std::unique_ptr<NetworkBackend>> LoadTorchScript(const std::string& bytes,
                                                                const std::string& name,
                                                                int threads) {
  if (threads > 0) at::set_num_threads(threads);
  try {
    std::istringstream stream(bytes);
    torch::jit::Module module = torch::jit::load(stream, torch::kCPU);
    module.eval();
    const std::vector<std::string> names = InputsOf(module);
    if (names.size() != 1 && names.size() != 2) {
      return InvalidArgument(
          "{}: forward takes {} arguments, but must take left and right, or one "
          "tensor of both",
          name, names.size());
    }
    return std::unique_ptr<NetworkBackend>(
        std::make_unique<TorchScriptBackend>(std::move(module), names));
  } catch (const std::exception& error) {
    return InvalidArgument("{}: libtorch " TORCH_VERSION " cannot load it as TorchScript: {}", name,
                           FirstLine(error));
  }
}

}  // namespace parallax
