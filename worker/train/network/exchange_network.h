// Networks in the exchange formats TorchScript and ONNX, whichever trainer made them, predict pairs
// on CPUs. No torch in this header.
//
// A network takes the left and the right picture as two inputs of shape (1, 3, height, width), left
// first unless their names ("left", "right") say otherwise, or as one input of shape (1, 6, height,
// width), left first; which of them, its file tells. It gives the left picture's
// disparity in pixels, in the first channel of one of its outputs: (1, channels, height, width),
// (1, height, width) or (height, width).
#pragma once

#include <array>
#include <memory>
#include <string>

#include "common/base/status.h"
#include "common/image/image.h"

namespace parallax {

enum class ExchangeFormat { kTorchScript, kOnnx };

// How a network wants its pictures, and what it gives.
struct NetworkConventions {
  double pixel_range = 255;              // The value of a white pixel, before mean and std.
  std::array<double, 3> mean{};          // Subtracted; in the order of the channels.
  std::array<double, 3> std{{1, 1, 1}};  // Divided by.
  bool bgr = false;                      // Blue first; else red first.
  // Pictures are padded to the right and below to multiples of this, by their last pixels.
  int pad_multiple = 32;
  // The only size that it takes: pictures are scaled to it and disparities scaled back. 0: any
  // size, or the one that an ONNX file tells.
  int width_px = 0, height_px = 0;
  int output = -1;      // Counts from 0; negative: from the end.
  bool negate = false;  // It gives the flow to the right picture, which is the negative disparity.
};

// A network's outputs and their making; see torchscript_network.cc, onnx_network.cc.
class NetworkBackend;

// Not thread-safe.
class ExchangeNetwork {
 public:
  // Loads a network. Errors: those of ReadFile; kInvalidArgument for a file that is not of the
  // format, that has operations which the library does not know, or other inputs than above; and
  // for a size that is negative, or another than the file's.
  static absl::StatusOr<ExchangeNetwork> Load(const std::string& path, ExchangeFormat format,
                                              const NetworkConventions& conventions, int threads);

  // Returns the disparity of each left pixel in pixels of the input, finite, >= 0, of the input's
  // size. Errors: kInvalidArgument for an empty picture or two sizes, and for an output that is
  // missing or not of the pictures' size; kInternal for a disparity that is not finite and for what
  // the library says when the network fails; kResourceExhausted when memory is short.
  absl::StatusOr<ImageF> Predict(const ImageRgb8& left, const ImageRgb8& right);

  ExchangeNetwork(ExchangeNetwork&&) noexcept;
  ~ExchangeNetwork();

 private:
  ExchangeNetwork(std::unique_ptr<NetworkBackend> backend, const NetworkConventions& conventions);
  std::unique_ptr<NetworkBackend> backend_;
  NetworkConventions conventions_;
};

}  // namespace parallax
