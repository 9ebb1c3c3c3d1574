// Walks of folders of content: what counts, and where links may lead.
#include "worker/materials/pictures/picture_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "common/base/system/file.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::string_view kEndings[] = {".png", ".glb"};

class ContentFolderTest : public testing::Test {
 protected:
  ContentFolderTest()
      : root_(testing::TempDir() + "content_folder_" +
              testing::UnitTest::GetInstance()->current_test_info()->name()),
        dir_(root_ + "/mine") {
    fs::remove_all(root_);
    Write("mine/chairs/a.glb");
  }
  ~ContentFolderTest() override {
    SetFollowLinks(false);
    fs::remove_all(root_);
  }

  void Write(const std::string& name) const {
    fs::create_directories(fs::path(root_ + "/" + name).parent_path());
    ASSERT_TRUE(WriteFile(root_ + "/" + name, name).ok());
  }
  void Link(const std::string& target, const std::string& name) const {
    fs::create_directory_symlink(target, dir_ + "/" + name);
  }
  std::vector<std::string> Files() const {
    const auto names = NamesOfContent(dir_, kEndings);
    EXPECT_TRUE(names.ok()) << names.status();
    return names.ok() ? names->files : std::vector<std::string>();
  }
  std::string Refusal() const {
    return std::string(NamesOfContent(dir_, kEndings).status().message());
  }

  const std::string root_, dir_;
};

TEST_F(ContentFolderTest, FilesOfSystemsAreLeftOut) {
  for (const char* name : {"mine/._b.png", "mine/.DS_Store", "mine/__MACOSX/chairs/a.glb",
                           "mine/.git/c.png", "mine/@eaDir/d.png", "mine/note.txt", "mine/B.PNG"}) {
    Write(name);
  }
  const auto names = NamesOfContent(dir_, kEndings);
  ASSERT_TRUE(names.ok()) << names.status();
  EXPECT_THAT(names->files, ElementsAre("B.PNG", "chairs/a.glb"));
  EXPECT_THAT(names->left_out,
              ElementsAre(".DS_Store", "._b.png", ".git/", "@eaDir/", "__MACOSX/", "note.txt"));
}

TEST_F(ContentFolderTest, LinksInsideAreFollowed) {
  Link("chairs", "seats");
  Link("a.glb", "chairs/b.glb");
  EXPECT_THAT(Files(), ElementsAre("chairs/a.glb", "chairs/b.glb", "seats/a.glb", "seats/b.glb"));
  fs::create_directory_symlink(dir_, root_ + "/link");
  EXPECT_EQ(NamesOfContent(root_ + "/link", kEndings)->files.size(), 4u) << "the folder is a link";
}

TEST_F(ContentFolderTest, LinksThatLeadOutNeedLeave) {
  Write("library/x.glb");
  Link(root_ + "/library", "shelf");
  EXPECT_THAT(Refusal(), HasSubstr("mine/shelf: a link to " + root_ +
                                   "/library, outside of the "
                                   "folder; --follow-links allows it"));
  SetFollowLinks(true);
  EXPECT_THAT(Files(), ElementsAre("chairs/a.glb", "shelf/x.glb"));
  SetFollowLinks(false);
  fs::remove(dir_ + "/shelf");
  Link("../library/x.glb", "y.glb");
  EXPECT_THAT(Refusal(), HasSubstr("mine/y.glb: a link to " + root_ + "/library/x.glb, outside"));
  SetFollowLinks(true);
  EXPECT_THAT(Files(), ElementsAre("chairs/a.glb", "y.glb"));
}

TEST_F(ContentFolderTest, LinksToNothingAndInCirclesAreRefused) {
  Link("nothing", "c.glb");
  EXPECT_THAT(Refusal(), HasSubstr("mine/c.glb: a link to nothing, which is not there"));
  fs::remove(dir_ + "/c.glb");
  Link("nothing", "note");  // Would be no content anyway.
  EXPECT_THAT(Files(), ElementsAre("chairs/a.glb"));
  Link("..", "chairs/up");
  EXPECT_THAT(Refusal(), HasSubstr("a link to " + dir_ + ", in which it lies"));
  SetFollowLinks(true);
  EXPECT_THAT(Refusal(), HasSubstr("in which it lies"));
}

}  // namespace
}  // namespace parallax
