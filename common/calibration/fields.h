// Inner part of common/calibration: the values of a file by their names, each with its line, and
// errors that name it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"

namespace parallax::calibration_internal {

class Fields {
 public:
  explicit Fields(std::string file) : file_(std::move(file)) {}

  void Add(const std::string& name, std::string text, int line);

  // The first of `names` that the file has; empty if it has none.
  std::string FirstOf(const std::vector<std::string>& names) const;
  bool Has(const std::string& name) const { return by_name_.count(name) > 0; }
  // Names in byte order.
  std::vector<std::string> Names() const;
  // Nothing without the field.
  std::string Text(const std::string& name) const;

  // Numbers, separated by blanks, commas, semicolons and brackets. `count` 0: any number of them.
  // Errors: kInvalidArgument for a missing field, what is no finite number, another count.
  absl::StatusOr<std::vector<double>> Numbers(const std::string& name, size_t count) const;
  absl::StatusOr<double> Number(const std::string& name) const;
  absl::StatusOr<double> NumberOr(const std::string& name, double otherwise) const;
  // A whole number of pixels. Errors: as Numbers; outside of 1 to 16384.
  absl::StatusOr<int> Pixels(const std::string& name) const;

  // Errors: always kInvalidArgument "file:line: name: what"; the line of a field that the file has.
  absl::Status Error(const std::string& name, std::string_view what) const;

 private:
  struct Value {
    std::string text;
    int line = 0;
  };
  std::string file_;
  std::map<std::string, Value> by_name_;
};

// Lines "name SEPARATOR value"; a line "[section]" puts "section." before the names that follow.
// Other lines are passed over. Names are kept as they stand but for blanks around them.
Fields ReadLines(std::string_view text, const std::string& file, char separator);
// A YAML or JSON document: names of nested maps are joined by dots, matrices of cv::FileStorage are
// their numbers. Errors: kInvalidArgument with the line of what is no YAML.
absl::StatusOr<Fields> ReadYaml(std::string_view text, const std::string& file);
// XML of cv::FileStorage. Errors: kInvalidArgument with the line of what is no XML.
absl::StatusOr<Fields> ReadXml(std::string_view text, const std::string& file);

}  // namespace parallax::calibration_internal
