// Two machines in one domain and namespace, each on a host of its own: two network and pid
// namespaces of this computer, with a link between them. Neither fences, drives or ends the other.

#include <algorithm>
#include <memory>

#include "musher/test/fault_injection/host/isolation.hpp"
#include "musher/test/fault_injection/host/link.hpp"
#include "musher/test/integration/cli/host.hpp"
#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::two_machines_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kDds =
    "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"link\"/></Interfaces>"
    "</General></Domain></CycloneDDS>";

class TwoMachines : public MachineByCli {
 protected:
  void SetUp() override {
    if (geteuid() != 0 || access("/dev/net/tun", R_OK | W_OK) != 0) {
      GTEST_SKIP() << "two hosts need root and /dev/net/tun";
    }
    dog_ = std::make_unique<Host>();
    cat_ = std::make_unique<Host>();
    ASSERT_TRUE(dog_->up() && cat_->up());
    cat_->InNetwork([] { fault_injection::BringUp("lo"); });
    dog_->InNetwork([this] {
      fault_injection::BringUp("lo");
      link_ = std::make_unique<fault_injection::Link>(cat_->init());
    });
    setenv("CYCLONEDDS_URI", kDds, 1);
    Replace("name = \"robot\"", "name = \"dog\"");
    cat_config_ = OtherRobot("cat", name_space_, folder_ / "cat_state");
    const Ended dog = dog_->Run({"up", config_, "--detach"});
    ASSERT_EQ(dog.exit, 0) << dog.err;
    const Ended cat = cat_->Run({"up", cat_config_, "--detach"});
    ASSERT_EQ(cat.exit, 0) << cat.err;
  }
  void TearDown() override { unsetenv("CYCLONEDDS_URI"); }

  std::string DogLog() const { return ReadFile(folder_ / "state/controller.log"); }
  std::string CatLog() const { return ReadFile(folder_ / "cat_state/controller.log"); }
  // Each actuator of `host` is Active: `up` returns before those of a later stage that are not
  // critical are.
  static bool AllActive(Host& host) {
    return Until([&host] {
      const nlohmann::json actuators = host.Status()["actuators"];
      return !actuators.empty() && std::ranges::all_of(actuators, [](const nlohmann::json& one) {
        return one["state"] == "Active";
      });
    });
  }
  // Each controller has received heartbeats of the other, and nothing of either changes by itself
  // any more.
  bool Met() const {
    return AllActive(*dog_) && AllActive(*cat_) && Until([this] {
             return DogLog().find("another machine, cat") != std::string::npos &&
                    CatLog().find("another machine, dog") != std::string::npos;
           });
  }

  std::unique_ptr<Host> dog_;
  std::unique_ptr<Host> cat_;
  std::unique_ptr<fault_injection::Link> link_;
  std::string cat_config_;
};

TEST_F(TwoMachines, KeepTheirControllersWhenTheyMeet) {
  EXPECT_TRUE(Met()) << DogLog() << CatLog();
  EXPECT_THAT(DogLog(), Not(HasSubstr("leads this machine")));
  EXPECT_THAT(CatLog(), Not(HasSubstr("leads this machine")));
}

TEST_F(TwoMachines, ACommandReachesTheMachineOfItsHost) {
  ASSERT_TRUE(Met());
  EXPECT_EQ(dog_->Status()["machine"], "dog");
  EXPECT_EQ(cat_->Status()["machine"], "cat");
  EXPECT_THAT(dog_->Status()["other_machines"].dump(), HasSubstr("cat"));
  const Ended set = dog_->Run({"set", "LowPower"});
  EXPECT_EQ(set.exit, 0) << set.err;
  EXPECT_EQ(dog_->Status()["state"], "LowPower");
  EXPECT_EQ(cat_->Status()["state"], "Active");
  const Ended named = dog_->Run({"set", "LowPower", "--machine", "cat"});
  EXPECT_EQ(named.exit, 0) << named.err;
  EXPECT_EQ(cat_->Status()["state"], "LowPower");
}

TEST_F(TwoMachines, DownLeavesTheOtherMachineAsItIs) {
  ASSERT_TRUE(Met());
  const nlohmann::json before = cat_->Status();
  const Ended down = dog_->Run({"down"});
  EXPECT_EQ(down.exit, 0) << down.err;
  EXPECT_EQ(down.err, "") << "nothing of the other machine counts as left behind";
  const nlohmann::json after = cat_->Status();
  for (const char* what : {"machine", "state", "epoch", "switch", "actuators", "phase"}) {
    EXPECT_EQ(before[what], after[what]);
  }
}

TEST_F(TwoMachines, TheRestOfAKilledMachineIsStoppedAndNothingOfTheOther) {
  ASSERT_TRUE(Met());
  const auto pid = dog_->Status()["pid"].get<int>();
  ASSERT_EQ(dog_->Do({"kill", "-9", std::to_string(pid)}).exit, 0);
  // Not the controller that still answers: it leads another machine.
  const Ended set = dog_->Run({"set", "LowPower"});
  EXPECT_EQ(set.exit, 3) << set.out << set.err;
  EXPECT_THAT(set.err, HasSubstr("actuators of dog"));
  const nlohmann::json before = cat_->Status();
  const Ended down = dog_->Run({"down", "--without-controller"});
  EXPECT_EQ(down.exit, 0) << down.out << down.err;
  EXPECT_THAT(down.out, Not(HasSubstr("without TearDown"))) << "each answers for itself";
  EXPECT_EQ(before["actuators"], cat_->Status()["actuators"]);
  EXPECT_EQ(before["epoch"], cat_->Status()["epoch"]);
}

TEST_F(TwoMachines, WhereTheActuatorsOfAHostAreSilentACommandActsOnNoOtherMachine) {
  ASSERT_TRUE(Met());
  const nlohmann::json dog = dog_->Status();
  const nlohmann::json before = cat_->Status();
  ASSERT_EQ(dog_->Do({"kill", "-9", std::to_string(dog["pid"].get<int>())}).exit, 0);
  const auto signal = [&](const char* what) {
    for (const nlohmann::json& actuator : dog["actuators"]) {
      EXPECT_EQ(dog_->Do({"kill", what, std::to_string(actuator["pid"].get<int>())}).exit, 0);
    }
  };
  signal("-STOP");
  const Ended set = dog_->Run({"set", "LowPower"});
  EXPECT_EQ(set.exit, 3) << set.out << set.err;
  EXPECT_THAT(set.err, HasSubstr("Nothing was done"));
  EXPECT_EQ(before["state"], cat_->Status()["state"]);
  EXPECT_EQ(before["switch"], cat_->Status()["switch"]);
  signal("-CONT");
}

TEST_F(TwoMachines, WhereNothingOfAHostsMachineRunsACommandActsOnNoOtherMachine) {
  ASSERT_TRUE(Met());
  const auto run = [this](std::vector<std::string> words) {
    std::vector<std::string> in_folder = {"sh", "-c", "cd '" + folder_.path() + "' && exec \"$@\"",
                                          "sh"};
    for (std::string& word : Command(std::move(words))) in_folder.push_back(std::move(word));
    return dog_->Do(std::move(in_folder));
  };
  ASSERT_EQ(run({"down"}).exit, 0);
  const nlohmann::json before = cat_->Status();
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"set", "LowPower"},
                                             {"down"},
                                             {"down", "--without-controller"},
                                             {"restart", "legs"},
                                             {"estop"},
                                             {"estop", "--release"},
                                             {"wake"}}) {
    const Ended ended = run(words);
    EXPECT_EQ(ended.exit, 3) << words[0] << ": " << ended.out << ended.err;
    EXPECT_THAT(ended.err, AllOf(HasSubstr("dog"), HasSubstr("cat"), HasSubstr("--machine")));
  }
  const nlohmann::json after = cat_->Status();
  for (const char* what : {"state", "epoch", "switch", "actuators", "emergency_stop"}) {
    EXPECT_EQ(before[what], after[what]);
  }
  const Ended status = run({"status"});
  EXPECT_EQ(status.exit, 0);
  EXPECT_THAT(status.err, AllOf(HasSubstr("the machine of this host, dog"), HasSubstr("cat")));
  EXPECT_EQ(run({"set", "LowPower", "--machine", "cat"}).exit, 0);
}

TEST_F(TwoMachines, AnEmergencyStopStopsTheMachineOfItsHost) {
  ASSERT_TRUE(Met());
  const Ended stop = dog_->Run({"estop", "a person is near"});
  EXPECT_EQ(stop.exit, 0) << stop.out << stop.err;
  EXPECT_EQ(dog_->Status()["emergency_stop"]["engaged"], true);
  EXPECT_EQ(cat_->Status()["emergency_stop"]["engaged"], false);
  EXPECT_EQ(cat_->Status()["held_by_stop"], nlohmann::json::array());
}

// It gave up after 1.2 s and took the stop back, where the answer needed longer.
TEST_F(TwoMachines, AnEmergencyStopOverALinkOf300MillisecondsEachWayIsConfirmed) {
  ASSERT_TRUE(Met());
  const fault_injection::LinkImpairment slow{.delay = Milliseconds(300)};
  link_->Set(slow, slow, 1);
  const Ended stop = cat_->Run({"estop", "seen from afar", "--machine", "dog", "--timeout", "30"});
  EXPECT_EQ(stop.exit, 0) << stop.out << stop.err;
  link_->Heal();
  EXPECT_EQ(dog_->Status()["emergency_stop"]["engaged"], true);
  EXPECT_EQ(cat_->Status()["emergency_stop"]["engaged"], false);
}

// One machine of the profile lan: `legs` was started by hand on another host, the rest and the
// controller run on the robot.
class MachineOnTwoHosts : public MachineByCli {
 protected:
  void SetUp() override {
    if (geteuid() != 0 || access("/dev/net/tun", R_OK | W_OK) != 0) {
      GTEST_SKIP() << "two hosts need root and /dev/net/tun";
    }
    robot_ = std::make_unique<Host>();
    far_ = std::make_unique<Host>();
    ASSERT_TRUE(robot_->up() && far_->up());
    far_->InNetwork([] { fault_injection::BringUp("lo"); });
    robot_->InNetwork([this] {
      fault_injection::BringUp("lo");
      link_ = std::make_unique<fault_injection::Link>(far_->init());
    });
    Replace("[controller]\n",
            "[transport]\nprofile = \"lan\"\ninterfaces = [\"link\"]\n[controller]\n");
    Start();
  }
  virtual void Start() {
    Drop("command = [\"musher-exec\", \"" + (folder_ / "legs.toml") + "\"]\n");
    legs_ = StartFar("legs", config_);
    Up();
  }
  std::unique_ptr<Process> StartFar(const std::string& actuator, const std::string& config) const {
    return std::make_unique<Process>(
        far_->Here({BinDir() + "/musher-exec", folder_ / (actuator + ".toml"), "--config", config,
                    "--actuator", actuator}));
  }
  void Up() {
    const Ended up = robot_->Run({"up", config_, "--detach"});
    ASSERT_EQ(up.exit, 0) << up.err;
    ASSERT_TRUE(Until([this] { return AllHaveArrivedIn("Active")(robot_->Status()); }));
  }
  // The controller exits, the actuators continue.
  void LoseController() {
    const std::string pid = std::to_string(robot_->Status()["pid"].get<int>());
    ASSERT_EQ(robot_->Do({"kill", "-9", pid}).exit, 0);
    const std::string name = name_space_ + "/musher/controller$";  // that it holds on its host
    ASSERT_TRUE(Until([&] {
      return robot_->Do({"grep", "-q", name, "/proc/net/unix"}).exit != 0;
    }));
  }

  std::unique_ptr<Host> robot_;
  std::unique_ptr<Host> far_;
  std::unique_ptr<fault_injection::Link> link_;
  std::unique_ptr<Process> legs_;
};

// A person types it on the robot, where nothing says that the machine has the profile lan. It ended
// with 0, and the actuators of the other host moved on.
TEST_F(MachineOnTwoHosts, IsStoppedOnBothWithoutAControllerAndNotReportedAsComplete) {
  ASSERT_NO_FATAL_FAILURE(LoseController());
  const Ended stop = robot_->Run({"estop", "--timeout", "15"});
  EXPECT_EQ(stop.exit, 1) << stop.out << stop.err;
  EXPECT_THAT(stop.out, HasSubstr("legs   stopped after "));
  EXPECT_THAT(stop.err, HasSubstr("the actuators of other hosts are not known"));
}

TEST_F(MachineOnTwoHosts, IsNotReportedAsStoppedWhileTheLinkToOneIsCut) {
  ASSERT_NO_FATAL_FAILURE(LoseController());
  const fault_injection::LinkImpairment cut{.loss_percent = 100};
  link_->Set(cut, cut, 1);
  const Ended stop = robot_->Run({"estop", "--timeout", "5"});
  EXPECT_EQ(stop.exit, 1) << stop.out << stop.err;
  EXPECT_THAT(stop.err, HasSubstr("stop not confirmed: legs"));
}

// The TearDown was over before the other host was discovered, and the exit code was 0.
class MachineOfOneHostOfTwo : public MachineOnTwoHosts {
 protected:
  void Start() override { Up(); }
};

TEST_F(MachineOfOneHostOfTwo, IsNotDownWhileAnActuatorOfAnEarlierConfigRunsOnTheOther) {
  std::string earlier = ReadFile(config_);
  for (std::size_t at = 0; (at = earlier.find("voice", at)) != std::string::npos;) {
    earlier.replace(at, 5, "tail");
  }
  std::ofstream(folder_ / "earlier.toml") << earlier;
  Does("tail", "[state.OTA]\nrun = [\"true\"]\n");
  const auto tail = StartFar("tail", folder_ / "earlier.toml");
  ASSERT_TRUE(Until([&] {
    return robot_->Run({"status", "--transport", "lan"}).err.find("tail") != std::string::npos;
  }));
  const fault_injection::LinkImpairment slow{.delay = Milliseconds(150)};
  link_->Set(slow, slow, 1);
  const Ended down = robot_->Run({"down", "--transport", "lan"});
  EXPECT_EQ(down.exit, 1) << down.out << down.err;
  EXPECT_THAT(down.err, HasSubstr("tail"));
}

}  // namespace musher::testing::two_machines_test
