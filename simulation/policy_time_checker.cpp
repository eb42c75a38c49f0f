#include "musher/simulation/policy_time_checker.hpp"

#include <algorithm>

namespace musher::simulation {
namespace {

// A step of /clock that is longer is a jump.
constexpr Duration kLongestStep = std::chrono::seconds(10);
// A controller has received what was published so long before, on links without faults.
constexpr Duration kClockLag = Milliseconds(250);

}  // namespace

// Jumps do not count; of two in a row, the second one does.
void PolicyTimeChecker::OnClock(Time time) {
  const Time now = robot_.network().now();
  const Duration step = clock_ ? time - *clock_ : Duration::zero();
  const bool counts =
      step > Duration::zero() && (step <= kLongestStep || clock_step_ > kLongestStep);
  if (counts) clock_passed_ += step;
  clock_step_ = step;
  clock_ = time;
  clock_samples_.emplace_back(now, clock_passed_);
  while (clock_samples_.size() > 1 && clock_samples_[1].first <= now - kClockLag) {
    clock_samples_.pop_front();
  }
}

Duration PolicyTimeChecker::PolicyTime() const {
  const bool by_topic = config_.clock == ClockSource::kTopic;
  return by_topic ? clock_passed_ : robot_.network().now().time_since_epoch();
}

// The last samples of /clock may be on their way to the controller.
PolicyTimeChecker::Mark PolicyTimeChecker::MarkNow() const {
  const Time now = robot_.network().now();
  if (config_.clock == ClockSource::kSteady) return {now, now.time_since_epoch(), now};
  Mark mark{now, {}, now};
  for (const auto& [at, by_clock] : clock_samples_) {
    const bool first = at == clock_samples_.front().first;
    if (first || at <= now - kClockLag) mark = {now, by_clock, at};
  }
  return mark;
}

void PolicyTimeChecker::OnMotion(std::int32_t motion) {
  if (!config_.policy || !config_.policy->low_power) return;
  const std::vector<std::int32_t>& ids = config_.policy->low_power->motion_ids;
  if (std::ranges::find(ids, motion) != ids.end()) {
    if (!still_) still_ = MarkNow();
    return;
  }
  if (!still_) return;
  if (!JustMoved()) still_before_ = still_;
  moved_at_ = robot_.network().now();
  still_.reset();
}

// A controller may not have received that it moves.
bool PolicyTimeChecker::JustMoved() const {
  return moved_at_ && robot_.network().now() - *moved_at_ <= kClockLag;
}

void PolicyTimeChecker::NotePolicyTimes(const SimulatedController& controller) {
  Seen& seen = seen_[controller.serial()];
  const Machine& machine = controller.shell().machine();
  const bool awake = machine.state == kActive || machine.state == kProtected;
  const auto& keep = machine.policy.keep;
  if (!awake || keep) {
    seen.awake.reset();
  } else if (!seen.awake) {
    seen.awake = MarkNow();
  }
  if (!keep) {
    seen.kept.reset();
  } else if (!seen.kept) {
    seen.kept = MarkNow();
    seen.kept_for_s = keep->seconds;
  }
}

// nullopt: one of them is not so.
std::optional<PolicyTimeChecker::Mark> PolicyTimeChecker::LaterOf(const std::optional<Mark>& a,
                                                                  const std::optional<Mark>& b) {
  if (!a || !b) return std::nullopt;
  return a->at < b->at ? b : a;
}

// What the policy does by time. The state before is as it was seen after the step before.
void PolicyTimeChecker::CheckPolicyTime(const SimulatedController& controller,
                                        const action::Record& record) {
  const Seen& seen = seen_[controller.serial()];
  switch (record.event) {
    case EventName::kLyingStillSwitch:
      return CheckWaited(controller, LaterOf(seen.awake, JustMoved() ? still_before_ : still_),
                         config_.policy->low_power->lying_still, "takes the machine to LowPower");
    case EventName::kKeepEnded:
      if (ArgumentOf(record.arguments, "reason") != "time expired") return;
      return CheckWaited(controller, seen.kept, std::chrono::seconds(seen.kept_for_s),
                         "ends what keeps the machine");
    default:
      return;
  }
}

void PolicyTimeChecker::CheckWaited(const SimulatedController& controller,
                                    const std::optional<Mark>& since, Duration limit,
                                    const std::string& what) {
  const Time now = robot_.network().now();
  // What a controller has received late, or not at all, it times by itself. The sample before a
  // pause of /clock is long ago.
  const Time from = since ? std::min(since->at, since->sampled) - std::chrono::seconds(1) : now;
  const bool late = (context_.link_faults_until && *context_.link_faults_until >= from) ||
                    controller.frozen || (controller.thawed && *controller.thawed >= from);
  if (late) return;
  const Duration waited = since ? PolicyTime() - since->by_clock : Duration::zero();
  if (waited + Milliseconds(1) >= limit) return;
  ReportViolation(Invariant::kNotBeforeItsTime,
                  "the policy " + what + " after " + std::to_string(ToMilliseconds(waited)) +
                      " of " + std::to_string(ToMilliseconds(limit)) + " ms by its clock");
}

}  // namespace musher::simulation
