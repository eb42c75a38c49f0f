// One command to one actuator, with a certain outcome.

#include <algorithm>
#include <utility>

#include "musher/lifecycle/decision.hpp"

namespace musher {

// Takes a newer report over. What ended without an order of ours (one that was overdue, one of the
// controller before) may have led anywhere.
void Decision::Accept(std::size_t i, const ActuatorReport& report) {
  ActuatorRecord& record = Of(i);
  // That it was busy may not have been heard.
  const bool was_busy =
      record.report.busy() || (report.incarnation == record.report.incarnation &&
                               report.outcome_number != record.report.outcome_number);
  const bool came_free = was_busy && !report.busy() && !record.order;
  if (!report.busy()) record.free_by.reset();
  // In the run phase a check leaves the state as it is.
  const bool passed_late = (report.state == kSelfCheck && record.report.state != kSelfCheck) ||
                           (record.report.target == kSelfCheck && report.outcome_code == kCodeOk);
  if (came_free && passed_late) record.checked = true;
  if (came_free && record.checked && !record.held) record.due = true;
  // A report that was held up on the way would make commands look older than they are. Once in a
  // while a new one counts all the same: clocks drift.
  const bool other_process = record.report.incarnation != report.incarnation;
  const bool came_faster = report.stamp - now_ >= record.clock_theirs - record.clock_ours;
  if (other_process || came_faster || now_ - record.clock_ours > kClockGoodFor) {
    record.clock_theirs = report.stamp;
    record.clock_ours = now_;
  }
  const bool moved = !other_process && record.presence == Presence::kPresent && !record.order &&
                     report.state != record.report.state &&
                     report.outcome_number == record.report.outcome_number;
  record.report = report;
  if (moved) Drifted(i);
  if (came_free && !record.checked && report.outcome_code != kCodeOk) {
    Degrade(i, report.outcome_code, "it failed late: " + report.outcome_message);
  }
  HoldTo(report, i);
  if (report.number < kLastNumber) machine_.number = std::max(machine_.number, report.number);
}

// It is somewhere else than where it was sent, without having been told to.
void Decision::Drifted(std::size_t i) {
  ActuatorRecord& record = Of(i);
  if (!record.checked) record.join_tried = false;  // it may have been configured by hand
  const bool told = record.report.outcome_code == kCodeOk;
  record.cause = RecordActuator(i, kCodeStatusError,
                                ConfigOf(i).name + " has gone to " + record.state() + " by itself" +
                                    (told ? "" : ": " + record.report.outcome_message));
  if (!record.held && MayFollow(i)) record.due = true;
}

void Decision::On(const event::Replied& replied) {
  ActuatorRecord& record = Of(replied.actuator);
  if (replied.report.incarnation != record.report.incarnation) return;
  if (replied.report.stamp >= record.report.stamp) Accept(replied.actuator, replied.report);
  const bool denied = replied.verdict == Verdict::kRefused && replied.code == kCodePermissionDenied;
  if (replied.ask && denied && replied.report.epoch > machine_.epoch)
    return TakeControl(replied.actuator);
  if (replied.ask && denied && record.take_control_again) {
    record.take_control_again = now_ + kIntroductionPeriod;  // it has not heard yet who we are
  }
  if (replied.ask && replied.verdict == Verdict::kDone && record.take_control_again) {
    Follow(replied.actuator);
  }
  if (!record.order || record.order->number != replied.number) return;
  if (replied.ask && record.order->asked == 0) return;  // a claim, not the question
  if (replied.ask)
    return EndOrder(replied.actuator, EvaluateReport(replied.actuator, *record.order));
  switch (replied.verdict) {
    case Verdict::kDone:
      return EndOrder(replied.actuator, DoneUnlessLie(replied.actuator, replied.message));
    case Verdict::kRefused:
      return EndOrder(replied.actuator, {record.order->asked > 0 ? ActuatorOutcome::kOverdue
                                                                 : ActuatorOutcome::kRefused,
                                         replied.code, replied.message, false});
    case Verdict::kFailed:
      return EndOrder(replied.actuator,
                      {ActuatorOutcome::kFailed, replied.code, replied.message, true});
  }
}

// It says that the order is done; its own status may contradict that.
OrderEnd Decision::DoneUnlessLie(std::size_t i, const std::string& message) const {
  const ActuatorRecord& record = Of(i);
  const State& target = record.order->target;
  if (target == kSelfCheck && record.report.degraded_code != kCodeOk) {
    return {ActuatorOutcome::kDone, record.report.degraded_code,
            "degraded: " + record.report.degraded_reason, true};
  }
  if (target == kSelfCheck || record.state() == target) {
    return {ActuatorOutcome::kDone, kCodeOk, message, true};
  }
  return {ActuatorOutcome::kFailed, kCodeStatusError,
          "it says that it is done, and also that it is in " + record.state().substr(0, 64), true};
}

void Decision::Issue(std::size_t i, std::uint64_t number, const State& target, Duration budget,
                     bool apart) {
  machine_.number = std::max(machine_.number, number);
  Of(i).order = Order{number, target, now_, now_ + budget, 0};
  if (target == kSelfCheck) Of(i).join_tried = true;
  Do(action::SendSwitch{i, number, target, budget, apart});
}

// What the latched status of an asked actuator says about the order.
OrderEnd Decision::EvaluateReport(std::size_t i, const Order& order) const {
  const ActuatorReport& report = Of(i).report;
  const std::string time = std::to_string(ToMilliseconds(now_ - order.sent)) + " ms";
  if (report.outcome_number == order.number) {
    if (report.outcome_code == kCodeOk) return DoneUnlessLie(i, "");
    return {ActuatorOutcome::kFailed, report.outcome_code, report.outcome_message, true};
  }
  if (report.busy_number == order.number) {
    return {ActuatorOutcome::kOverdue, kCodeTimeout,
            "still busy with " + order.target + " after " + time, true};
  }
  return {ActuatorOutcome::kOverdue, kCodeTimeout,
          "had not begun " + order.target + " after " + time, false};
}

void Decision::AskOrLose(std::size_t i) {
  Order& order = *Of(i).order;
  if (order.asked >= kAskAttempts) {
    return LoseSight(i, "it does not answer, not even when asked how " + order.target + " stands",
                     Of(i).cause);
  }
  if (order.asked == 0) {
    const std::string next = ConfigOf(i).protocol == Protocol::kCyberdog
                                 ? "; by its protocol it cannot be asked how " + order.target +
                                       " stands, so its state is unknown until it answers"
                                 : "; it is asked how " + order.target + " stands";
    Of(i).cause = RecordActuator(i, kCodeTimeout,
                                 ConfigOf(i).name + " did not answer within " +
                                     std::to_string(ToMilliseconds(order.deadline - order.sent)) +
                                     " ms" + next,
                                 machine_.current ? machine_.current->cause : Of(i).cause);
  }
  ++order.asked;
  order.deadline = now_ + kAskTimeout;
  Do(action::SendAsk{i, order.number, true});
}

void Decision::CheckOrders() {
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    ActuatorRecord& record = Of(i);
    if (record.order && record.order->deadline <= now_) AskOrLose(i);
    if (record.take_control_again && *record.take_control_again <= now_) TakeControl(i);
    if (record.free_by && *record.free_by <= now_) EvaluateFoundBusy(i);
  }
}

// What it was found busy with, or what was superseded, has its time, too.
void Decision::EvaluateFoundBusy(std::size_t i) {
  ActuatorRecord& record = Of(i);
  record.free_by.reset();
  if (!record.report.busy() || record.order || record.presence != Presence::kPresent) return;
  const State& target = record.report.target;
  Degrade(i, kCodeTimeout,
          "still busy with " + target + ", for which nobody waits, after " +
              std::to_string(ToMilliseconds(config_.TimeFor(i, target))) + " ms");
  Do(action::SendAsk{i, record.report.number, true});
  Fall(i);
}

void Decision::EndOrder(std::size_t i, const OrderEnd& given) {
  const Order order = *Of(i).order;
  const OrderEnd end = Tolerate(i, order, given);
  const std::string took = std::to_string(ToMilliseconds(now_ - order.sent)) + " ms";
  const std::uint64_t cause = end.cause != 0                         ? end.cause
                              : machine_.current && order.asked == 0 ? machine_.current->cause
                                                                     : Of(i).cause;
  const std::uint64_t told = RecordActuator(
      i, end.code,
      ConfigOf(i).name + ": " + order.target + " " + std::string(OutcomeName(end.outcome)) +
          " after " + took + (end.message.empty() ? "" : ": " + end.message),
      cause);
  if (end.outcome != ActuatorOutcome::kDone) Of(i).cause = told;
  Of(i).order.reset();
  if (end.outcome == ActuatorOutcome::kDone) {
    // A ROS 2 node that has got to a state has been configured, and answers.
    const bool configured =
        ConfigOf(i).protocol == Protocol::kRos2Lifecycle && config_.RankOf(order.target);
    if (order.target == kSelfCheck || configured) Of(i).checked = true;
    // A check that failed stays on record until one passes, a hang until it ends; one that is torn
    // down has nothing left to do well.
    const bool well = Of(i).checked && Of(i).health != Health::kHung && !Of(i).parked;
    if (well || order.target == kTearDown) Of(i).fault.reset();
  }
  // Driven on once it is free, unless it is a check that is still out.
  if (end.outcome == ActuatorOutcome::kOverdue && order.target != kSelfCheck) Of(i).due = true;
  if (Leg* leg = LegUnderWay(i)) {
    EndLeg(*leg, end);
  } else {
    EndJoin(i, order, end);
  }
  // Of one that cannot be asked nothing is known any more, but for a new start.
  const bool unknown = ConfigOf(i).protocol == Protocol::kCyberdog &&
                       end.outcome == ActuatorOutcome::kOverdue &&
                       machine_.phase != Phase::kStopping;
  if (unknown && MayRestart(i) && ProcessOf(i) != 0) {
    Hang(i, true, "hung: in " + order.target + " for " + took + ", and it cannot be asked");
  }
}

// The part of the switch under way that waits for this actuator; null when there is none.
Leg* Decision::LegUnderWay(std::size_t i) {
  if (!machine_.current) return nullptr;
  Switch& s = *machine_.current;
  std::vector<Leg>& legs = s.rolling_back ? s.back : s.legs;
  const auto found = std::find_if(legs.begin(), legs.end(), [i](const Leg& leg) {
    return leg.actuator == i && leg.progress == Leg::Progress::kUnderWay;
  });
  return found == legs.end() ? nullptr : &*found;
}

void Decision::Lose(std::size_t i, const std::string& how, std::uint64_t cause, std::int32_t code) {
  ActuatorRecord& record = Of(i);
  const bool torn_down = record.state() == kTearDown;
  const bool had_answered = record.presence == Presence::kPresent;
  if (record.order) EndOrder(i, {ActuatorOutcome::kLost, code, how, true, cause});
  record.presence = Presence::kLost;
  record.take_control_again.reset();
  record.checked = false;
  record.held = record.held && torn_down;  // who was torn down alone stays set apart
  record.due = false;
  record.healthy_at.reset();
  record.outbid_at.reset();
  record.free_by.reset();
  record.report.target.clear();
  record.report.busy_number = 0;
  if (machine_.phase == Phase::kStopping) return;
  if (torn_down) {
    return Degrade(i, kCodeStateInvalid, kTornDownAlone, cause);
  }
  // Why its SetUp failed says more than that its process is gone.
  if (!record.fault || had_answered) Degrade(i, code, how, cause);
}

// Nothing reaches it any more. What a process of ours came to will be found out: if it has ended or
// hangs, it is restarted.
void Decision::LoseSight(std::size_t i, const std::string& how, std::uint64_t cause) {
  Lose(i, how, cause);
  if (!MayRestart(i) || ProcessOf(i) == 0) Fall(i);
}

// The end of a process can overtake its last word.
void Decision::TakeForTornDown(std::size_t i) {
  if (!Of(i).order || Of(i).order->target != kTearDown) return;
  Of(i).report.state = State(kTearDown);
  Of(i).report.apart = true;  // while the machine goes on, it was told alone
  EndOrder(i, {ActuatorOutcome::kDone, kCodeOk, "", true});
}

void Decision::On(const event::Vanished& vanished) {
  ActuatorRecord& record = Of(vanished.actuator);
  if (record.other && record.other->incarnation == vanished.incarnation) record.other.reset();
  if (record.report.incarnation != vanished.incarnation) return;
  if (record.dead == vanished.incarnation) return;  // its successor may be starting already
  const bool was_there =
      record.presence == Presence::kPresent || record.presence == Presence::kStarting;
  if (!vanished.for_good) {
    if (was_there) LoseSight(vanished.actuator, vanished.how);
    return;
  }
  record.dead = vanished.incarnation;
  TakeForTornDown(vanished.actuator);
  if (record.health != Health::kHung) record.health = Health::kCrashed;
  if (was_there) Lose(vanished.actuator, "crashed: " + vanished.how);
  if (record.restart_at || record.given_up) return;  // what we had started it with ended before
  if (record.process != 0) return Terminate(vanished.actuator, record.process, kEndTime);
  Recover(vanished.actuator);
}

}  // namespace musher
