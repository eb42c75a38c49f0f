#include "musher/base/memory_limit.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "musher/test/support/temp_folder.hpp"

namespace musher::memory_limit_test {

class MemoryLimit : public ::testing::Test {
 protected:
  void Write(const std::string& file, const std::string& text) const {
    const std::filesystem::path path = root_ / file;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }

  TempFolder root_;
};

TEST_F(MemoryLimit, IsTheLeastOfTheGroupAndOfThoseAboveIt) {
  Write("proc/self/cgroup", "0::/robot/tools\n");
  Write("sys/fs/cgroup/robot/tools/memory.max", "max\n");
  Write("sys/fs/cgroup/robot/memory.max", "2000000\n");
  EXPECT_EQ(MemoryLimitOfGroups(root_.path()), 2'000'000U);
  Write("sys/fs/cgroup/robot/tools/memory.max", "1000000\n");
  EXPECT_EQ(MemoryLimitOfGroups(root_.path()), 1'000'000U);
}

TEST_F(MemoryLimit, IsReadFromTheFirstVersionOfControlGroups) {
  Write("proc/self/cgroup", "9:name=systemd:/\n4:cpu,memory:/robot\n0::/\n");
  Write("sys/fs/cgroup/memory/robot/memory.limit_in_bytes", "3000000\n");
  EXPECT_EQ(MemoryLimitOfGroups(root_.path()), 3'000'000U);
}

TEST_F(MemoryLimit, IsThatOfTheRootWhereTheGroupIsNotVisible) {
  Write("proc/self/cgroup", "0::/outside/container\n");
  Write("sys/fs/cgroup/memory.max", "4000000\n");
  EXPECT_EQ(MemoryLimitOfGroups(root_.path()), 4'000'000U);
}

TEST_F(MemoryLimit, IsNoneWithoutControlGroups) {
  EXPECT_EQ(MemoryLimitOfGroups(root_.path()), std::nullopt);
  Write("proc/self/cgroup", "nonsense\n0::/\n");
  EXPECT_EQ(MemoryLimitOfGroups(root_.path()), std::nullopt);
}

TEST_F(MemoryLimit, LeavesWhatTheKernelHasAvailable) {
  EXPECT_EQ(AvailableMemory(root_.path()), std::nullopt);
  Write("proc/meminfo", "MemTotal:       24000000 kB\nMemAvailable:    5 kB\n");
  EXPECT_EQ(AvailableMemory(root_.path()), 5U * 1024);
  EXPECT_GT(AvailableMemory().value_or(1), 0U);
}

}  // namespace musher::memory_limit_test
