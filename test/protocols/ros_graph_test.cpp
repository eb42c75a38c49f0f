// What ROS 2 processes see of Musher's: `ros2 node list`, `ros2 node info`, and what they log.

#include <gmock/gmock.h>

#include <cerrno>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/controller/machine_controller.hpp"
#include "musher/messages/before_iron.hpp"
#include "musher/messages/rmw_dds_common/participant_entities.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/test/actuator/robot_file.hpp"
#include "musher/test/contract/type_hash_table.hpp"
#include "musher/test/contract/world.hpp"
#include "musher/test/protocols/ros_graph.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/dds/participant.hpp"
#include "musher/transport/dds/raw_type.hpp"
#include "musher/transport/dds/ros_nodes.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/transport/service.hpp"

namespace musher::testing::ros_graph_test {

using ::testing::IsEmpty;
using transport::Must;

constexpr int kBurst = 200;

// A message of a robot's own, which Musher's IDL does not define.
struct Own {
  static constexpr std::string_view kTypeName = "robot_msgs::msg::dds_::Own_";
  std::uint8_t data = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.data);
  }
};

class ARobotBesideRos2 : public ::testing::Test {
 protected:
  static std::string Here(const std::string& name) {
    return "/" + RobotFile::name_space() + "/" + name;
  }

  RobotFile file_{{"arm", "leg"}, kAllStates};
};

// Two actuators that share a process are two nodes.
TEST_F(ARobotBesideRos2, IsListedByNameWithItsEndpointsAndWithoutAWarning) {
  const auto thread = Must(transport::NodeThread::Start());
  ActuatorRunner<MachineActuator> arm("arm"), leg("leg");
  MachineController controller;
  for (ActuatorRunner<MachineActuator>* actuator : {&arm, &leg}) {
    actuator->RegisterStateCallback([](const State&) { return kCodeOk; });
    ASSERT_TRUE(actuator->Init(file_.path(), thread));
    ASSERT_TRUE(actuator->Start());
  }
  ASSERT_TRUE(controller.Init(file_.path()));
  RosGraphPeer ros;
  EXPECT_TRUE(ros.Sees([&](const RosGraph& graph) {
    return graph.Has(Here("arm"), "service " + Here("arm/musher_command")) &&
           graph.Has(Here("leg"), "service " + Here("leg/musher_command")) &&
           graph.Has(Here("arm"), "publisher " + Here("musher/actuator_status")) &&
           graph.Has(Here("musher"), "service " + Here("musher/set_state")) &&
           graph.Has(Here("musher"), "client " + Here("leg/musher_command")) &&
           graph.unknown.empty();
  })) << ros.text();
  EXPECT_FALSE(ros.graph().Has(Here("arm"), "service " + Here("leg/musher_command")));
  EXPECT_THAT(ros.graph().log, IsEmpty());
  const msg::HashTable table = msg::JazzyTypeHashes();
  for (const auto& [type, hash] : ros.graph().hashes) {
    EXPECT_EQ(hash.size(), 7U + 64U) << type;
    if (table.contains(type)) {
      EXPECT_EQ(hash, table.at(type)) << type;
    }
  }
  RecordProperty("user_data_bytes", ros.graph().bytes);
  RecordProperty("endpoints", ros.graph().endpoints);

  leg.Shutdown();
  EXPECT_TRUE(ros.Sees([&](const RosGraph& graph) {
    return !graph.Has(Here("leg")) && graph.Has(Here("arm")) && graph.unknown.empty();
  })) << ros.text();
}

class NodesBesideRos2 : public ::testing::Test {
 protected:
  NodesBesideRos2() { setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1); }

  std::unique_ptr<transport::Node> MakeNode(const transport::DdsOptions& options = {}) {
    return Must(transport::MakeDdsNode(loop_, options));
  }

  transport::LinuxEventLoop loop_;
};

// Of a node of this process that has no other name.
std::string OwnName() {
  return std::string(program_invocation_short_name) + "_" + std::to_string(getpid());
}

TEST_F(NodesBesideRos2, HaveTheNameOfTheirProgramWithoutAnother) {
  const auto thread = Must(transport::NodeThread::Start());
  RosGraphPeer ros;
  EXPECT_TRUE(ros.Sees([](const RosGraph& graph) { return graph.Has("/" + OwnName()); }))
      << ros.text();
}

TEST_F(NodesBesideRos2, AreHiddenWhereTheyOnlyCall) {
  const auto thread = Must(transport::NodeThread::Start({.hidden = true}));
  RosGraphPeer ros;
  EXPECT_TRUE(ros.Sees([](const RosGraph& graph) { return graph.Has("/_" + OwnName()); }))
      << ros.text();
}

TEST_F(NodesBesideRos2, HaveNamesThatRos2Accepts) {
  transport::DdsOptions options;
  options.node_name = "3d-camera";
  options.name_space = "fleet/dog1";
  const auto thread = Must(transport::NodeThread::Start(options));
  RosGraphPeer ros;
  EXPECT_TRUE(ros.Sees([](const RosGraph& graph) {
    return graph.Has("/fleet/dog1/node_3d_camera");
  })) << ros.text();
}

TEST_F(NodesBesideRos2, MakeABurstOfEndpointsKnownByOneSample) {
  const auto thread = Must(transport::NodeThread::Start({.node_name = "burst"}));
  RosGraphPeer ros;
  ASSERT_TRUE(ros.Sees([](const RosGraph& graph) { return graph.Has("/burst"); }));
  const int before = ros.graph().samples;
  std::vector<std::unique_ptr<transport::Publisher<msg::String>>> publishers;
  thread->RunOnLoop([&] {
    for (int i = 0; i < kBurst; ++i) {
      publishers.push_back(Must(transport::MakePublisher<msg::String>(
          thread->node(), "burst/topic_" + std::to_string(i))));
    }
  });
  EXPECT_TRUE(ros.Sees([](const RosGraph& graph) {
    return graph.Has("/burst") && graph.nodes.at("/burst").size() == kBurst;
  })) << ros.text();
  EXPECT_EQ(ros.graph().samples, before + 1);
  thread->RunOnLoop([&] { publishers.clear(); });
  // The endpoints are gone from discovery before the sample without them comes.
  EXPECT_TRUE(ros.Sees([&](const RosGraph& graph) {
    return graph.nodes.at("/burst").empty() && graph.samples > before + 1;
  })) << ros.text();
  EXPECT_EQ(ros.graph().samples, before + 2);
}

TEST_F(NodesBesideRos2, MayHaveTypesWhoseHashMusherDoesNotKnow) {
  const auto thread = Must(transport::NodeThread::Start({.node_name = "own"}));
  std::unique_ptr<transport::Publisher<Own>> publisher;
  thread->RunOnLoop(
      [&] { publisher = Must(transport::MakePublisher<Own>(thread->node(), "own/data")); });
  RosGraphPeer ros;
  EXPECT_TRUE(ros.Sees([](const RosGraph& graph) {
    return graph.Has("/own", "publisher /own/data");
  })) << ros.text();
  EXPECT_THAT(ros.graph().log, IsEmpty());
  thread->RunOnLoop([&] { publisher.reset(); });
}

struct DistroRow {
  const char* name;
  RosDistro distro;
  std::size_t gid_bytes;
};

class NodesOfADistro : public ::testing::TestWithParam<DistroRow> {};

// From the environment, as in a shell with ROS.
TEST_P(NodesOfADistro, AreListedInItsLayout) {
  setenv("ROS_DISTRO", GetParam().name, 1);
  EXPECT_EQ(transport::ChosenDistro(std::nullopt) < RosDistro::kIron, GetParam().gid_bytes == 24);
  unsetenv("ROS_DISTRO");
  transport::LinuxEventLoop loop;
  transport::DdsOptions options;
  options.domain_id = transport::TestDomain();
  options.node_name = "arm";
  options.ros_distro = GetParam().distro;
  const auto node = Must(transport::MakeDdsNode(loop, options));
  msg::Bytes received;
  transport::ReaderCallbacks callbacks;
  callbacks.on_sample = [&](std::span<const std::byte> bytes, const transport::SampleInfo&) {
    received.assign(bytes.begin(), bytes.end());
  };
  const auto reader = Must(node->MakeRawReader("ros_discovery_info",
                                               std::string(msg::ParticipantEntitiesInfo::kTypeName),
                                               transport::kLatchedQos, std::move(callbacks)));
  ASSERT_TRUE(
      loop.RunUntil([&] { return !received.empty(); }, loop.Now() + std::chrono::seconds(120)));
  msg::ParticipantEntitiesInfo info;
  info.node_entities_info_seq.push_back({"/", "arm", {{}}, {}});
  const std::size_t size = GetParam().gid_bytes == 24 ? msg::Encode(msg::BeforeIron(info)).size()
                                                      : msg::Encode(info).size();
  EXPECT_EQ(received.size(), size);
}
TEST_P(NodesOfADistro, AreKnownByTheirClients) {
  transport::LinuxEventLoop loop;
  transport::DdsOptions options;
  options.domain_id = transport::TestDomain();
  options.name_space = "dog1";
  options.node_name = "arm";
  options.ros_distro = GetParam().distro;
  const auto node = Must(transport::MakeDdsNode(loop, options));
  const auto client = Must(transport::MakeClient<msg::Trigger>(*node, "dog1/reset"));
  const transport::RosNodes nodes(*node);
  EXPECT_TRUE(loop.RunUntil(
      [&] { return nodes.CallersOf("dog1/reset", node->participant()) == "/dog1/arm"; },
      loop.Now() + std::chrono::seconds(120)));
  EXPECT_EQ(nodes.CallersOf("dog1/other", node->participant()), "") << "it has no client of it";
}
// A request of the other client counted as one of the person who typed a command beside it.
TEST(NodesOfAProcess, NameNoSingleCallerBesideAClientWhoseNodeIsNotKnown) {
  transport::LinuxEventLoop loop;
  transport::DdsOptions options;
  options.domain_id = transport::TestDomain();
  options.name_space = "dog1";
  options.node_name = "_ros2cli_4711";
  const auto node = Must(transport::MakeDdsNode(loop, options));
  const auto client = Must(transport::MakeClient<msg::Trigger>(*node, "dog1/reset"));
  const dds_entity_t participant = transport::dds::ParticipantOf(*node)->get();
  const transport::dds::Entity topic(transport::dds::CreateRawTopic(
      participant, "rq/dog1/resetRequest", std::string(msg::Trigger::kTypeName) + "Request_"));
  const transport::dds::Entity writer(
      dds_create_writer(participant, topic.get(), nullptr, nullptr));
  ASSERT_GT(writer.get(), 0);
  const transport::RosNodes nodes(*node);
  std::string callers;
  loop.RunUntil(
      [&] {
        callers = nodes.CallersOf("dog1/reset", node->participant());
        return callers.find("/dog1/") != std::string::npos;
      },
      loop.Now() + std::chrono::seconds(120));
  EXPECT_EQ(callers, "/dog1/_ros2cli_4711, a node that is not known");
}
INSTANTIATE_TEST_SUITE_P(Ros2, NodesOfADistro,
                         ::testing::Values(DistroRow{"galactic", RosDistro::kGalactic, 24},
                                           DistroRow{"humble", RosDistro::kHumble, 24},
                                           DistroRow{"iron", RosDistro::kIron, 16},
                                           DistroRow{"jazzy", RosDistro::kJazzy, 16},
                                           DistroRow{"kilted", RosDistro::kKilted, 16}),
                         [](const auto& row) { return row.param.name; });

}  // namespace musher::testing::ros_graph_test
