#include "musher/modules/skills/skills/travel_skill.hpp"

#include <cmath>

namespace musher::skills {
namespace {

constexpr std::string_view kComplete = "complete";  // data: the task is done

}  // namespace

skill::Next TravelSkill::Cancel(skill::Tick& tick) {
  travel_.GiveUp();
  tick.Report(0, "Stopping");
  return tick.state == stopping_ ? skill::Next::Stay() : skill::Next::To(stopping_);
}

skill::Next TravelSkill::Complete(skill::Tick& tick) {
  tick.data.Set(kComplete, true);
  travel_.GiveUp();
  return skill::Next::To(stopping_);
}

skill::Next TravelSkill::Stop(skill::Tick& tick, const std::string& success) {
  if (!travel_.Stop(tick.step)) return skill::Next::Stay();
  if (tick.cancelling || !tick.data.Get(kComplete, false)) return skill::Next::Cancelled();
  return skill::Next::Succeed(success);
}

std::vector<navigation::Point> TravelSkill::Around(const navigation::Pose& pose,
                                                   double most_m) const {
  std::vector<navigation::Point> around;
  const double c = std::cos(pose.yaw_rad), s = std::sin(pose.yaw_rad);
  for (const navigation::Point& point : robot_.obstacles()) {
    const double x = point.x_m - pose.at.x_m, y = point.y_m - pose.at.y_m;
    if (std::hypot(x, y) > most_m) continue;
    around.push_back({c * x + s * y, c * y - s * x, 0});
  }
  return around;
}

void TravelSkill::OnEnd(const skill::Ended& /*ended*/) {
  travel_.End();
}

void TravelSkill::OnPause() {
  travel_.GiveUp();
  robot_.StopMotion();
}

}  // namespace musher::skills
