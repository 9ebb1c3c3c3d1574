#include <algorithm>
#include <new>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>
#include <set>

#include "worker/train/network/network_backend.h"
#include "worker/train/onnx_graph.pb.h"

namespace parallax {
namespace {

// OpenCV's text without its version, file and function: "Can't create layer ..." of
// "OpenCV(4.6.0) ./modules/x.cpp:110: error: (-2:Unspecified error) Can't create layer ... in
// function 'f'".
std::string Reason(const cv::Exception& error) {
  std::string text = error.err.empty() ? error.what() : error.err;
  if (const size_t at = text.rfind("error: ("); at != std::string::npos) {
    text = text.substr(text.find(") ", at) + 2);
  }
  text = text.substr(0, text.find(" in function"));
  return text.substr(0, text.find('\n'));
}

// From operator set 13 on these work along the last axis where a node names none; OpenCV 4.6 takes
// the channels, as before.   Source: ONNX, Operators.md, Softmax-13.
void WriteOutAxes(onnx::Model& model) {
  constexpr int64_t kLastAxisIsDefault = 13;
  constexpr int kWholeNumber = 2;
  for (const onnx::OperatorSet& set : model.opset_import()) {
    if (set.domain().empty() && set.version() < kLastAxisIsDefault) return;
  }
  for (onnx::Node& node : *model.mutable_graph()->mutable_node()) {
    const std::string& type = node.op_type();
    if (type != "Softmax" && type != "LogSoftmax" && type != "Hardmax") continue;
    const auto& attributes = node.attribute();
    if (std::any_of(attributes.begin(), attributes.end(),
                    [](const onnx::Attribute& one) { return one.name() == "axis"; })) {
      continue;
    }
    onnx::Attribute& axis = *node.add_attribute();
    axis.set_name("axis");
    axis.set_i(-1);
    axis.set_type(kWholeNumber);
  }
}

// The inputs that pictures go into, left first, see RightComesFirst. Old files list weights among
// their inputs.
std::vector<onnx::Value> PictureInputs(const onnx::Graph& graph) {
  std::set<std::string> weights;
  for (const onnx::Tensor& tensor : graph.initializer()) weights.insert(tensor.name());
  std::vector<onnx::Value> inputs;
  for (const onnx::Value& input : graph.input()) {
    if (!weights.contains(input.name())) inputs.push_back(input);
  }
  if (inputs.size() == 2 && RightComesFirst(inputs[0].name(), inputs[1].name())) {
    std::swap(inputs[0], inputs[1]);
  }
  return inputs;
}

int64_t SizeOf(const onnx::Value& input, int dimension) {
  const onnx::Shape& shape = input.type().tensor_type().shape();
  return shape.dim_size() > dimension ? shape.dim(dimension).dim_value() : 0;
}

class OnnxBackend : public NetworkBackend {
 public:
  OnnxBackend(onnx::Model model, std::string name)
      : model_(std::move(model)),
        name_(std::move(name)),
        pictures_(PictureInputs(model_.graph())) {}

  int inputs() const override { return static_cast<int>(pictures_.size()); }

  cv::Size size() const override {
    const int64_t height = SizeOf(pictures_[0], 2), width = SizeOf(pictures_[0], 3);
    if (height <= 0 || width <= 0) return {};
    return {static_cast<int>(width), static_cast<int>(height)};
  }

  absl::StatusOr<NetworkOutput> Run(const std::vector<cv::Mat>& inputs, int output) override {
    ASSIGN_OR_RETURN(const size_t number,
                     OutputNumber(output, static_cast<size_t>(model_.graph().output_size())));
    try {
      RETURN_IF_ERROR(LoadFor(inputs[0]));
      for (size_t i = 0; i < inputs.size(); ++i) network_.setInput(inputs[i], pictures_[i].name());
      const cv::Mat given =
          network_.forward(model_.graph().output(static_cast<int>(number)).name());
      NetworkOutput result;
      for (int d = 0; d < given.dims; ++d) result.shape.push_back(given.size[d]);
      const auto* const values = given.ptr<float>();
      result.values.assign(values, values + given.total());
      return result;
    } catch (const std::bad_alloc&) {
      return ResourceExhausted("no memory for the network");
    } catch (const cv::Exception& error) {
      return error.code == cv::Error::StsNoMem ? ResourceExhausted("{}", Reason(error))
                                               : Internal("the network failed: {}", Reason(error));
    }
  }

  // Loads the network for pictures of the size of `input`: OpenCV knows more networks by their
  // sizes than with open ones.
  absl::Status LoadFor(const cv::Mat& input) {
    const cv::Size size(input.size[3], input.size[2]);
    if (size == loaded_) return absl::OkStatus();
    onnx::Model sized = model_;
    for (onnx::Value& value : *sized.mutable_graph()->mutable_input()) {
      SetSizes(value, input);
    }
    const std::string bytes = sized.SerializeAsString();
    try {
      network_ = cv::dnn::readNetFromONNX(bytes.data(), bytes.size());
    } catch (const cv::Exception& error) {
      return InvalidArgument("{}: OpenCV " CV_VERSION
                             " cannot load it: {}; a command with another "
                             "library (onnxruntime) can predict in its place",
                             name_, Reason(error));
    }
    loaded_ = size;
    return absl::OkStatus();
  }

 private:
  // Sets the sizes of a picture's input that are open.
  void SetSizes(onnx::Value& value, const cv::Mat& input) const {
    const bool picture = std::any_of(pictures_.begin(), pictures_.end(),
                                     [&](const auto& one) { return one.name() == value.name(); });
    onnx::Shape& shape = *value.mutable_type()->mutable_tensor_type()->mutable_shape();
    if (!picture || shape.dim_size() != 4) return;
    for (int d = 0; d < 4; ++d) {
      if (shape.dim(d).dim_value() > 0) continue;
      shape.mutable_dim(d)->clear_dim_param();
      shape.mutable_dim(d)->set_dim_value(input.size[d]);
    }
  }

  onnx::Model model_;
  std::string name_;
  std::vector<onnx::Value> pictures_;
  cv::dnn::Net network_;
  cv::Size loaded_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<NetworkBackend>> LoadOnnx(const std::string& bytes,
                                                         const std::string& name, int threads) {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // Its errors come here.
  if (threads > 0) cv::setNumThreads(threads);
  onnx::Model model;
  if (!model.ParseFromString(bytes) || model.graph().input_size() == 0 ||
      model.graph().output_size() == 0) {
    return InvalidArgument("{}: is not an ONNX file", name);
  }
  WriteOutAxes(model);
  const std::vector<onnx::Value> pictures = PictureInputs(model.graph());
  const int64_t channels = pictures.size() == 1 ? 6 : 3;
  bool good = pictures.size() == 1 || pictures.size() == 2;
  std::string seen;
  for (const onnx::Value& input : pictures) {
    seen += (seen.empty() ? "" : ", ") + input.name();
    good &= SizeOf(input, 1) == channels || SizeOf(input, 1) == 0;
  }
  if (!good) {
    return InvalidArgument("{}: its inputs are {}, but must be two of 3 channels, or one of 6",
                           name, seen);
  }
  return std::unique_ptr<NetworkBackend>(std::make_unique<OnnxBackend>(std::move(model), name));
}

}  // namespace parallax
