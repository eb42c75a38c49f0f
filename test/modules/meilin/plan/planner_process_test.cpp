// musher-meilin-planner as a controller and a web page use it: the real program over DDS.

#include <optional>

#include "musher/messages/std_msgs/multi_array.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/modules/module_process.hpp"

namespace musher::meilin::planner_process_test {

class PlannerProcess : public test::ModuleProcess {
 protected:
  PlannerProcess()
      : ModuleProcess("meilin_planner", "musher-meilin-planner",
                      {"SetUp", "TearDown", "SelfCheck", "Active"}) {}
};

TEST_F(PlannerProcess, SendsAPlanOnCommandInActive) {
  std::optional<msg::Float32MultiArray> plan;
  std::optional<msg::String> paths;
  Listen("mf_action_seq", plan, transport::kLatchedQos);
  Listen("planning/paths_for_web", paths, transport::kLatchedQos);
  const auto map = Publisher<msg::String>("mf_r2_data", transport::kLatchedQos);
  const auto command = Publisher<msg::String>("planning/command", transport::kLatchedQos);
  ASSERT_TRUE(map->Publish(
      {R"({"grid": [[0,0,0],[0,2,0],[0,0,1],[2,0,0],[0,0,0],[0,0,0]], "team": "blue"})"}));
  Start("");
  ASSERT_TRUE(peer_.Until([&] { return paths && !paths->data.empty(); })) << peer_.Output();
  ExpectDone("SelfCheck");
  ExpectDone("Active");
  ASSERT_TRUE(command->Publish({"SEND"}));
  EXPECT_TRUE(peer_.Until([&] { return plan.has_value(); })) << peer_.Output();
  ExpectTornDown();
}

}  // namespace musher::meilin::planner_process_test
