// Reads what a program writes into its log, line by line while it runs.
#pragma once

#include <fstream>
#include <string>
#include <vector>

namespace parallax {

// Not thread-safe.
class LogReader {
 public:
  explicit LogReader(std::string path) : path_(std::move(path)) {}

  // Whole lines since the last call, without their ends; what a program ends by a carriage return
  // (a progress bar) is a line too. With `last` also what has no end.
  std::vector<std::string> NewLines(bool last = false);
  // The end of the log: at most 200 lines and 16 kB.
  std::string Tail() const;
  // The last line that says something; empty if none does.
  std::string LastLine() const;

 private:
  const std::string path_;
  std::streamoff read_ = 0;
  std::string open_line_;
};

}  // namespace parallax
