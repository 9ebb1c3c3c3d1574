// Output for people: colours, widths of text on a screen, and lines that are redrawn in place.
//
// A Terminal describes one output stream. Only Terminal::Standard reads global state, so tests can
// draw on strings. Not thread-safe.
#pragma once

#include <functional>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

namespace parallax::client {

// The meaning of a text, which its colour shows.
enum class Tone { kPlain, kBold, kDim, kGood, kWarning, kBad, kAccent };

struct TerminalSize {
  int columns = 80;
  int rows = 24;
};

struct Terminal {
  std::ostream* stream = nullptr;
  bool interactive = false;  // A person watches it: lines may be redrawn.
  bool colour = false;
  bool unicode = false;  // Bars and sparklines of block characters rather than ASCII.
  std::function<TerminalSize()> size = [] { return TerminalSize{}; };
  // Returns errno of the first write to `stream` that failed, 0 if none did. Empty: not known.
  std::function<int()> write_error;

  // Returns standard output (1) or standard error (2). It is interactive if it is a terminal that
  // can move its cursor, coloured if it is interactive and NO_COLOR is empty, and unicode if the
  // locale is UTF-8.
  static Terminal Standard(int file_descriptor);
  // Returns a terminal that writes to a descriptor and knows why a write failed. Each line is
  // written at once if the descriptor is a screen. The stream lives as long as a copy of the
  // terminal, and does not close the descriptor.
  static Terminal OnDescriptor(int file_descriptor);

  // Returns `text` in a tone; unchanged without colours.
  std::string Paint(Tone tone, std::string_view text) const;
};

// Returns the columns that UTF-8 `text` takes; escape sequences take none. Every character counts
// as one column, because our output has no wide or combining ones.
int DisplayWidth(std::string_view text);

// Returns the longest prefix of at most `columns` columns; escape sequences are kept and closed.
std::string Truncate(std::string_view text, int columns);

enum class Align { kLeft, kRight };
// Returns `text` filled with spaces to `columns` columns; unchanged if it is wider.
std::string Pad(std::string_view text, int columns, Align align = Align::kLeft);

// A block of lines at the bottom of the screen that is redrawn in place. On a stream that is not
// interactive, the block is not drawn and only `Print` writes.
class LiveBlock {
 public:
  explicit LiveBlock(const Terminal& terminal) : terminal_(terminal) {}
  ~LiveBlock() { Keep(); }
  LiveBlock(const LiveBlock&) = delete;
  LiveBlock& operator=(const LiveBlock&) = delete;

  // Replaces the block's lines by these, cut to the screen's width and height.
  void Update(const std::vector<std::string>& lines);
  // Writes a line that stays, above the block.
  void Print(std::string_view line);
  // Removes the block from the screen.
  void Clear();
  // Leaves the block on the screen; the next update starts a new one below.
  void Keep();

 private:
  std::string EraseSequence() const;

  const Terminal terminal_;
  std::vector<std::string> shown_;
};

}  // namespace parallax::client
