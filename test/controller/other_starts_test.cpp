#include "musher/controller/storage/other_starts.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "musher/controller/storage/state_store.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::other_starts_test {

namespace fs = std::filesystem;
using ::testing::IsEmpty;

const StoredStops kStops{{{7, "alice", "smoke"}}, {3}};

// A robot that systemd starts, with the folder of an earlier start by a user.
class OtherStart : public ::testing::Test {
 protected:
  OtherStart() { std::ofstream(robot_.file) << "x"; }

  static void StopIn(const std::string& folder, const MachineOrigin& machine,
                     const StoredStops& stops = kStops) {
    auto store = StateStore::Open(folder, machine);
    ASSERT_TRUE(store) << store.error().message;
    ASSERT_TRUE(store.value().SaveEmergencyStops(stops));
  }
  std::vector<StopsElsewhere> Found(const StoredStops& known = {}) const {
    return FindStopsElsewhere(by_service_, robot_, {by_user_, by_service_}, known);
  }

  const TempFolder folder_;
  const MachineOrigin robot_{"robot", "", 0, folder_ / "robot.toml"};
  const std::string by_user_ = folder_ / "user/robot";
  const std::string by_service_ = folder_ / "service/robot";
};

TEST_F(OtherStart, LeavesItsStopToTheNextOne) {
  EXPECT_THAT(Found(), IsEmpty());
  StopIn(by_user_, robot_);
  StopIn(by_service_, robot_);
  const auto found = Found();
  ASSERT_EQ(found.size(), 1U) << "its own is known";
  EXPECT_EQ(found[0].state_dir, by_user_);
  EXPECT_EQ(found[0].stops, kStops);
}

TEST_F(OtherStart, LeavesNoStopThatHasBeenReleasedSince) {
  StopIn(by_user_, robot_);
  EXPECT_THAT(Found({{}, {7}}), IsEmpty());
}

// Started by systemd, the robot went to Active: the stop was over, and that no person had requested
// a state since was on the other disk only.
TEST_F(OtherStart, LeavesWhatItsReleasedStopHasSwitchedOffToTheNextOne) {
  const StoredStops released{{}, {3, 7}, true};
  StopIn(by_user_, robot_, released);
  const auto found = Found();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].stops, released);
  EXPECT_EQ(Found({{}, {3}}).size(), 1U) << "of an earlier stop";
  EXPECT_THAT(Found({{}, {3, 7}}), IsEmpty()) << "this folder says whether it waits since";
}

TEST_F(OtherStart, LeavesNothingOfAReleasedStopAfterWhichAStateWasRequested) {
  StopIn(by_user_, robot_, {{}, {3, 7}, false});
  EXPECT_THAT(Found(), IsEmpty());
}

TEST_F(OtherStart, OfAnotherMachineLeavesNone) {
  MachineOrigin other = robot_;
  other.file = folder_ / "moved.toml";
  StopIn(by_user_, other);
  EXPECT_THAT(Found(), IsEmpty()) << "also of one whose config is no longer there";
}

TEST_F(OtherStart, WithADamagedFileLeavesNone) {
  StopIn(by_user_, robot_);
  std::ofstream(by_user_ + "/emergency_stop") << "engaged 7";
  EXPECT_THAT(Found(), IsEmpty());
}

TEST(DefaultStateDirs, AreThoseOfThisUserOfSystemdAndOfTheOwnerOfTheConfig) {
  const TempFolder folder;
  std::ofstream(folder / "robot.toml") << "x";
  const auto folders = DefaultStateDirs({"robot", "", 0, folder / "robot.toml"});
  ASSERT_GE(folders.size(), 2U);
  for (const std::string& one : folders) {
    EXPECT_EQ(fs::path(one).parent_path().filename(), "musher") << one;
    EXPECT_TRUE(fs::path(one).filename().string().starts_with("robot")) << one;
  }
}

}  // namespace musher::other_starts_test
