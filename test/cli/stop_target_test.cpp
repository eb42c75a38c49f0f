// Which machine a stop is for and how far it reaches, where what the host believes of its machines
// is wrong: not readable, old, of two with one name or one beginning of an id, or of none.

#include "musher/cli/machine/stop_target.hpp"

#include <gmock/gmock.h>

namespace musher::cli::stop_target_test {

using ::testing::ElementsAre;

const MachineIdentity kDog{"dog", "d0900000-0000-4000-8000-000000000002"};
const MachineIdentity kOtherDog{"dog", "d0900001-0000-4000-8000-000000000003"};
const MachineIdentity kCat{"cat", "cafe0000-0000-4000-8000-000000000001"};

MachineHere Local(const MachineIdentity& identity, std::vector<std::string> actuators = {"legs"}) {
  MachineHere machine{identity};
  machine.actuators = std::move(actuators);
  return machine;
}
MachineHere Lan(const MachineIdentity& identity, std::vector<std::string> actuators = {"legs"}) {
  MachineHere machine = Local(identity, std::move(actuators));
  machine.lan = true;
  machine.interfaces = {identity.name + "0"};
  return machine;
}
MachineHere Unread(std::vector<std::string> actuators, std::string name = "") {
  MachineHere machine = Lan({std::move(name), ""}, std::move(actuators));
  machine.interfaces = {};
  machine.unread = "its config is not read";
  return machine;
}

TEST(MachineToStop, IsThatOfThisHostsControllerWhateverItsFilesSay) {
  EXPECT_EQ(MachineToStop({"", kDog, true, kCat}), kDog);
}

TEST(MachineToStop, IsEveryMachineWhereAnythingRunsHereWhoseControllerIsNotRead) {
  EXPECT_EQ(MachineToStop({"", std::nullopt, true, kDog}), MachineIdentity{})
      << "the files may be of another machine than what runs";
}

TEST(MachineToStop, IsThatOfTheFilesWhereNothingRuns) {
  EXPECT_EQ(MachineToStop({"", std::nullopt, false, kDog}), kDog);
  EXPECT_EQ(MachineToStop({}), MachineIdentity{}) << "every machine, without files";
}

TEST(MachineToStop, IsEveryMachineOfTheNameThatAPersonSaysAlsoOnTheRobotItself) {
  const MachineIdentity named = MachineToStop({"dog", kDog, true, std::nullopt});
  EXPECT_EQ(named, (MachineIdentity{"dog", ""}));
  EXPECT_TRUE(SameMachine(named, kDog));
  EXPECT_TRUE(SameMachine(named, kOtherDog)) << "a copy of it moves on otherwise";
}

TEST(MachineToStop, IsTheOneLedHereByTheBeginningOfItsIdAndByNoShorterOne) {
  EXPECT_EQ(MachineToStop({"d0900000", kDog, true, std::nullopt}), kDog);
  EXPECT_EQ(MachineToStop({"d09", kDog, true, std::nullopt}), (MachineIdentity{"d09", ""}));
  EXPECT_EQ(MachineToStop({"d0900001", kDog, true, std::nullopt}),
            (MachineIdentity{"d0900001", ""}))
      << "of another machine";
}

// Its name is what another machine's id begins with.
TEST(MachineToStop, IsNotTheOneLedHereByItsIdWhereThatIsANameThatItHasToo) {
  const MachineIdentity odd{"d090", "d0900000-0000-4000-8000-000000000002"};
  EXPECT_EQ(MachineToStop({"d090", odd, true, std::nullopt}), (MachineIdentity{"d090", ""}));
}

TEST(MachineByFiles, IsTheOneWhoseIdBeginsSo) {
  EXPECT_EQ(MachineByFiles("d0900000", {Local(kCat), Local(kDog)}), kDog);
  EXPECT_EQ(MachineByFiles("d0900000", {Local(kDog), Local({"dog", ""}), Local(kDog)}), kDog)
      << "found several times, once by its config alone";
}

TEST(MachineByFiles, IsNoneOfTwoWhoseIdsBeginSo) {
  EXPECT_EQ(MachineByFiles("d090", {Local(kDog), Local(kOtherDog)}), std::nullopt);
}

// A folder that was copied with its id, under another name.
TEST(MachineByFiles, IsNoneOfTwoNamesWithOneId) {
  EXPECT_EQ(MachineByFiles("d0900000", {Local(kDog), Local({"copy", kDog.id})}), std::nullopt);
}

TEST(MachineByFiles, IsNoneForANameThatAlsoBeginsAnId) {
  EXPECT_EQ(MachineByFiles("cafe", {Local({"cafe", kDog.id}), Local(kCat)}), std::nullopt);
}

TEST(MachineByFiles, IsNoneOfWhatIsNotReadAndOfNone) {
  EXPECT_EQ(MachineByFiles("d0900000", {Unread({"legs"}), Unread({}, "dog")}), std::nullopt);
  EXPECT_EQ(MachineByFiles("d0900000", {}), std::nullopt);
  EXPECT_EQ(MachineByFiles("", {Local(kDog)}), std::nullopt);
}

TEST(StopReach, IsTheNetworkOfTheMachineThatIsMeantAndOfNoOther) {
  const std::vector<MachineHere> machines{Local(kDog), Lan(kCat)};
  EXPECT_EQ(ReachOf(kDog, "", machines, {"legs"}), StopReach{});
  EXPECT_THAT(ReachOf(kCat, "", machines, {"legs"}).interfaces, ElementsAre("cat0"));
}

TEST(StopReach, IsTheNetworkOfEveryMachineOfTheNameThatIsMeant) {
  EXPECT_TRUE(ReachOf({"dog", ""}, "dog", {Local(kDog), Lan(kOtherDog)}, {}).lan);
}

TEST(StopReach, IsTheNetworkWhereTheMachineIsNotKnownAndAnythingThatRunsMayBeOfOne) {
  EXPECT_TRUE(ReachOf({}, "", {Local(kDog, {"arm"}), Lan(kCat, {"legs"})}, {"legs"}).lan);
  EXPECT_FALSE(ReachOf({}, "", {Local(kDog, {"legs"}), Lan(kCat, {"arm"})}, {"legs"}).lan)
      << "no actuator of the other one runs here";
  EXPECT_TRUE(ReachOf({}, "", {Lan(kCat, {"arm"})}, {}).lan) << "nothing runs here";
}

// The robot.toml of the working directory says that the machine has no other hosts.
TEST(StopReach, IsTheNetworkWhereWhatRunsIsNotReadWhateverAConfigSays) {
  EXPECT_TRUE(ReachOf({}, "", {Unread({"legs"}), Local({"dog", ""})}, {"legs"}).lan);
  EXPECT_TRUE(ReachOf(kDog, "", {Local(kDog), Unread({"legs"})}, {"legs"}).lan)
      << "it may be of the machine that is meant";
  EXPECT_TRUE(ReachOf(kDog, "", {Local(kDog), Unread({}, "dog")}, {}).lan);
  EXPECT_FALSE(ReachOf(kDog, "", {Local(kDog), Unread({}, "cat")}, {}).lan)
      << "the folder is of another machine";
}

TEST(StopReach, IsTheNetworkOfAMachineWithoutAnIdForAWordThatMayBeginIt) {
  EXPECT_TRUE(ReachOf({"5982c7ee", ""}, "5982c7ee", {Lan({"dog", ""})}, {}).lan);
  EXPECT_FALSE(ReachOf({"5982c7ee", ""}, "5982c7ee", {Lan(kDog)}, {}).lan)
      << "it has another id and another name";
}

// The robot.toml of the working directory is of another machine.
TEST(StopReach, IsNotConfinedToTheInterfacesOfAMachineThatOnlyMayBeMeant) {
  EXPECT_THAT(ReachOf({"5982c7ee", ""}, "5982c7ee", {Lan({"dog", ""})}, {}).interfaces,
              ::testing::IsEmpty());
  EXPECT_EQ(ReachOf({"robot17", ""}, "robot17", {Lan({"cat", ""})}, {}), StopReach{})
      << "no id begins so";
  EXPECT_FALSE(ReachOf({"cafe", ""}, "cafe", {Local({"cafe", ""}), Lan({"dog", ""})}, {}).lan)
      << "it is a name";
}

TEST(StopReach, IsThisHostOfNoMachine) {
  EXPECT_EQ(ReachOf({}, "", {}, {}), StopReach{});
  EXPECT_EQ(ReachOf(kDog, "", {}, {"legs"}), StopReach{});
}

TEST(StopReach, HasTheInterfacesOfTheFirstConfigThatIsRead) {
  EXPECT_THAT(ReachOf({}, "", {Unread({"legs"}), Lan(kCat)}, {"legs"}).interfaces,
              ElementsAre("cat0"));
}

}  // namespace musher::cli::stop_target_test
