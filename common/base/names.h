// Rules for names and texts that one program accepts from another, and the form in which such texts
// are shown on a terminal or in a log. Every check of a name in the tree uses these functions.
//
// - A name (worker, tag, user, certificate, trainer): 1 to 100 characters of A-Z, a-z, 0-9, '.',
//   '_' and '-'; the first is a letter or a digit.
// - A folder name (study, variant): a name of a-z, 0-9, '_' and '-' with at most 64 characters.
//   Lower case only, because some file systems do not tell "A" from "a".
// - A plain text (reason, comment): UTF-8 without control characters, line separators and marks
//   that change the direction of writing; its length is bounded by the caller.
//
// All functions are pure and thread-safe.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "common/base/status.h"

namespace parallax {

inline constexpr size_t kMaxNameBytes = 100;
inline constexpr size_t kMaxFolderNameBytes = 64;
// Longest reason that a person may give for a pause or a cancel, in bytes.
inline constexpr size_t kMaxReasonBytes = 1000;
// Longest text of a program about a failure or a job that it hands back, in bytes.
inline constexpr size_t kMaxErrorBytes = 4000;

// Return whether `text` is a name, folder name or plain text as defined above, or valid UTF-8.
bool IsName(std::string_view text);
bool IsFolderName(std::string_view text);
bool IsPlainText(std::string_view text);
bool IsUtf8(std::string_view text);

// Checks that `text` is a name. `what` says whose: "worker name", "hello.tags[2]". Errors:
// kInvalidArgument, `WHAT "TEXT" is not a name, allowed are ...`, with the text printable and cut.
absl::Status CheckName(std::string_view what, std::string_view text);
// Checks that `text` is a plain text of at most `most` bytes. Errors: kInvalidArgument.
absl::Status CheckPlainText(std::string_view what, std::string_view text, size_t most);

// Say why a text is not a name, or not a folder name, for messages that name the object themselves:
// `"A b" is not a name, allowed are ...`. Require that it is not.
std::string WhyNotName(std::string_view text);
std::string WhyNotFolderName(std::string_view text);

// Returns `text` as one line without anything that a terminal could take for a command: control
// characters become \n, \t or \x1b, line separators and direction marks \u{202e}, bytes that are no
// UTF-8 \xff. A plain text stays as it is.
std::string Printable(std::string_view text);
// Returns the first 60 bytes of `text`, printable and in double quotes; a longer text ends with
// "...".
std::string Quoted(std::string_view text);
// Cuts `text` to at most `most` bytes, "..." included, without splitting a character.
std::string CutText(std::string_view text, size_t most);

}  // namespace parallax
