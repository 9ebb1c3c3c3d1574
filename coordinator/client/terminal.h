// What a person sees: colours, widths of text on a screen, lines that are redrawn in place.
//
// A Terminal describes one output stream. Nothing here reads global state but `Terminal::Standard`,
// so tests draw on strings. Not thread-safe.
#pragma once

#include <functional>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

namespace parallax::client {

enum class Tone { kPlain, kBold, kDim, kGood, kWarning, kBad, kAccent };

struct TerminalSize {
  int columns = 80;
  int rows = 24;
};

struct Terminal {
  std::ostream* stream = nullptr;
  bool interactive = false;  // A person looks at it: lines may be redrawn.
  bool colour = false;
  bool unicode = false;  // Bars and sparklines of block characters rather than ASCII.
  std::function<TerminalSize()> size = [] { return TerminalSize{}; };

  // Standard output (1) or error (2): interactive if it is a terminal that can move its cursor,
  // coloured if so and NO_COLOR is empty, unicode if the locale says UTF-8.
  static Terminal Standard(int file_descriptor);

  // `text` in a tone; unchanged without colours.
  std::string Paint(Tone tone, std::string_view text) const;
};

// Columns that UTF-8 `text` takes; escape sequences take none. Wide and combining characters are
// not looked up: our own output has none.
int DisplayWidth(std::string_view text);

// The longest prefix of at most `columns` columns; escape sequences are kept and closed.
std::string Truncate(std::string_view text, int columns);

enum class Align { kLeft, kRight };
std::string Pad(std::string_view text, int columns, Align align = Align::kLeft);

// A block of lines at the bottom of the screen that is redrawn in place. On a stream that isn't
// interactive nothing is drawn and only `Print` writes.
class LiveBlock {
 public:
  explicit LiveBlock(const Terminal& terminal) : terminal_(terminal) {}
  ~LiveBlock() { Keep(); }
  LiveBlock(const LiveBlock&) = delete;
  LiveBlock& operator=(const LiveBlock&) = delete;

  // Shows these lines instead of the last ones, cut to the screen's width and height.
  void Update(const std::vector<std::string>& lines);
  // Writes a line that stays, above the block.
  void Print(std::string_view line);
  // Takes the block off the screen.
  void Clear();
  // Leaves the block on the screen for good; the next update starts below it.
  void Keep();

 private:
  std::string EraseSequence() const;

  const Terminal terminal_;
  std::vector<std::string> shown_;
};

}  // namespace parallax::client
