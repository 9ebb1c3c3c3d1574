// Texts as words of a shell, for messages that name a command to copy. Pure; thread-safe.
#pragma once

#include <string>
#include <string_view>

namespace parallax {

// Returns `text` as one word of a POSIX shell: as it is where no character of it means something to
// a shell, else in single quotes, "'my rooms.yaml'". What a terminal could take for a command is
// escaped as by Printable (names.h), after which a shell no longer reads the same text.
std::string ShellWord(std::string_view text);

}  // namespace parallax
