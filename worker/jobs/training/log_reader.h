// Reads what a program writes into its log, line by line while it runs.
#pragma once

#include <fstream>
#include <string>
#include <vector>

namespace parallax {

// Reads one log file. Not thread-safe.
class LogReader {
 public:
  explicit LogReader(std::string path) : path_(std::move(path)) {}

  // Returns the whole lines since the last call, without line ends. A carriage return (of a
  // progress bar) ends a line too. With `last`, includes an unfinished line.
  std::vector<std::string> NewLines(bool last = false);
  // Returns the end of the log: at most 200 lines and 16 kB.
  std::string Tail() const;
  // Returns the last line that is not blank; empty if none exists.
  std::string LastLine() const;

 private:
  const std::string path_;
  std::streamoff read_ = 0;
  std::string open_line_;
};

}  // namespace parallax
