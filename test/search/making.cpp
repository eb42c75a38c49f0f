// What a choice does, and what is put away after it.

#include <algorithm>
#include <utility>

#include "musher/test/search/harness.hpp"

namespace musher::search {
namespace {

constexpr std::int32_t kFailure = 3001;

// But for the emergency stop.
bool SaysTheSame(const ActuatorReport& a, const ActuatorReport& b) {
  return a.incarnation == b.incarnation && a.state == b.state && a.target == b.target &&
         a.busy_number == b.busy_number && a.epoch == b.epoch && a.number == b.number &&
         a.outcome_number == b.outcome_number && a.outcome_code == b.outcome_code &&
         a.apart == b.apart;
}

// Once it has heard of the stop, that an actuator has latched it is no news to the controller.
bool StopIsKnown(const World& world, const ActuatorReport& report) {
  return report.emergency_stop == 0 || world.machine.emergency_stop;
}

// Whether the controller knows already what the latch would tell it.
bool TellsNothing(const World& world, const ActuatorRecord& record, const ActuatorReport& report) {
  return StopIsKnown(world, report) && record.presence == Presence::kPresent &&
         SaysTheSame(record.report, report);
}

// Whether the controller waits for the end of the command that it is about, which brings a newer
// report, and nothing else can come between.
bool IsWaitedFor(const World& world, const ActuatorRecord& record, const ActuatorReport& report) {
  return world.faults_left == 0 && record.presence == Presence::kPresent && record.order &&
         record.order->number == report.number && record.order->number != report.outcome_number &&
         record.report.incarnation == report.incarnation && record.report.epoch == report.epoch &&
         StopIsKnown(world, report);
}

// Whether nobody waits for this reply any more, and the latch tells as much.
bool IsOver(const World& world, const Actor& actor, const ActuatorRecord& record,
            const event::Replied& reply) {
  const bool waited =
      (record.order && record.order->number == reply.number) || record.take_control_again;
  const bool told = actor.status_due && SaysTheSame(actor.core.report, reply.report) &&
                    actor.core.report.emergency_stop == reply.report.emergency_stop;
  return !waited && record.presence == Presence::kPresent &&
         (told || TellsNothing(world, record, reply.report));
}

// What nobody waits for is put away, so that nodes which differ by it alone are one.
void Tidy(Harness& harness) {
  World& world = harness.world();
  if (world.faults_left == 0) {
    for (const Message& message : std::exchange(world.outbox, {})) harness.Deliver(message, false);
  }
  const bool stopped = world.machine.phase == Phase::kStopped;
  for (std::size_t i = 0; i < kActuators; ++i) {
    Actor& actor = world.actors[i];
    const ActuatorRecord& record = world.machine.actuators[i];
    const ActuatorReport& report = actor.core.report;
    std::erase_if(actor.replies,
                  [&](const auto& reply) { return IsOver(world, actor, record, reply); });
    if (TellsNothing(world, record, report) || IsWaitedFor(world, record, report)) {
      actor.status_due = false;
    }
    if (!stopped) continue;
    actor.status_due = false;
    actor.replies.clear();
    actor.end.reset();
    std::erase_if(actor.late, FromActuator);
  }
}

class Making {
 public:
  Making(Harness& harness, const Choice& choice)
      : harness_(harness), world_(harness.world()), choice_(choice), i_(choice.actuator) {}

  void Make() {
    world_.faults_left -= choice_.cost;
    if (choice_.deed == Deed::kTime) return PassTime();
    if (choice_.deed == Deed::kLate) return TakeLate();
    if (choice_.deed >= Deed::kEndFailed && choice_.deed <= Deed::kEndCrash) return End();
    if (choice_.deed >= Deed::kReplyLost && choice_.deed <= Deed::kReplyDoubled) return Reply();
    if (choice_.deed >= Deed::kStatusLost && choice_.deed <= Deed::kStatusDoubled) return Status();
    if (choice_.deed >= Deed::kLose && choice_.deed <= Deed::kUnheard) return Sent();
    Simple();
  }

 private:
  Actor& actor() { return world_.actors[i_]; }
  std::string name() const { return harness_.Name(i_); }
  State target() { return actor().core.report.target; }

  void Simple() {
    switch (choice_.deed) {
      case Deed::kAsk:
        world_.at_start = false;
        return harness_.Ask(harness_.Wanted());
      case Deed::kDeliver:
        return Sent();
      case Deed::kEndOk:
      case Deed::kEndAsked:
      case Deed::kEndFirst:
        return End();
      case Deed::kReply:
        return Reply();
      case Deed::kStatus:
        return Status();
      case Deed::kEnd:
        harness_.Say("the end of " + name() + "'s process is heard of");
        return harness_.TellEnd(i_);
      case Deed::kSeeStop:
        harness_.Say("the controller hears of the emergency stop");
        world_.stop_seen_due = false;
        return harness_.Tell(event::EmergencyStopSeen{{5, "somebody", ""}});
      case Deed::kCrash:
        harness_.Say("FAULT: " + name() + " crashes");
        return harness_.Crash(i_);
      case Deed::kRestart:
        harness_.Say("FAULT: the controller dies, and another takes over");
        return harness_.RestartController();
      case Deed::kAskError:
        harness_.Say("CROSSED by a more urgent request");
        return harness_.Ask(State(kError));
      case Deed::kAskTearDown:
        harness_.Say("CROSSED by a more urgent request");
        return harness_.Ask(State(kTearDown));
      case Deed::kEngageStopLate:
        harness_.Say("CROSSED by an emergency stop; FAULT: held back: what tells " + name());
        actor().late.emplace_back(StopMessage{});
        return harness_.EngageStop(i_);
      default:
        harness_.Say("CROSSED by an emergency stop");
        return harness_.EngageStop();
    }
  }

  void PassTime() {
    const Time next = *NextDeadline(harness_.config(), world_.machine);
    harness_.Say(std::to_string(ToMilliseconds(next - world_.now)) + " ms pass");
    world_.now = std::max(world_.now, next);
    for (std::size_t k = 0; k < kActuators; ++k) {
      if (world_.actors[k].work != Work::kRunning) continue;
      harness_.Say("FAULT: " + harness_.Name(k) + "'s callback is overdue");
      world_.actors[k].work = Work::kOverdue;
    }
    harness_.Tell(event::TimePassed{});
  }

  void TakeLate() {
    const Late late = actor().late[choice_.index];
    actor().late.erase(actor().late.begin() + choice_.index);
    harness_.Say("what was held back comes: " + Text(late));
    if (const auto* message = std::get_if<Message>(&late)) return harness_.Deliver(*message, true);
    if (const auto* reply = std::get_if<event::Replied>(&late)) return harness_.Tell(*reply);
    if (const auto* seen = std::get_if<event::StatusSeen>(&late)) return harness_.Tell(*seen);
    harness_.HearStop(i_);
  }

  std::string Text(const Late& late) const {
    if (const auto* message = std::get_if<Message>(&late)) return Text(*message);
    if (const auto* reply = std::get_if<event::Replied>(&late)) return Text(*reply);
    if (std::holds_alternative<StopMessage>(late)) return name() + " is told of the emergency stop";
    return name() + "'s status, " + std::get<event::StatusSeen>(late).report.state;
  }
  std::string Text(const Message& message) const {
    if (const auto* command = std::get_if<SwitchCommand>(&message.what)) {
      return "command " + std::to_string(command->number) + " to " + harness_.Name(message.to) +
             ", " + command->target;
    }
    return "the question to " + harness_.Name(message.to) + " about " +
           std::to_string(std::get<AskCommand>(message.what).number);
  }
  std::string Text(const event::Replied& reply) const {
    return name() + "'s reply to " + (reply.ask ? "the question about " : "") +
           std::to_string(reply.number);
  }

  void Sent() {
    const Message message = world_.outbox.front();
    world_.outbox.erase(world_.outbox.begin());
    switch (choice_.deed) {
      case Deed::kLose:
        return harness_.Say("FAULT: lost: " + Text(message));
      case Deed::kHold:
        actor().late.emplace_back(message);
        return harness_.Say("FAULT: held back: " + Text(message));
      case Deed::kDouble:
        actor().late.emplace_back(message);
        harness_.Say("FAULT: comes twice: " + Text(message));
        return harness_.Deliver(message, false);
      case Deed::kUnheard:
        harness_.Say("FAULT: before the controller was heard of: " + Text(message));
        return harness_.Deliver(message, false, false);
      default:
        harness_.Say(Text(message));
        return harness_.Deliver(message, false);
    }
  }

  void End() {
    const bool failed = choice_.deed == Deed::kEndFailed;
    const bool asked = choice_.deed == Deed::kEndAsked;
    const bool overtaken = !actor().replies.empty();
    harness_.Say((failed ? "FAULT: " : "") + name() + "'s callback of " + target() +
                 (failed  ? " fails"
                  : asked ? " ends because it was asked to stop"
                          : " ends"));
    harness_.EndCallback(i_, failed || asked ? kFailure : 0, asked ? "asked to stop" : "");
    if (choice_.deed == Deed::kEndCrash) {
      harness_.Say("FAULT: and its process, which is heard before its reply");
      Move(true);
      return harness_.Crash(i_);
    }
    if (choice_.deed == Deed::kEndFirst) {
      harness_.Say("and its process, which is heard before its reply");
      if (actor().end) harness_.TellEnd(i_);
      actor().status_due = false;  // heard after the end, it is not handled
      return;
    }
    if (!actor().replies.empty() && !overtaken) Reply();
  }

  // The first of the replies: to the late ones, or away.
  void Move(bool keep) {
    auto& replies = actor().replies;
    if (keep) actor().late.emplace_back(replies.front());
    replies.erase(replies.begin());
  }

  void Reply() {
    const std::string text = Text(actor().replies.front());
    switch (choice_.deed) {
      case Deed::kReplyLost:
      case Deed::kEndReplyLost:
        harness_.Say("FAULT: lost: " + text);
        return Move(false);
      case Deed::kReplyHeld:
      case Deed::kEndReplyHeld:
        harness_.Say("FAULT: held back: " + text);
        return Move(true);
      case Deed::kReplyDoubled:
      case Deed::kEndReplyDoubled:
        harness_.Say("FAULT: comes twice: " + text);
        actor().late.emplace_back(actor().replies.front());
        return harness_.TellReply(i_);
      default:
        harness_.Say(text + " comes");
        return harness_.TellReply(i_);
    }
  }

  void Status() {
    const std::string text = name() + "'s status, " + actor().core.report.state;
    if (choice_.deed == Deed::kStatus) {
      harness_.Say(text);
      return harness_.TellStatus(i_);
    }
    const bool twice = choice_.deed == Deed::kStatusDoubled;
    const bool lost = choice_.deed == Deed::kStatusLost;
    harness_.Say((lost    ? "FAULT: lost: "
                  : twice ? "FAULT: comes twice: "
                          : "FAULT: held back: ") +
                 text);
    actor().status_due = false;
    if (lost) return;
    const event::StatusSeen seen{i_, harness_.Report(i_)};
    actor().late.emplace_back(seen);
    if (twice) harness_.Tell(seen);
  }

  Harness& harness_;
  World& world_;
  const Choice& choice_;
  std::size_t i_;
};

}  // namespace

void Make(const Model& model, World& world, const Choice& choice, Notes& notes) {
  Harness harness(model, world, notes);
  Making(harness, choice).Make();
  Tidy(harness);
}

Model::Model(MachineConfig machine, State wanted, Rules decisions)
    : config(std::move(machine)), target(std::move(wanted)), rules(std::move(decisions)) {
  for (std::size_t i = 0; i < kActuators; ++i) {
    ActuatorConfig named = config.actuators[i];
    kinds[i] = i;
    for (std::size_t k = 0; k < i && kinds[i] == i; ++k) {
      named.name = config.actuators[k].name;
      if (named == config.actuators[k]) kinds[i] = k;
    }
  }
}

World NewWorld(const Model& model) {
  World world;
  world.now = Time(std::chrono::hours(1));
  world.machine = MakeMachine(model.config);
  return world;
}

void Begin(const Model& model, World& world, bool by_hand, Notes& notes) {
  Harness harness(model, world, notes);
  for (std::size_t i = 0; i < kActuators; ++i) {
    if (model.config.actuators[i].command.empty()) harness.StartActuator(i);
  }
  harness.BeginController(by_hand);
  Tidy(harness);
}

void Ask(const Model& model, World& world, const State& target, Notes& notes) {
  Harness harness(model, world, notes);
  harness.Ask(target);
  Tidy(harness);
}

void Settle(const Model& model, World& world, Notes& notes) {
  while (true) {
    const std::vector<Choice> choices = Choices(model, world);
    const auto next = std::find_if(choices.begin(), choices.end(), [](const Choice& choice) {
      return choice.cost == 0 && choice.deed != Deed::kAsk;
    });
    if (next == choices.end()) return;
    Make(model, world, *next, notes);
  }
}

}  // namespace musher::search
