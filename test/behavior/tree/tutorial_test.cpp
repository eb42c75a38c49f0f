// The tree of docs/behavior-trees.md, whose code comes from here.

#include <fstream>
#include <iterator>

#include "musher/test/behavior/tree/trees.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::tree::tutorial_test {

struct Robot {
  double battery_percent = 80;
  double at_m = 0;
  double speed_mps = 0;
};

// [move]
class Move : public tree::StatefulAction {
 public:
  Move(tree::Setup& setup, Robot& robot)
      : goal_m_(setup.Input<double>("goal_m", "m along the corridor")),
        speed_mps_(setup.Input<double>("speed_mps", 0.5, "m/s")),
        driven_m_(setup.Output<double>("driven_m", "m so far")),
        robot_(robot) {}

  tree::Status OnStart(const tree::Tick& tick) override {
    start_m_ = robot_.at_m;
    return OnRunning(tick);
  }
  tree::Status OnRunning(const tree::Tick&) override {
    driven_m_.Set(robot_.at_m - start_m_);
    if (robot_.at_m >= goal_m_.Get()) {
      robot_.speed_mps = 0;
      return tree::Status::kSuccess;
    }
    robot_.speed_mps = speed_mps_.Get();
    return tree::Status::kRunning;
  }
  void OnHalted(const tree::Tick&) override { robot_.speed_mps = 0; }

 private:
  tree::InPort<double> goal_m_;
  tree::InPort<double> speed_mps_;
  tree::OutPort<double> driven_m_;
  Robot& robot_;
  double start_m_ = 0;
};
// [move end]

std::string DocumentXml() {
  std::ifstream file(SourceDir() + "/test/behavior/tree/patrol.xml");
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Tutorial, PatrolsAndStopsWhenTheBatteryIsLow) {
  Robot robot;
  Result<> added;
  // [factory]
  tree::Factory factory;
  added = factory.Add<Move>("Move", robot);
  added = factory.AddCondition("BatteryOk", [&robot](const tree::Tick&) {
    return robot.battery_percent > 20 ? tree::Status::kSuccess : tree::Status::kFailure;
  });
  // [factory end]
  ASSERT_TRUE(added);
  const std::string path = SourceDir() + "/test/behavior/tree/patrol.xml";
  // [load]
  const tree::Reading reading = tree::ReadTreeFile(path);
  const tree::Built built = tree::Build(reading.document, factory);
  for (const auto& diagnostics : {reading.diagnostics, built.diagnostics}) {
    for (const Diagnostic& each : diagnostics) ADD_FAILURE() << FormatDiagnostic(each);
  }
  // [load end]
  ASSERT_NE(built.tree, nullptr);
  tree::Tree& tree = *built.tree;
  const auto drive = [&](int from, int to) {
    for (int i = from; i < to; ++i) {
      // [tick]
      const Result<tree::Status> status = tree.TickOnce(At(20 * i));
      // [tick end]
      ASSERT_TRUE(status) << status.error().message;
      robot.at_m += robot.speed_mps * 0.02;
    }
  };
  drive(0, 100);
  EXPECT_EQ(robot.speed_mps, 0.4);
  EXPECT_NEAR(tree.board().Get<double>("driven").value(), 0.8, 0.02);
  robot.battery_percent = 10;
  drive(100, 101);
  EXPECT_EQ(robot.speed_mps, 0);
  EXPECT_EQ(tree.board().Get<std::string>("reason").value(), "battery");
}

// [substitute]
TEST(Patrol, CallsForHelpWhenTheWayIsBlocked) {
  tree::Factory factory;
  Robot robot;
  ASSERT_TRUE(factory.Add<Move>("Move", robot));
  ASSERT_TRUE(
      factory.AddCondition("BatteryOk", [](const auto&) { return tree::Status::kSuccess; }));
  factory.Substitute("*/there", {.result = tree::Status::kFailure, .delay = Milliseconds(500)});
  const auto tree = MakeTree(DocumentXml(), factory);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(tree->TickOnce(At(20 * i)));
  EXPECT_EQ(tree->board().Get<std::string>("reason").value(), "blocked");
}
// [substitute end]

}  // namespace musher::tree::tutorial_test
