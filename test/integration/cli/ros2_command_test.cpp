// What the command `ros2` shows of a robot of real processes, to the word.

#include <map>
#include <regex>
#include <sstream>

#include "musher/messages/type_hash.hpp"
#include "musher/test/contract/plain_ros2_command.hpp"
#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::ros2_command_test {

using ::testing::HasSubstr;

class Ros2Command : public MachineByCli {
 protected:
  void SetUp() override {
    const Ended up = UpDetached();
    ASSERT_EQ(up.exit, 0) << up.err;
  }
  std::string Here(const std::string& name) const { return "/" + name_space_ + "/" + name; }
  // The text with the names of the robot's namespace: "~/legs" is "/test_12/legs".
  std::string Text(std::string text) const {
    for (std::size_t at; (at = text.find('~')) != std::string::npos;) {
      text.replace(at, 1, "/" + name_space_);
    }
    return text;
  }
  // The command prints that, once it has discovered the robot.
  void Expect(const std::string& text, const std::function<std::string()>& command) {
    const std::string expected = Text(text);
    EXPECT_EQ(ros2_.Await(expected, command), expected);
  }

  PlainRos2Command ros2_{transport::TestDomain()};
};

const std::map<std::string, std::string> kServicesOfANode = {
    {"change_state", "lifecycle_msgs/srv/ChangeState"},
    {"describe_parameters", "rcl_interfaces/srv/DescribeParameters"},
    {"get_available_states", "lifecycle_msgs/srv/GetAvailableStates"},
    {"get_available_transitions", "lifecycle_msgs/srv/GetAvailableTransitions"},
    {"get_parameter_types", "rcl_interfaces/srv/GetParameterTypes"},
    {"get_parameters", "rcl_interfaces/srv/GetParameters"},
    {"get_state", "lifecycle_msgs/srv/GetState"},
    {"get_transition_graph", "lifecycle_msgs/srv/GetAvailableTransitions"},
    {"get_type_description", "type_description_interfaces/srv/GetTypeDescription"},
    {"list_parameters", "rcl_interfaces/srv/ListParameters"},
    {"set_parameters", "rcl_interfaces/srv/SetParameters"},
    {"set_parameters_atomically", "rcl_interfaces/srv/SetParametersAtomically"}};
constexpr const char* kNodes = "~/eyes\n~/legs\n~/musher\n~/voice\n";

TEST_F(Ros2Command, NodeListAndLifecycleNodesHaveTheMachineAndItsActuators) {
  Expect(kNodes, [this] { return ros2_.NodeList(); });
  Expect(kNodes, [this] { return ros2_.LifecycleNodes(); });
}

TEST_F(Ros2Command, NodeInfoHasTheEndpointsOfAnActuator) {
  Expect(R"(~/legs
  Subscribers:
    ~/bms_status: protocol/msg/BmsStatus
    ~/musher/controller_heartbeat: musher_msgs/msg/ControllerHeartbeat
    ~/musher/emergency_stop: musher_msgs/msg/EmergencyStop
  Publishers:
    ~/legs/transition_event: lifecycle_msgs/msg/TransitionEvent
    ~/manager_heartbeats: protocol/msg/Heartbeats
    ~/musher/actuator_heartbeat: musher_msgs/msg/ActuatorHeartbeat
    ~/musher/actuator_status: musher_msgs/msg/ActuatorStatus
  Service Servers:
    ~/legs/change_state: lifecycle_msgs/srv/ChangeState
    ~/legs/describe_parameters: rcl_interfaces/srv/DescribeParameters
    ~/legs/get_available_states: lifecycle_msgs/srv/GetAvailableStates
    ~/legs/get_available_transitions: lifecycle_msgs/srv/GetAvailableTransitions
    ~/legs/get_parameter_types: rcl_interfaces/srv/GetParameterTypes
    ~/legs/get_parameters: rcl_interfaces/srv/GetParameters
    ~/legs/get_state: lifecycle_msgs/srv/GetState
    ~/legs/get_transition_graph: lifecycle_msgs/srv/GetAvailableTransitions
    ~/legs/get_type_description: type_description_interfaces/srv/GetTypeDescription
    ~/legs/list_parameters: rcl_interfaces/srv/ListParameters
    ~/legs/musher_command: musher_msgs/srv/ActuatorCommand
    ~/legs/set_parameters: rcl_interfaces/srv/SetParameters
    ~/legs/set_parameters_atomically: rcl_interfaces/srv/SetParametersAtomically
    ~/legsmachine_service: protocol/srv/FsMachine
  Service Clients:

  Action Servers:

  Action Clients:

)",
         [this] { return ros2_.NodeInfo(Here("legs")); });
  EXPECT_EQ(ros2_.NodeInfo("/absent"), "Unable to find node '/absent'\n");
}

TEST_F(Ros2Command, TopicListHasTheTypes) {
  Expect(R"(/diagnostics [diagnostic_msgs/msg/DiagnosticArray]
/musher/machines [musher_msgs/msg/MachineInfo]
/rosout [rcl_interfaces/msg/Log]
~/bms_status [protocol/msg/BmsStatus]
~/eyes/transition_event [lifecycle_msgs/msg/TransitionEvent]
~/legs/transition_event [lifecycle_msgs/msg/TransitionEvent]
~/manager_heartbeats [protocol/msg/Heartbeats]
~/musher/actuator_heartbeat [musher_msgs/msg/ActuatorHeartbeat]
~/musher/actuator_status [musher_msgs/msg/ActuatorStatus]
~/musher/capabilities [musher_msgs/msg/Capabilities]
~/musher/controller_heartbeat [musher_msgs/msg/ControllerHeartbeat]
~/musher/emergency_stop [musher_msgs/msg/EmergencyStop]
~/musher/machine_status [musher_msgs/msg/MachineStatus]
~/musher/transition_event [lifecycle_msgs/msg/TransitionEvent]
~/voice/transition_event [lifecycle_msgs/msg/TransitionEvent]
)",
         [this] { return ros2_.TopicList(); });
}

TEST_F(Ros2Command, TopicInfoHasTheTypeHashAndTheQos) {
  const auto info = [this](const std::string& topic) {
    return std::regex_replace(ros2_.TopicInfo(topic), std::regex("GID: [0-9a-f.]{47}\n"),
                              "GID: 16 bytes\n");
  };
  const std::string hash(msg::TypeHashOf("musher_msgs::msg::dds_::MachineStatus_"));
  Expect(R"(Type: musher_msgs/msg/MachineStatus

Publisher count: 1

Node name: musher
Node namespace: ~
Topic type: musher_msgs/msg/MachineStatus
Topic type hash: )" +
             hash + R"(
Endpoint type: PUBLISHER
GID: 16 bytes
QoS profile:
  Reliability: RELIABLE
  History (Depth): UNKNOWN
  Durability: TRANSIENT_LOCAL
  Lifespan: Infinite
  Deadline: Infinite
  Liveliness: AUTOMATIC
  Liveliness lease duration: Infinite

Subscription count: 0

)",
         [&] { return info(Here("musher/machine_status")); });
  EXPECT_THAT(info("/rosout"), HasSubstr("  Lifespan: 10000000000 nanoseconds\n"));
  EXPECT_EQ(info("/nothing"), "Unknown topic '/nothing'\n");
}

TEST_F(Ros2Command, ServiceListHasTheTypes) {
  std::map<std::string, std::string> services;
  for (const char* node : {"~/eyes", "~/legs", "~/musher", "~/voice"}) {
    for (const auto& [name, type] : kServicesOfANode) {
      services[Text(std::string(node) + "/" + name)] = type;
    }
    if (node == std::string("~/musher")) continue;
    services[Text(std::string(node) + "/musher_command")] = "musher_msgs/srv/ActuatorCommand";
    services[Text(std::string(node) + "machine_service")] = "protocol/srv/FsMachine";
  }
  for (const char* name :
       {"GetCapabilities get_capabilities", "GetHistory get_history", "GetPlan get_plan",
        "GetStatus get_status", "GetSwitch get_switch",
        "ReleaseEmergencyStop release_emergency_stop", "RequestPolicy request_policy",
        "RestartActuator restart_actuator", "SetState set_state"}) {
    std::istringstream words(name);
    std::string type, service;
    words >> type >> service;
    services[Here("musher/" + service)] = "musher_msgs/srv/" + type;
  }
  std::string text;
  for (const auto& [name, type] : services) text += name + " [" + type + "]\n";
  Expect(text, [this] { return ros2_.ServiceList(); });
}

TEST_F(Ros2Command, LifecycleGetsListsAndSetsTheMachine) {
  const std::string machine = Here("musher");
  Expect("active [3]\n", [&] { return ros2_.LifecycleGet(machine); });
  Expect(
      "- deactivate [4]\n\tStart: active\n\tGoal: deactivating\n"
      "- shutdown [7]\n\tStart: active\n\tGoal: shuttingdown\n",
      [&] { return ros2_.LifecycleList(machine); });
  EXPECT_EQ(
      ros2_.LifecycleSet(machine, "configure"),
      "Unknown transition requested, available ones are:\n- deactivate [4]\n- shutdown [7]\n");
  EXPECT_EQ(ros2_.LifecycleSet(machine, "deactivate"), "Transitioning successful\n");
  EXPECT_EQ(ros2_.LifecycleGet(machine), "inactive [2]\n");
  EXPECT_EQ(ros2_.LifecycleGet(Here("legs")), "inactive [2]\n");
  EXPECT_EQ(ros2_.LifecycleSet(Here("legs"), "activate"), "Transitioning failed\n")
      << "it is under the control of the machine";
  EXPECT_EQ(ros2_.LifecycleSet(machine, "activate"), "Transitioning successful\n");
  EXPECT_EQ(Status()["state"], "Active");
}

TEST_F(Ros2Command, ParamListGetAndSetAreAnsweredByEveryNode) {
  Expect(kNodes, [this] { return ros2_.NodeList(); });
  std::string all;
  for (const char* node : {"~/eyes", "~/legs", "~/musher", "~/voice"}) {
    all += std::string(node) + ":\n  config_file\n  config_hash\n  machine\n  use_sim_time\n";
  }
  EXPECT_EQ(ros2_.ParamList(), Text(all));
  EXPECT_EQ(ros2_.ParamGet(Here("legs"), "machine"), "String value is: robot\n");
  EXPECT_EQ(ros2_.ParamGet(Here("legs"), "use_sim_time"), "Boolean value is: False\n");
  EXPECT_EQ(ros2_.ParamGet(Here("legs"), "speed"), "Parameter not set\n");
  EXPECT_EQ(ros2_.ParamSet(Here("legs"), "machine", "other"),
            "Setting parameter failed: 'machine' is read-only: change the config file, and restart "
            "the machine with it\n");
}

TEST_F(Ros2Command, TopicEchoHasTheLatchedStateAndTheOnesAfterIt) {
  using Status = musher_msgs_msg_dds__MachineStatus_;
  const auto echo = [&](int count) {
    return ros2_.Echo<Status>(musher_msgs_msg_dds__MachineStatus__desc,
                              Here("musher/machine_status"), count,
                              [](const Status& status) { return std::string(status.state); });
  };
  EXPECT_EQ(echo(1), "Active\n---\n");
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  EXPECT_EQ(echo(1), "LowPower\n---\n");
}

TEST_F(Ros2Command, TopicHzHasTheRateOfTheDiagnostics) {
  const double rate = ros2_.Hz(diagnostic_msgs_msg_dds__DiagnosticArray__desc, "/diagnostics", 4);
  EXPECT_GT(rate, 0.5);
  EXPECT_LT(rate, 2) << "once a second while nothing changes";
}

TEST_F(Ros2Command, ServiceCallHasTheAnswer) {
  std::string target = "LowPower", none;
  musher_msgs_srv_dds__SetState_Request_ request{};
  request.target = target.data();
  for (char** text : {&request.actuator, &request.by, &request.machine, &request.machine_id}) {
    *text = none.data();
  }
  using Response = musher_msgs_srv_dds__SetState_Response_;
  std::string response;
  ros2_.Call<Response>(
      Here("musher/set_state"), musher_msgs_srv_dds__SetState_Request__desc,
      musher_msgs_srv_dds__SetState_Response__desc, request, [&](const Response& reply) {
        response = "target='" + std::string(reply.target) + "', actuator='" + reply.actuator +
                   "', outcome='" + reply.outcome + "', code=" + std::to_string(reply.code) +
                   ", reason='" + reply.reason + "', state='" + reply.state + "'";
      });
  EXPECT_EQ(response,
            "target='LowPower', actuator='', outcome='done', code=0, reason='', state='LowPower'");
}

// The warnings are those that it has of every robot: of topics that no process reads yet.
TEST_F(Ros2Command, DoctorFindsNoPublisherWhoseQosDoesNotFitASubscriber) {
  Expect(R"(Publisher without subscriber detected on /diagnostics.
Publisher without subscriber detected on /musher/machines.
Publisher without subscriber detected on /rosout.
Subscriber without publisher detected on ~/bms_status.
Publisher without subscriber detected on ~/eyes/transition_event.
Publisher without subscriber detected on ~/legs/transition_event.
Publisher without subscriber detected on ~/manager_heartbeats.
Publisher without subscriber detected on ~/musher/capabilities.
Publisher without subscriber detected on ~/musher/machine_status.
Publisher without subscriber detected on ~/musher/transition_event.
Publisher without subscriber detected on ~/voice/transition_event.
)",
         [this] { return ros2_.DoctorTopics(); });
  EXPECT_EQ(ros2_.DoctorQos(), "");
}

}  // namespace musher::testing::ros2_command_test
