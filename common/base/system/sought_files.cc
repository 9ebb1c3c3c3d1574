#include "common/base/system/sought_files.h"

namespace parallax {
namespace {

thread_local SoughtFiles* innermost = nullptr;

}  // namespace

SoughtFiles::SoughtFiles() : outer_(innermost) { innermost = this; }
SoughtFiles::~SoughtFiles() { innermost = outer_; }

void NoteSought(const std::string& path) {
  if (innermost != nullptr) innermost->paths_.insert(path);
}

}  // namespace parallax
