#include "musher/controller/storage/other_starts.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "musher/base/host.hpp"
#include "musher/controller/storage/state_store.hpp"
#include "musher/lifecycle/step/emergency_stops.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::other_starts_test {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;

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
  // What a controller without stops of its own begins with.
  StoredStops Merged(const std::vector<std::string>& folders) const {
    StoredStops stops;
    for (const StopsElsewhere& other : FindStopsElsewhere(by_service_, robot_, folders, stops)) {
      stops = Merge(stops, other.stops);
    }
    return stops;
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
  EXPECT_EQ(found[0].stops, (StoredStops{kStops.engaged, {}}));
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
  EXPECT_TRUE(found[0].stops.awaits_request);
  EXPECT_THAT(found[0].stops.engaged, IsEmpty());
  EXPECT_EQ(Found({{}, {3, 7}}).size(), 1U) << "a start there may have engaged it again since";
}

TEST_F(OtherStart, WaitsForOneRequestAlone) {
  StopIn(by_user_, robot_, {{}, {3, 7}, true});
  StoredStops own = Merged({by_user_});
  EXPECT_TRUE(own.awaits_request);
  own.awaits_request = false;  // a person has requested a state
  EXPECT_THAT(Found(own), IsEmpty());
  StopIn(by_user_, robot_, {{}, {3, 7, 8}, true});
  EXPECT_EQ(Found(own).size(), 1U) << "of another stop";
  StopIn(by_user_, robot_, {{}, {3, 7}, true, {}, {}, 1});
  EXPECT_EQ(Found(own).size(), 1U) << "of the same one, which was engaged again";
}

// Its panel still published it: the robot was reported as stopped, and went to Active.
TEST_F(OtherStart, ThatHasEngagedAReleasedStopAgainLeavesThatItWaits) {
  StopIn(by_user_, robot_, {{{7, "a panel", "smoke"}}, {}, true, {}, {}, 1});
  StoredStops own{{}, {7}};
  const auto found = Found(own);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0].stops.engaged, IsEmpty());
  EXPECT_TRUE(found[0].stops.awaits_request);
  own = Merge(own, found[0].stops);
  own.awaits_request = false;  // a person has requested a state
  EXPECT_THAT(Found(own), IsEmpty());
}

// Any user can write one: the actuators that had latched the stop were released by the start.
TEST_F(OtherStart, ReleasesNoStopThatActuatorsHaveLatched) {
  StopIn(by_user_, robot_, {{}, {3, 7}, true});
  const EmergencyStop stop{7, "alice", "smoke"};
  const StoredStops own = Merged({by_user_});
  EXPECT_THAT(own.released, AllOf(Not(Contains(StopId(3))), Not(Contains(StopId(7)))));
  EXPECT_THAT(Merge(own, WithoutReleased(own, {{stop}, {}, true})).engaged, ElementsAre(stop));
}

// Whichever is read first: the release ended the stop if its folder was.
TEST_F(OtherStart, ReleasesNoStopOfAThirdOne) {
  const std::string third = folder_ / "third/robot";
  StopIn(by_user_, robot_, {{}, {3, 7}, true});
  StopIn(third, robot_);
  for (const auto& folders : {std::vector{by_user_, third}, std::vector{third, by_user_}}) {
    EXPECT_EQ(Merged(folders).engaged, kStops.engaged);
  }
}

// An actuator may report it later. It engaged it again after the release.
TEST_F(OtherStart, LeavesWhatItsStopHasReplacedToTheReleaseOfThatOne) {
  StopIn(by_user_, robot_, {{{7, "a panel", "smoke"}}, {3, 6}, true, {}, {6}});
  const auto found = Found();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0].stops.released, AllOf(Contains(StopId(6)), Not(Contains(StopId(3)))));
  EXPECT_THAT(found[0].stops.replaced, ElementsAre(StopId(6)));
  EXPECT_THAT(Found({{{6, "alice", ""}}, {}}).at(0).stops.replaced, IsEmpty()) << "engaged here";
  EXPECT_THAT(Found({{}, {7}}).at(0).stops.replaced, IsEmpty()) << "its stop is over";
}

TEST_F(OtherStart, LeavesNothingOfAReleasedStopAfterWhichAStateWasRequested) {
  StopIn(by_user_, robot_, {{}, {3, 7}, false});
  EXPECT_THAT(Found(), IsEmpty());
}

// A damaged file, or a machine that was taken over from another host.
TEST_F(OtherStart, WhoseLastStopHasNoIdLeavesThatItWaits) {
  for (const StoredStops& waits : {StoredStops{{}, {kUnknownStop}, true}, {{}, {}, true}}) {
    StopIn(by_user_, robot_, waits);
    EXPECT_EQ(Found({{}, {kUnknownStop}}).size(), 1U);
  }
}

TEST_F(OtherStart, ReleasesNoStopThatIsEngagedHere) {
  StopIn(by_user_, robot_, {{}, {3, 7}, true});
  const auto found = Found({{{7, "alice", "smoke"}}, {}});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0].stops.released, Not(Contains(StopId(7))));
}

TEST_F(OtherStart, OfAnotherMachineLeavesNone) {
  MachineOrigin other = robot_;
  other.file = folder_ / "moved.toml";
  StopIn(by_user_, other);
  EXPECT_THAT(Found(), IsEmpty()) << "also of one whose config is no longer there";
}

// A power cut may have torn the save of a stop: it was passed over, and the robot went to Active.
TEST_F(OtherStart, WithADamagedFileLeavesAStopThatAReleaseEnds) {
  StopIn(by_user_, robot_);
  std::ofstream(by_user_ + "/emergency_stop") << "engaged 7";
  const auto found = Found();
  ASSERT_EQ(found.size(), 1U);
  ASSERT_EQ(found[0].stops.engaged.size(), 1U);
  const EmergencyStop& stop = found[0].stops.engaged[0];
  EXPECT_EQ(stop.reason, by_user_ + "/emergency_stop is damaged");
  EXPECT_NE(stop.id, kUnknownStop) << "a release of one without an id would cover the next one";
  EXPECT_THAT(Found({{}, {stop.id}}), IsEmpty());
  std::ofstream(by_user_ + "/emergency_stop", std::ios::app) << "8";
  fs::last_write_time(by_user_ + "/emergency_stop",
                      fs::file_time_type::clock::now() + std::chrono::seconds(5));
  EXPECT_EQ(Found({{}, {stop.id}}).size(), 1U) << "it was written again";
}

TEST_F(OtherStart, LeavesAStopWithoutAnId) {
  StopIn(by_user_, robot_, {{{kUnknownStop, "", "its file was damaged"}}, {}});
  const auto found = Found({{}, {kUnknownStop}});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(Found({{}, {found[0].stops.engaged.at(0).id}}), IsEmpty());
}

// Its first save found a full disk.
TEST_F(OtherStart, WhoseFolderDoesNotSayOfWhichMachineItIsLeavesItsStop) {
  StopIn(by_user_, robot_);
  fs::remove(by_user_ + "/machine");
  EXPECT_EQ(Found().size(), 1U);
}

// A root start waited for them without end.
TEST_F(OtherStart, WithPipesAndLinksHoldsNoStartUp) {
  for (const char* name : {"machine", "emergency_stop", "policy", "controller.lock"}) {
    fs::create_directories(by_user_);
    ASSERT_EQ(mkfifo((by_user_ + "/" + name).c_str(), 0666), 0);
    EXPECT_FALSE(LoadOrigin(by_user_));
    EXPECT_EQ(Found().size(), name == std::string("emergency_stop") ? 1U : 0U) << name;
    EXPECT_THAT(FindLevelsElsewhere(by_service_, robot_, {by_user_}), IsEmpty());
    EXPECT_EQ(StateStore::OwnerOf(by_user_), 0);
    fs::remove_all(by_user_);
  }
  StopIn(by_user_, robot_);
  const fs::path secret = folder_ / "secret";
  fs::rename(by_user_ + "/machine", secret);
  fs::create_symlink(secret, by_user_ + "/machine");
  EXPECT_FALSE(LoadOrigin(by_user_));
}

// The same config with another name, namespace or domain, whose motors are the same.
TEST_F(OtherStart, UnderAnotherNameNamespaceOrDomainLeavesWhatHoldsToTheNextOne) {
  for (const MachineOrigin& earlier : {MachineOrigin{"renamed", "", 0, robot_.file},
                                       MachineOrigin{"robot", "fleet", 0, robot_.file},
                                       MachineOrigin{"robot", "", 7, robot_.file}}) {
    const std::string folder = folder_ / "user/earlier";
    StopIn(folder, earlier);
    auto store = StateStore::Open(folder, earlier);
    ASSERT_TRUE(store);
    ASSERT_TRUE(store.value().SavePolicy({std::nullopt, std::nullopt, BatteryLevel::kLowPower}));
    ASSERT_TRUE(store.value().SaveActuators(
        {{"arm", StaysDown::kTornDown}, {"legs", StaysDown::kNo, "Active"}}, HostId()));
    const auto folders = FoldersOfFile(robot_, {by_user_, by_service_});
    EXPECT_THAT(folders, ElementsAre(folder)) << earlier.Text();
    EXPECT_EQ(FindStopsElsewhere(by_service_, robot_, folders, {}).size(), 1U);
    const auto levels = FindLevelsElsewhere(by_service_, robot_, folders);
    ASSERT_EQ(levels.size(), 1U);
    EXPECT_EQ(levels[0].level, BatteryLevel::kLowPower);
    const auto down = FindStayDownElsewhere(by_service_, robot_, folders);
    ASSERT_EQ(down.size(), 1U);
    EXPECT_THAT(down[0].actuators, ElementsAre(StoredActuator{"arm", StaysDown::kTornDown}));
    ASSERT_TRUE(store.value().SaveActuators({{"leg", StaysDown::kTornDown}}, HostId()));
    EXPECT_NE(FindStayDownElsewhere(by_service_, robot_, folders).at(0).mark, down[0].mark)
        << "they were stored again";
    ASSERT_TRUE(store.value().SaveActuatorsTaken({down[0].mark, 7}));
    EXPECT_EQ(StateStore::ActuatorsTakenIn(folder), (std::vector{down[0].mark, std::uint64_t{7}}));
    fs::remove_all(folder);
  }
  // With a file of its own it is another robot.
  StopIn(folder_ / "user/cat", {"cat", "", 0, folder_ / "cat.toml"});
  EXPECT_THAT(FoldersOfFile(robot_, {by_user_, by_service_}), IsEmpty());
}

TEST_F(OtherStart, LeavesItsLowBatteryToTheNextOneOnce) {
  const auto found = [&] {
    return FindLevelsElsewhere(by_service_, robot_, {by_user_, by_service_});
  };
  EXPECT_THAT(found(), IsEmpty());
  auto store = StateStore::Open(by_user_, robot_);
  ASSERT_TRUE(store);
  ASSERT_TRUE(store.value().SavePolicy({std::nullopt, std::nullopt, BatteryLevel::kProtected}));
  ASSERT_EQ(found().size(), 1U);
  EXPECT_EQ(found()[0].level, BatteryLevel::kProtected);
  const std::uint64_t mark = found()[0].mark;
  ASSERT_TRUE(store.value().SaveLevelsTaken({mark, 7}));
  EXPECT_EQ(StateStore::LevelsTakenIn(by_user_), (std::vector<std::uint64_t>{mark, 7}));
  ASSERT_TRUE(store.value().SavePolicy({std::nullopt, std::nullopt, BatteryLevel::kLowPower}));
  EXPECT_NE(found().at(0).mark, mark) << "it was stored again";
  ASSERT_TRUE(store.value().SavePolicy({}));
  EXPECT_THAT(found(), IsEmpty());
}

// A start by systemd, as root, and later one by a person who may not read its files. The stop was
// passed over, and the robot went to Active.
class ClosedStart : public OtherStart {
 protected:
  ClosedStart() {
    fs::permissions(folder_.path(), fs::perms(0755));
    fs::create_directory(folder_ / "service");
    fs::permissions(folder_ / "service", fs::perms(0755));
  }
  ~ClosedStart() override { Close(by_service_, 0700); }

  static void Close(const std::string& path, int mode = 0) {
    std::error_code error;
    fs::permissions(path, fs::perms(mode), error);
  }
  // The times of files are those of the kernel's last tick.
  static void SetTheDayBefore(const std::string& path) {
    fs::last_write_time(path, fs::last_write_time(path) - std::chrono::hours(24));
  }
  // By a user who may not read them.
  std::vector<UnreadFolder> Unread(const std::vector<UnreadFolder>& known = {}) const {
    const bool as_another = geteuid() == 0;
    EXPECT_TRUE(!as_another || seteuid(65534) == 0);
    auto unread = FindUnreadFolders(by_user_, robot_, {by_user_, by_service_, by_service_}, known);
    EXPECT_TRUE(!as_another || seteuid(0) == 0);
    return unread;
  }
  // What is known once a person has answered it.
  static std::vector<UnreadFolder> Answered(std::vector<UnreadFolder> unread) {
    for (UnreadFolder& one : unread) one.answered = true;
    return unread;
  }
};

TEST_F(ClosedStart, LeavesWhetherAStopIsEngagedOpen) {
  EXPECT_THAT(Unread(), IsEmpty()) << "there was none";
  StopIn(by_service_, robot_);
  Close(by_service_);
  const auto unread = Unread();
  ASSERT_EQ(unread.size(), 1U) << "once, however often the place is named";
  EXPECT_EQ(unread[0].folder, by_service_);
  EXPECT_NE(unread[0].owner, "");
  EXPECT_FALSE(unread[0].answered);
}

TEST_F(ClosedStart, IsAnsweredByAPersonUntilItsFolderHasChanged) {
  StopIn(by_service_, robot_);
  Close(by_service_);
  const auto answered = Answered(Unread());
  ASSERT_EQ(answered.size(), 1U);
  EXPECT_TRUE(Unread(answered).at(0).answered) << "it does not wait at each start";
  Close(by_service_, 0700);
  fs::last_write_time(by_service_, fs::last_write_time(by_service_) + std::chrono::seconds(5));
  Close(by_service_);
  EXPECT_FALSE(Unread(answered).at(0).answered) << "a controller has run there since";
}

// As a person of its log_group sees it.
TEST_F(ClosedStart, WithAFileOfStopsThatIsClosedLeavesItOpenToo) {
  StopIn(by_service_, robot_);
  Close(by_service_, 0755);
  Close(by_service_ + "/emergency_stop");
  const auto unread = Unread();
  ASSERT_EQ(unread.size(), 1U);
  EXPECT_EQ(unread[0].folder, by_service_);
  const auto answered = Answered(unread);
  fs::last_write_time(by_service_ + "/emergency_stop",
                      fs::file_time_type::clock::now() + std::chrono::seconds(5));
  EXPECT_FALSE(Unread(answered).at(0).answered) << "its stops have changed";
}

TEST(UnreadFolderText, SaysWhoMayReadItOrThatNoUserCan) {
  EXPECT_EQ(WhyUnread({"/a", "root"}), "this user may not read it, user root may");
  EXPECT_EQ(WhyUnread({"/a"}), "it cannot be read");
}

// Of a machine's own folder that was made by root, as where `state_dir` names it.
TEST_F(ClosedStart, InTheMachinesOwnFolderIsOpenTooIfThatCannotBeOpened) {
  StopIn(by_service_, robot_);
  Close(by_service_);
  const bool as_another = geteuid() == 0;
  ASSERT_TRUE(!as_another || seteuid(65534) == 0);
  const StoredStops stops = OpenStopsIn(by_service_);
  const auto unread = FindUnreadFolders("", robot_, {by_service_}, {});
  ASSERT_TRUE(!as_another || seteuid(0) == 0);
  EXPECT_EQ(stops, StoredStops{});
  ASSERT_EQ(unread.size(), 1U);
  EXPECT_EQ(unread[0].folder, by_service_);
}

TEST_F(ClosedStart, WhoseBatteryCannotBeReadLeavesItOpenToo) {
  auto store = StateStore::Open(by_service_, robot_);
  ASSERT_TRUE(store);
  ASSERT_TRUE(store.value().SavePolicy({std::nullopt, std::nullopt, BatteryLevel::kProtected}));
  Close(by_service_, 0755);
  Close(by_service_ + "/emergency_stop", 0644);
  Close(by_service_ + "/policy");
  EXPECT_EQ(Unread().size(), 1U);
}

// What was written since an answer was passed over: a disk that fails changes no time of its files.
TEST_F(ClosedStart, OnADiskThatFailsIsOpenAtEachStartHoweverOftenItWasAnswered) {
  StopIn(by_service_, robot_);
  Close(by_service_, 0755);
  Close(by_service_ + "/emergency_stop", 0644);
  fs::remove(by_service_ + "/policy");
  ASSERT_EQ(mkfifo((by_service_ + "/policy").c_str(), 0644), 0) << "no file that can be read";
  const auto answered = Answered(Unread());
  ASSERT_EQ(answered.size(), 1U);
  EXPECT_FALSE(Unread(answered).at(0).answered);
}

TEST_F(ClosedStart, OfAnotherMachineLeavesNothingOpen) {
  MachineOrigin other = robot_;
  other.file = folder_ / "moved.toml";
  StopIn(by_service_, other);
  Close(by_service_, 0755);
  Close(by_service_ + "/emergency_stop");
  EXPECT_THAT(Unread(), IsEmpty());
}

TEST_F(ClosedStart, ThatCanBeReadLeavesNothingOpen) {
  StopIn(by_service_, robot_);
  Close(by_service_, 0755);
  Close(by_service_ + "/emergency_stop", 0644);
  Close(by_service_ + "/policy", 0644);
  EXPECT_THAT(Unread(), IsEmpty());
}

TEST_F(ClosedStart, InAPlaceThatIsClosedCountsByThePlace) {
  StopIn(by_service_, robot_);
  Close(folder_ / "service");
  const auto unread = Unread();
  Close(folder_ / "service", 0755);
  ASSERT_EQ(unread.size(), 1U);
  EXPECT_EQ(unread[0].folder, folder_ / "service");
}

// As ~/.local/state/musher is where a controller has made it. The mark stayed the same, and a stop
// that was engaged there since was passed over.
TEST_F(ClosedStart, InAPlaceThatIsClosedIsAnsweredUntilTheNextStartThere) {
  StopIn(by_service_, robot_, {});
  SetTheDayBefore(folder_ / "service");
  Close(folder_ / "service");
  const auto answered = Answered(Unread());
  ASSERT_EQ(answered.size(), 1U);
  EXPECT_TRUE(Unread(answered).at(0).answered) << "it does not wait at each start";
  Close(folder_ / "service", 0755);
  StopIn(by_service_, robot_);
  Close(folder_ / "service");
  const auto unread = Unread(answered);
  Close(folder_ / "service", 0755);
  EXPECT_FALSE(unread.at(0).answered) << "a controller has run there since";
}

// Such a user can start the robot there, and cannot mark the place as changed.
TEST_F(ClosedStart, InAPlaceThatIsClosedToThisUserButNotToAllOthersIsOpenAtEachStart) {
  StopIn(by_service_, robot_);
  Close(folder_ / "service", 0001);
  const auto answered = Answered(Unread());
  const auto unread = Unread(answered);
  Close(folder_ / "service", 0755);
  ASSERT_EQ(unread.size(), 1U);
  EXPECT_FALSE(unread[0].answered);
}

// The home folder of root is closed on every host: nothing says that a machine was started there.
TEST_F(ClosedStart, InAPlaceThatCannotBeSeenIsNotKnownAndBlocksNoRobot) {
  StopIn(by_service_, robot_);
  Close(folder_.path());
  const auto unread = Unread();
  Close(folder_.path(), 0755);
  EXPECT_THAT(unread, IsEmpty());
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

// A person's robot is started by systemd at the next boot: its config belongs to root, and its
// folder to the person.
TEST(DefaultStateDirs, OfRootAreThoseOfEveryUserWhoHasStartedTheMachine) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can read them";
  const TempFolder folder;
  const std::string pi = folder / "home/pi";
  std::ofstream(folder / "passwd") << "root:x:0:0:root:/root:/bin/bash\n"
                                   << "pi:x:1000:1000:,,,:" << pi << ":/bin/bash\n"
                                   << "guest:x:1001:1001::" << (folder / "home/guest") << ":\n"
                                   << "broken\n";
  const MachineOrigin robot{"robot", "", 0, "/etc/musher/robot.toml"};
  const fs::path name = fs::path(DefaultStateDirs(robot).at(0)).filename();
  const std::string state = pi + "/.local/state/musher/" + name.string();
  const auto found = [&] { return DefaultStateDirs(robot, folder / "passwd"); };
  EXPECT_THAT(found(), Not(Contains(state))) << "the person has not started it";
  fs::create_directories(state);
  EXPECT_THAT(found(), Contains(state));
  std::ofstream(folder / "mounts")
      << "22 1 8:1 / / rw - ext4 /dev/sda1 rw\n"
      << "23 22 0:40 / " << (folder / "home") << " rw,relatime shared:7 - nfs4 server:/home rw\n";
  EXPECT_THAT(DefaultStateDirs(robot, folder / "passwd", folder / "mounts"), Not(Contains(state)))
      << "a start at boot would wait for the server";
  fs::remove_all(state);
  fs::create_directory_symlink(folder / "home/data", state);
  EXPECT_THAT(found(), Contains(state)) << "its files may be on another disk";
  EXPECT_THAT(DefaultStateDirs(robot, folder / "passwd", folder / "mounts"), Not(Contains(state)));
}

}  // namespace musher::other_starts_test
