#include "common/base/system/installation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>

#include "common/base/system/file.h"
#include "common/base/version.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class InstallationTest : public FolderTest {
 protected:
  void SetUp() override { fs::create_directories(dir_ + "/share/parallax"); }

  Installation PackageOf(const std::string& kind) {
    EXPECT_TRUE(WriteFile(dir_ + "/share/parallax/installed_as", kind + "\n").ok());
    return InstallationOf(dir_ + "/libexec/parallax");
  }
};

TEST_F(InstallationTest, ProgramsOfABuildLieInOneFolder) {
  const Installation built = InstallationOf("/src/build/release/bin/parallax");
  EXPECT_EQ(built.as, InstalledAs::kBuild);
  EXPECT_EQ(built.programs, "/src/build/release/bin");
  EXPECT_EQ(built.data, "");
}

TEST_F(InstallationTest, APackageStartsItsProgramsFromBinAndKeepsDataInShare) {
  const Installation unpacked = InstallationOf(dir_ + "/libexec/parallax");
  EXPECT_EQ(unpacked.as, InstalledAs::kTarball) << "without the file that tells";
  EXPECT_EQ(unpacked.programs, dir_ + "/bin");
  EXPECT_EQ(unpacked.data, dir_ + "/share/parallax");
  EXPECT_EQ(PackageOf("tarball").as, InstalledAs::kTarball);
  EXPECT_EQ(PackageOf("wheel").as, InstalledAs::kWheel);
  EXPECT_EQ(PackageOf("deb").as, InstalledAs::kDebianPackage);
}

TEST_F(InstallationTest, TheRemedyFitsTheWayOfInstallation) {
  const auto remedy = [&](const Installation& installation) {
    return HowToAddProgram(installation, "trainer");
  };
  EXPECT_EQ(remedy(InstallationOf("/src/build/release/bin/parallax")),
            "build it: cmake --build /src/build/release --target trainer");
  EXPECT_THAT(remedy(PackageOf("tarball")),
              AllOf(HasSubstr("tar -xf parallax-trainer-"), HasSubstr("-C " + dir_ + " ")));
  EXPECT_THAT(remedy(PackageOf("wheel")), HasSubstr("pip install parallax_stereo_trainer-"));
  EXPECT_THAT(remedy(PackageOf("deb")), HasSubstr(std::string("./parallax-stereo-trainer_") +
                                                  kProgramVersion + "_amd64.deb"));
  EXPECT_THAT(HowToAddProgram(PackageOf("deb"), "worker"), HasSubstr("install Parallax again"));
  EXPECT_THAT(HowToAddRealPair(InstallationOf("/b/bin/parallax")), HasSubstr("deploy/setup.sh"));
}

TEST_F(InstallationTest, AProgramIsFoundByItsVariableOrBesideThisOne) {
  unsetenv("PARALLAX_NONE");
  const auto missing = FindProgram("none");
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(missing.status().message()),
              AllOf(HasSubstr(ThisInstallation().programs + "/none"), HasSubstr("--target none"),
                    HasSubstr("$PARALLAX_NONE")));
  EXPECT_EQ(FindProgram("base_test").value_or(""), ThisInstallation().programs + "/base_test");

  setenv("PARALLAX_NONE", "/bin/sh", 1);
  EXPECT_EQ(FindProgram("none").value_or(""), "/bin/sh");
  setenv("PARALLAX_NONE", "/nowhere/none", 1);
  EXPECT_THAT(std::string(FindProgram("none").status().message()),
              HasSubstr("$PARALLAX_NONE: /nowhere/none"));
  unsetenv("PARALLAX_NONE");
}

TEST_F(InstallationTest, TheTrainedNetworkIsFoundByItsVariableOrBesideThePrograms) {
  const std::string beside = ThisInstallation().programs + "/network.pt";
  unsetenv("PARALLAX_NETWORK");
  const auto installed = FindNetwork();
  if (access(beside.c_str(), R_OK) == 0) {
    EXPECT_EQ(installed.value_or(""), beside);
  } else {
    EXPECT_EQ(installed.status().code(), absl::StatusCode::kNotFound);
    EXPECT_THAT(
        std::string(installed.status().message()),
        AllOf(HasSubstr("no " + beside), HasSubstr("`parallax run network --out DIR` trains one"),
              HasSubstr("in $PARALLAX_NETWORK")));
  }
  ASSERT_TRUE(WriteFile(dir_ + "/mine.pt", "weights").ok());
  setenv("PARALLAX_NETWORK", (dir_ + "/mine.pt").c_str(), 1);
  EXPECT_EQ(FindNetwork().value_or(""), dir_ + "/mine.pt");
  setenv("PARALLAX_NETWORK", "/nowhere/net.pt", 1);
  EXPECT_THAT(std::string(FindNetwork().status().message()),
              HasSubstr("$PARALLAX_NETWORK: /nowhere/net.pt"));
  unsetenv("PARALLAX_NETWORK");
}

}  // namespace
}  // namespace parallax
