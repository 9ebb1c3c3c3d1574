// Walks of folders of content: what counts, and where links may lead.
#include "worker/materials/pictures/picture_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "common/base/system/file.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::string_view kEndings[] = {".png", ".glb"};

class ContentFolderTest : public FolderTest {
 protected:
  ContentFolderTest() { Write("mine/chairs/a.glb"); }
  ~ContentFolderTest() override { SetFollowLinks(false); }

  void Write(const std::string& name) const {
    fs::create_directories(fs::path(dir_ + "/" + name).parent_path());
    ASSERT_TRUE(WriteFile(dir_ + "/" + name, name).ok());
  }
  void Link(const std::string& target, const std::string& name) const {
    fs::create_directory_symlink(target, mine_ + "/" + name);
  }
  std::vector<std::string> Files() const {
    const auto names = NamesOfContent(mine_, kEndings);
    EXPECT_TRUE(names.ok()) << names.status();
    return names.ok() ? names->files : std::vector<std::string>();
  }
  std::string Refusal() const {
    return std::string(NamesOfContent(mine_, kEndings).status().message());
  }

  const std::string mine_ = dir_ + "/mine";
};

TEST_F(ContentFolderTest, FilesOfSystemsAreLeftOut) {
  for (const char* name : {"mine/._b.png", "mine/.DS_Store", "mine/__MACOSX/chairs/a.glb",
                           "mine/.git/c.png", "mine/@eaDir/d.png", "mine/note.txt", "mine/B.PNG"}) {
    Write(name);
  }
  const auto names = NamesOfContent(mine_, kEndings);
  ASSERT_TRUE(names.ok()) << names.status();
  EXPECT_THAT(names->files, ElementsAre("B.PNG", "chairs/a.glb"));
  EXPECT_THAT(names->left_out,
              ElementsAre(".DS_Store", "._b.png", ".git/", "@eaDir/", "__MACOSX/", "note.txt"));
}

TEST_F(ContentFolderTest, LinksInsideAreFollowed) {
  Link("chairs", "seats");
  Link("a.glb", "chairs/b.glb");
  EXPECT_THAT(Files(), ElementsAre("chairs/a.glb", "chairs/b.glb", "seats/a.glb", "seats/b.glb"));
  fs::create_directory_symlink(mine_, dir_ + "/link");
  EXPECT_EQ(NamesOfContent(dir_ + "/link", kEndings)->files.size(), 4u) << "the folder is a link";
}

TEST_F(ContentFolderTest, LinksThatLeadOutNeedLeave) {
  Write("library/x.glb");
  Link(dir_ + "/library", "shelf");
  EXPECT_THAT(Refusal(), HasSubstr("mine/shelf: a link to " + dir_ +
                                   "/library, outside of the "
                                   "folder; --follow-links allows it"));
  SetFollowLinks(true);
  EXPECT_THAT(Files(), ElementsAre("chairs/a.glb", "shelf/x.glb"));
  SetFollowLinks(false);
  fs::remove(mine_ + "/shelf");
  Link("../library/x.glb", "y.glb");
  EXPECT_THAT(Refusal(), HasSubstr("mine/y.glb: a link to " + dir_ + "/library/x.glb, outside"));
  SetFollowLinks(true);
  EXPECT_THAT(Files(), ElementsAre("chairs/a.glb", "y.glb"));
}

TEST_F(ContentFolderTest, LinksToNothingAndInCirclesAreRefused) {
  Link("nothing", "c.glb");
  EXPECT_THAT(Refusal(), HasSubstr("mine/c.glb: a link to nothing, which is not there"));
  fs::remove(mine_ + "/c.glb");
  Link("nothing", "note");  // Would be no content anyway.
  EXPECT_THAT(Files(), ElementsAre("chairs/a.glb"));
  Link("..", "chairs/up");
  EXPECT_THAT(Refusal(), HasSubstr("a link to " + mine_ + ", in which it lies"));
  SetFollowLinks(true);
  EXPECT_THAT(Refusal(), HasSubstr("in which it lies"));
}

}  // namespace
}  // namespace parallax
