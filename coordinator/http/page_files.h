// The page's own files, which CMake puts into the program. Nothing in them is secret.
#pragma once

#include <span>
#include <string_view>

namespace parallax {

struct PageFile {
  std::string_view path;  // "/js/app.js"
  std::string_view type;  // "text/javascript; charset=utf-8"
  std::string_view bytes;
  std::string_view etag;  // Of the content, with its quotes.
};

std::span<const PageFile> PageFiles();

}  // namespace parallax
