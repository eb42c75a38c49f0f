// examples/ros2_stack: nodes as in a navigation stack, two actuators of Musher, a launch file for
// one of them, and nav2's manager for the whole machine.

#include "musher/test/integration/foreign/ros2_stack.hpp"

#include <array>
#include <chrono>
#include <future>

#include "musher/test/contract/plain_lifecycle_manager.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/transport/ros_environment.hpp"

namespace musher::testing::ros2_stack_test {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::UnorderedElementsAre;

constexpr std::array kNodes = {"map_server", "amcl", "controller_server", "planner_server",
                               "bt_navigator"};

// The state of each node as `ros2 lifecycle get` prints it.
class NodeStates {
 public:
  std::string Of(const std::string& node) {
    PlainLifecycleClient client(participant_, node);
    return client.GetState();
  }

 private:
  PlainParticipant participant_{transport::TestDomain()};
};

class TheStack : public Ros2Stack {
 protected:
  void Start() {
    const Ended up = Up();
    ASSERT_EQ(up.exit, 0) << up.out << up.err;
  }
  void SetTo(const std::string& state) {
    NewEvents();
    const Ended set = Musher({"set", state});
    ASSERT_EQ(set.exit, 0) << set.out << set.err;
  }
  // Checks that all nodes have made that transition, each after those that it needs.
  void ExpectOrder(const std::string& transition) const {
    const auto events = Events();
    const auto place = [&](const std::string& node) {
      return Place(events, node + ": " + transition);
    };
    EXPECT_LT(place("map_server"), place("amcl")) << transition;
    EXPECT_LT(place("amcl"), place("controller_server")) << transition;
    EXPECT_LT(place("amcl"), place("planner_server")) << transition;
    EXPECT_LT(place("controller_server"), place("bt_navigator")) << transition;
    EXPECT_LT(place("planner_server"), place("bt_navigator")) << transition;
    EXPECT_LT(place("bt_navigator"), std::ssize(events)) << transition;
  }
};

TEST_F(TheStack, IsConfiguredAndActivatedInTheOrderOfNav2sManager) {
  ASSERT_NO_FATAL_FAILURE(Start());
  ExpectOrder("on_configure");
  ExpectOrder("on_activate");
  const auto events = Events();
  EXPECT_LT(Place(events, "rplidar_node: /start_motor"), Place(events, "rplidar_node: a scan"));
  EXPECT_LT(Place(events, "rplidar_node: a scan"), Place(events, "amcl: on_activate"));
  EXPECT_EQ(Lamp(), "on");
  NodeStates states;
  for (const char* node : kNodes) EXPECT_EQ(states.Of(node), "active [3]") << node;
}

TEST_F(TheStack, IsLocalisedAndPlansInProtected) {
  ASSERT_NO_FATAL_FAILURE(Start());
  ASSERT_NO_FATAL_FAILURE(SetTo("Protected"));
  EXPECT_THAT(NewEvents(), UnorderedElementsAre("bt_navigator: on_deactivate",
                                                "controller_server: on_deactivate",
                                                "rplidar_node: /start_motor"));
  EXPECT_EQ(Lamp(), "blinking");
  NodeStates states;
  EXPECT_EQ(states.Of("planner_server"), "active [3]");
  EXPECT_EQ(states.Of("controller_server"), "inactive [2]");
}

TEST_F(TheStack, FreesItsCostmapsAndStopsItsLidarInLowPower) {
  ASSERT_NO_FATAL_FAILURE(Start());
  ASSERT_NO_FATAL_FAILURE(SetTo("LowPower"));
  const auto down = NewEvents();
  EXPECT_THAT(
      down, UnorderedElementsAre("bt_navigator: on_deactivate", "controller_server: on_deactivate",
                                 "controller_server: on_cleanup", "planner_server: on_deactivate",
                                 "planner_server: on_cleanup", "map_server: on_deactivate",
                                 "rplidar_node: /stop_motor"));
  EXPECT_EQ(Lamp(), "off");
  NodeStates states;
  EXPECT_EQ(states.Of("planner_server"), "unconfigured [1]");
  EXPECT_EQ(states.Of("amcl"), "active [3]") << "activated again it would lose its pose";

  ASSERT_NO_FATAL_FAILURE(SetTo("Protected"));
  const auto up = NewEvents();
  EXPECT_THAT(up, Contains("rplidar_node: /start_motor")) << "amcl needs scans";
  EXPECT_LT(Place(up, "planner_server: on_configure"), Place(up, "planner_server: on_activate"));
  ASSERT_NO_FATAL_FAILURE(SetTo("Active"));
  for (const char* node : kNodes) EXPECT_EQ(states.Of(node), "active [3]") << node;
}

TEST_F(TheStack, DoesNotDriveWhileAmclIsRestarted) {
  ASSERT_NO_FATAL_FAILURE(Start());
  NewEvents();
  kill(Actuator("amcl")["pid"].get<pid_t>(), SIGKILL);
  const auto status = AwaitStatus([](const nlohmann::json& now) {
    return AllHaveArrived(now) && now["actuators"]["amcl"]["restarts"] == 1;
  });
  EXPECT_EQ(status["state"], "Active");
  const auto events = NewEvents();
  EXPECT_LT(Place(events, "controller_server: on_deactivate"), Place(events, "amcl: on_activate"));
  EXPECT_LT(Place(events, "amcl: on_activate"), Place(events, "controller_server: on_activate"));
  EXPECT_THAT(events, Not(Contains(HasSubstr("planner_server"))));
}

TEST_F(TheStack, IsShutDownInReverseOrderWithoutSigkill) {
  ASSERT_NO_FATAL_FAILURE(Start());
  NewEvents();
  const Ended down = Musher({"down"});
  EXPECT_EQ(down.exit, 0) << down.out << down.err;
  const auto events = NewEvents();
  for (const char* node : kNodes) {
    EXPECT_THAT(events, Contains(std::string(node) + ": on_shutdown"));
  }
  EXPECT_LT(Place(events, "bt_navigator: on_shutdown"), Place(events, "amcl: on_deactivate"));
  EXPECT_LT(Place(events, "amcl: on_shutdown"), Place(events, "map_server: on_deactivate"));
  EXPECT_THAT(down.out, Not(HasSubstr("SIGKILL")));
  EXPECT_EQ(Lamp(), "");
  EXPECT_TRUE(AwaitNoChildren());
}

TEST_F(TheStack, IsFoundWithoutFaultWhereRos2Is) {
  const Ended check = Musher({"check", robot_});
  EXPECT_EQ(check.exit, 0);
  EXPECT_EQ(check.out, "ok: 7 actuators, 7 states, 1 stage\n");
}

class TheStackWithoutRos2 : public TheStack {
 protected:
  TheStackWithoutRos2() {
    SetPath("");
    if (RunToEnd({"sh", "-c", "command -v ros2"}).exit == 0) skipped_ = true;
  }
  void SetUp() override {
    if (skipped_) GTEST_SKIP() << "ros2 is in /usr/bin";
  }

  bool skipped_ = false;
};

constexpr const char* kHint =
    " (set up ROS 2 in this shell first: . /opt/ros/<distribution>/setup.sh)";

TEST_F(TheStackWithoutRos2, IsValidAndCheckPrintsHowToInstallRos2) {
  const Ended check = Musher({"check", robot_});
  EXPECT_EQ(check.exit, 0);
  for (const char* node : kNodes) {
    EXPECT_THAT(check.out, HasSubstr("warning: in 'actuator." + std::string(node) +
                                     "': 'command': program 'ros2' not found in PATH" + kHint));
  }
  EXPECT_THAT(check.out, HasSubstr("\nok: 7 actuators, 7 states, 1 stage\n"));
}

TEST_F(TheStackWithoutRos2, DoesNotStartAndPrintsHowToInstallRos2) {
  const Ended up = Musher({"up", robot_, "--detach"});
  EXPECT_EQ(up.exit, 1);
  EXPECT_THAT(up.out + up.err,
              HasSubstr("can't run ros2: No such file or directory" + std::string(kHint)));
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

class TheTalker : public Ros2Stack {
 protected:
  // A line of talker.toml is another one.
  void Replace(const std::string& line, const std::string& by) const {
    std::string toml = ReadFile(talker_);
    toml.replace(toml.find(line), line.size(), by);
    std::ofstream(talker_) << toml;
  }

  const std::string talker_ = stack_ + "/talker.toml";
};

TEST_F(TheTalker, IsTheSmallestMachine) {
  EXPECT_EQ(Musher({"check", talker_}).out, "ok: 1 actuator, 5 states, 1 stage\n");
  const Ended up = testing::UpDetached(talker_);
  ASSERT_EQ(up.exit, 0) << up.out << up.err;
  EXPECT_EQ(Musher({"set", "LowPower"}).exit, 0);
  EXPECT_EQ(Musher({"down"}).exit, 0);
  EXPECT_THAT(Events(), ElementsAre("lc_talker: on_configure", "lc_talker: on_activate",
                                    "lc_talker: on_deactivate", "lc_talker: on_cleanup",
                                    "lc_talker: on_shutdown"));
}

// It was "not set up within 20000 ms", as if its on_configure were slow.
TEST_F(TheTalker, IsReportedAsNotDiscoveredWhenItIsInAnotherDomain) {
  const auto another = transport::LockFreeDomain(transport::TestDomain());  // of no other test
  ASSERT_NE(another.id, transport::TestDomain());
  const std::string other = std::to_string(another.id);
  Replace("times = [20000", "env = { ROS_DOMAIN_ID = \"" + other + "\" }\ntimes = [400");
  const Ended up = Musher({"up", talker_, "--detach"});
  EXPECT_EQ(up.exit, 1);
  EXPECT_THAT(up.err, AllOf(HasSubstr("no managed node /lc_talker was discovered within 400 ms, "
                                      "but its program runs (process "),
                            HasSubstr("does not discover the machine: `musher check` shows why")));
  EXPECT_THAT(Musher({"check", talker_}).out,
              HasSubstr("the ROS 2 node does not discover the machine: ROS_DOMAIN_ID is " + other));
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

TEST_F(TheTalker, IsReportedAsNotDiscoveredWhenNoPersonHasStartedIt) {
  Replace("command = [\"ros2\", \"run\", \"lifecycle\", \"lifecycle_talker\"]\n", "");
  Replace("times = [20000", "times = [400");
  const Ended up = Musher({"up", talker_, "--detach"});
  EXPECT_EQ(up.exit, 1);
  EXPECT_THAT(up.err, HasSubstr("no managed node /lc_talker was discovered within 400 ms; "));
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

TEST_F(TheTalker, IsActivatedWhenItsLaunchFileStartsAndRespawnsIt) {
  Replace("command = [\"ros2\", \"run\", \"lifecycle\", \"lifecycle_talker\"]\n", "");
  Process up(Command({"up", talker_}));
  ASSERT_NE(up.LineWith("controller started"), "");
  const Process first({BinDir() + "/managed_node", "lc_talker"});
  ASSERT_NE(up.LineWith("the machine is Active"), "");
  first.Signal(SIGKILL);
  Process second({BinDir() + "/managed_node", "lc_talker"});
  EXPECT_NE(second.LineWith("lc_talker: on_activate"), "");
  EXPECT_EQ(AwaitStatus(AllHaveArrived)["state"], "Active");
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

// lidar.launch.py, with what it takes from ROS 2's `launch` replaced by classes that keep their
// arguments.
class TheLaunchedLidar : public TheStack {
 protected:
  void SetUp() override {
    if (RunToEnd({"sh", "-c", "command -v python3"}).exit != 0) GTEST_SKIP() << "no python3";
    const std::string keep =
        "(dict):\n    def __init__(self, **given):\n        super().__init__(given)\n";
    Write("launch/__init__.py",
          "class LaunchDescription:\n    def __init__(self, all):\n        self.all = all\n");
    Write("launch/actions.py", "class ExecuteProcess" + keep);
    Write("launch_ros/__init__.py", "");
    Write("launch_ros/actions.py", "class Node" + keep);
    const Ended ran = RunToEnd({"env", "PYTHONDONTWRITEBYTECODE=1",
                                "PYTHONPATH=" + (folder_ / "python"), "python3", "-c",
                                "import json, runpy, sys; file = runpy.run_path(sys.argv[1]); "
                                "print(json.dumps(file['generate_launch_description']().all))",
                                stack_ + "/lidar.launch.py"});
    ASSERT_EQ(ran.exit, 0) << ran.err;
    const auto described = Json(ran.out);
    command_ = described[0]["cmd"].get<std::vector<std::string>>();
    manager_ = described[1];
  }
  // With the parameters that the launch file gives to nav2's manager.
  PlainNav2Manager Manager() const {
    const auto& parameters = manager_["parameters"][0];
    return {transport::TestDomain(), "", parameters["node_names"].get<std::vector<std::string>>(),
            parameters["bond_timeout"].get<double>()};
  }
  // Does the work while the manager spins: without its heartbeats a bond ends after 4 s.
  template <class Work>
  static auto Beside(PlainNav2Manager& manager, Work work) {
    auto result = std::async(std::launch::async, std::move(work));
    manager.participant().Spin(
        [&] { return result.wait_for(std::chrono::seconds(0)) == std::future_status::ready; });
    return result.get();
  }

  std::vector<std::string> command_;
  nlohmann::json manager_;

 private:
  void Write(const std::string& file, const std::string& text) const {
    const std::filesystem::path path = folder_ / ("python/" + file);
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
};

TEST_F(TheLaunchedLidar, GivesTheManagerTheSettingsThatARos2ProcessNeeds) {
  const auto environment = manager_["additional_env"].get<std::map<std::string, std::string>>();
  EXPECT_EQ(environment, transport::RosEnvironment(TransportProfile::kLocal, {}));
}

TEST_F(TheLaunchedLidar, IsBroughtUpAndDownByABondedManagerWithoutAController) {
  Process lidar(command_);
  PlainNav2Manager manager = Manager();
  ASSERT_TRUE(manager.Startup());
  EXPECT_THAT(Events(),
              AllOf(Contains("rplidar_node: a scan"), Contains("rplidar_node: /start_motor")));
  EXPECT_TRUE(manager.Shutdown());
  EXPECT_THAT(manager.errors(), IsEmpty());
  EXPECT_EQ(lidar.Wait().exit, 0);
}

TEST_F(TheLaunchedLidar, IsTakenOverWhileItRunsAndThenRefusesTheManager) {
  Process lidar(command_);
  PlainNav2Manager manager = Manager();
  ASSERT_TRUE(manager.Startup());
  const Ended up = Beside(manager, [&] { return Up(); });
  ASSERT_EQ(up.exit, 0) << up.out << up.err;
  EXPECT_EQ(Beside(manager, [&] { return Actuator("lidar"); })["pid"], lidar.pid())
      << "it is not started twice";
  EXPECT_FALSE(manager.Pause());
  EXPECT_THAT(manager.errors(), Contains("Failed to change state for node: lidar"));
  EXPECT_EQ(manager.client("lidar").GetState(), "active [3]") << "queries are answered";
  EXPECT_EQ(Beside(manager, [&] { return Status(); })["state"], "Active");
  const Ended set = Beside(manager, [&] { return Musher({"set", "LowPower"}); });
  ASSERT_EQ(set.exit, 0) << set.out << set.err;
  EXPECT_EQ(manager.client("lidar").GetState(), "inactive [2]");
  EXPECT_FALSE(manager.bond("lidar")->broken()) << "its process lives";
  EXPECT_EQ(Beside(manager, [&] { return Musher({"down"}); }).exit, 0);
  EXPECT_EQ(lidar.Wait().exit, 0);
  EXPECT_TRUE(manager.participant().Spin([&] { return manager.bond("lidar")->broken(); }));
}

TEST_F(TheLaunchedLidar, IsStartedByTheControllerWhenItsLaunchFileEnds) {
  Process lidar(command_);
  PlainNav2Manager manager = Manager();
  ASSERT_TRUE(manager.Startup());
  ASSERT_NO_FATAL_FAILURE(Start());
  lidar.Signal(SIGINT);  // Ctrl-C of `ros2 launch`
  const auto status = AwaitStatus([&](const nlohmann::json& now) {
    return AllHaveArrived(now) && now["actuators"]["lidar"]["pid"] != lidar.pid();
  });
  EXPECT_EQ(status["state"], "Active");
  EXPECT_THAT(Events(), Contains("controller_server: on_deactivate"));
  const Ended down = Musher({"down"});
  EXPECT_EQ(down.exit, 0) << down.out << down.err;
}

TEST_F(TheStack, IsOneManagedNodeOfNav2sManagerThatStartsResetsAndShutsItDown) {
  std::ofstream(robot_, std::ios::app) << "[ros2]\nstart = \"manager\"\ncleanup = \"DeActive\"\n";
  Process up(Command({"up", robot_}));
  ASSERT_NE(up.LineWith("the machine waits in SetUp for a manager to configure it"), "");
  PlainNav2Manager manager(transport::TestDomain(), "", {"musher"}, 4.0);
  ASSERT_TRUE(manager.Startup());
  ExpectOrder("on_activate");
  EXPECT_EQ(Status()["state"], "Active");
  EXPECT_TRUE(manager.Pause());
  EXPECT_EQ(Status()["state"], "DeActive");
  EXPECT_TRUE(manager.Resume());
  EXPECT_TRUE(manager.Reset());
  EXPECT_TRUE(manager.Startup());
  EXPECT_TRUE(manager.Shutdown());
  EXPECT_THAT(manager.errors(), IsEmpty());
  EXPECT_EQ(up.Wait().exit, 0);
}

}  // namespace musher::testing::ros2_stack_test
