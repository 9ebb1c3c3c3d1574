// A folder of this process for inputs that readers want as files.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <string>

namespace parallax {

inline const std::string& FuzzFolder() {
  static const std::string dir = [] {
    const std::string made = std::filesystem::temp_directory_path().string() + "/parallax_fuzz_" +
                             std::to_string(getpid());
    std::filesystem::create_directories(made);
    return made;
  }();
  return dir;
}

}  // namespace parallax
