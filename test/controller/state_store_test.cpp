#include "musher/controller/storage/state_store.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/controller/process/host_uptime.hpp"
#include "musher/controller/storage/stored_power.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::state_store_test {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

class Store : public ::testing::Test {
 protected:
  StateStore MustOpen() {
    auto store = StateStore::Open(dir_, robot_);
    if (!store) throw std::runtime_error(store.error().message);
    return std::move(store).value();
  }

  // The power fails while the slot is written.
  void Tear(const std::string& name, const std::string& slot) const {
    std::fstream file(dir_ + "/" + name, std::ios::in | std::ios::out | std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)), {});
    const std::size_t at = bytes.find(slot);
    ASSERT_NE(at, std::string::npos) << name;
    file.clear();
    file.seekp(static_cast<std::streamoff>(at + slot.size()));
    file.write("\0\0\0", 3).flush();
  }

  TempFolder folder_;
  const std::string dir_ = folder_ / "state/musher/robot";
  const MachineOrigin robot_{"robot", "", 0, folder_ / "robot.toml"};
};

TEST_F(Store, MakesItsFolderForItsOwnerOnly) {
  const StateStore store = MustOpen();
  struct stat info {};
  ASSERT_EQ(stat(dir_.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0700U);
  EXPECT_TRUE(fs::is_directory(fs::path(store.LogFile("motion")).parent_path()));
  EXPECT_THAT(store.LogFile("motion"), EndsWith("/logs/motion.log"));
}

TEST_F(Store, KeepsAndDeletesTheValuesOfThePolicy) {
  StateStore store = MustOpen();
  EXPECT_EQ(store.LoadPolicy(), StoredPolicy{});
  const StoredPolicy lowered{true, BatteryFallback{"Active", "Protected", 7},
                             BatteryLevel::kProtected};
  ASSERT_TRUE(store.SavePolicy(lowered).ok());
  EXPECT_EQ(store.LoadPolicy(), lowered);
  const StoredPolicy off{false, std::nullopt, BatteryLevel::kLowPower};
  ASSERT_TRUE(store.SavePolicy(off).ok());
  EXPECT_EQ(store.LoadPolicy(), off);
}

// A controller that was killed after the decision, and started again hours or a boot later, powered
// the robot off at once.
TEST_F(Store, ForgetsAPowerOffOfAnEarlierBootOrOlderThanTheBound) {
  StateStore store = MustOpen();
  const StoredPolicy off{{}, {}, BatteryLevel::kFree, PowerAhead::kOff};
  ASSERT_TRUE(store.SavePolicy(off));
  EXPECT_EQ(store.LoadPolicy(), off);
  EXPECT_EQ(WhyPowerForgottenIn(dir_), "");
  const std::string host = HostId();
  const std::string boot = host.substr(0, host.find('/'));
  const auto decided = [&](const std::string& in_boot, Duration ago) {
    const std::string stamp = in_boot + " " + std::to_string(ToMilliseconds(SinceBoot() - ago));
    std::ofstream(dir_ + "/policy") << "level protected\npower reboot " << stamp << "\n";
    EXPECT_EQ(store.LoadPolicy().level, BatteryLevel::kProtected) << "the rest counts";
    return store.LoadPolicy().power;
  };
  EXPECT_EQ(decided(boot, std::chrono::minutes(9)), PowerAhead::kReboot);
  EXPECT_EQ(decided(boot, std::chrono::minutes(75) + std::chrono::seconds(1)), PowerAhead::kNone);
  EXPECT_EQ(WhyPowerForgottenIn(dir_),
            "a reboot that was decided 75 min ago is forgotten: it outlasts its controller for 10 "
            "min");
  EXPECT_EQ(decided(boot, -std::chrono::minutes(1)), PowerAhead::kNone) << "another clock";
  EXPECT_EQ(decided("another-boot", std::chrono::minutes(1)), PowerAhead::kNone);
  EXPECT_EQ(WhyPowerForgottenIn(dir_),
            "a reboot that was decided before this computer was booted is forgotten");
  std::ofstream(dir_ + "/policy") << "power off\n";
  EXPECT_EQ(store.LoadPolicy().power, PowerAhead::kNone);
  EXPECT_THAT(WhyPowerForgottenIn(dir_), HasSubstr("its time is not known"));
}

TEST_F(Store, KeepsTheTimeOfAPowerOffOverLaterSaves) {
  StateStore store = MustOpen();
  const std::string host = HostId();
  const auto stamp = std::to_string(ToMilliseconds(SinceBoot() - std::chrono::minutes(9)));
  const std::string line = "power off " + host.substr(0, host.find('/')) + " " + stamp + "\n";
  std::ofstream(dir_ + "/policy") << line;
  ASSERT_TRUE(store.SavePolicy({{}, {}, BatteryLevel::kLowPower, PowerAhead::kOff}));
  EXPECT_THAT(ReadFile(dir_ + "/policy"), HasSubstr(line));
}

TEST_F(Store, GivesAPowerOffThatIsDecidedAgainANewTime) {
  StateStore store = MustOpen();
  std::ofstream(dir_ + "/policy") << "power off another-boot 1000\n";
  ASSERT_EQ(store.LoadPolicy().power, PowerAhead::kNone);
  ASSERT_TRUE(store.SavePolicy({{}, {}, BatteryLevel::kFree, PowerAhead::kOff}));
  EXPECT_EQ(store.LoadPolicy().power, PowerAhead::kOff);
}

// With a full disk `musher down` was forgotten: the next start by a supervisor led to Active.
TEST_F(Store, KeepsTheIntentToStopOnAFullDisk) {
  StateStore store = MustOpen();
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit full{0, before.rlim_max};  // files can be made, and have no block
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &full), 0);
  EXPECT_FALSE(store.SavePolicy({true, std::nullopt, BatteryLevel::kProtected}));
  const bool saved = store.SaveStopIntent(true).ok();
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, ignored);
  EXPECT_TRUE(saved);
  EXPECT_TRUE(store.LoadStopIntent());
  ASSERT_TRUE(store.SaveStopIntent(false));
  EXPECT_FALSE(store.LoadStopIntent());
}

TEST_F(Store, OfADamagedPolicyOnlyWhatCanBeReadCounts) {
  const StateStore store = MustOpen();
  const auto load = [&](const std::string& text) {
    std::ofstream(dir_ + "/policy", std::ios::binary) << text;
    return store.LoadPolicy();
  };
  for (const char* text : {"", "low_power", "low_power maybe", "lowered Active", "\xff\xfe 1 2",
                           "lowered Active Protected -", "lowered", "level", "level high"}) {
    EXPECT_EQ(load(text), StoredPolicy{}) << text;
  }
  EXPECT_EQ(load("low_power on\nlowered Active"), (StoredPolicy{true, std::nullopt}));
}

TEST_F(Store, KeepsTheEmergencyStopsThatAreEngagedAndTheReleasedIds) {
  StateStore store = MustOpen();
  EXPECT_EQ(store.LoadEmergencyStops(), StoredStops{});
  const StoredStops stops{
      {{7, "alice@desk", "smoke in\nthe lab"}, {9, "", ""}}, {3, 4}, true, {}, {}, 12};
  ASSERT_TRUE(store.SaveEmergencyStops(stops));
  StoredStops loaded = store.LoadEmergencyStops();
  EXPECT_EQ(loaded.engaged.at(0).reason, "smoke in the lab") << "one line each";
  loaded.engaged[0].reason = stops.engaged[0].reason;
  EXPECT_EQ(loaded, stops);
}

TEST_F(Store, KeepsTheFoldersWhoseStopsAreNotKnownAndWhatAPersonHasAnswered) {
  StateStore store = MustOpen();
  StoredStops stops{{}, {3}};
  stops.unread = {{"/var/lib/musher/a robot", "root", 4711, false}, {"/other", "", 12, true}};
  ASSERT_TRUE(store.SaveEmergencyStops(stops));
  EXPECT_EQ(store.LoadEmergencyStops(), stops);
  std::ofstream(dir_ + "/emergency_stop") << "unread x\nanswered 7\nunread 5 - /there\nend\n";
  EXPECT_EQ(store.LoadEmergencyStops().unread,
            (std::vector<UnreadFolder>{{"/there", "", 5, false}}));
}

TEST_F(Store, KeepsThatAControllerOfAnotherHostHasReplacedTheLastOne) {
  StateStore store = MustOpen();
  StoredStops stops{{}, {3}};
  stops.led_elsewhere = true;
  ASSERT_TRUE(store.SaveEmergencyStops(stops));
  EXPECT_EQ(store.LoadEmergencyStops(), stops);
}

TEST_F(Store, KeepsTheEmergencyStopsOfAFileThatALaterVersionHasWritten) {
  StateStore store = MustOpen();
  std::ofstream(dir_ + "/emergency_stop") << "released 7\na word of tomorrow\nend\n";
  EXPECT_EQ(store.LoadEmergencyStops(), (StoredStops{{}, {7}}));
}

TEST_F(Store, ReadsADamagedOrShortenedFileOfEmergencyStopsAsAnEngagedStop) {
  StateStore store = MustOpen();
  for (const char* text : {"", "engaged 7\n", "released x\nend\n", "engagements -1\nend\n",
                           "4711 \n", "by me\nend\n", "end "}) {
    std::ofstream(dir_ + "/emergency_stop") << text;
    EXPECT_EQ(store.LoadEmergencyStops().engaged.size(), 1U) << text;
  }
}

TEST_F(Store, DistinguishesReplacedEmergencyStopsFromReleasedOnes) {
  StateStore store = MustOpen();
  const StoredStops stops{{{8, "a panel", "smoke"}}, {5, 7, 6}, true, {}, {7}};
  ASSERT_TRUE(store.SaveEmergencyStops(stops));
  EXPECT_EQ(store.LoadEmergencyStops(), stops);
}

// A version that did not distinguish them has written it.
TEST_F(Store, ReadsWhatIsOverInAnOlderFileAsReleased) {
  StateStore store = MustOpen();
  std::ofstream(dir_ + "/emergency_stop") << "engaged 8\nby a panel\nreason \nreleased 7\nend\n";
  EXPECT_EQ(store.LoadEmergencyStops(), (StoredStops{{{8, "a panel", ""}}, {7}}));
}

TEST_F(Store, KnowsWhetherAControllerHasBegunInThisBoot) {
  StateStore store = MustOpen();
  EXPECT_FALSE(StateStore::BeganInBootOf(dir_, "boot-1/4026531836"));
  ASSERT_TRUE(store.SaveBootOf("boot-1/4026531836"));
  EXPECT_TRUE(StateStore::BeganInBootOf(dir_, "boot-1/4026531836"));
  EXPECT_TRUE(StateStore::BeganInBootOf(dir_, "boot-1/4026532000")) << "in a container";
  EXPECT_FALSE(StateStore::BeganInBootOf(dir_, "boot-2/4026531836"));
}

TEST_F(Store, NotesTheBootWhereThereIsNoRoomForAnotherFile) {
  StateStore store = MustOpen();
  ASSERT_TRUE(store.SaveBootOf("boot-1/4026531836"));
  fs::create_directory(dir_ + "/boot.new");  // as on a full disk: no draft can be written
  ASSERT_TRUE(store.SaveBootOf("boot-2/4026531836"));
  EXPECT_TRUE(StateStore::BeganInBootOf(dir_, "boot-2/4026531836"));
}

TEST_F(Store, SavesEmergencyStopsInPlaceInReservedBlocks) {
  StateStore store = MustOpen();
  struct stat before {};
  ASSERT_EQ(stat((dir_ + "/emergency_stop").c_str(), &before), 0);
  EXPECT_GE(before.st_blocks * 512, before.st_size)
      << "the blocks are taken before there is a stop";
  EXPECT_EQ(store.LoadEmergencyStops(), StoredStops{});
  StoredStops many;
  for (StopId id = 1; id <= 65; ++id) {
    many.engaged.push_back({id, ToString(id + 100) + std::string(253, 'b'), std::string(256, 'r')});
  }
  for (std::uint64_t id = 0; id < 256; ++id) many.released.emplace_back(UINT64_MAX - id);
  for (int saves = 0; saves < 5; ++saves) {
    ASSERT_TRUE(store.SaveEmergencyStops(many));
    EXPECT_EQ(store.LoadEmergencyStops(), many);
    many.released.pop_back();
  }
  struct stat after {};
  ASSERT_EQ(stat((dir_ + "/emergency_stop").c_str(), &after), 0);
  EXPECT_EQ(after.st_ino, before.st_ino);
  EXPECT_EQ(after.st_size, before.st_size);
  EXPECT_EQ(after.st_blocks, before.st_blocks);
}

// As on a full disk: no draft of another file can be written. What had ended came on at the next
// start of the controller.
TEST_F(Store, SavesWhatDecidesWhichActuatorsMoveWhereThereIsNoRoomForAnotherFile) {
  StateStore store = MustOpen();
  for (const char* file : {"actuators", "policy", "epoch", "processes"}) {
    struct stat info {};
    ASSERT_EQ(stat((dir_ + "/" + file).c_str(), &info), 0) << file;
    EXPECT_GE(info.st_blocks * 512, info.st_size) << "the blocks are taken before: " << file;
    fs::create_directory(dir_ + "/" + file + ".new");
  }
  for (const Epoch epoch : {Epoch(41), Epoch(42), Epoch(43)}) {
    const std::string name = "arm_" + ToString(epoch);
    const std::vector<StoredActuator> down = {{name, StaysDown::kTornDown, {}}};
    ASSERT_TRUE(store.SaveActuators(down, "boot-1/10"));
    EXPECT_EQ(StateStore::ActuatorsIn(dir_, "boot-1/10"), down);
    const StoredPolicy lowered{true, BatteryFallback{"Active", "Protected", epoch},
                               BatteryLevel::kProtected};
    ASSERT_TRUE(store.SavePolicy(lowered));
    EXPECT_EQ(store.LoadPolicy(), lowered);
    ASSERT_TRUE(store.SaveEpoch(epoch));
    EXPECT_EQ(store.LoadEpoch().value(), epoch);
    ASSERT_TRUE(store.SaveChildren({{name, 4711, 1}}, "boot-1/10"));
    ASSERT_EQ(StateStore::LoadChildren(dir_, "boot-1/10").size(), 1U);
    EXPECT_EQ(StateStore::LoadChildren(dir_, "boot-1/10")[0].actuator, name);
  }
}

// Another folder's battery level is taken over again when its file has changed.
TEST_F(Store, ThatIsOpenedAgainLeavesItsPolicyAsItIs) {
  const std::string file = dir_ + "/policy";
  {
    StateStore store = MustOpen();
    ASSERT_TRUE(store.SavePolicy({{}, {}, BatteryLevel::kProtected}));
  }
  const timespec long_ago[2] = {{1, 0}, {1, 0}};
  ASSERT_EQ(utimensat(AT_FDCWD, file.c_str(), long_ago, 0), 0);
  const StateStore store = MustOpen();
  struct stat info {};
  ASSERT_EQ(stat(file.c_str(), &info), 0);
  EXPECT_EQ(info.st_mtim.tv_sec, 1);
  EXPECT_EQ(store.LoadPolicy().level, BatteryLevel::kProtected);
}

// A power cut in the middle of a save.
TEST_F(Store, OfATornSaveTheOlderOneCounts) {
  StateStore store = MustOpen();
  const std::vector<StoredActuator> arm = {{"arm", StaysDown::kTornDown, {}}};
  const StoredPolicy lowered{{}, {}, BatteryLevel::kProtected};
  ASSERT_TRUE(store.SaveActuators(arm, "boot-1/10"));
  ASSERT_TRUE(store.SaveActuators({}, "boot-1/10"));
  ASSERT_TRUE(store.SavePolicy(lowered));
  ASSERT_TRUE(store.SavePolicy({true, {}, BatteryLevel::kLowPower}));
  ASSERT_TRUE(store.SaveEpoch(41));
  ASSERT_TRUE(store.SaveEpoch(42));
  Tear("actuators", "slot 2");
  Tear("policy", "slot 2");
  Tear("epoch", "slot 2");
  EXPECT_EQ(StateStore::ActuatorsIn(dir_, "boot-1/10"), arm);
  EXPECT_EQ(store.LoadPolicy(), lowered);
  EXPECT_EQ(store.LoadEpoch().value(), Epoch(41));
  Tear("policy", "slot 1");
  Tear("epoch", "slot 1");
  EXPECT_EQ(store.LoadPolicy().level, BatteryLevel::kLowPower) << "it cannot be read";
  EXPECT_THAT(store.LoadEpoch().error().message, HasSubstr("damaged"));
  ASSERT_TRUE(store.SavePolicy(lowered));
  ASSERT_TRUE(store.SaveEpoch(43));
  EXPECT_EQ(store.LoadPolicy(), lowered);
  EXPECT_EQ(store.LoadEpoch().value(), Epoch(43));
}

TEST_F(Store, TakesOverTheSmallFilesOfAnEarlierVersion) {
  { const StateStore store = MustOpen(); }
  std::ofstream(dir_ + "/actuators") << "host boot-1/10\ntorn_down arm\n";
  std::ofstream(dir_ + "/policy") << "low_power on\nlevel protected\n";
  std::ofstream(dir_ + "/epoch") << "41\n";
  const std::vector<StoredActuator> arm = {{"arm", StaysDown::kTornDown, {}}};
  const StoredPolicy policy{true, {}, BatteryLevel::kProtected};
  const auto expect_all = [&](const char* when) {
    EXPECT_EQ(StateStore::ActuatorsIn(dir_, "boot-1/10"), arm) << when;
    EXPECT_EQ(StateStore::PolicyIn(dir_), policy) << when;
    EXPECT_EQ(StateStore::EpochIn(dir_).value(), Epoch(41)) << when;
  };
  expect_all("before");
  const StateStore store = MustOpen();
  expect_all("converted");
  EXPECT_EQ(fs::file_size(dir_ + "/actuators"), 2U * 65536U);
  EXPECT_EQ(fs::file_size(dir_ + "/policy"), 2U * 4096U);
  EXPECT_EQ(fs::file_size(dir_ + "/epoch"), 2U * 4096U);
}

// With the size that the file has with slots, too.
TEST_F(Store, SavesAListOfActuatorsThatIsLongerThanASlot) {
  StateStore store = MustOpen();
  const std::string host = "boot-1/10";
  std::vector<StoredActuator> many;
  const auto fill = [&](std::size_t bytes) {
    many.clear();
    std::size_t left = bytes - std::string("host " + host + "\n").size();
    while (left > 0) {
      const std::size_t line = left > 200 ? 100 : left;
      std::string name = std::to_string(many.size()) + "_";
      name.resize(line - std::string("torn_down \n").size(), 'x');
      many.push_back({name, StaysDown::kTornDown, {}});
      left -= line;
    }
  };
  for (const std::size_t bytes : {65'000U, 70'000U, 131'072U, 131'073U, 200'000U, 1'000U}) {
    fill(bytes);
    ASSERT_TRUE(store.SaveActuators(many, host)) << bytes;
    EXPECT_EQ(StateStore::ActuatorsIn(dir_, host), many) << bytes;
  }
  EXPECT_EQ(fs::file_size(dir_ + "/actuators"), 2U * 65536U) << "it has slots again";
}

// A power cut in the middle of a save.
TEST_F(Store, OfATornSaveOfEmergencyStopsTheOlderOneIsKeptAndAStopIsEngaged) {
  StateStore store = MustOpen();
  const StoredStops first{{{7, "alice", "smoke"}}, {3}};
  ASSERT_TRUE(store.SaveEmergencyStops(first));
  ASSERT_TRUE(store.SaveEmergencyStops({{}, {3, 7}}));
  std::fstream file(dir_ + "/emergency_stop", std::ios::in | std::ios::out | std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(file)), {});
  const std::size_t torn = bytes.find("released 7");
  ASSERT_NE(torn, std::string::npos);
  file.clear();
  file.seekp(static_cast<std::streamoff>(torn));
  file.write("relea\0\0\0", 8).flush();
  const StoredStops loaded = store.LoadEmergencyStops();
  ASSERT_EQ(loaded.engaged.size(), 2U);
  EXPECT_EQ(loaded.engaged[0], first.engaged[0]);
  EXPECT_EQ(loaded.engaged[1].id, kUnknownStop);
  EXPECT_EQ(loaded.released, first.released);
  ASSERT_TRUE(store.SaveEmergencyStops({{}, {7}}));
  EXPECT_EQ(store.LoadEmergencyStops(), (StoredStops{{}, {7}})) << "the torn slot is overwritten";
}

TEST_F(Store, TakesOverTheEmergencyStopsOfAnEarlierVersion) {
  { const StateStore store = MustOpen(); }
  std::ofstream(dir_ + "/emergency_stop") << "engaged 7\nby alice\nreason smoke\nreleased 3\nend\n";
  const StateStore store = MustOpen();
  EXPECT_EQ(store.LoadEmergencyStops(), (StoredStops{{{7, "alice", "smoke"}}, {3}}));
  EXPECT_EQ(fs::file_size(dir_ + "/emergency_stop"), 2U * 65536U);
}

TEST_F(Store, KeepsTheIntentToStopUntilItIsCleared) {
  StateStore store = MustOpen();
  EXPECT_FALSE(store.LoadStopIntent());
  ASSERT_TRUE(store.SaveStopIntent(true));
  EXPECT_TRUE(store.LoadStopIntent());
  ASSERT_TRUE(store.SaveStopIntent(false));
  EXPECT_FALSE(store.LoadStopIntent());
  EXPECT_TRUE(store.SaveStopIntent(false)) << "it is removed already";
}

TEST_F(Store, KeepsTheActuatorsOfOtherHostsWithTheirHost) {
  StateStore store = MustOpen();
  EXPECT_TRUE(store.LoadRemoteActuators("boot-1/10").empty());
  const std::vector<RemoteActuator> remote = {{"lidar", "other-boot/10"}, {"camera", ""}};
  ASSERT_TRUE(store.SaveRemoteActuators(remote, "boot-1/10"));
  EXPECT_EQ(store.LoadRemoteActuators("boot-1/10"), remote);
  EXPECT_EQ(store.LoadRemoteActuators("boot-2/10"), remote) << "the other host was not booted";
  ASSERT_TRUE(store.SaveRemoteActuators({}, "boot-1/10"));
  EXPECT_TRUE(store.LoadRemoteActuators("boot-1/10").empty());
}

TEST_F(Store, KeepsHowActuatorsHaveEnded) {
  StateStore store = MustOpen();
  EXPECT_TRUE(StateStore::ActuatorsIn(dir_, "boot-1/10").empty());
  const std::vector<StoredActuator> down = {{"arm", StaysDown::kTornDown, {}},
                                            {"legs", StaysDown::kGivenUp, State("Active")},
                                            {"lidar", StaysDown::kNo, State("DeActive")},
                                            {"head", StaysDown::kNo, {}, State("LowPower")}};
  ASSERT_TRUE(store.SaveActuators(down, "boot-1/10"));
  EXPECT_EQ(StateStore::ActuatorsIn(dir_, "boot-1/10"), down);
  const std::vector<StoredActuator> arm = {{"arm", StaysDown::kTornDown, {}}};
  EXPECT_EQ(StateStore::ActuatorsIn(dir_, "boot-2/10"), arm) << "the others begin afresh";
  ASSERT_TRUE(store.SaveActuators({}, "boot-1/10"));
  EXPECT_TRUE(StateStore::ActuatorsIn(dir_, "boot-1/10").empty());
}

TEST_F(Store, ForgetsTheActuatorsOfAnotherContainerWhenTheirComputerIsBooted) {
  StateStore store = MustOpen();
  const std::vector<RemoteActuator> remote = {{"lidar", "boot-1/20"}};
  ASSERT_TRUE(store.SaveRemoteActuators(remote, "boot-1/10"));
  EXPECT_EQ(store.LoadRemoteActuators("boot-1/11"), remote);
  EXPECT_TRUE(store.LoadRemoteActuators("boot-2/10").empty());
}

TEST_F(Store, StoresNoLinesThatTheHostOfARemoteActuatorContains) {
  StateStore store = MustOpen();
  ASSERT_TRUE(store.SaveRemoteActuators(
      {{"lidar", "x\nactuator camera y"}, {"imu", std::string(9000, 'z')}}, "boot-1/10"));
  const std::vector<RemoteActuator> loaded = {{"lidar", "xactuatorcameray"},
                                              {"imu", std::string(256, 'z')}};
  EXPECT_EQ(store.LoadRemoteActuators("boot-1/10"), loaded);
}

TEST_F(Store, OfADamagedListOfRemoteActuatorsOnlyWhatCanBeReadCounts) {
  const StateStore store = MustOpen();
  const auto load = [&](const std::string& text) {
    std::ofstream(dir_ + "/remote_actuators", std::ios::binary) << text;
    return store.LoadRemoteActuators("boot-1/10");
  };
  for (const char* text : {"", "host", "actuator", "\xff\xfe 1 2", "host boot-1/10\nactuator\n"}) {
    EXPECT_TRUE(load(text).empty()) << text;
  }
  const std::vector<RemoteActuator> lidar = {{"lidar", "boot-3/1"}};
  EXPECT_EQ(load("actuator lidar boot-3/1\nactua"), lidar);
}

TEST_F(Store, RefusesASecondControllerAndNamesTheFirst) {
  const StateStore first = MustOpen();
  const auto second = StateStore::Open(dir_, robot_);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, kCodeTargetBusy);
  EXPECT_THAT(second.error().message, HasSubstr("process " + std::to_string(getpid()) + " robot"));
}

TEST_F(Store, IsFreeAgainWhenItsOwnerHasExited) {
  { const StateStore first = MustOpen(); }
  EXPECT_TRUE(StateStore::Open(dir_, robot_));
}

TEST_F(Store, IsFreeAgainAfterItsOwnerWasKilled) {
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t owner = fork();
  if (owner == 0) {
    const auto store = StateStore::Open(dir_, robot_);
    const char answer = store ? 'y' : 'n';
    if (write(ready[1], &answer, 1) == 1) pause();
    _exit(1);
  }
  char answer = 0;
  ASSERT_EQ(read(ready[0], &answer, 1), 1);
  EXPECT_EQ(answer, 'y');
  EXPECT_THAT(StateStore::Open(dir_, robot_).error().message, HasSubstr(std::to_string(owner)));
  kill(owner, SIGKILL);
  waitpid(owner, nullptr, 0);
  EXPECT_TRUE(StateStore::Open(dir_, robot_));
}

TEST_F(Store, WhoseLockNamesNoProcessHasNoOwner) {
  fs::create_directories(dir_);
  for (const char* text : {"", "-1 robot\n", "robot\n", "99999999999999999999 robot\n"}) {
    std::ofstream(dir_ + "/controller.lock") << text;
    EXPECT_EQ(StateStore::OwnerOf(dir_), 0) << text;
  }
  const StateStore store = MustOpen();
  EXPECT_EQ(StateStore::OwnerOf(dir_), getpid());
}

TEST_F(Store, ReportsAFolderThatCannotBeCreated) {
  std::ofstream(folder_ / "file") << "in the way";
  const auto store = StateStore::Open(folder_ / "file/robot", robot_);
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().code, kCodeFailed);
  EXPECT_THAT(store.error().message, EndsWith("Not a directory"));
}

// Its new file was taken for a removed one, and saved again as it was without the id.
TEST_F(Store, KeepsTheIdOfTheMachineForTheNextController) {
  {
    StateStore store = MustOpen();
    store.SetMachineId("5982c7ee-4f4e");
    ASSERT_TRUE(store.SaveMachineId());
    EXPECT_THAT(store.SaveRemoved().value(), ::testing::IsEmpty());
  }
  EXPECT_EQ(MustOpen().machine_id(), "5982c7ee-4f4e");
}

TEST_F(Store, HasEpochZeroAtFirst) {
  EXPECT_EQ(MustOpen().LoadEpoch().value(), Epoch(0));
}

TEST_F(Store, KeepsTheEpochForTheNextController) {
  for (const Epoch epoch : {Epoch(41), Epoch(UINT64_MAX), Epoch(7)}) {
    ASSERT_TRUE(MustOpen().SaveEpoch(epoch));
    EXPECT_EQ(MustOpen().LoadEpoch().value(), epoch);
  }
}

TEST_F(Store, ReportsADamagedEpochAndCanReplaceIt) {
  StateStore store = MustOpen();
  for (const char* text : {"", "4", "four\n", "4 \n", "-4\n", "99999999999999999999\n"}) {
    std::ofstream(dir_ + "/epoch") << text;
    const auto epoch = store.LoadEpoch();
    ASSERT_FALSE(epoch) << text;
    EXPECT_THAT(epoch.error().message, HasSubstr("damaged"));
  }
  EXPECT_TRUE(store.SaveEpoch(5));
  EXPECT_EQ(store.LoadEpoch().value(), Epoch(5));
}

TEST_F(Store, KeepsTheOldEpochWhenTheDiskIsFull) {
  StateStore store = MustOpen();
  ASSERT_TRUE(store.SaveEpoch(5));
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit full{0, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &full);
  const auto saved = store.SaveEpoch(6);
  setrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, handler);
  ASSERT_FALSE(saved);
  EXPECT_THAT(saved.error().message, HasSubstr("can't save " + dir_ + "/epoch"));
  EXPECT_EQ(store.LoadEpoch().value(), Epoch(5));
  EXPECT_FALSE(fs::exists(dir_ + "/epoch.new"));
}

TEST_F(Store, OfAnotherMachineIsNamedAndRefused) {
  { const StateStore store = MustOpen(); }
  for (const MachineOrigin& other :
       {MachineOrigin{"robot", "", 0, folder_ / "b/robot.toml"},
        MachineOrigin{"robot", "fleet", 0, robot_.file}, MachineOrigin{"robot", "", 7, robot_.file},
        MachineOrigin{"sled", "", 0, robot_.file}}) {
    std::ofstream(robot_.file) << "is there";
    const auto store = StateStore::Open(dir_, other);
    ASSERT_FALSE(store) << other.Text();
    EXPECT_EQ(store.error().code, kCodePermissionDenied);
    EXPECT_THAT(store.error().message,
                HasSubstr(dir_ + " belongs to another machine, robot of " + robot_.file +
                          " (the default namespace, domain 0)"));
    EXPECT_THAT(store.error().message, HasSubstr("this one is " + other.Text()));
  }
  EXPECT_TRUE(StateStore::Open(dir_, robot_));
}

TEST_F(Store, OfAMachineWhoseConfigWasMovedGoesAlong) {
  { const StateStore store = MustOpen(); }
  const MachineOrigin moved{"robot", "", 0, folder_ / "moved.toml"};
  EXPECT_TRUE(StateStore::Open(dir_, moved));
  EXPECT_EQ(LoadOrigin(dir_), moved);
}

TEST_F(Store, OfAMachineThatIsLedFromAFileThatWasMovedStaysItsOwn) {
  const StateStore store = MustOpen();
  const auto second = StateStore::Open(dir_, {"robot", "", 0, folder_ / "moved.toml"});
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, kCodePermissionDenied);
  EXPECT_THAT(second.error().message, HasSubstr("which process " + std::to_string(getpid())));
}

TEST_F(Store, IsFoundThroughTheProcessThatHasIt) {
  EXPECT_FALSE(OriginOfProcess(getpid()));
  const StateStore store = MustOpen();
  EXPECT_EQ(OriginOfProcess(getpid()), robot_);
}

TEST_F(Store, KeepsTheConfigThatTheMachineRanWith) {
  StateStore store = MustOpen();
  EXPECT_EQ(store.LoadConfigHash(), "");
  ASSERT_TRUE(store.SaveConfigHash("ab12"));
  EXPECT_EQ(store.LoadConfigHash(), "ab12");
}

TEST_F(Store, SavesFilesAgainThatWereRemoved) {
  { static_cast<void>(MustOpen().SaveConfigHash("hash of before")); }
  StateStore store = MustOpen();
  ASSERT_TRUE(store.SaveEpoch(7));
  const StoredStops stops{{{7, "alice@desk", "smoke"}}, {}};
  ASSERT_TRUE(store.SaveEmergencyStops(stops));
  ASSERT_TRUE(store.SaveStopIntent(true));
  ASSERT_TRUE(store.SaveStopIntent(false));
  EXPECT_THAT(store.SaveRemoved().value(), IsEmpty());
  fs::rename(dir_, dir_ + ".before");  // as another volume is mounted there
  EXPECT_THAT(store.SaveRemoved().value(),
              UnorderedElementsAre("controller.lock", "machine", "config", "epoch",
                                   "emergency_stop", "policy", "actuators", "processes"));
  EXPECT_EQ(store.LoadEpoch().value(), Epoch(7));
  EXPECT_EQ(store.LoadEmergencyStops(), stops);
  EXPECT_EQ(store.LoadConfigHash(), "hash of before");
  EXPECT_FALSE(store.LoadStopIntent());
  EXPECT_EQ(StateStore::OwnerOf(dir_), getpid());
  EXPECT_FALSE(StateStore::Open(dir_, robot_)) << "its lock is taken again";
  fs::remove(dir_ + "/epoch");
  EXPECT_THAT(store.SaveRemoved().value(), ElementsAre("epoch"));
}

TEST_F(Store, LoadsTheProcessesAndHostsOfTheLargestMachine) {
  StateStore store = MustOpen();
  std::vector<RemoteActuator> remote;
  std::vector<ChildProcess> children;
  for (std::size_t i = 0; i < 4096; ++i) {
    const std::string name = "actuator_with_a_long_name_" + std::to_string(i);
    remote.push_back({name, "host_" + std::to_string(i)});
    children.push_back({name, static_cast<pid_t>(i + 2), 1});
  }
  ASSERT_TRUE(store.SaveRemoteActuators(remote, "here/1"));
  EXPECT_EQ(store.LoadRemoteActuators("here/1").size(), remote.size());
  ASSERT_TRUE(store.SaveChildren(children, "here/1"));
  EXPECT_EQ(StateStore::LoadChildren(dir_, "here/1").size(), children.size());
}

TEST_F(Store, IsNotOpenedInAFolderThatOthersCanChange) {
  fs::create_directories(dir_);
  ASSERT_EQ(chmod(dir_.c_str(), 0777), 0);
  const auto store = StateStore::Open(dir_, robot_);
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().code, kCodePermissionDenied) << "the controller ends";
  EXPECT_THAT(store.error().message, HasSubstr("is writable for all users"));
}

// As on a disk that is read-only after a loss of power.
TEST_F(Store, IsReadWithoutItsLock) {
  const StoredStops stops{{{7, "alice", "smoke"}}, {3}};
  const StoredPolicy policy{true, std::nullopt, BatteryLevel::kProtected};
  {
    StateStore store = MustOpen();
    ASSERT_TRUE(store.SaveEmergencyStops(stops));
    ASSERT_TRUE(store.SavePolicy(policy));
    ASSERT_TRUE(store.SaveEpoch(5));
    ASSERT_TRUE(store.SaveStopIntent(true));
    ASSERT_TRUE(store.SaveConfigHash("hash"));
  }
  fs::remove(dir_ + "/controller.lock");
  fs::create_directory(dir_ + "/controller.lock");  // it cannot be opened for writing
  const auto store = StateStore::Open(dir_, robot_);
  ASSERT_FALSE(store);
  EXPECT_EQ(store.error().code, kCodeFailed) << "the controller continues";
  EXPECT_EQ(StateStore::EmergencyStopsIn(dir_), stops);
  EXPECT_EQ(StateStore::PolicyIn(dir_), policy);
  EXPECT_EQ(StateStore::EpochIn(dir_).value(), Epoch(5));
  EXPECT_TRUE(StateStore::StopIntentIn(dir_));
  EXPECT_EQ(StateStore::ConfigHashIn(dir_), "hash");
  MachineOrigin other = robot_;
  other.name_space = "other";
  EXPECT_EQ(StateStore::Open(dir_, other).error().code, kCodePermissionDenied);
}

TEST_F(Store, OfWhichNothingIsThereHasNoStop) {
  EXPECT_EQ(StateStore::EmergencyStopsIn(dir_), StoredStops{});
  std::ofstream(folder_ / "file") << "x";
  EXPECT_EQ(StateStore::EmergencyStopsIn(folder_ / "file/robot"), StoredStops{});
  EXPECT_FALSE(StateStore::StopIntentIn(folder_ / "file/robot"));
  EXPECT_EQ(StateStore::PolicyIn(folder_ / "file/robot"), StoredPolicy{});
}

TEST_F(Store, WhosePolicyCannotBeReadHasALowBattery) {
  fs::create_directories(dir_ + "/policy");
  EXPECT_EQ(StateStore::PolicyIn(dir_).level, BatteryLevel::kLowPower);
}

TEST_F(Store, KeepsTheStopOfAFileThatCannotBeRead) {
  fs::create_directories(dir_);
  ASSERT_EQ(chmod(dir_.c_str(), 0700), 0);
  ASSERT_EQ(mkfifo((dir_ + "/emergency_stop").c_str(), 0600), 0);
  for (int starts = 0; starts < 2; ++starts) {
    const StateStore store = MustOpen();
    const StoredStops stops = store.LoadEmergencyStops();
    ASSERT_EQ(stops.engaged.size(), 1U) << starts;
    EXPECT_THAT(stops.engaged[0].reason, HasSubstr("can't read " + dir_ + "/emergency_stop"));
  }
}

// As another user could have left them before the folder became ours.
TEST_F(Store, FollowsNoLinks) {
  const std::string target = folder_ / "target";
  ASSERT_TRUE(WriteFile(target, "of root"));
  fs::create_directories(dir_);
  for (const char* name : {"epoch", "epoch.new", "machine", "emergency_stop"}) {
    fs::create_symlink(target, fs::path(dir_) / name);
  }
  StateStore store = MustOpen();
  EXPECT_EQ(store.LoadEmergencyStops().engaged.size(), 1U) << "a damaged file counts as a stop";
  static_cast<void>(store.SaveEpoch(7));  // it fails, or replaces the links
  static_cast<void>(store.SaveEmergencyStops({}));
  EXPECT_EQ(ReadFile(target), "of root");
  fs::remove(dir_ + "/controller.lock");
  fs::create_symlink(target, dir_ + "/controller.lock");
  EXPECT_FALSE(StateStore::Open(dir_, robot_));
  EXPECT_EQ(ReadFile(target), "of root");
}

}  // namespace musher::state_store_test
