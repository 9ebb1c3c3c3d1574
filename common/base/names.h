// The rules for names and texts that one program takes from another, and the form in which such
// texts reach a terminal or a log. Every check of a name in the tree uses these functions.
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
// What a person gives as the reason for a pause or a cancel.
inline constexpr size_t kMaxReasonBytes = 1000;
// What a program says of a failure or of a job that it hands back.
inline constexpr size_t kMaxErrorBytes = 4000;

bool IsName(std::string_view text);
bool IsFolderName(std::string_view text);
bool IsPlainText(std::string_view text);
bool IsUtf8(std::string_view text);

// Errors: kInvalidArgument "WHAT "TEXT" is not a name, allowed are ..." with the text printable and
// cut. `what` names the object: "worker name", "hello.tags[2]".
absl::Status CheckName(std::string_view what, std::string_view text);
// Errors: kInvalidArgument, if the text is no plain text or has more than `most` bytes.
absl::Status CheckPlainText(std::string_view what, std::string_view text, size_t most);

// The verdict on a text that is no name, or no folder name, for a message that names the object
// itself: ""A b" is not a name, allowed are ...".
std::string WhyNotName(std::string_view text);
std::string WhyNotFolderName(std::string_view text);

// `text` with everything that a terminal could take for a command escaped: control characters as
// \n, \t or \x1b, line separators and direction marks as \u{202e}, bytes that are no UTF-8 as \xff.
// One line; equal to `text` if that is plain.
std::string Printable(std::string_view text);
// Printable, in double quotes, at most 60 bytes of `text`; a longer text ends with "...".
std::string Quoted(std::string_view text);
// The beginning of `text`, at most `most` bytes with the "..." that marks the cut; never half a
// character.
std::string CutText(std::string_view text, size_t most);

}  // namespace parallax
