// Actuators and the machine under the control of ROS 2's tools: plain C peers on real DDS.

#include "musher/test/contract/plain_lifecycle_manager.hpp"

#include <gmock/gmock.h>
#include <musher_idl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <mutex>
#include <thread>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/controller/machine_controller.hpp"
#include "musher/test/actuator/robot_file.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/test/support/wait.hpp"

namespace musher::testing::plain_lifecycle_manager_test {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::uint64_t kFlood = 5000;  // requests
constexpr std::uint8_t kConfigure = 1;
constexpr std::uint8_t kActivate = 3;
constexpr std::uint8_t kDeactivate = 4;

// An actuator that records its callbacks.
class Module : public MachineActuator {
 public:
  explicit Module(const std::string& name) : MachineActuator(name) {
    RegisterStateCallback([this](const State& state) {
      const std::lock_guard lock(mutex_);
      ran_.push_back(state);
      return state == fails_in_ ? 2012 : kCodeOk;
    });
  }

  std::vector<State> ran() const {
    const std::lock_guard lock(mutex_);
    return ran_;
  }
  void FailIn(const State& state) {
    const std::lock_guard lock(mutex_);
    fails_in_ = state;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<State> ran_;
  State fails_in_;
};

int Domain() {
  return transport::TestDomain();
}

class AnActuatorWithoutAController : public ::testing::Test {
 protected:
  AnActuatorWithoutAController() : file_({"arm", "leg"}, kAllStates) {
    for (ActuatorRunner<Module>* module : {&arm_, &leg_}) {
      EXPECT_TRUE(module->Init(file_.path()));
      EXPECT_TRUE(module->Start());
    }
  }

  RobotFile file_;
  ActuatorRunner<Module> arm_{"arm"};
  ActuatorRunner<Module> leg_{"leg"};
};

TEST_F(AnActuatorWithoutAController, IsBroughtUpAndDownByNav2sManagerWithoutErrors) {
  PlainNav2Manager manager(Domain(), RobotFile::name_space(), {"arm", "leg"});
  EXPECT_TRUE(manager.Startup());
  EXPECT_EQ(arm_.CurrentState(), "Active");
  EXPECT_TRUE(manager.Pause());
  EXPECT_EQ(arm_.CurrentState(), "DeActive");
  EXPECT_TRUE(manager.Resume());
  EXPECT_TRUE(manager.Reset());
  EXPECT_TRUE(manager.Startup()) << "after its cleanup a node is configured again";
  EXPECT_TRUE(manager.Shutdown());
  EXPECT_THAT(manager.errors(), IsEmpty());
  EXPECT_EQ(arm_.Wait(), 0) << "its process exits after the manager has queried it finalized";
  EXPECT_THAT(arm_.ran(), ElementsAre("SetUp", "SelfCheck", "Active", "DeActive", "Active",
                                      "DeActive", "SelfCheck", "Active", "DeActive", "TearDown"));
}

TEST_F(AnActuatorWithoutAController, KeepsABondWithABondedManager) {
  PlainNav2Manager manager(Domain(), RobotFile::name_space(), {"arm", "leg"}, 3.0);
  const auto begun = std::chrono::steady_clock::now();
  ASSERT_TRUE(manager.Startup());
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begun;
  RecordProperty("bonded_startup_of_two_ms", std::to_string(took.count()));
  // Longer than the bond's timeout.
  EXPECT_TRUE(manager.participant().Spin([&] { return manager.bond("arm")->received() >= 40; }));
  EXPECT_FALSE(manager.bond("arm")->broken());
  EXPECT_FALSE(manager.bond("leg")->broken());
  EXPECT_TRUE(manager.Pause());
  EXPECT_TRUE(manager.Resume()) << "with a new bond";
  EXPECT_TRUE(manager.Shutdown());
  EXPECT_THAT(manager.errors(), IsEmpty());
}

TEST_F(AnActuatorWithoutAController, KeepsItsBondWhenAnotherClientDeactivatesIt) {
  PlainNav2Manager manager(Domain(), RobotFile::name_space(), {"arm"}, 4.0);
  ASSERT_TRUE(manager.Startup());
  PlainParticipant person(Domain());
  PlainLifecycleClient tool(person, RobotFile::name_space() + "/arm");
  ASSERT_EQ(tool.ChangeState(kDeactivate), true);
  const int before = manager.bond("arm")->received();
  EXPECT_TRUE(
      manager.participant().Spin([&] { return manager.bond("arm")->received() >= before + 10; }));
  EXPECT_FALSE(manager.bond("arm")->broken()) << "nav2's manager would take it for a crash";
}

TEST_F(AnActuatorWithoutAController, HasTheGraphThatRos2LifecycleLists) {
  PlainParticipant person(Domain());
  PlainLifecycleClient tool(person, RobotFile::name_space() + "/arm");
  EXPECT_EQ(tool.GetState(), "unconfigured [1]");
  EXPECT_THAT(
      tool.GetAvailableStates(),
      ElementsAre("unknown [0]", "unconfigured [1]", "inactive [2]", "active [3]", "finalized [4]",
                  "configuring [10]", "cleaningup [11]", "shuttingdown [12]", "activating [13]",
                  "deactivating [14]", "errorprocessing [15]"));
  EXPECT_THAT(tool.GetAvailableTransitions(),
              ElementsAre("configure [1] unconfigured -> configuring",
                          "shutdown [5] unconfigured -> shuttingdown"));
  EXPECT_THAT(tool.GetTransitionGraph(),
              AllOf(SizeIs(25), Contains("transition_success [30] activating -> active"),
                    Contains("transition_error [62] errorprocessing -> finalized")));
}

TEST_F(AnActuatorWithoutAController, PublishesItsTransitionsAndAcceptsThemByLabel) {
  PlainParticipant person(Domain());
  PlainLifecycleClient tool(person, RobotFile::name_space() + "/arm");
  ASSERT_EQ(tool.ChangeState(0, "configure"), true);
  arm_.FailIn("Active");
  EXPECT_EQ(tool.ChangeState(kActivate), false);
  EXPECT_EQ(tool.GetState(), "inactive [2]") << "like a ROS 2 node after a failed on_activate";
  EXPECT_EQ(tool.ChangeState(0, "fly"), false);
  EXPECT_TRUE(person.Spin([&] { return tool.events.size() >= 4; }));
  EXPECT_THAT(tool.events, ElementsAre("configure: unconfigured -> configuring",
                                       "transition_success: configuring -> inactive",
                                       "activate: inactive -> activating",
                                       "transition_failure: activating -> inactive"));
}

// One call as a tool of ROS 2 makes it. `on_reply` gets the reply while it is on loan.
template <class Response, class Request>
void Ask(const std::string& service, const dds_topic_descriptor_t& request_type,
         const dds_topic_descriptor_t& response_type, Request request,
         const std::function<void(const Response&)>& on_reply) {
  PlainParticipant tool(Domain());
  const dds_entity_t writer = tool.Writer(request_type, "rq/" + service + "Request");
  bool answered = false;
  dds_entity_t reader = 0;
  reader = tool.Reader(response_type, "rr/" + service + "Reply", [&] {
    TakeAll<Response>(reader, [&](const Response& response) {
      if (response.client_id != request.client_id) return;
      on_reply(response);
      answered = true;
    });
  });
  dds_get_instance_handle(writer, &request.client_id);
  request.sequence_number = 1;
  ASSERT_TRUE(tool.SpinUntilMatched(writer, reader)) << service;
  ASSERT_EQ(dds_write(writer, &request), DDS_RETCODE_OK);
  EXPECT_TRUE(tool.Spin([&] { return answered; })) << service;
}

// `ros2 param list` waited 5 s for each node of Musher.
TEST_F(AnActuatorWithoutAController, AnswersRos2ParamListAndGet) {
  const std::string arm = RobotFile::name_space() + "/arm/";
  std::vector<std::string> names;
  Ask<rcl_interfaces_srv_dds__ListParameters_Response_>(
      arm + "list_parameters", rcl_interfaces_srv_dds__ListParameters_Request__desc,
      rcl_interfaces_srv_dds__ListParameters_Response__desc,
      rcl_interfaces_srv_dds__ListParameters_Request_{}, [&](const auto& response) {
        for (std::uint32_t i = 0; i < response.result.names._length; ++i) {
          names.emplace_back(response.result.names._buffer[i]);
        }
      });
  EXPECT_THAT(names, ElementsAre("config_file", "config_hash", "machine", "use_sim_time"));
  std::array<char*, 2> wanted = {strdup("config_file"), strdup("use_sim_time")};
  rcl_interfaces_srv_dds__GetParameters_Request_ get{};
  get.names = {2, 2, wanted.data(), false};
  std::vector<std::string> values;
  Ask<rcl_interfaces_srv_dds__GetParameters_Response_>(
      arm + "get_parameters", rcl_interfaces_srv_dds__GetParameters_Request__desc,
      rcl_interfaces_srv_dds__GetParameters_Response__desc, get, [&](const auto& response) {
        for (std::uint32_t i = 0; i < response.values._length; ++i) {
          const auto& value = response.values._buffer[i];
          values.push_back(value.type == 4   ? value.string_value
                           : value.type == 1 ? (value.bool_value ? "true" : "false")
                                             : "another type");
        }
      });
  EXPECT_THAT(values, ElementsAre(file_.path(), "false"));
  for (char* name : wanted) std::free(name);
}

TEST_F(AnActuatorWithoutAController, RefusesRos2ParamSetWithTheReason) {
  std::vector<std::string> reasons;
  std::array<rcl_interfaces_msg_dds__Parameter_, 3> wanted{};
  const std::array names = {"speed", "machine", "machine"};
  const std::array<std::uint8_t, 3> types = {2, 2, 4};
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    wanted[i].name = strdup(names[i]);
    wanted[i].value.type = types[i];
    wanted[i].value.string_value = strdup("");
  }
  rcl_interfaces_srv_dds__SetParameters_Request_ set{};
  set.parameters = {3, 3, wanted.data(), false};
  Ask<rcl_interfaces_srv_dds__SetParameters_Response_>(
      RobotFile::name_space() + "/arm/set_parameters",
      rcl_interfaces_srv_dds__SetParameters_Request__desc,
      rcl_interfaces_srv_dds__SetParameters_Response__desc, set, [&](const auto& response) {
        for (std::uint32_t i = 0; i < response.results._length; ++i) {
          EXPECT_FALSE(response.results._buffer[i].successful);
          reasons.emplace_back(response.results._buffer[i].reason);
        }
      });
  EXPECT_THAT(reasons, ElementsAre(HasSubstr("'speed' is not declared"),
                                   HasSubstr("'machine' is a string, and the value is an integer"),
                                   HasSubstr("'machine' is read-only")));
  for (auto& one : wanted) {
    std::free(one.name);
    std::free(one.value.string_value);
  }
}

// It was silent: nothing that it reads is decoded by Musher.
TEST_F(AnActuatorWithoutAController, LogsAClientWithAnotherDefinitionOfAReplyOnce) {
  PlainParticipant other(Domain());
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  const std::string tag = "typehash=RIHS01_\n0123;";  // a log would have a line of its own by it
  dds_qset_userdata(qos, tag.data(), tag.size());
  const std::string topic = "rr/" + RobotFile::name_space() + "/arm/get_stateReply";
  const dds_entity_t named =
      dds_create_topic(other.entity(), &lifecycle_msgs_srv_dds__GetState_Response__desc,
                       topic.c_str(), nullptr, nullptr);
  ::testing::internal::CaptureStderr();
  EXPECT_GT(dds_create_reader(other.entity(), named, qos, nullptr), 0);
  EXPECT_GT(dds_create_reader(other.entity(), named, qos, nullptr), 0);
  dds_delete_qos(qos);
  PlainLifecycleClient tool(other, RobotFile::name_space() + "/arm");
  EXPECT_EQ(tool.GetState(), "unconfigured [1]") << "its own reader has no hash";
  const std::string log = ::testing::internal::GetCapturedStderr();
  const std::string fault = "has another definition of lifecycle_msgs::srv::dds_::GetState_";
  EXPECT_THAT(log, HasSubstr("arm: warning: process " + std::to_string(getpid()) + " of "));
  EXPECT_THAT(log, HasSubstr(fault));
  EXPECT_EQ(log.find(fault), log.rfind(fault)) << log;
  EXPECT_THAT(log, HasSubstr("RIHS01_0123, on " + topic + "; logged once"));
}

class AMachineAndItsManagers : public ::testing::Test {
 protected:
  AMachineAndItsManagers() : file_({"arm", "leg"}, kAllStates) {}

  void BringActuatorsUp() {
    for (ActuatorRunner<Module>* module : {&arm_, &leg_}) {
      ASSERT_TRUE(module->Init(file_.path()));
      ASSERT_TRUE(module->Start());
    }
    ASSERT_TRUE(controller_.Init(file_.path()));
  }

  RobotFile file_;
  ActuatorRunner<Module> arm_{"arm"};
  ActuatorRunner<Module> leg_{"leg"};
  MachineController controller_;
};

TEST_F(AMachineAndItsManagers, ItsActuatorsRefuseAManagerWithAReasonAndAnswerQueries) {
  BringActuatorsUp();
  ASSERT_TRUE(controller_.AwaitSetUp());
  ASSERT_TRUE(controller_.Switch("SelfCheck").done());
  PlainParticipant person(Domain());
  PlainLifecycleClient tool(person, RobotFile::name_space() + "/arm");
  EXPECT_EQ(tool.GetState(), "inactive [2]");
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(tool.ChangeState(kActivate), false);
  EXPECT_THAT(
      ::testing::internal::GetCapturedStderr(),
      AllOf(HasSubstr("arm: warning: change_state 3 failed: "), HasRefusal(Refusal::kUnderControl),
            HasSubstr("lifecycle set /" + RobotFile::name_space() + "/musher")));
  EXPECT_EQ(arm_.CurrentState(), "SelfCheck");
  ASSERT_TRUE(controller_.Switch("Active").done());
  EXPECT_EQ(tool.GetState(), "active [3]");
  EXPECT_TRUE(person.Spin([&] { return tool.events.size() >= 2; }));
  EXPECT_THAT(tool.events, ElementsAre("activate: inactive -> activating",
                                       "transition_success: activating -> active"));
}

TEST_F(AMachineAndItsManagers, AsOneNodeItIsBroughtUpAndDownByNav2sManager) {
  BringActuatorsUp();
  PlainNav2Manager manager(Domain(), RobotFile::name_space(), {"musher"});
  EXPECT_TRUE(manager.Startup());
  EXPECT_EQ(arm_.CurrentState(), "Active");
  EXPECT_EQ(leg_.CurrentState(), "Active");
  EXPECT_TRUE(manager.Pause());
  EXPECT_EQ(leg_.CurrentState(), "DeActive");
  EXPECT_TRUE(manager.Resume());
  EXPECT_TRUE(manager.Shutdown()) << "it answers queries after the TearDown as well";
  EXPECT_THAT(manager.errors(), IsEmpty());
  EXPECT_EQ(arm_.Wait(), 0);
  EXPECT_EQ(leg_.Wait(), 0);
}

TEST_F(AMachineAndItsManagers, AsOneNodeItKeepsABond) {
  BringActuatorsUp();
  PlainNav2Manager manager(Domain(), RobotFile::name_space(), {"musher"}, 1.0);
  ASSERT_TRUE(manager.Startup());
  EXPECT_TRUE(manager.participant().Spin([&] { return manager.bond("musher")->received() >= 20; }));
  EXPECT_FALSE(manager.bond("musher")->broken());
  EXPECT_TRUE(manager.Shutdown());
  EXPECT_THAT(manager.errors(), IsEmpty());
}

// nav2's bonded manager took the end of the bond for a crash, reset the machine and started it
// again: a person's pause lasted 1.1 s.
TEST_F(AMachineAndItsManagers, AsOneNodeItStaysPausedByAPersonUnderABondedManager) {
  BringActuatorsUp();
  PlainNav2Manager manager(Domain(), RobotFile::name_space(), {"musher"}, 1.0);
  ASSERT_TRUE(manager.Startup());
  ASSERT_TRUE(controller_.Switch("DeActive").done());
  const int before = manager.bond("musher")->received();
  EXPECT_TRUE(manager.participant().Spin(
      [&] { return manager.bond("musher")->received() >= before + 10; }));
  EXPECT_FALSE(manager.bond("musher")->broken());
  EXPECT_EQ(manager.client("musher").ChangeState(kActivate), false);
  EXPECT_EQ(arm_.CurrentState(), "DeActive");
  ASSERT_TRUE(controller_.Switch("Active").done());
  EXPECT_FALSE(manager.bond("musher")->broken());
  EXPECT_TRUE(manager.Pause());
  EXPECT_TRUE(manager.Resume()) << "its own pause";
}

TEST_F(AMachineAndItsManagers, AsOneNodeAPersonsRos2LifecycleEndsAPersonsPause) {
  BringActuatorsUp();
  PlainNav2Manager manager(Domain(), RobotFile::name_space(), {"musher"});
  ASSERT_TRUE(manager.Startup());
  ASSERT_TRUE(controller_.Switch("DeActive").done());
  EXPECT_EQ(manager.client("musher").ChangeState(kActivate), false);
  PlainParticipant person(Domain());
  // As each node of ROS 2 has it; that of the command `ros2` has this name.
  person.Writer(lifecycle_msgs_srv_dds__GetState_Response__desc,
                "rr/_ros2cli_4711/get_type_descriptionReply");
  PlainLifecycleClient tool(person, RobotFile::name_space() + "/musher");
  EXPECT_EQ(tool.ChangeState(kActivate), true);
  EXPECT_EQ(arm_.CurrentState(), "Active");
}

// As in Humble, its node has no services of its own: only ros_discovery_info has its name.
TEST_F(AMachineAndItsManagers, AsOneNodeAPersonsRos2LifecycleWithoutServicesEndsAPersonsPause) {
  BringActuatorsUp();
  PlainNav2Manager manager(Domain(), RobotFile::name_space(), {"musher"});
  ASSERT_TRUE(manager.Startup());
  ASSERT_TRUE(controller_.Switch("DeActive").done());
  EXPECT_EQ(manager.client("musher").ChangeState(kActivate), false);
  PlainParticipant person(Domain());
  PlainLifecycleClient tool(person, RobotFile::name_space() + "/musher");
  EXPECT_TRUE(PublishNodes(person, {{"_ros2cli_4711", {tool.change_state_writer()}}}));
  // Refused where it comes before the list of the nodes, which is another topic.
  EXPECT_TRUE(Until([&] { return tool.ChangeState(kActivate) == true; }));
  EXPECT_EQ(arm_.CurrentState(), "Active");
}

// A node of the command beside a manager in one process would be no person.
TEST_F(AMachineAndItsManagers, AsOneNodeItTakesTheNodeOfTheClientForTheRequester) {
  BringActuatorsUp();
  ASSERT_TRUE(controller_.AwaitSetUp());
  PlainParticipant container(Domain());
  PlainLifecycleClient manager(container, RobotFile::name_space() + "/musher");
  const dds_entity_t other = container.Writer(lifecycle_msgs_srv_dds__GetState_Response__desc,
                                              "rr/_ros2cli_4711/get_type_descriptionReply");
  EXPECT_TRUE(PublishNodes(
      container, {{"_ros2cli_4711", {other}}, {"manager", {manager.change_state_writer()}}}));
  ASSERT_TRUE(controller_.Switch("SelfCheck").done());
  ASSERT_TRUE(controller_.Switch("DeActive").done());
  EXPECT_EQ(manager.ChangeState(kActivate), false);
  EXPECT_EQ(arm_.CurrentState(), "DeActive");
}

// Nor is it one while its process has not published the node of each client.
TEST_F(AMachineAndItsManagers, AsOneNodeItTakesNoProcessOfSeveralNodesForAPerson) {
  BringActuatorsUp();
  ASSERT_TRUE(controller_.AwaitSetUp());
  PlainParticipant container(Domain());
  for (const char* node : {"_ros2cli_4711", "manager"}) {
    container.Writer(lifecycle_msgs_srv_dds__GetState_Response__desc,
                     std::string("rr/") + node + "/get_type_descriptionReply");
  }
  PlainLifecycleClient manager(container, RobotFile::name_space() + "/musher");
  ASSERT_TRUE(controller_.Switch("SelfCheck").done());
  ASSERT_TRUE(controller_.Switch("DeActive").done());
  EXPECT_EQ(manager.ChangeState(kActivate), false) << "no node is published";
  PlainLifecycleClient tool(container, RobotFile::name_space() + "/musher");
  EXPECT_TRUE(PublishNodes(container, {{"_ros2cli_4711", {tool.change_state_writer()}}}));
  EXPECT_EQ(manager.ChangeState(kActivate), false) << "its own node is not published";
  EXPECT_EQ(arm_.CurrentState(), "DeActive");
}

TEST_F(AMachineAndItsManagers, AsOneNodeItKeepsItsStateWhenAnActuatorFails) {
  BringActuatorsUp();
  PlainParticipant person(Domain());
  PlainLifecycleClient tool(person, RobotFile::name_space() + "/musher");
  ASSERT_EQ(tool.ChangeState(0, "configure"), true);
  leg_.FailIn("Active");
  EXPECT_EQ(tool.ChangeState(0, "activate"), false);
  EXPECT_EQ(tool.GetState(), "inactive [2]");
}

TEST_F(AnActuatorWithoutAController, LogsEachFailureOfACallbackAlsoAfterARefusal) {
  PlainParticipant person(Domain());
  PlainLifecycleClient tool(person, RobotFile::name_space() + "/arm");
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(tool.ChangeState(kActivate), false) << "it is unconfigured";
  ASSERT_EQ(tool.ChangeState(0, "configure"), true);
  arm_.FailIn("Active");
  EXPECT_EQ(tool.ChangeState(kActivate), false);
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, HasSubstr("change_state 3 failed: the node is unconfigured"));
  EXPECT_THAT(log, HasSubstr("change_state activate failed: "));
  EXPECT_THAT(log, HasSubstr("2012"));
}

TEST(AnActuatorWithoutActive, RefusesToBeActivated) {
  const RobotFile file({"arm"}, {"SetUp", "TearDown", "SelfCheck", "DeActive"});
  ActuatorRunner<Module> arm("arm");
  ASSERT_TRUE(arm.Init(file.path()));
  ASSERT_TRUE(arm.Start());
  PlainParticipant person(Domain());
  PlainLifecycleClient tool(person, RobotFile::name_space() + "/arm");
  ASSERT_EQ(tool.ChangeState(kConfigure), true);
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(tool.ChangeState(kActivate), false);
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasRefusal(Refusal::kNoStateForTransition));
}

TEST_F(AMachineAndItsManagers, AppearInRos2sDiagnosticsAndLog) {
  BringActuatorsUp();
  PlainParticipant person(Domain());
  std::vector<std::string> shown;  // the status of the arm, each time
  std::vector<std::string> logged;
  const std::string arm = "robot: arm";
  person.Read<diagnostic_msgs_msg_dds__DiagnosticArray_>(
      diagnostic_msgs_msg_dds__DiagnosticArray__desc, "rt/diagnostics", [&](const auto& array) {
        for (std::uint32_t i = 0; i < array.status._length; ++i) {
          const auto& status = array.status._buffer[i];
          if (status.name == arm) shown.emplace_back(status.message);
        }
      });
  person.Read<rcl_interfaces_msg_dds__Log_>(rcl_interfaces_msg_dds__Log__desc, "rt/rosout",
                                            [&](const auto& log) { logged.emplace_back(log.msg); });
  ASSERT_TRUE(controller_.AwaitSetUp());
  ASSERT_TRUE(controller_.Switch("SelfCheck").done());
  EXPECT_TRUE(person.Spin([&] { return !shown.empty() && shown.back() == "SelfCheck"; }));
  // Each switch begins with what is published once a second: without a change of it the next one
  // comes a second later. A busy computer may take as long, but not each time.
  bool on_change = false;
  for (int tries = 0; tries < 10 && !on_change; ++tries) {
    const std::string target = tries % 2 == 0 ? "Active" : "Protected";
    const auto begun = std::chrono::steady_clock::now();
    ASSERT_TRUE(controller_.Switch(State(target)).done());
    ASSERT_TRUE(person.Spin([&] { return shown.back() == target; }));
    on_change = std::chrono::steady_clock::now() - begun < std::chrono::milliseconds(900);
  }
  EXPECT_TRUE(on_change) << "on change, not after the period of 1 s";
  EXPECT_FALSE(controller_.Switch("SetUp").done());
  EXPECT_TRUE(person.Spin([&] { return !logged.empty(); }));
  EXPECT_THAT(logged.back(), HasSubstr("SetUp"));
}

// A faulty client that sends requests at full speed to each actuator and the machine.
class RogueClient {
 public:
  RogueClient()
      : thread_([this] {
          PlainParticipant participant(Domain());
          std::vector<std::unique_ptr<PlainLifecycleClient>> clients;
          for (const char* node : {"arm", "leg", "musher"}) {
            clients.push_back(std::make_unique<PlainLifecycleClient>(
                participant, RobotFile::name_space() + "/" + node));
            clients.back()->WaitForServices();
          }
          floods_ = true;
          while (!over_) {
            for (const auto& client : clients) client->ChangeStateWithoutWaiting(kConfigure);
            sent_ += clients.size();
            if (sent_ % kBurst == 0) participant.Spin([] { return false; }, 1);
          }
          for (const auto& client : clients) answers_ += client->answers();
        }) {}
  ~RogueClient() { End(); }
  RogueClient(const RogueClient&) = delete;
  RogueClient& operator=(const RogueClient&) = delete;

  bool floods() const { return floods_; }
  void End() {
    over_ = true;
    if (thread_.joinable()) thread_.join();
  }
  std::uint64_t sent() const { return sent_; }
  std::uint64_t answers() const { return answers_; }

 private:
  static constexpr std::uint64_t kBurst = 30;
  std::atomic<bool> floods_ = false;
  std::atomic<bool> over_ = false;
  std::atomic<std::uint64_t> sent_ = 0;
  std::atomic<std::uint64_t> answers_ = 0;
  std::thread thread_;  // last: it uses all of the above
};

TEST_F(AMachineAndItsManagers, AFloodOfRequestsDoesNotDelayASwitch) {
  BringActuatorsUp();
  ASSERT_TRUE(controller_.AwaitSetUp());
  ASSERT_TRUE(controller_.Switch("SelfCheck").done());
  const auto median_ms = [&](const std::function<bool()>& enough) {
    std::vector<double> took;
    for (int i = 0; i < 40 || i % 2 != 0 || !enough(); ++i) {
      const auto begun = std::chrono::steady_clock::now();
      EXPECT_TRUE(controller_.Switch(i % 2 == 0 ? kActive : kProtected).done());
      const std::chrono::duration<double, std::milli> one =
          std::chrono::steady_clock::now() - begun;
      took.push_back(one.count());
    }
    std::sort(took.begin(), took.end());
    return took[took.size() / 2];
  };
  const double idle = median_ms([] { return true; });
  PlainParticipant person(Domain());
  RogueClient rogue;
  ASSERT_TRUE(person.Spin([&] { return rogue.floods(); }));
  const double beside = median_ms([&] { return rogue.sent() >= kFlood; });
  rogue.End();
  RecordProperty("switch_idle_ms", std::to_string(idle));
  RecordProperty("switch_in_flood_ms", std::to_string(beside));
  RecordProperty("requests", std::to_string(rogue.sent()));
  EXPECT_GT(rogue.answers(), 0U)
      << "the replies that its reader, which keeps the last 10, has taken";
  EXPECT_EQ(arm_.CurrentState(), "Protected");
  // A computer that is busy with other things is as slow without the flood.
  EXPECT_LT(beside, 250.0 + 10 * idle)
      << "ms for a switch of two actuators; without the flood: " << idle;
  EXPECT_EQ(std::ranges::count(arm_.ran(), "SelfCheck"), 1)
      << "no request of the flood was executed";
}

}  // namespace musher::testing::plain_lifecycle_manager_test
