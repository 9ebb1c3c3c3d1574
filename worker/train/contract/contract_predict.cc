#include "worker/train/contract/contract_predict.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace parallax {
namespace {

const std::set<std::string> kPredictNames = {"checkpoint", "list", "device",
                                             "threads",    "out",  "repository"};
const std::vector<std::string> kFields = {"format",   "pixel_range",  "mean",     "std",
                                          "channels", "pad_multiple", "width_px", "height_px",
                                          "output",   "negate"};

bool IsFormat(const std::string& name) { return name == "torchscript" || name == "onnx"; }

// Appends "--option=value" if the field is there and `good`; tells what it must be if it is not
// good.
template <typename T, typename Good>
void AddOption(ContractReader& reader, const YAML::Node& predict, const char* field,
               const char* option, const Good& good, const char* wanted,
               std::vector<std::string>& command) {
  const YAML::Node node = predict[field];
  if (!node) return;
  T value{};
  if (!YAML::convert<T>::decode(node, value) || !good(value)) {
    return reader.Error(node, fmt::format("\"{}\" must be {}", field, wanted));
  }
  std::string text;
  if constexpr (std::is_same_v<T, std::vector<double>>) {
    for (const double one : value) text += (text.empty() ? "" : ",") + fmt::format("{}", one);
  } else {
    text = fmt::format("{}", value);
  }
  command.push_back(fmt::format("--{}={}", option, text));
}

void AddSize(ContractReader& reader, const YAML::Node& predict, std::vector<std::string>& command) {
  const int64_t width = reader.Count(predict, "width_px");
  const int64_t height = reader.Count(predict, "height_px");
  if (width > 0 && height > 0) return command.push_back(fmt::format("--size={}x{}", height, width));
  if (predict["width_px"] || predict["height_px"]) {
    reader.Error(predict, "\"width_px\" and \"height_px\" go together, each at least 1");
  }
}

std::vector<std::string> NetworkCommand(ContractReader& reader, const YAML::Node& predict,
                                        const std::string& format) {
  std::vector<std::string> command = {"trainer",      "predict",      "--format=" + format,
                                      "--checkpoint", "{checkpoint}", "--list",
                                      "{list}",       "--threads",    "{threads}"};
  if (!predict.IsMap()) return command;
  const auto three = [](const std::vector<double>& v) {
    return v.size() == 3 &&
           std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); });
  };
  const auto three_positive = [&](const std::vector<double>& v) {
    return three(v) && std::all_of(v.begin(), v.end(), [](double x) { return x > 0; });
  };
  AddOption<double>(
      reader, predict, "pixel_range", "pixel-range",
      [](double x) { return std::isfinite(x) && x > 0; }, "a number above 0", command);
  AddOption<std::vector<double>>(reader, predict, "mean", "mean", three, "three numbers", command);
  AddOption<std::vector<double>>(reader, predict, "std", "std", three_positive,
                                 "three numbers above 0", command);
  AddOption<std::string>(
      reader, predict, "channels", "channels",
      [](const std::string& x) { return x == "rgb" || x == "bgr"; }, "rgb or bgr", command);
  AddOption<int>(
      reader, predict, "pad_multiple", "pad-multiple", [](int x) { return x >= 1 && x <= 4096; },
      "a whole number of 1 to 4096", command);
  AddOption<int>(
      reader, predict, "output", "output", [](int) { return true; },
      "the number of an output: from 0, or negative from the end", command);
  AddOption<bool>(
      reader, predict, "negate", "negate", [](bool) { return true; }, "true or false", command);
  AddSize(reader, predict, command);
  return command;
}

}  // namespace

std::vector<std::string> ReadPredictCommand(ContractReader& reader, const YAML::Node& root) {
  const YAML::Node predict = root["predict"];
  if (predict && predict.IsSequence()) {
    const std::vector<std::string> command = reader.Texts(root, "predict", true);
    reader.CheckPlaceholders(predict, command, kPredictNames);
    return command;
  }
  std::string format;
  if (predict && predict.IsScalar()) format = predict.Scalar();
  if (predict && predict.IsMap()) {
    reader.CheckKeys(predict, "predict", kFields);
    format = reader.Text(predict, "format", true);
    if (format.empty()) return {};
  }
  if (IsFormat(format)) return NetworkCommand(reader, predict, format);
  reader.Error(
      predict ? predict : root,
      "\"predict\" is " + (predict ? "\"" + format + "\"" : "missing") +
          ", but must be torchscript, onnx, a map with \"format\", or a command that writes "
          "disparities, for example [python3, predict.py, \"{checkpoint}\", \"{list}\"]");
  return {};
}

}  // namespace parallax
