// Inner part of common/calibration: a file's values by name. Each value keeps its line, which
// errors name.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/status.h"

namespace parallax::calibration_internal {

class Fields {
 public:
  explicit Fields(std::string file) : file_(std::move(file)) {}

  // Adds a field with its text; `line` is from 1. The first field of a name counts.
  void Add(const std::string& name, std::string text, int line);

  // Returns the first of `names` that the file has; empty if it has none.
  std::string FirstOf(const std::vector<std::string>& names) const;
  bool Has(const std::string& name) const { return by_name_.count(name) > 0; }
  // Returns all names in byte order.
  std::vector<std::string> Names() const;
  // Returns the field's line from 1; 0 if the file lacks it or gives none.
  int LineOf(const std::string& name) const;
  // Returns no fields of the same file.
  Fields Empty() const { return Fields(file_); }
  // Returns the field's text; empty if the file lacks the field.
  std::string Text(const std::string& name) const;

  // Returns the field's numbers, which blanks, commas, semicolons and brackets may separate.
  // `count` is how many there must be; 0: any number. Errors: kInvalidArgument if the field is
  // missing, something is not a finite number, or the count differs.
  absl::StatusOr<std::vector<double>> Numbers(const std::string& name, size_t count) const;
  absl::StatusOr<double> Number(const std::string& name) const;
  absl::StatusOr<double> NumberOr(const std::string& name, double otherwise) const;
  // Returns a whole number of pixels. Errors: those of Numbers; kInvalidArgument outside of 1 to
  // 16384.
  absl::StatusOr<int> Pixels(const std::string& name) const;
  // Returns a picture's width and height. Errors: as Pixels, for either.
  absl::StatusOr<std::pair<int, int>> Size(const std::string& name) const;

  // Makes an error about a field. Errors: always kInvalidArgument "file:line: name: what", with the
  // line of the field if the file has it.
  absl::Status Error(const std::string& name, std::string_view what) const;

 private:
  struct Value {
    std::string text;
    int line = 0;
  };
  std::string file_;
  std::map<std::string, Value> by_name_;
};

// Reads lines "name SEPARATOR value". A line "[section]" puts "section." before the names that
// follow. Other lines are skipped. Blanks around names are removed.
Fields ReadLines(std::string_view text, const std::string& file, char separator);
// Reads a YAML or JSON document. Names of nested maps are joined by dots; a matrix of
// cv::FileStorage becomes its numbers. Errors: kInvalidArgument with the line of a syntax error;
// for a document that is larger than 24 MiB when its aliases are written out.
absl::StatusOr<Fields> ReadYaml(std::string_view text, const std::string& file);
// Reads XML of cv::FileStorage. Errors: kInvalidArgument with the line of a syntax error.
absl::StatusOr<Fields> ReadXml(std::string_view text, const std::string& file);

}  // namespace parallax::calibration_internal
