// A table of text with aligned columns. Not thread-safe.
#pragma once

#include <string>
#include <vector>

#include "coordinator/client/views/terminal.h"

namespace parallax::client {

class Table {
 public:
  struct Column {
    Column(std::string column_title, Align alignment)
        : title(std::move(column_title)), align(alignment) {}
    Column(const char* column_title) : Column(column_title, Align::kLeft) {}  // NOLINT: a title.

    std::string title;
    Align align;
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

// Returns a column that is aligned to the right.
inline Table::Column Right(const char* title) { return {title, Align::kRight}; }

}  // namespace parallax::client
