// The web page's own files, which CMake embeds in the program. Nothing in them is secret.
#pragma once

#include <span>
#include <string_view>

namespace parallax {

struct PageFile {
  std::string_view path;  // "/js/app.js"
  std::string_view type;  // "text/javascript; charset=utf-8"
  std::string_view bytes;
  std::string_view etag;  // Hash of the content, with its quotes.
};

// Returns all files. They live as long as the program.
std::span<const PageFile> PageFiles();

}  // namespace parallax
