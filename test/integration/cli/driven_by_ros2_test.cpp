// A robot of real processes that nav2's manager starts up and shuts down.

#include <optional>

#include "musher/base/host.hpp"
#include "musher/test/contract/plain_lifecycle_manager.hpp"
#include "musher/test/contract/plain_ros2_command.hpp"
#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::driven_by_ros2_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class ARobotDrivenByRos2 : public MachineByCli {
 protected:
  void Add(const std::string& toml) const { std::ofstream(config_, std::ios::app) << toml; }
  // The machine waits for nav2's manager, which has requested nothing yet.
  void UpForManager(std::optional<double> bond_timeout_s = 4.0) {
    Add("[ros2]\nstart = \"manager\"\n");
    up_.emplace(Command({"up", config_}));
    ASSERT_NE(up_->LineWith("the machine waits in SetUp for a manager to configure it"), "");
    manager_.emplace(transport::TestDomain(), name_space_, std::vector<std::string>{"musher"},
                     bond_timeout_s);
  }
  void Down() {
    EXPECT_EQ(Musher({"down"}).exit, 0);
    EXPECT_EQ(up_->Wait().exit, 0);
  }

  std::optional<Process> up_;
  std::optional<PlainNav2Manager> manager_;
};

TEST_F(ARobotDrivenByRos2, WaitsInSetUpUntilABondedManagerBringsItUp) {
  ASSERT_NO_FATAL_FAILURE(UpForManager());
  ASSERT_TRUE(manager_->Startup());
  EXPECT_EQ(Status()["state"], "Active");
  EXPECT_TRUE(manager_->Pause());
  EXPECT_EQ(Status()["state"], "LowPower") << "its highest state below Active: it has no DeActive";
  EXPECT_TRUE(manager_->Resume());
  EXPECT_FALSE(manager_->bond("musher")->broken());
  EXPECT_THAT(manager_->errors(), IsEmpty());
  Down();
}

TEST_F(ARobotDrivenByRos2, SaysWhoHasPausedItInStatusAndHistory) {
  ASSERT_NO_FATAL_FAILURE(UpForManager());
  manager_->participant().Writer(lifecycle_msgs_srv_dds__GetState_Response__desc,
                                 "rr/lifecycle_manager/get_type_descriptionReply");
  ASSERT_TRUE(manager_->Startup());
  EXPECT_EQ(Status()["requested_by"], "/lifecycle_manager");
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  EXPECT_EQ(Status()["requested_by"], UserAtHost());
  EXPECT_EQ(manager_->client("musher").ChangeState(0, "activate"), false);
  const std::string history = Musher({"history"}).out;
  EXPECT_THAT(history, HasSubstr("LowPower was last requested by " + UserAtHost()));
  Down();
}

// nav2 composed in one process: the name of the process is that of none of its nodes.
TEST_F(ARobotDrivenByRos2, NamesTheNodeOfAContainerThatHasRequestedASwitch) {
  ASSERT_NO_FATAL_FAILURE(UpForManager());
  const auto service = [&](const std::string& node) {
    return manager_->participant().Writer(lifecycle_msgs_srv_dds__GetState_Response__desc,
                                          "rr/" + node + "/get_type_descriptionReply");
  };
  const dds_entity_t amcl = service("amcl"), own = service("lifecycle_manager_navigation");
  EXPECT_TRUE(PublishNodes(
      manager_->participant(),
      {{"amcl", {amcl}},
       {"lifecycle_manager_navigation", {own, manager_->client("musher").change_state_writer()}}}));
  ASSERT_TRUE(manager_->Startup());
  EXPECT_EQ(Status()["requested_by"], "/lifecycle_manager_navigation");
  Down();
}

// As in Humble, its node has no services of its own: only ros_discovery_info has its name.
TEST_F(ARobotDrivenByRos2, IsResumedByAPersonsRos2LifecycleWithoutServices) {
  ASSERT_NO_FATAL_FAILURE(UpForManager());
  ASSERT_TRUE(manager_->Startup());
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  EXPECT_EQ(manager_->client("musher").ChangeState(0, "activate"), false);
  PlainParticipant person(transport::TestDomain());
  PlainLifecycleClient tool(person, name_space_ + "/musher");
  EXPECT_TRUE(PublishNodes(person, {{"_ros2cli_4711", {tool.change_state_writer()}}}));
  EXPECT_EQ(tool.ChangeState(0, "activate"), true);
  EXPECT_EQ(Status()["requested_by"], "ros2 lifecycle (/_ros2cli_4711)");
  Down();
}

// Of Humble, in its layout: its request may be discovered before its list of nodes.
TEST_F(ARobotDrivenByRos2, IsResumedByAPersonsRos2LifecycleWhoseNodesComeAfterItsRequest) {
  ASSERT_NO_FATAL_FAILURE(UpForManager());
  ASSERT_TRUE(manager_->Startup());
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  PlainParticipant person(transport::TestDomain());
  PlainLifecycleClient tool(person, name_space_ + "/musher");
  ASSERT_TRUE(tool.WaitForServices());
  tool.ChangeStateWithoutWaiting(3);  // activate
  ASSERT_EQ(dds_wait_for_acks(tool.change_state_writer(), DDS_SECS(20)), DDS_RETCODE_OK);
  EXPECT_TRUE(PublishNodesOfHumble(person, {{"_ros2cli_4711", {tool.change_state_writer()}}}));
  AwaitStatus([](const nlohmann::json& status) { return status["state"] == "Active"; });
  EXPECT_EQ(Status()["requested_by"], "ros2 lifecycle (/_ros2cli_4711)");
  Down();
}

// Before it has published its nodes.
TEST_F(ARobotDrivenByRos2, NamesAllNodesOfAContainerWhereItDoesNotKnowTheOne) {
  ASSERT_NO_FATAL_FAILURE(UpForManager());
  for (const char* node : {"e", "d", "c", "b", "a"}) {
    manager_->participant().Writer(lifecycle_msgs_srv_dds__GetState_Response__desc,
                                   std::string("rr/") + node + "/get_type_descriptionReply");
  }
  ASSERT_TRUE(manager_->Startup());
  EXPECT_EQ(Status()["requested_by"], "/a, /b, /c, /d and 1 more");
  Down();
}

TEST_F(ARobotDrivenByRos2, IsShutDownByAManagerThatQueriesItFinalized) {
  ASSERT_NO_FATAL_FAILURE(UpForManager(std::nullopt));
  ASSERT_TRUE(manager_->Startup());
  EXPECT_TRUE(manager_->Shutdown());
  EXPECT_THAT(manager_->errors(), IsEmpty());
  const Ended ended = up_->Wait();
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

// Its message has a name only if the client gives one.
TEST_F(ARobotDrivenByRos2, NamesTheNodeThatRequestsASwitchOfThePolicy) {
  Add("[policy]\n");
  ASSERT_EQ(UpDetached().exit, 0);
  PlainRos2Command node(transport::TestDomain());
  node.participant().Writer(lifecycle_msgs_srv_dds__GetState_Response__desc,
                            "rr/dock/get_type_descriptionReply");
  musher_msgs_srv_dds__RequestPolicy_Request_ request{};
  std::string ota = "ota", none;
  request.request = ota.data();
  request.state = request.machine = request.machine_id = request.by = none.data();
  request.enable = true;
  std::string state;
  EXPECT_TRUE(node.Call<musher_msgs_srv_dds__RequestPolicy_Response_>(
      "/" + name_space_ + "/musher/request_policy",
      musher_msgs_srv_dds__RequestPolicy_Request__desc,
      musher_msgs_srv_dds__RequestPolicy_Response__desc, request,
      [&](const auto& reply) { state = reply.state; }));
  EXPECT_EQ(state, "OTA");
  EXPECT_EQ(Status()["requested_by"], "/dock");
  EXPECT_THAT(Musher({"history"}).out, HasSubstr("OTA entry requested by /dock"));
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

// Writes samples of another type under the name of a topic's type.
void WriteGarbage(const std::string& topic, const dds_topic_descriptor_t& type,
                  const std::string& type_hash) {
  const PlainParticipant settings(transport::TestDomain());  // the domain's, for all of a process
  dds_topic_descriptor_t garbage = std_msgs_msg_dds__UInt8__desc;
  garbage.m_typename = type.m_typename;
  const dds_entity_t participant = dds_create_participant(
      static_cast<dds_domainid_t>(transport::TestDomain()), nullptr, nullptr);
  const dds_entity_t named =
      dds_create_topic(participant, &garbage, topic.c_str(), nullptr, nullptr);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(10));
  const std::string tag = "typehash=" + type_hash + ";";
  dds_qset_userdata(qos, tag.data(), tag.size());
  const dds_entity_t writer = dds_create_writer(participant, named, qos, nullptr);
  dds_delete_qos(qos);
  dds_set_status_mask(writer, DDS_PUBLICATION_MATCHED_STATUS);
  const dds_entity_t waitset = dds_create_waitset(participant);
  dds_waitset_attach(waitset, writer, 0);
  EXPECT_GT(dds_waitset_wait(waitset, nullptr, 0, DDS_SECS(20)), 0);
  const std_msgs_msg_dds__UInt8_ sample = {7};
  for (int i = 0; i < 50; ++i) EXPECT_EQ(dds_write(writer, &sample), DDS_RETCODE_OK);
  EXPECT_EQ(dds_wait_for_acks(writer, DDS_SECS(20)), DDS_RETCODE_OK);
  dds_delete(participant);
}

int CountIn(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

TEST_F(ARobotDrivenByRos2, RecordsGarbageAndAWrongTypeOnceWithTheirSource) {
  ASSERT_EQ(UpDetached().exit, 0);
  WriteGarbage("rq/" + name_space_ + "/musher/change_stateRequest",
               lifecycle_msgs_srv_dds__ChangeState_Request__desc, "RIHS01_0123");
  std::string history;
  EXPECT_TRUE(Until([&history] {
    history = Musher({"history"}).out;
    return CountIn(history, "sends samples that do not fit the type") > 0;
  }));
  const std::string source = "process " + std::to_string(getpid()) + " of host ";
  EXPECT_EQ(CountIn(history, "sends samples that do not fit the type"), 1) << history;
  EXPECT_EQ(CountIn(history, "has another definition of"), 1) << history;
  EXPECT_THAT(history, HasSubstr(source));
  EXPECT_THAT(history, HasSubstr("change_stateRequest; recorded once"));
  EXPECT_EQ(Musher({"down"}).exit, 0);
}

// As a client that was built with other packages: it does not even receive a reply that fits.
TEST_F(ARobotDrivenByRos2, RecordsAReaderOfAnotherTypeOnceWithItsSource) {
  ASSERT_EQ(UpDetached().exit, 0);
  PlainParticipant other(transport::TestDomain());
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  const std::string tag = "typehash=RIHS01_0123;";
  dds_qset_userdata(qos, tag.data(), tag.size());
  const std::string topic = "rr/" + name_space_ + "/musher/get_stateReply";
  const dds_entity_t named =
      dds_create_topic(other.entity(), &lifecycle_msgs_srv_dds__GetState_Response__desc,
                       topic.c_str(), nullptr, nullptr);
  EXPECT_GT(dds_create_reader(other.entity(), named, qos, nullptr), 0);
  EXPECT_GT(dds_create_reader(other.entity(), named, qos, nullptr), 0);
  dds_delete_qos(qos);
  PlainLifecycleClient machine(other, name_space_ + "/musher");
  EXPECT_EQ(machine.GetState(), "active [3]") << "its own reader, found after both, has no hash";
  const std::string history = Musher({"history"}).out;
  EXPECT_EQ(CountIn(history, "has another definition of lifecycle_msgs::srv::dds_::GetState_"), 1)
      << history;
  EXPECT_THAT(history, HasSubstr("process " + std::to_string(getpid()) + " of host "));
  EXPECT_THAT(history, HasSubstr("RIHS01_0123, on " + topic + "; recorded once"));
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
