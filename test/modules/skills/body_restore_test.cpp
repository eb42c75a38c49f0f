// A skill that another process continues, from a snapshot after any of its steps: what was asked
// before is asked again, and what the hand has done meanwhile is not done twice.

#include <gtest/gtest.h>

#include "musher/test/modules/skills/fake_robot.hpp"

namespace musher::skills::body_restore_test {

using skill::Numbers;
using skill::Status;
using skill::Values;
using testing::Bench;

struct Case {
  std::string skill;
  Values parameters;
  bool held = false;  // the object, before
};

void Prepare(Bench& bench, const Case& executed) {
  bench.robot.camera_names = {"front"};
  bench.robot.body.at.z_m = executed.skill == "take_off" ? 0 : 0.5;
  bench.robot.seen = {{"box_red", "box", {{0.5, 0, 0}, 0}, executed.held ? "robot_0" : ""}};
  bench.Start(executed.skill, executed.parameters);
}

TEST(AnySkillOfTheBody, ContinuesInAnotherProcess) {
  const std::vector<Case> cases{{"take_off", {}},
                                {"hover", {{"altitude", 1.0}, {"duration", 1.0}}},
                                {"land", {}},
                                {"take_photo", {{"save_path", "a.png"}}},
                                {"object_detection", {}},
                                {"detect", {{"target_prim", "box_red"}}},
                                {"pick_up", {{"object_prim_path", "box_red"}}},
                                {"grasp", {{"object_prim_path", "box_red"}}},
                                {"put_down", {}, true},
                                {"place", {{"target_location", Numbers{1, 0, 0}}}, true}};
  for (const Case& executed : cases) {
    Bench whole("robot_0", "other");
    Prepare(whole, executed);
    int steps = 0;
    for (; whole.run().running(); ++steps) whole.Step();
    EXPECT_EQ(whole.feedback().status, Status::kCompleted) << executed.skill;
    for (int after = 1; after < steps; ++after) {
      Bench bench("robot_0", "other");
      Prepare(bench, executed);
      for (int i = 0; i < after; ++i) bench.Step();
      bench.robot.Advance(Milliseconds(100));  // what is on its way is done
      bench.Restore();
      EXPECT_EQ(bench.RunOut().status, Status::kCompleted)
          << executed.skill << " after " << after << ": " << bench.feedback().message;
      EXPECT_EQ(bench.robot.Held(), whole.robot.Held()) << executed.skill << " after " << after;
      EXPECT_EQ(bench.robot.files.size(), whole.robot.files.size());
    }
  }
}

}  // namespace musher::skills::body_restore_test
