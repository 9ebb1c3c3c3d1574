// A test with a folder of its own, empty at first and removed after it.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "common/base/system/temporary_folder.h"

namespace parallax {

// The members of a fixture end before its folder is removed.
class FolderTest : public testing::Test {
  const TemporaryFolder own_folder_ = *TemporaryFolder::Make("test");

 protected:
  const std::string& dir_ = own_folder_.path();
};

}  // namespace parallax
