// Where the files of a machine are.

#include "musher/cli/machine/machine_files.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>

#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::machine_files_test {

namespace fs = std::filesystem;

// A robot whose config has no state_dir, with the state folders of a start by a user and by
// systemd.
class StateDir : public ::testing::Test {
 protected:
  void Start(const std::string& state_dir, std::chrono::minutes ago, MachineOrigin machine) const {
    fs::create_directories(state_dir);
    ASSERT_TRUE(SaveOrigin(state_dir, machine));
    std::ofstream(state_dir + "/journal.sqlite") << "x";
    fs::last_write_time(state_dir + "/journal.sqlite", fs::file_time_type::clock::now() - ago);
  }
  std::string Found() const { return StateDirOf(robot_, by_user_, folder_ / "service"); }

  const TempFolder folder_;
  const MachineOrigin robot_{"robot", "", 0, folder_ / "robot.toml"};
  const std::string by_user_ = folder_ / "user/robot";
  const std::string by_service_ = folder_ / "service/robot";
};

TEST_F(StateDir, OfARobotThatSystemdStartsIsThatOfItsUnit) {
  EXPECT_EQ(Found(), by_user_);
  Start(by_service_, std::chrono::minutes(9), robot_);
  EXPECT_EQ(Found(), by_service_);
}

TEST_F(StateDir, IsTheOneThatWasUsedLast) {
  Start(by_service_, std::chrono::minutes(9), robot_);
  Start(by_user_, std::chrono::minutes(5), robot_);
  EXPECT_EQ(Found(), by_user_);
  Start(by_service_, std::chrono::minutes(1), robot_);
  EXPECT_EQ(Found(), by_service_);
}

TEST_F(StateDir, IsNeverThatOfAnotherMachine) {
  std::ofstream(folder_ / "other.toml") << "x";
  MachineOrigin other = robot_;
  other.file = folder_ / "other.toml";
  Start(by_service_, std::chrono::minutes(1), other);
  EXPECT_EQ(Found(), by_user_);
}

TEST_F(StateDir, OfAnUpgradeRootIsFoundByAConfigInIt) {
  fs::create_directory(folder_ / "root");
  MachineOrigin root = robot_;
  root.file = folder_ / "root";
  Start(by_service_, std::chrono::minutes(1), root);
  EXPECT_EQ(Found(), by_service_);
}

}  // namespace musher::cli::machine_files_test
