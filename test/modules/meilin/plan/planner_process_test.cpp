// musher-meilin-planner as a controller and a web page use it: the real program over DDS.

#include <gtest/gtest.h>

#include "musher/messages/std_msgs/multi_array.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/modules/actuator_peer.hpp"

namespace musher::meilin::planner_process_test {
namespace {

TEST(PlannerProcess, SendsAPlanOnCommandInActive) {
  test::ActuatorPeer peer("meilin_planner", {"SetUp", "TearDown", "SelfCheck", "Active"},
                          "musher-meilin-planner");
  std::vector<msg::Float32MultiArray> plans;
  const auto plan = transport::MakeSubscription<msg::Float32MultiArray>(
      peer.node(), "mf_action_seq",
      [&](const msg::Float32MultiArray& sample, const auto&) { plans.push_back(sample); },
      transport::kLatchedQos);
  std::string paths;
  const auto found = transport::MakeSubscription<msg::String>(
      peer.node(), "planning/paths_for_web",
      [&](const msg::String& sample, const auto&) { paths = sample.data; }, transport::kLatchedQos);
  const auto map =
      transport::MakePublisher<msg::String>(peer.node(), "mf_r2_data", transport::kLatchedQos);
  const auto command = transport::MakePublisher<msg::String>(peer.node(), "planning/command",
                                                             transport::kLatchedQos);
  ASSERT_TRUE(plan && found && map && command);
  ASSERT_TRUE(map.value()->Publish(
      {R"({"grid": [[0,0,0],[0,2,0],[0,0,1],[2,0,0],[0,0,0],[0,0,0]], "team": "blue"})"}));
  peer.Start("");
  ASSERT_TRUE(peer.AwaitVisible());
  ASSERT_TRUE(peer.Until([&] { return !paths.empty(); })) << peer.Output();
  ASSERT_TRUE(peer.Switch("SelfCheck"));
  ASSERT_TRUE(peer.Switch("Active"));
  ASSERT_TRUE(command.value()->Publish({"SEND"}));
  EXPECT_TRUE(peer.Until([&] { return !plans.empty(); })) << peer.Output();
  ASSERT_TRUE(peer.Switch("TearDown"));
  EXPECT_EQ(peer.AwaitExit(), 0) << peer.Output();
}

}  // namespace
}  // namespace musher::meilin::planner_process_test
