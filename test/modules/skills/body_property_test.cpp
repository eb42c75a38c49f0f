// The skills of the body under random parameters, faults, cancellations and pauses: each run ends,
// and leaves the robot without a velocity command.

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <array>

#include "musher/test/modules/skills/fake_robot.hpp"

namespace musher::skills::body_property_test {

using skill::Numbers;
using skill::Values;
using testing::Bench;
using testing::Reply;

Values Parameters(const std::string& skill, double number) {
  if (skill == "take_off") return {{"altitude", number}};
  if (skill == "hover") return {{"altitude", number}, {"duration", number * 2}};
  if (skill == "land") return {{"ground_height", number / 10}};
  if (skill == "take_photo") return {{"save_path", "a.png"}};
  if (skill == "object_detection") return {{"radius", number}};
  if (skill == "detect") return {{"target_prim", "box_red"}};
  if (skill == "place") return {{"target_location", Numbers{number / 2, 0, 0}}};
  if (skill == "put_down") return {};
  if (skill == "assembly") return {{"station", "dock"}, {"distance", 0.3 + number / 10}};
  return {{"object_prim_path", "box_red"}, {"distance_threshold", number / 4}};
}

Reply AnyReply(std::uint64_t bits) {
  constexpr std::array<Reply, 6> kReplies{Reply::kGiven,     Reply::kGiven, Reply::kGiven,
                                          Reply::kAbandoned, Reply::kFails, Reply::kNever};
  return kReplies[bits % kReplies.size()];
}

// One random event of the world or of the caller.
void Disturb(Bench& bench, const std::string& skill, int event, std::uint64_t bits) {
  testing::FakeRobot& robot = bench.robot;
  const double number = static_cast<double>(bits % 21) / 10 - 1;
  switch (event) {
    case 0:
      robot.has_odometry = !robot.has_odometry;
      return;
    case 1:
      robot.has_objects = !robot.has_objects;
      robot.has_detector = bits % 2 == 0;
      return;
    case 2:
      robot.wind = {number / 2, -number / 3, number / 4, 0};
      return;
    case 3:
      robot.seen[0].pose.at.x_m += number;
      return;
    case 4:
      robot.seen[0].held_by = bits % 2 == 0 ? "" : robot.name();
      return;
    case 5:
      robot.camera_replies = robot.file_replies = AnyReply(bits);
      robot.hand_replies = [bits](const HandRequest& request) {
        return AnyReply(bits >> static_cast<unsigned>(request.action));
      };
      return;
    case 6:
      robot.scan = {{number, 0, 0}};
      return;
    case 7:
      static_cast<void>(bench.manager().Cancel(skill, "random").ok());
      return;
    case 8:
      static_cast<void>(bench.manager().CancelNow(skill, "random").ok());
      return;
    case 9:
      robot.body.at.x_m = bits % 2 == 0 ? std::nan("") : 0;
      return;
    default:
      bench.manager().Pause();
      RC_ASSERT(robot.command == navigation::Velocity{});
  }
}

RC_GTEST_PROP(AnySkillOfTheBody, EndsWithoutAVelocityCommand, ()) {
  const auto kind = *rc::gen::element<std::string>("jetbot", "cf2x", "other");
  Bench bench("robot_0", kind);
  bench.robot.camera_names = {"front"};
  const bool held = *rc::gen::arbitrary<bool>();
  bench.robot.seen = {{"box_red", "box", {{1, 0, 0}, 0}, held ? "robot_0" : ""},
                      {"dock", "station", {{1.5, 0.5, 0.1}, 0}, ""}};
  bench.robot.body.at.z_m = *rc::gen::element(0.0, 1.0, 3.0);
  const auto skill = *rc::gen::elementOf(bench.manager().Names());
  bench.Start(skill, Parameters(skill, *rc::gen::inRange(-10, 60) / 10.0));
  const auto events = *rc::gen::container<std::vector<std::pair<int, std::uint64_t>>>(
      rc::gen::pair(rc::gen::inRange(-10, 11), rc::gen::arbitrary<std::uint64_t>()));
  for (const auto& [event, bits] : events) {
    if (event >= 0) Disturb(bench, skill, event, bits);
    bench.Step();
    if (!bench.run().running()) RC_ASSERT(bench.robot.command == navigation::Velocity{});
  }
  for (int i = 0; i < 1200 && bench.run().running(); ++i) bench.Step();
  RC_ASSERT(bench.run().ended());
  RC_ASSERT(bench.robot.command == navigation::Velocity{});
  RC_ASSERT(!bench.feedback().message.empty());
  if (kind == "jetbot" && skill == "take_off") RC_ASSERT(bench.feedback().progress < 100);
}

// A flight that is called off at any time neither falls nor flies on.
RC_GTEST_PROP(AnyFlight, HoversAfterItsEnd, ()) {
  Bench bench("cf2x_0", "cf2x");
  bench.robot.body.at.z_m = 3;
  const auto skill = *rc::gen::element<std::string>("take_off", "hover", "land");
  bench.Start(skill, skill == "land" ? Values{} : Values{{"altitude", 5.0}});
  bench.StepFor(*rc::gen::inRange(0, 50) / 10.0);
  if (*rc::gen::arbitrary<bool>()) {
    static_cast<void>(bench.manager().Cancel(skill, "random").ok());
  } else {
    static_cast<void>(bench.manager().CancelNow(skill, "random").ok());
  }
  bench.Step();
  RC_ASSERT(bench.run().ended());
  bench.StepFor(1);
  const navigation::Point there = bench.robot.body.at;
  bench.StepFor(10);
  RC_ASSERT(navigation::Distance(there, bench.robot.body.at) < 0.01);
}

}  // namespace musher::skills::body_property_test
