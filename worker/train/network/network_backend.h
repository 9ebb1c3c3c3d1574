// The libraries that run networks in exchange formats, behind one interface.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/base/status.h"

namespace parallax {

// One output of a network.
struct NetworkOutput {
  std::vector<int64_t> shape;
  std::vector<float> values;  // Row-major.
};

class NetworkBackend {
 public:
  virtual ~NetworkBackend() = default;

  // Returns the number of inputs: 2 pictures, or 1 of both.
  virtual int inputs() const = 0;

  // Returns the only size of pictures that the file allows; empty if it allows any or does not
  // tell.
  virtual cv::Size size() const = 0;

  // Runs the network on `inputs`, each (1, channels, height, width), and returns its output number
  // `output`, negative counted from the end. Errors: kInvalidArgument for a number beyond the
  // outputs; kInternal, kResourceExhausted.
  virtual absl::StatusOr<NetworkOutput> Run(const std::vector<cv::Mat>& inputs, int output) = 0;
};

// Load a file's bytes; `name` is for errors. Errors: as ExchangeNetwork::Load.
absl::StatusOr<std::unique_ptr<NetworkBackend>> LoadTorchScript(const std::string& bytes,
                                                                const std::string& name,
                                                                int threads);
absl::StatusOr<std::unique_ptr<NetworkBackend>> LoadOnnx(const std::string& bytes,
                                                         const std::string& name, int threads);

// Whether the first of two inputs, by their names ("left", "img_L", "right_image", "imgR"...),
// takes the right picture. Names that say no eye leave the left one first.
bool RightComesFirst(const std::string& first, const std::string& second);

// Returns `output` counted from 0 among `count`. Errors: kInvalidArgument.
absl::StatusOr<size_t> OutputNumber(int output, size_t count);

}  // namespace parallax
