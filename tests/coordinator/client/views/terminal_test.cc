#include "coordinator/client/views/terminal.h"

#include <gtest/gtest.h>

#include <sstream>

#include "coordinator/client/views/text_table.h"

namespace parallax::client {
namespace {

Terminal On(std::ostream& stream, bool interactive, int columns = 80, int rows = 24) {
  Terminal terminal{.stream = &stream, .interactive = interactive};
  terminal.size = [=] { return TerminalSize{columns, rows}; };
  return terminal;
}

TEST(Terminal, WidthCountsCharactersButNotEscapes) {
  EXPECT_EQ(DisplayWidth("abc"), 3);
  EXPECT_EQ(DisplayWidth("█▒░"), 3);
  EXPECT_EQ(DisplayWidth("\x1b[1;31mred\x1b[0m"), 3);
  EXPECT_EQ(DisplayWidth(""), 0);
  EXPECT_EQ(DisplayWidth("\x1b["), 0);
}

TEST(Terminal, TruncateKeepsWholeCharactersAndClosesTones) {
  EXPECT_EQ(Truncate("abcdef", 3), "abc");
  EXPECT_EQ(Truncate("abc", 3), "abc");
  EXPECT_EQ(Truncate("█▒░", 2), "█▒");
  EXPECT_EQ(Truncate("\x1b[32mgreen\x1b[0m!", 3), "\x1b[32mgre\x1b[0m");
  EXPECT_EQ(Truncate("\x1b[32mgreen\x1b[0m!", 5), "\x1b[32mgreen\x1b[0m");
}

TEST(Terminal, PadAlignsByWhatIsSeen) {
  EXPECT_EQ(Pad("ab", 4), "ab  ");
  EXPECT_EQ(Pad("ab", 4, Align::kRight), "  ab");
  EXPECT_EQ(Pad("\x1b[2m█\x1b[0m", 3), "\x1b[2m█\x1b[0m  ");
  EXPECT_EQ(Pad("abcdef", 3), "abcdef");
}

TEST(Terminal, PaintsOnlyWhereColoursAreSeen) {
  std::ostringstream stream;
  Terminal terminal = On(stream, true);
  EXPECT_EQ(terminal.Paint(Tone::kBad, "x"), "x");
  terminal.colour = true;
  EXPECT_EQ(terminal.Paint(Tone::kBad, "x"), "\x1b[1;31mx\x1b[0m");
  EXPECT_EQ(terminal.Paint(Tone::kPlain, "x"), "x");
}

TEST(LiveBlock, RedrawsInPlaceAndPrintsAbove) {
  std::ostringstream stream;
  LiveBlock block(On(stream, true));
  block.Update({"one", "two"});
  EXPECT_EQ(stream.str(), "one\ntwo\n");
  stream.str("");
  block.Update({"one", "two"});
  EXPECT_EQ(stream.str(), "") << "nothing has changed";
  block.Update({"three"});
  EXPECT_EQ(stream.str(), "\r\x1b[2A\x1b[Jthree\n");
  stream.str("");
  block.Print("stays");
  EXPECT_EQ(stream.str(), "\r\x1b[1A\x1b[Jstays\nthree\n");
  stream.str("");
  block.Keep();
  block.Update({"four"});
  EXPECT_EQ(stream.str(), "four\n") << "what was kept is not erased";
}

TEST(LiveBlock, CutsLinesToTheScreen) {
  std::ostringstream stream;
  LiveBlock block(On(stream, true, 10, 4));
  block.Update({"0123456789abc", "b", "c", "d", "e"});
  EXPECT_EQ(stream.str(), "012345678\nb\nc\n");
}

TEST(LiveBlock, DrawsNothingWhereNobodyLooks) {
  std::ostringstream stream;
  LiveBlock block(On(stream, false));
  block.Update({"bars"});
  EXPECT_EQ(stream.str(), "");
  block.Print("line");
  EXPECT_EQ(stream.str(), "line\n");
}

TEST(Table, AlignsColumnsWithoutTrailingSpace) {
  std::ostringstream stream;
  Table table({"NAME", Right("N"), "DETAIL"});
  table.AddRow({"a", "1", "x"});
  table.AddRow({"long", "100"});
  table.Print(On(stream, false));
  EXPECT_EQ(stream.str(),
            "NAME    N  DETAIL\n"
            "a       1  x\n"
            "long  100  \n");
}

TEST(Table, IsCutOnlyOnAScreen) {
  std::ostringstream narrow;
  Table table({"NAME", "DETAIL"});
  table.AddRow({"a", "a very long text"});
  table.Print(On(narrow, true, 12));
  EXPECT_EQ(narrow.str(), "NAME  DETAIL\na     a very\n");
  std::ostringstream file;
  table.Print(On(file, false, 12), 2);
  EXPECT_EQ(file.str(), "  NAME  DETAIL\n  a     a very long text\n");
}

}  // namespace
}  // namespace parallax::client
