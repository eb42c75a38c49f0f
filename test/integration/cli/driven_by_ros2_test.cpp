// A robot of real processes that nav2's manager starts up and shuts down.

#include "musher/test/contract/plain_lifecycle_manager.hpp"
#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::driven_by_ros2_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class ARobotDrivenByRos2 : public MachineByCli {
 protected:
  void Add(const std::string& toml) const { std::ofstream(config_, std::ios::app) << toml; }
};

TEST_F(ARobotDrivenByRos2, WaitsInSetUpUntilABondedManagerBringsItUp) {
  Add("[ros2]\nstart = \"manager\"\n");
  Process up(Command({"up", config_}));
  ASSERT_NE(up.LineWith("the machine waits in SetUp for a manager to configure it"), "");
  PlainNav2Manager manager(transport::TestDomain(), name_space_, {"musher"}, 4.0);
  ASSERT_TRUE(manager.Startup());
  EXPECT_EQ(Status()["state"], "Active");
  EXPECT_TRUE(manager.Pause());
  EXPECT_EQ(Status()["state"], "LowPower") << "its highest state below Active: it has no DeActive";
  EXPECT_TRUE(manager.Resume());
  EXPECT_FALSE(manager.bond("musher")->broken());
  EXPECT_THAT(manager.errors(), IsEmpty());
  EXPECT_EQ(Musher({"down"}).exit, 0);
  EXPECT_EQ(up.Wait().exit, 0);
}

TEST_F(ARobotDrivenByRos2, IsShutDownByAManagerThatQueriesItFinalized) {
  Add("[ros2]\nstart = \"manager\"\n");
  Process up(Command({"up", config_}));
  ASSERT_NE(up.LineWith("the machine waits in SetUp"), "");
  PlainNav2Manager manager(transport::TestDomain(), name_space_, {"musher"});
  ASSERT_TRUE(manager.Startup());
  EXPECT_TRUE(manager.Shutdown());
  EXPECT_THAT(manager.errors(), IsEmpty());
  const Ended ended = up.Wait();
  EXPECT_EQ(ended.exit, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("the machine is stopped after"));
  EXPECT_TRUE(AwaitNoChildren());
}

TEST_F(ARobotDrivenByRos2, RefusesAFloodOfForbiddenRequestsWithoutARecordOfEach) {
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  ASSERT_EQ(Musher({"estop"}).exit, 0);
  PlainParticipant person(transport::TestDomain());
  PlainLifecycleClient machine(person, name_space_ + "/musher");
  for (int i = 0; i < 20; ++i) EXPECT_EQ(machine.ChangeState(0, "activate"), false);
  const std::string history = Musher({"history"}).out;
  EXPECT_THAT(history, HasSubstr("change_state activate failed: "));
  EXPECT_THAT(history, Not(HasSubstr("switch to Active requested")));
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

TEST_F(ARobotDrivenByRos2, IsActiveForRos2AfterItsOwnStart) {
  const Ended up = UpDetached();
  ASSERT_EQ(up.exit, 0) << up.err;
  PlainParticipant person(transport::TestDomain());
  PlainLifecycleClient machine(person, name_space_ + "/musher");
  EXPECT_EQ(machine.GetState(), "active [3]");
  PlainLifecycleClient legs(person, name_space_ + "/legs");
  EXPECT_EQ(legs.GetState(), "active [3]");
  EXPECT_EQ(legs.ChangeState(0, "deactivate"), false) << "it is under control of a controller";
  EXPECT_EQ(machine.ChangeState(0, "deactivate"), true);
  EXPECT_EQ(legs.GetState(), "inactive [2]");
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

}  // namespace musher::testing::driven_by_ros2_test
