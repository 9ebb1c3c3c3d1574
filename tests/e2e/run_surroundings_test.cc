// `parallax run` where its surroundings are narrow or odd: limits of memory, content behind links.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>

#include "tests/e2e/process.h"
#include "tests/folder_test.h"

namespace parallax::e2e {
namespace {

namespace fs = std::filesystem;
using ::testing::AnyOf;
using ::testing::HasSubstr;

class RunSurroundingsTest : public FolderTest {
 protected:
  // The command for one pair of an empty room; `more` are lines of the variant's settings.
  std::vector<std::string> Command(const std::string& more = "") {
    std::ofstream(dir_ + "/small.yaml")
        << "study: small\nseed: 5\npairs: 1\nrigs_per_scene: 1\nvariants:\n  - name: empty\n"
           "    set:\n"
           "      room: {kinds: [office]}\n"
           "      furniture: {enabled: false}\n"
           "      floating: {count: 1}\n"
           "      rigs: {count: 1, width_px: 64, height_px: 48}\n"
           "      render: {profile: preview, samples_per_pixel: 1}\n"
        << more;
    return {PARALLAX_BINARY, "run", dir_ + "/small.yaml", "--out", dir_ + "/out"};
  }
};

TEST_F(RunSurroundingsTest, OwnContentLeadsOutOfItsFolderOnlyByFollowLinks) {
  fs::create_directories(dir_ + "/mine");
  fs::copy_file(PARALLAX_A_PICTURE, dir_ + "/elsewhere.jpg");
  fs::create_symlink(dir_ + "/elsewhere.jpg", dir_ + "/mine/poster.jpg");
  std::vector<std::string> command = Command("      materials: {picture_dir: mine}\n");
  Process refused(command);
  EXPECT_EQ(refused.Wait(), 2);
  EXPECT_THAT(refused.Err(), HasSubstr("outside of the folder; --follow-links allows it"));
  command.push_back("--follow-links");
  Process run(command);
  EXPECT_EQ(run.Wait(), 0) << run.Err();
  EXPECT_TRUE(fs::exists(dir_ + "/out/empty/frames/000000/000/left.png"));
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_F(RunSurroundingsTest, ALimitedAddressSpaceEndsTheRunWithALineAndNeverHangs) {
  // Too little for the coordinator inside of `run`, and for its threads or those of workers.
  for (const char* space_kb : {"500000", "1000000"}) {
    std::vector<std::string> command = {
        "/bin/sh", "-c", std::string("ulimit -v ") + space_kb + "; exec \"$@\"", "sh"};
    for (const std::string& word : Command()) command.push_back(word);
    Process run(command);
    const int status = run.Wait(std::chrono::seconds(120));
    ASSERT_NE(status, -1) << "it hangs: " << run.Err();
    if (status == 0) continue;  // Enough, on a machine of few threads.
    EXPECT_THAT(run.Err(), AnyOf(HasSubstr("ulimit -v"), HasSubstr("out of memory"))) << space_kb;
    EXPECT_TRUE(run.Err().ends_with("\n")) << run.Err();
    fs::remove_all(dir_ + "/out");
  }
}
#endif

}  // namespace
}  // namespace parallax::e2e
