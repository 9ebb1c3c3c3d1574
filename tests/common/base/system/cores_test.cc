#include "common/base/system/cores.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "common/base/system/cgroup.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

class Cores : public FolderTest {
 protected:
  void Set(const std::string& folder, const char* file, const char* text) const {
    std::filesystem::create_directories(dir_ + folder);
    std::ofstream(dir_ + folder + "/" + file) << text << "\n";
  }
};

TEST_F(Cores, TheSmallestQuotaOfAGroupAndThoseAboveItHolds) {
  Set("/kubepods/pod/container", "cpu.max", "400000 100000");
  Set("/kubepods/pod", "cpu.max", "150000 100000");
  Set("/kubepods", "cpu.max", "max 100000");
  EXPECT_DOUBLE_EQ(CgroupCpuLimit("0::/kubepods/pod/container\n", dir_), 1.5);
  EXPECT_DOUBLE_EQ(CgroupCpuLimit("0::/kubepods\n", dir_), 0);
  EXPECT_DOUBLE_EQ(CgroupCpuLimit("0::/\n", dir_), 0);
  EXPECT_DOUBLE_EQ(CgroupCpuLimit("", dir_), 0);
  // A container that does not see its own folder has its quota at the root.
  Set("", "cpu.max", "50000 100000");
  EXPECT_DOUBLE_EQ(CgroupCpuLimit("0::/nowhere/to/be/seen\n", dir_), 0.5);
}

TEST_F(Cores, QuotasOfTheOlderHierarchyCount) {
  Set("/cpu/docker/a", "cpu.cfs_quota_us", "250000");
  Set("/cpu/docker/a", "cpu.cfs_period_us", "100000");
  Set("/cpu", "cpu.cfs_quota_us", "-1");
  Set("/cpu", "cpu.cfs_period_us", "100000");
  EXPECT_DOUBLE_EQ(CgroupCpuLimit("4:memory:/x\n3:cpu,cpuacct:/docker/a\n0::/\n", dir_), 2.5);
  EXPECT_DOUBLE_EQ(CgroupCpuLimit("3:cpuset:/docker/a\n", dir_), 0);
}

TEST_F(Cores, ThereIsAtLeastOne) { EXPECT_GE(UsableCores(), 1); }

}  // namespace
}  // namespace parallax
