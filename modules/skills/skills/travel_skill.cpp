#include "musher/modules/skills/skills/travel_skill.hpp"

#include <fmt/format.h>

namespace musher::skills {
namespace {

// The data of a run.
constexpr std::string_view kComplete = "complete";    // the task is done
constexpr std::string_view kLost = "lost";            // what it waits for
constexpr std::string_view kLostSince = "lost_at_s";  // of run time
constexpr std::string_view kAttempted =
    "attempted";  // an attempt has failed: the next one is later

void SetLost(skill::Tick& tick, const std::string& why) {
  tick.data.Set(kLost, why);
  if (tick.data.Find(kLostSince) == nullptr) tick.data.Set(kLostSince, ToSeconds(tick.now));
}

double LostForS(const skill::Tick& tick) {
  return ToSeconds(tick.now) - tick.data.Get<double>(kLostSince, ToSeconds(tick.now));
}

skill::Next FailLost(const skill::Tick& tick, const std::string& prefix, const std::string& why) {
  return skill::Next::Fail(prefix + why + fmt::format(", waited for {:.0f} s", LostForS(tick)));
}

}  // namespace

void TravelSkill::DeclareLostLimit(skill::Table& table) {
  table.Takes("lost_limit", 20.0,
              "s at a stand without map, planner, controller, odometry or scan, then it fails");
}

Result<> TravelSkill::CheckLostLimit(const skill::Values& parameters) {
  const double limit_s = parameters.Number("lost_limit");
  if (limit_s >= 0) return Ok();
  return Error{kCodeParametersInvalid,
               fmt::format("lost_limit is {:g}; expected 0 or more seconds", limit_s)};
}

std::optional<skill::Next> TravelSkill::WaitForParts(skill::Tick& tick, double progress,
                                                     const std::string& prefix,
                                                     const std::string& doing) {
  constexpr double kSaidAfterS = 1;
  const TravelStep step = travel_.Reach();
  const bool reached = step.kind == TravelStep::Kind::kDone;
  const bool later = tick.data.Get(kAttempted, false) && tick.elapsed < kServerWait;
  if (!reached) SetLost(tick, step.why);
  tick.Report(progress, prefix + doing);
  if (reached && !later) {
    tick.data.Remove(kAttempted);
    return std::nullopt;
  }
  const double limit_s = tick.parameters.Number("lost_limit");
  if (LostForS(tick) >= limit_s) return FailLost(tick, prefix, WhyLost(tick));
  if (later || LostForS(tick) >= kSaidAfterS) {
    tick.Report(progress, prefix + fmt::format("Waiting ({:.0f} of {:.0f} s): {}", LostForS(tick),
                                               limit_s, WhyLost(tick)));
  }
  return skill::Next::Stay();
}

skill::Next TravelSkill::AfterLoss(skill::Tick& tick, const std::string& prefix,
                                   const std::string& why) {
  SetLost(tick, why);
  if (LostForS(tick) >= tick.parameters.Number("lost_limit")) return FailLost(tick, prefix, why);
  tick.data.Set(kAttempted, true);
  return skill::Next::Replan(initializing_, prefix + why);
}

void TravelSkill::NoteDriving(skill::Tick& tick) const {
  if (tick.data.Find(kLostSince) == nullptr) return;
  if (tick.elapsed <= kLostAfter || travel_.Reach().kind != TravelStep::Kind::kDone) return;
  tick.data.Remove(kLost);
  tick.data.Remove(kLostSince);
}

std::string TravelSkill::WhyLost(const skill::Tick& tick) const {
  const TravelStep step = travel_.Reach();
  return step.kind == TravelStep::Kind::kDone ? tick.data.Text(kLost) : step.why;
}

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

void TravelSkill::OnEnd(const skill::Ended& ended) {
  if (ended.paused) return;  // its drive is given up, and the base may be another skill's
  travel_.End();
}

void TravelSkill::OnPause() {
  was_paused_ = true;
  travel_.GiveUp();
  robot_.StopMotion();
}

Result<> TravelSkill::MayResume() {
  const auto pose = robot_.pose();
  if (!pose) return Ok();
  if (Result<> flies = CheckInTheAir(robot_, pose->at.z_m); !flies) return flies;
  const std::string why = robot_.WhyNotHeld();
  return why.empty() ? Ok() : Result<>(Error{kCodeStateInvalid, why});
}

Result<> TravelSkill::CheckAfterPause() {
  if (!was_paused_ || !robot_.pose()) return Ok();
  was_paused_ = false;
  return MayResume();
}

}  // namespace musher::skills
