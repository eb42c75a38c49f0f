// `musher up` as a service of systemd, whose part the test plays.

#include <signal.h>

#include <fstream>

#include "musher/test/cli/notify_socket.hpp"
#include "musher/test/integration/cli/machine.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::testing::service_test {

using ::testing::HasSubstr;
using ::testing::Not;

class UpAsAService : public MachineByCli {
 protected:
  UpAsAService() { setenv("WATCHDOG_USEC", "300000", 1); }

  // The launcher is the main process, so systemd names it.
  std::vector<std::string> Unit(const std::string& options = "") const {
    return {"sh", "-c",
            "export WATCHDOG_PID=$$; exec " + BinDir() + "/musher up " + options + config_};
  }

  ServiceManagerThatReads systemd_{folder_ / "notify"};
};

TEST_F(UpAsAService, SendsItsStatePingsTheWatchdogAndStopsInOrder) {
  Process up(Unit());
  EXPECT_TRUE(systemd_.WaitFor("STATUS=Active, 2 of 3 actuators"));  // stage 1
  EXPECT_TRUE(systemd_.WaitFor("READY=1"));
  EXPECT_TRUE(systemd_.WaitFor("STATUS=Active, 3 actuators"));
  EXPECT_TRUE(systemd_.WaitFor("WATCHDOG=1"));
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  EXPECT_TRUE(systemd_.WaitFor("STATUS=LowPower, 3 actuators"));
  EXPECT_TRUE(systemd_.WaitFor("WATCHDOG=1"));
  up.Signal(SIGTERM);
  EXPECT_TRUE(systemd_.WaitFor("STOPPING=1"));
  EXPECT_EQ(up.Wait().exit, 0);
  EXPECT_TRUE(AwaitNoChildren());
}

TEST_F(UpAsAService, IsNotReadyWhenTheStartFails) {
  Does("legs", "[state.SelfCheck]\nrun = [\"false\"]\n");
  const Ended up = RunToEnd(Unit());
  EXPECT_EQ(up.exit, 1);
  std::string messages;
  for (const std::string& message : systemd_.Take()) messages += message + "\n";
  EXPECT_THAT(messages, HasSubstr("STATUS=start-up failed, the machine stays in SelfCheck"));
  EXPECT_THAT(messages, Not(HasSubstr("READY=1")));
}

TEST_F(UpAsAService, HidesTheNotifySocketFromActuators) {
  const std::string seen = folder_ / "seen";
  Does("legs", "[state.Active]\nshell = \"env > " + seen + "\"\n");
  Process up(Unit());
  ASSERT_TRUE(systemd_.WaitFor("READY=1"));
  const std::string env = ReadFile(seen);
  EXPECT_THAT(env, HasSubstr("MUSHER_ACTUATOR=legs"));
  EXPECT_THAT(env, Not(HasSubstr("NOTIFY_SOCKET")));
  EXPECT_THAT(env, Not(HasSubstr("WATCHDOG_")));
}

TEST_F(UpAsAService, StopsWhenAnotherControllerTakesTheMachineOver) {
  Process up(Unit("--restarted "));
  ASSERT_TRUE(systemd_.WaitFor("STATUS=Active, 3 actuators"));
  ASSERT_EQ(Musher({"up", config_, "--takeover", "--detach"}).exit, 0);
  EXPECT_TRUE(systemd_.WaitFor("STOPPING=1"));
  EXPECT_EQ(up.Wait().exit, 2) << "it must not be started again";
}

// To systemd a service that ends before it is ready has failed, and would be started again.
TEST_F(UpAsAService, IsReadyBeforeItStopsWhereItOnlyFinishesATearDown) {
  setenv("RUNTIME_DIRECTORY", folder_.path().c_str(), 1);  // as systemd keeps it over restarts
  Blocks("legs", "TearDown");
  {
    Process up(Unit("--restarted "));
    ASSERT_TRUE(systemd_.WaitFor("READY=1")) << "the first start is a person's";
    ASSERT_TRUE(systemd_.WaitFor("STATUS=Active, 3 actuators"));
    const pid_t controller = Status()["pid"];
    Process down(Command({"down"}));
    ASSERT_TRUE(systemd_.WaitFor("STOPPING=1"));
    AwaitStatus([](const auto& s) { return s["actuators"]["legs"]["target"] == "TearDown"; });
    kill(controller, SIGKILL);
    EXPECT_EQ(up.Wait().exit, 1);
  }
  Release();
  Process again(Unit("--restarted "));
  EXPECT_TRUE(systemd_.WaitFor("READY=1"));
  EXPECT_TRUE(systemd_.WaitFor("STOPPING=1"));
  EXPECT_EQ(again.Wait().exit, 0);
  EXPECT_TRUE(AwaitNoChildren());
  unsetenv("RUNTIME_DIRECTORY");
}

// A power cut after a released stop: at boot the robot went to Active, without a command of a
// person.
TEST_F(UpAsAService, WaitsAtBootForARequestAfterAReleasedStopAndAPersonsStartIsOne) {
  const auto boot = [this] {
    std::filesystem::remove(folder_ / "started");  // /run is empty
    setenv("RUNTIME_DIRECTORY", folder_.path().c_str(), 1);
    const Ended up = RunToEnd(Unit("--restarted "));
    unsetenv("RUNTIME_DIRECTORY");
    return up;
  };
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"estop", "smoke"}).exit, 0);
  ASSERT_EQ(Musher({"estop", "--release"}).exit, 0);
  ASSERT_EQ(Musher({"down"}).exit, 0);
  const Ended up = boot();
  EXPECT_EQ(up.exit, 1);
  EXPECT_THAT(up.err, HasSubstr("no state was requested since the last emergency stop"));
  EXPECT_EQ(Status()["state"], "SetUp");
  ASSERT_EQ(Musher({"set", "SelfCheck"}).exit, 0);
  EXPECT_EQ(Musher({"set", "Active"}).exit, 0);
  ASSERT_EQ(Musher({"down"}).exit, 0);
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"estop", "smoke"}).exit, 0);
  ASSERT_EQ(Musher({"estop", "--release"}).exit, 0);
  ASSERT_EQ(Musher({"down"}).exit, 0);
  EXPECT_EQ(UpDetached().exit, 0) << "a person starts it";
  EXPECT_EQ(Status()["state"], "Active");
}

// The watchdog sends SIGABRT to the main process, the launcher. What follows is as after any crash
// of the controller: systemd starts `musher up` again.
TEST_F(UpAsAService, EndsItsControllerWhenItsWatchdogRanOutAndIsTakenOverByTheNext) {
  pid_t legs = 0;
  {
    Process up(Unit());
    ASSERT_TRUE(systemd_.WaitFor("STATUS=Active, 3 actuators"));
    const auto status = Status();
    legs = status["actuators"]["legs"]["pid"];
    kill(status["pid"].get<pid_t>(), SIGSTOP);
    up.Signal(SIGABRT);
    const Ended ended = up.Wait();
    EXPECT_EQ(ended.exit, 1);
    EXPECT_THAT(ended.err, HasSubstr("the controller of robot has crashed (killed by SIGABRT)"));
  }
  Process again(Unit());
  EXPECT_TRUE(systemd_.WaitFor("READY=1"));
  EXPECT_EQ(Status()["actuators"]["legs"]["pid"], legs);
  again.Signal(SIGTERM);
  EXPECT_EQ(again.Wait().exit, 0);
}

}  // namespace musher::testing::service_test
