// What the command `ros2` shows of a robot of real processes, to the word.

#include <map>
#include <regex>
#include <sstream>

#include "musher/messages/example_interfaces/fibonacci.hpp"
#include "musher/messages/type_hash.hpp"
#include "musher/test/contract/plain_ros2_command.hpp"
#include "musher/test/integration/cli/machine.hpp"
#include "musher/transport/action.hpp"
#include "musher/transport/dds/node_thread.hpp"

namespace musher::testing::ros2_command_test {

using ::testing::HasSubstr;
using ::testing::Not;

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

// Without an answer the real one waits 5 s.
TEST_F(Ros2Command, ParamListIsAnsweredByThePageWhichHasNone) {
  if (!std::filesystem::exists(BinDir() + "/musher-view")) GTEST_SKIP() << "built without it";
  Process view({BinDir() + "/musher-view", "--namespace", name_space_, "--port", "0", "--no-link",
                "--token-file", folder_ / "view_token"});
  ASSERT_NE(view.LineWith("The page is at"), "");
  std::string nodes = kNodes;
  nodes.insert(nodes.find("~/voice"), "~/musher_view\n");
  Expect(nodes, [this] { return ros2_.NodeList(); });
  const std::string all = ros2_.ParamList();
  EXPECT_THAT(all, HasSubstr(Text("~/musher_view:\n~/voice:\n")));
  EXPECT_THAT(all, Not(HasSubstr("timed out")));
  EXPECT_EQ(ros2_.ParamSet(Here("musher_view"), "port", "80"),
            "Setting parameter failed: 'port' is not declared: Musher's settings are in its config "
            "files\n");
}

class Ros2CommandOfUnmanagedNodes : public Ros2Command {
 protected:
  void SetUp() override {
    std::ofstream(config_, std::ios::app) << "[ros2]\nmanaged_nodes = false\n";
    ASSERT_NO_FATAL_FAILURE(Ros2Command::SetUp());
  }
};

TEST_F(Ros2CommandOfUnmanagedNodes, ParamListIsAnsweredByEveryNode) {
  Expect(kNodes, [this] { return ros2_.NodeList(); });
  EXPECT_EQ(ros2_.LifecycleNodes(), "");
  std::string all;
  for (const char* node : {"~/eyes", "~/legs", "~/musher", "~/voice"}) {
    all += std::string(node) + ":\n  config_file\n  config_hash\n  machine\n  use_sim_time\n";
  }
  EXPECT_EQ(ros2_.ParamList(), Text(all));
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

// rosidl_runtime_py's message_to_yaml().
std::string Yaml(const std::string& text) {
  const bool quoted = text.empty() || text.find(": ") != std::string::npos;
  return quoted ? "'" + text + "'" : text;
}
std::string Yaml(const dds_sequence_string& texts, const std::string& indent) {
  if (texts._length == 0) return " []\n";
  std::string all = "\n";
  for (std::uint32_t i = 0; i < texts._length; ++i) {
    all += indent + "- " + Yaml(texts._buffer[i]) + "\n";
  }
  return all;
}

using CapabilitiesSample = musher_msgs_msg_dds__Capabilities_;

std::string Yaml(const CapabilitiesSample& sample) {
  std::string all = "capabilities:\n";
  for (std::uint32_t i = 0; i < sample.capabilities._length; ++i) {
    const auto& one = sample.capabilities._buffer[i];
    all += "- name: " + Yaml(one.name) + "\n  description: " + Yaml(one.description) +
           "\n  allowed: " + (one.allowed ? "true" : "false") +
           "\n  code: " + std::to_string(one.code) + "\n  reason: " + Yaml(one.reason) +
           "\n  actuators:" + Yaml(one.actuators, "  ") + "  states:" + Yaml(one.states, "  ");
  }
  return all;
}

class Ros2CommandOfCapabilities : public Ros2Command {
 protected:
  std::string Echo() {
    return ros2_.Echo<CapabilitiesSample>(
        musher_msgs_msg_dds__Capabilities__desc, Here("musher/capabilities"), 1,
        [](const CapabilitiesSample& sample) { return Yaml(sample); });
  }
};

constexpr const char* kGuideAndTalk = R"(capabilities:
- name: guide
  description: shows the way
  allowed: true
  code: 0
  reason: ''
  actuators:
  - legs
  - eyes
  states:
  - Active
- name: talk
  description: ''
  allowed: true
  code: 0
  reason: ''
  actuators:
  - voice
  states:
  - Active
  - LowPower
- name: jump
  description: ''
)";

TEST_F(Ros2CommandOfCapabilities, TopicEchoHasTheWholeMessage) {
  Expect(std::string(kGuideAndTalk) + R"(  allowed: false
  code: 113
  reason: jump needs at least 50 % of the battery; its level is not known
  actuators:
  - legs
  states:
  - Active

---
)",
         [this] { return Echo(); });
}

// A recorded battery is that of a driver: the robot may jump then.
TEST_F(Ros2CommandOfCapabilities, BagPlayIsReceivedAsItsRecordedPublisherWas) {
  dds_qos_t* recorded = dds_create_qos();
  dds_qset_reliability(recorded, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(recorded, DDS_HISTORY_KEEP_LAST, 10);
  std::string none;
  protocol_msg_dds__BmsStatus_ battery{};
  battery.header.frame_id = none.data();
  battery.batt_soc = 80;
  Expect(std::string(kGuideAndTalk) +
             "  allowed: true\n  code: 0\n  reason: ''\n  actuators:\n  - legs\n  states:\n"
             "  - Active\n\n---\n",
         [&] {  // with --loop: a reader may be discovered later
           EXPECT_TRUE(ros2_.BagPlay(protocol_msg_dds__BmsStatus__desc, Here("bms_status"),
                                     recorded, &battery));
           return Echo();
         });
  dds_delete_qos(recorded);
}

TEST_F(Ros2Command, BagRecordSubscribesToEveryPublisher) {
  std::string topics;
  for (const char* name :
       {"/diagnostics", "/musher/machines", "/rosout", "~/eyes/transition_event",
        "~/legs/transition_event", "~/manager_heartbeats", "~/musher/actuator_heartbeat",
        "~/musher/actuator_status", "~/musher/capabilities", "~/musher/controller_heartbeat",
        "~/musher/emergency_stop", "~/musher/machine_status", "~/musher/transition_event",
        "~/voice/transition_event"}) {
    topics += std::string("Subscribed to topic '") + name + "'\n";
  }
  Expect(kNodes, [this] { return ros2_.NodeList(); });
  Expect(topics, [this] { return ros2_.BagRecord(); });
}

// An action of the robot, in this process.
class Ros2CommandOfActions : public Ros2Command {
 protected:
  void SetUp() override {
    ASSERT_NO_FATAL_FAILURE(Ros2Command::SetUp());
    transport::DdsOptions options;
    options.domain_id = transport::TestDomain();
    options.node_name = "counter";
    options.name_space = name_space_;
    auto started = transport::NodeThread::Start(options);
    ASSERT_TRUE(started) << started.error().message;
    thread_ = std::move(started).value();
    transport::ActionHandlers<msg::Fibonacci> handlers;
    handlers.accept = [](const msg::Fibonacci::Goal& goal, transport::ParticipantId) {
      return goal.order >= 0;
    };
    handlers.start = [](transport::ServerGoal<msg::Fibonacci> goal) {
      goal.Execute();
      goal.PublishFeedback({{0, 1}});
      goal.Succeed({{0, 1, 1, 2}});
    };
    thread_->RunOnLoop([&] {
      auto made = transport::MakeActionServer<msg::Fibonacci>(
          thread_->node(), name_space_ + "/fibonacci", std::move(handlers));
      ASSERT_TRUE(made) << made.error().message;
      server_ = std::move(made).value();
    });
  }
  ~Ros2CommandOfActions() override {
    if (thread_) thread_->RunOnLoop([&] { server_.reset(); });
  }

 private:
  std::shared_ptr<transport::NodeThread> thread_;
  std::unique_ptr<transport::ActionServer<msg::Fibonacci>> server_;
};

TEST_F(Ros2CommandOfActions, ActionListAndInfoHaveTheServer) {
  Expect("~/fibonacci [example_interfaces/action/Fibonacci]\n",
         [this] { return ros2_.ActionList(); });
  Expect("Action: ~/fibonacci\nAction clients: 0\nAction servers: 1\n    ~/counter\n",
         [this] { return ros2_.ActionInfo(Here("fibonacci")); });
  EXPECT_EQ(ros2_.ActionInfo("/nothing"),
            "Action: /nothing\nAction clients: 0\nAction servers: 0\n");
}

TEST_F(Ros2CommandOfActions, ActionSendGoalHasFeedbackAndTheResult) {
  EXPECT_EQ(ros2_.SendGoal(Here("fibonacci"), 3),
            R"(Waiting for an action server to become available...
Sending goal:
     order: 3

Goal accepted with ID: 0102030405060708090a0b0c0d0e0f10

Feedback:
    sequence:
- 0
- 1

Result:
    sequence:
- 0
- 1
- 1
- 2

Goal finished with status: SUCCEEDED
)");
}

TEST_F(Ros2CommandOfActions, ActionSendGoalSaysThatAGoalIsRejected) {
  EXPECT_EQ(ros2_.SendGoal(Here("fibonacci"), -1),
            "Waiting for an action server to become available...\n"
            "Sending goal:\n     order: -1\n\nGoal was rejected.\n");
}

TEST_F(Ros2Command, TopicHzHasTheRateOfTheDiagnostics) {
  const double rate = ros2_.Hz(diagnostic_msgs_msg_dds__DiagnosticArray__desc, "/diagnostics", 10);
  EXPECT_GT(rate, 0.5);
  EXPECT_LT(rate, 2) << "once a second while nothing changes";
}

// The repr() of rclpy's classes. A "?" is different each time.
std::string Printed(const musher_msgs_srv_dds__SetState_Response_& reply) {
  const auto quoted = [](const char* text) { return "'" + std::string(text) + "'"; };
  std::string degraded, actuators;
  for (std::uint32_t i = 0; i < reply.degraded._length; ++i) {
    degraded += (i == 0 ? "" : ", ") + quoted(reply.degraded._buffer[i]);
  }
  for (std::uint32_t i = 0; i < reply.actuators._length; ++i) {
    const auto& one = reply.actuators._buffer[i];
    actuators += std::string(i == 0 ? "" : ", ") +
                 "musher_msgs.msg.ActuatorOutcome(name=" + quoted(one.name) +
                 ", outcome=" + quoted(one.outcome) + ", code=" + std::to_string(one.code) +
                 ", message=" + quoted(one.message) +
                 ", duration_ms=?, state=" + quoted(one.state) + ")";
  }
  return "response:\nmusher_msgs.srv.SetState_Response(switch_number=?, target=" +
         quoted(reply.target) + ", actuator=" + quoted(reply.actuator) +
         ", outcome=" + quoted(reply.outcome) + ", code=" + std::to_string(reply.code) +
         ", reason=" + quoted(reply.reason) + ", state=" + quoted(reply.state) + ", degraded=[" +
         degraded + "], actuators=[" + actuators + "])\n\n";
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
  ros2_.Call<Response>(Here("musher/set_state"), musher_msgs_srv_dds__SetState_Request__desc,
                       musher_msgs_srv_dds__SetState_Response__desc, request,
                       [&](const Response& reply) { response = Printed(reply); });
  const auto done = [](const std::string& name) {
    return "musher_msgs.msg.ActuatorOutcome(name='" + name +
           "', outcome='done', code=0, message='', duration_ms=?, state='LowPower')";
  };
  EXPECT_EQ(response,
            "response:\nmusher_msgs.srv.SetState_Response(switch_number=?, target='LowPower', "
            "actuator='', outcome='done', code=0, reason='', state='LowPower', degraded=[], "
            "actuators=[" +
                done("legs") + ", " + done("voice") + ", " + done("eyes") + "])\n\n");
}

// As a recorder or Foxglove requests it, by the hash that the publisher announces.
TEST_F(Ros2Command, ATypeIsDescribedByTheNodeThatPublishesIt) {
  std::string name = "musher_msgs/msg/Capabilities";
  std::string hash(msg::TypeHashOf("musher_msgs::msg::dds_::Capabilities_"));
  type_description_interfaces_srv_dds__GetTypeDescription_Request_ request{};
  request.type_name = name.data();
  request.type_hash = hash.data();
  using Response = type_description_interfaces_srv_dds__GetTypeDescription_Response_;
  std::string answer = "no answer";
  const auto call = [&] {
    ros2_.Call<Response>(
        Here("musher/get_type_description"),
        type_description_interfaces_srv_dds__GetTypeDescription_Request__desc,
        type_description_interfaces_srv_dds__GetTypeDescription_Response__desc, request,
        [&](const Response& reply) {
          const auto& type = reply.type_description;
          answer = reply.successful ? "" : "failed";
          for (std::uint32_t i = 0; i < type.type_description.fields._length; ++i) {
            const auto& field = type.type_description.fields._buffer[i];
            answer += std::string(field.name) + " of " + field.type.nested_type_name + "; ";
          }
          for (std::uint32_t i = 0; i < type.referenced_type_descriptions._length; ++i) {
            answer += std::string("with ") + type.referenced_type_descriptions._buffer[i].type_name;
          }
        });
    return answer;
  };
  EXPECT_EQ(call(), "capabilities of musher_msgs/msg/Capability; with musher_msgs/msg/Capability");
  hash.back() = hash.back() == '0' ? '1' : '0';
  EXPECT_EQ(call(), "failed") << "of another definition";
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
