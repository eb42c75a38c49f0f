// What the commands of ROS 2 answer on a robot, word by word: `ros2 node`, `topic`, `service`,
// `action`, `lifecycle`, `param`, and what `ros2 bag record` receives.

#include "musher/test/protocols/ros_commands.hpp"

#include <gmock/gmock.h>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/controller/machine_controller.hpp"
#include "musher/messages/example_interfaces/fibonacci.hpp"
#include "musher/test/actuator/robot_file.hpp"
#include "musher/test/contract/world.hpp"
#include "musher/transport/action.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::testing::ros_commands_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;
using transport::Must;

// Two actuators in one process, and their controller; Active.
class ARobotForTheCommandsOfRos2 : public ::testing::Test {
 protected:
  void SetUp() override {
    for (MachineActuator* actuator : {&arm_, &leg_}) {
      actuator->RegisterStateCallback([](const State&) { return kCodeOk; });
      ASSERT_TRUE(actuator->Init(file_.path(), thread_));
      ASSERT_TRUE(actuator->Start());
    }
    ASSERT_TRUE(controller_.Init(file_.path()));
    ASSERT_TRUE(controller_.AwaitSetUp());
    ASSERT_TRUE(controller_.Switch("SelfCheck").done());
    ASSERT_TRUE(controller_.Switch("Active").done());
    ros2_.emplace();
    for (const char* node : {"arm", "leg", "musher"}) {
      ASSERT_TRUE(ros2_->AwaitNode(Here(node), "service " + Here(node) + "/set_parameters"));
    }
  }
  static std::string Here(const std::string& name) {
    return "/" + RobotFile::name_space() + "/" + name;
  }

  RobotFile file_{{"arm", "leg"}, kAllStates};
  std::shared_ptr<transport::NodeThread> thread_ = Must(transport::NodeThread::Start());
  MachineActuator arm_{"arm"};
  MachineActuator leg_{"leg"};
  MachineController controller_;
  std::optional<RosCommands> ros2_;
};

TEST_F(ARobotForTheCommandsOfRos2, IsListedByNodeListAndLifecycleNodes) {
  const std::string all = Here("arm") + "\n" + Here("leg") + "\n" + Here("musher") + "\n";
  EXPECT_EQ(ros2_->NodeList(), all);
  EXPECT_EQ(ros2_->LifecycleNodes(), all);
  EXPECT_EQ(ros2_->NodeInfo(Here("nose")), "Unable to find node '" + Here("nose") + "'\n");
}

TEST_F(ARobotForTheCommandsOfRos2, HasItsInterfacesInNodeInfo) {
  const std::string arm = Here("arm");
  EXPECT_EQ(ros2_->NodeInfo(arm), "");
}

TEST_F(ARobotForTheCommandsOfRos2, HasTypesAndQosInTopicListAndInfo) {
  EXPECT_THAT(ros2_->TopicList(),
              HasSubstr("/diagnostics [diagnostic_msgs/msg/DiagnosticArray]\n"));
  EXPECT_THAT(ros2_->TopicList(), HasSubstr("/rosout [rcl_interfaces/msg/Log]\n"));
  EXPECT_EQ(ros2_->TopicInfo("/rosout"), "");
  EXPECT_EQ(ros2_->TopicInfo("/nothing"), "Unknown topic '/nothing'\n");
  EXPECT_EQ(ros2_->ServiceType(Here("musher/change_state")), "lifecycle_msgs/srv/ChangeState\n");
  EXPECT_EQ(ros2_->ServiceType(Here("musher/set_state")), "musher_msgs/srv/SetState\n");
}

TEST_F(ARobotForTheCommandsOfRos2, IsSwitchedByLifecycleSet) {
  EXPECT_EQ(ros2_->LifecycleGet(Here("musher")), "active [3]\n");
  EXPECT_EQ(ros2_->LifecycleList(Here("musher")),
            "- deactivate [4]\n\tStart: active\n\tGoal: deactivating\n"
            "- shutdown [7]\n\tStart: active\n\tGoal: shuttingdown\n");
  EXPECT_EQ(
      ros2_->LifecycleSet(Here("musher"), "activate"),
      "Unknown transition requested, available ones are:\n- deactivate [4]\n- shutdown [7]\n");
  EXPECT_EQ(ros2_->LifecycleSet(Here("arm"), "deactivate"), "Transitioning failed\n")
      << "it is under the control of the controller";
  EXPECT_EQ(ros2_->LifecycleSet(Here("musher"), "4"), "Transitioning successful\n");
  EXPECT_EQ(ros2_->LifecycleGet(Here("arm")), "inactive [2]\n");
  EXPECT_EQ(ros2_->LifecycleSet(Here("musher"), "activate"), "Transitioning successful\n");
  EXPECT_EQ(ros2_->LifecycleGet(Here("leg")), "active [3]\n");
}

TEST_F(ARobotForTheCommandsOfRos2, ShowsItsParametersAndRefusesToSetThem) {
  std::string list;
  for (const char* node : {"arm", "leg", "musher"}) {
    list += Here(node) + ":\n  config_file\n  config_hash\n  machine\n  use_sim_time\n";
  }
  EXPECT_EQ(ros2_->ParamList(), list);
  const std::string musher = Here("musher");
  EXPECT_EQ(ros2_->ParamGet(musher, "config_file"), "String value is: " + file_.path() + "\n");
  EXPECT_EQ(ros2_->ParamGet(musher, "use_sim_time"), "Boolean value is: False\n");
  EXPECT_EQ(ros2_->ParamGet(musher, "speed"), "Parameter not set.\n");
  EXPECT_EQ(ros2_->ParamDescribe(musher, "machine"),
            "Parameter name: machine\n  Type: string\n  Description: the name of the machine\n"
            "  Constraints:\n    Read only: true\n");
  EXPECT_THAT(ros2_->ParamDump(musher),
              StartsWith(musher + ":\n  ros__parameters:\n    config_file: " + file_.path() +
                         "\n    config_hash: "));
  EXPECT_EQ(ros2_->ParamSet(musher, "machine", "cat"),
            "Setting parameter failed: 'machine' is read-only: change the config file, and restart "
            "the machine with it\n");
  EXPECT_EQ(ros2_->ParamSet(musher, "machine", "7"),
            "Setting parameter failed: 'machine' is a string, and the value is an integer\n");
  EXPECT_EQ(
      ros2_->ParamSet(musher, "speed", "7"),
      "Setting parameter failed: 'speed' is not declared: Musher's settings are in its config "
      "files\n");
}

// "a/msg/B" as its name on DDS.
std::string OnDds(const std::string& type) {
  const std::size_t first = type.find('/');
  const std::size_t second = type.rfind('/');
  return type.substr(0, first) + "::" + type.substr(first + 1, second - first - 1) +
         "::dds_::" + type.substr(second + 1) + "_";
}

// rosbag2 subscribes each topic with the QoS that all of its publishers offer.
TEST_F(ARobotForTheCommandsOfRos2, GivesBagRecordTheLastSampleOfEachLatchedTopic) {
  struct Topic {
    std::string type;
    bool reliable = true;
    bool latched = true;
    int samples = 0;
  };
  std::map<std::string, Topic> topics;
  for (const auto& [endpoint, qos] : ros2_->graph().qos) {
    const std::size_t at = endpoint.find(" publisher ");
    if (at == std::string::npos) continue;
    Topic& topic = topics[endpoint.substr(at + 11)];
    topic.type = ros2_->graph().types.at(endpoint);
    topic.reliable = topic.reliable && qos.starts_with("RELIABLE ");
    topic.latched = topic.latched && qos.find(" TRANSIENT_LOCAL ") != std::string::npos;
  }
  ASSERT_THAT(topics, Not(IsEmpty()));
  transport::LinuxEventLoop loop;
  const auto node = Must(transport::MakeDdsNode(loop, {}));
  std::vector<std::unique_ptr<transport::RawReader>> readers;
  for (auto& [name, topic] : topics) {
    transport::Qos qos;
    qos.reliability = topic.reliable ? transport::Qos::Reliability::kReliable
                                     : transport::Qos::Reliability::kBestEffort;
    qos.durability = topic.latched ? transport::Qos::Durability::kTransientLocal
                                   : transport::Qos::Durability::kVolatile;
    qos.depth = 10;
    transport::ReaderCallbacks callbacks;
    callbacks.on_sample = [&topic = topic](auto, const auto&) { ++topic.samples; };
    readers.push_back(
        Must(node->MakeRawReader("rt" + name, OnDds(topic.type), qos, std::move(callbacks))));
  }
  for (const auto& [name, topic] : topics) {
    if (!topic.latched || name == "/rosout") continue;  // nothing was logged, perhaps
    EXPECT_TRUE(loop.RunUntil([&topic = topic] { return topic.samples > 0; },
                              loop.Now() + std::chrono::seconds(20)))
        << name;
  }
}

TEST(AnActionServerForTheCommandsOfRos2, IsListedByActionListAndNodeInfo) {
  setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
  const auto thread = Must(transport::NodeThread::Start({.node_name = "counter"}));
  std::unique_ptr<transport::ActionServer<msg::Fibonacci>> server;
  thread->RunOnLoop([&] {
    server = Must(transport::MakeActionServer<msg::Fibonacci>(thread->node(), "count", {}));
  });
  RosCommands ros2;
  ASSERT_TRUE(ros2.AwaitNode("/counter", "service /count/_action/send_goal"));
  ASSERT_TRUE(ros2.AwaitNode("/counter", "publisher /count/_action/feedback"));
  EXPECT_EQ(ros2.ActionList(), "/count [example_interfaces/action/Fibonacci]\n");
  EXPECT_THAT(ros2.NodeInfo("/counter"),
              HasSubstr("  Action Servers:\n    /count: example_interfaces/action/Fibonacci\n"
                        "  Action Clients:\n"));
  EXPECT_THAT(ros2.TopicList(), Not(HasSubstr("_action")));
  thread->RunOnLoop([&] { server.reset(); });
}

}  // namespace musher::testing::ros_commands_test
