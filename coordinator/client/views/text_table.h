// A table of text with aligned columns. Not thread-safe.
#pragma once

#include <string>
#include <vector>

#include "coordinator/client/views/terminal.h"

namespace parallax::client {

class Table {
 public:
  struct Column {
    std::string title;
    Align align = Align::kLeft;
  };
  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  // Adds a row. Requires that there are not more cells than columns; missing cells are empty.
  void AddRow(std::vector<std::string> cells);
  size_t rows() const { return rows_.size(); }

  // Returns the title line and the rows, each indented by `indent` spaces. On an interactive
  // terminal the last column is cut to fit the screen; elsewhere nothing is cut, because a script
  // may read it.
  std::vector<std::string> Lines(const Terminal& terminal, int indent = 0) const;
  void Print(const Terminal& terminal, int indent = 0) const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace parallax::client
