#include "common/base/system/sought_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "common/base/system/file.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

using ::testing::UnorderedElementsAre;
using SoughtFilesTest = FolderTest;

TEST_F(SoughtFilesTest, FilesThatAreReadAreNotedWhetherTheyAreThereOrNot) {
  ASSERT_TRUE(WriteFile(dir_ + "/a", "text").ok());
  ASSERT_TRUE(ReadFile(dir_ + "/a").ok());
  const SoughtFiles sought;
  ASSERT_TRUE(ReadFile(dir_ + "/a").ok());
  ASSERT_FALSE(ReadFile(dir_ + "/b").ok());
  NoteSought("c");
  EXPECT_THAT(sought.paths(), UnorderedElementsAre(dir_ + "/a", dir_ + "/b", "c"));
}

TEST_F(SoughtFilesTest, EachThreadNotesItsOwnAndTheInnermostScopeNotes) {
  const SoughtFiles outer;
  std::thread([] { NoteSought("elsewhere"); }).join();
  {
    const SoughtFiles inner;
    NoteSought("inner");
    EXPECT_THAT(inner.paths(), UnorderedElementsAre("inner"));
  }
  NoteSought("outer");
  EXPECT_THAT(outer.paths(), UnorderedElementsAre("outer"));
}

}  // namespace
}  // namespace parallax
