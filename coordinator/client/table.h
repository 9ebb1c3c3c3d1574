// Columns of text, aligned. Not thread-safe.
#pragma once

#include <string>
#include <vector>

#include "coordinator/client/terminal.h"

namespace parallax::client {

class Table {
 public:
  struct Column {
    std::string title;
    Align align = Align::kLeft;
  };
  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  // Cells beyond the columns are an error of the caller; missing ones are empty.
  void AddRow(std::vector<std::string> cells);
  size_t rows() const { return rows_.size(); }

  // Title line and rows, each starting with `indent` spaces. On an interactive terminal the last
  // column is cut to fit the screen; elsewhere nothing is cut, because a script may read it.
  std::vector<std::string> Lines(const Terminal& terminal, int indent = 0) const;
  void Print(const Terminal& terminal, int indent = 0) const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace parallax::client
