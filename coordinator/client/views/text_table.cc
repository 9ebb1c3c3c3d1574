#include "coordinator/client/views/text_table.h"

#include <algorithm>

namespace parallax::client {

void Table::AddRow(std::vector<std::string> cells) {
  cells.resize(columns_.size());
  rows_.push_back(std::move(cells));
}

std::vector<std::string> Table::Lines(const Terminal& terminal, int indent) const {
  std::vector<int> widths;
  for (size_t c = 0; c < columns_.size(); ++c) {
    int width = DisplayWidth(columns_[c].title);
    for (const auto& row : rows_) width = std::max(width, DisplayWidth(row[c]));
    widths.push_back(width);
  }
  const auto line_of = [&](const auto& cell_of, Tone tone) {
    std::string line(static_cast<size_t>(indent), ' ');
    for (size_t c = 0; c < columns_.size(); ++c) {
      const bool last = c + 1 == columns_.size();
      // No spaces at the end of a line.
      const bool pad = !last || columns_[c].align == Align::kRight;
      line += terminal.Paint(
          tone, pad ? Pad(cell_of(c), widths[c], columns_[c].align) : std::string(cell_of(c)));
      if (!last) line += "  ";
    }
    return terminal.interactive ? Truncate(line, terminal.size().columns) : line;
  };
  std::vector<std::string> lines;
  lines.push_back(line_of([&](size_t c) { return columns_[c].title; }, Tone::kBold));
  for (const auto& row : rows_) {
    lines.push_back(line_of([&](size_t c) { return row[c]; }, Tone::kPlain));
  }
  return lines;
}

void Table::Print(const Terminal& terminal, int indent) const {
  for (const std::string& line : Lines(terminal, indent)) *terminal.stream << line << "\n";
}

}  // namespace parallax::client
