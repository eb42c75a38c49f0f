// Makes a choice, and removes what no longer matters after it.

#include <algorithm>
#include <utility>

#include "musher/base/check.hpp"
#include "musher/search/harness.hpp"

namespace musher::search {
namespace {

constexpr std::int32_t kFailure = 3001;
constexpr int kMostChoices = 100'000;  // until a world is quiet

// The code of a callback that fails: of a self-check one that counts as failed, if any does.
std::int32_t FailureOf(const ActuatorConfig& actuator, const State& target) {
  const bool listed = target == kSelfCheck && actuator.critical_codes.has_value();
  return listed && !actuator.critical_codes->empty() ? actuator.critical_codes->front() : kFailure;
}

// A code of a self-check that does not count as failed.
std::int32_t ToleratedFailureOf(const ActuatorConfig& actuator) {
  std::int32_t code = kFailure;
  while (std::ranges::count(*actuator.critical_codes, code) > 0) ++code;
  return code;
}

// Compares all but the id of the emergency stop.
bool HasSameContent(const ActuatorReport& a, const ActuatorReport& b) {
  return a.incarnation == b.incarnation && a.state == b.state && a.target == b.target &&
         a.busy_number == b.busy_number && a.epoch == b.epoch && a.number == b.number &&
         a.outcome_number == b.outcome_number && a.outcome_code == b.outcome_code &&
         a.detached == b.detached && a.held_by_stop == b.held_by_stop &&
         a.released_stop == b.released_stop;
}

// Once the controller has received the stop, an actuator's latch of it is no news, until a person
// releases it.
bool StopIsKnown(const World& world, const KnownActuator& known, const ActuatorReport& report) {
  if (world.released) return report.emergency_stop == known.report.emergency_stop;
  return report.emergency_stop == 0 || world.machine.emergency.stop;
}

// Whether the controller knows the content of the latched status already.
bool IsKnown(const World& world, const KnownActuator& known, const ActuatorReport& report) {
  return StopIsKnown(world, known, report) && known.presence == Presence::kPresent &&
         HasSameContent(known.report, report);
}

// Whether a reply to the command is under way, with a report from before.
bool IsReplied(const SimActuator& actuator, CommandNumber number) {
  const auto replies = [number](const event::Replied& reply) { return reply.number == number; };
  return std::ranges::any_of(actuator.replies, replies) ||
         std::ranges::any_of(actuator.late, [&](const Late& late) {
           const auto* reply = std::get_if<event::Replied>(&late);
           return reply != nullptr && replies(*reply);
         });
}

// Whether the controller awaits the end of the command in the report, which brings a newer report,
// and nothing else can happen before.
bool IsAwaited(const World& world, const SimActuator& actuator, const KnownActuator& known) {
  const ActuatorReport& report = actuator.core.report;
  return world.faults_left == 0 && !IsReplied(actuator, report.number) &&
         known.presence == Presence::kPresent && known.command &&
         known.command->number == report.number && known.command->number != report.outcome_number &&
         known.report.incarnation == report.incarnation && known.report.epoch == report.epoch &&
         StopIsKnown(world, known, report);
}

// Whether this reply is not awaited any more, and the latched status has the same content.
bool IsOver(const World& world, const SimActuator& actuator, const KnownActuator& known,
            const event::Replied& reply) {
  const bool waited =
      (known.command && known.command->number == reply.number) || known.control.again;
  const bool published = actuator.status_due &&
                         HasSameContent(actuator.core.report, reply.report) &&
                         actuator.core.report.emergency_stop == reply.report.emergency_stop;
  return !waited && known.presence == Presence::kPresent &&
         (published || IsKnown(world, known, reply.report));
}

// The controller ignores the reply of a process whose exit it knows. That of a process on another
// host may be a false report.
void RemoveRepliesOfTheExited(SimActuator& actuator, const KnownActuator& known) {
  const auto is_ignored = [&](const event::Replied& reply) {
    return reply.report.incarnation == known.process.dead;
  };
  std::erase_if(actuator.replies, is_ignored);
  std::erase_if(actuator.late, [&](const Late& late) {
    const auto* reply = std::get_if<event::Replied>(&late);
    return reply != nullptr && is_ignored(*reply);
  });
}

// Removes what is not awaited, so that nodes that differ only by it become one.
void Tidy(Harness& harness) {
  World& world = harness.world();
  if (world.faults_left == 0) {
    for (const Message& message : std::exchange(world.outbox, {})) harness.Transmit(message);
  }
  const bool stopped = world.machine.phase == Phase::kStopped;
  for (const ActuatorIndex i : world.actuators.Indices()) {
    SimActuator& actuator = world.actuators[i];
    const KnownActuator& known = world.machine.actuators[i];
    const ActuatorReport& report = actuator.core.report;
    std::erase_if(actuator.replies,
                  [&](const auto& reply) { return IsOver(world, actuator, known, reply); });
    if (harness.HostOf(i) == kHere) RemoveRepliesOfTheExited(actuator, known);
    if (IsKnown(world, known, report) || IsAwaited(world, actuator, known)) {
      actuator.status_due = false;
    }
    if (harness.IsOut(i)) actuator.status_due = false;  // due once it is reached
    if (!stopped) continue;
    actuator.status_due = false;
    actuator.replies.clear();
    actuator.end.reset();
    std::erase_if(actuator.late, FromActuator);
    actuator.hang_due = actuator.backtrace_due = false;
    actuator.unit_report = UnitReport::kNone;
    actuator.wanted = actuator.killed = actuator.silent = false;
    actuator.await_by.reset();
  }
  if (!stopped) return;
  for (Link& link : world.links) link.silent_by.reset();
}

// The names of other actuators, with those of `one` and `other` exchanged; their order is none.
std::vector<std::string> Exchanged(std::vector<std::string> names, const std::string& one,
                                   const std::string& other) {
  for (std::string& name : names) {
    if (name == one) {
      name = other;
    } else if (name == other) {
      name = one;
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

// Whether the config stays the same when the names of two actuators are exchanged, also where
// others refer to them.
bool AreAlike(const MachineConfig& config, ActuatorIndex one, ActuatorIndex other) {
  const std::string& name = config.actuators[one].name;
  const std::string& second = config.actuators[other].name;
  const auto exchanged = [&](ActuatorIndex i) { return i == one ? other : i == other ? one : i; };
  return std::ranges::all_of(config.actuators.Indices(), [&](ActuatorIndex i) {
    ActuatorConfig image = config.actuators[i];
    image.name = config.actuators[exchanged(i)].name;
    image.after = Exchanged(image.after, name, second);
    image.binds_to = Exchanged(image.binds_to, name, second);
    ActuatorConfig there = config.actuators[exchanged(i)];
    there.after = Exchanged(there.after, "", "");
    there.binds_to = Exchanged(there.binds_to, "", "");
    return image == there;
  });
}

class ChoiceMaker {
 public:
  ChoiceMaker(Harness& harness, const Choice& choice)
      : harness_(harness), world_(harness.world()), choice_(choice), i_(choice.which()) {}

  void Make() {
    world_.faults_left -= choice_.cost;
    if (choice_.kind == ChoiceKind::kTime) return PassTime();
    if (choice_.kind == ChoiceKind::kWait) return harness_.Wait();
    if (choice_.kind == ChoiceKind::kLate) return ReceiveLate();
    if (choice_.kind == ChoiceKind::kHang) return HangWorkThread();
    if (choice_.kind >= ChoiceKind::kHangReport && choice_.kind <= ChoiceKind::kProgress)
      return AfterHang();
    if (choice_.kind == ChoiceKind::kBattery || choice_.kind == ChoiceKind::kBatteryFalls)
      return Battery();
    if (choice_.kind >= ChoiceKind::kEndFailed && choice_.kind <= ChoiceKind::kEndCrash)
      return End();
    if (choice_.kind >= ChoiceKind::kReplyLost && choice_.kind <= ChoiceKind::kReplyDuplicated)
      return Reply();
    if (choice_.kind >= ChoiceKind::kStatusLost && choice_.kind <= ChoiceKind::kStatusDuplicated)
      return Status();
    if (choice_.kind >= ChoiceKind::kLose && choice_.kind <= ChoiceKind::kUnannounced)
      return Sent();
    if (choice_.kind >= ChoiceKind::kSilence && choice_.kind <= ChoiceKind::kHeartbeat)
      return OfLink();
    if (choice_.kind == ChoiceKind::kCutLink || choice_.kind == ChoiceKind::kRebootHost)
      return LoseHost();
    Simple();
  }

 private:
  SimActuator& actuator() { return world_.actuators[i_]; }
  std::string name() const { return harness_.Name(i_); }
  State target() { return actuator().core.report.target; }

  void Simple() {
    switch (choice_.kind) {
      case ChoiceKind::kRequest:
        world_.at_start = false;
        return harness_.RequestSwitch(harness_.Target());
      case ChoiceKind::kDeliver:
        return Sent();
      case ChoiceKind::kEndOk:
      case ChoiceKind::kEndOnRequest:
      case ChoiceKind::kEndFirst:
        return End();
      case ChoiceKind::kReply:
        return Reply();
      case ChoiceKind::kStatus:
        return Status();
      case ChoiceKind::kEnd:
        harness_.Log("the end of " + name() + "'s process is detected");
        return harness_.FeedEnd(i_);
      case ChoiceKind::kSeeStop:
        harness_.Log("the controller receives the emergency stop");
        world_.stop_seen_due = false;
        return harness_.Feed(event::EmergencyStopSeen{{5, "operator", ""}});
      case ChoiceKind::kRelease:
        harness_.Log("a person releases the emergency stop");
        world_.released = true;
        return harness_.Feed(event::ReleaseRequested{0, "a person"});
      case ChoiceKind::kRepeat:
        world_.repeat = Repeat::kRequested;
        return harness_.RequestSwitch(harness_.Target());
      case ChoiceKind::kCrash:
        harness_.Log("FAULT: " + name() + " crashes");
        return harness_.Crash(i_);
      case ChoiceKind::kRestart:
        harness_.Log("FAULT: the controller is killed, and its supervisor starts another");
        return harness_.RestartController(false);
      case ChoiceKind::kStartByPerson:
        harness_.Log("FAULT: the controller is killed, and a person starts another");
        return harness_.RestartController(true);
      case ChoiceKind::kRequestError:
        harness_.Log("CROSSED by a more urgent request");
        return harness_.RequestSwitch(State(kError));
      case ChoiceKind::kRequestTearDown:
        harness_.Log("CROSSED by a more urgent request");
        return harness_.RequestSwitch(State(kTearDown));
      case ChoiceKind::kOtherCommand:
        harness_.Log("FAULT: another machine commands " + name() + " to Active");
        return harness_.ReceiveOtherCommand(i_, State(kActive));
      case ChoiceKind::kOtherRelease:
        harness_.Log("FAULT: another machine releases the emergency stop of " + name());
        return harness_.ReceiveOtherRelease(i_);
      case ChoiceKind::kOtherHeartbeat:
        harness_.Log("FAULT: the heartbeat of another controller arrives, with a lower epoch");
        return harness_.Feed(
            event::RivalSeen{Epoch(world_.machine.epoch.value() - 1), "another controller", true});
      case ChoiceKind::kEngageStopLate:
        harness_.Log("CROSSED by an emergency stop; FAULT: delayed to " + name());
        actuator().late.emplace_back(StopMessage{});
        return harness_.EngageStop(i_);
      default:
        harness_.Log("CROSSED by an emergency stop");
        return harness_.EngageStop();
    }
  }

  void OfLink() {
    const std::size_t host = harness_.HostOf(i_);
    switch (choice_.kind) {
      case ChoiceKind::kSilence:
        harness_.Log("the controller notices that host " + harness_.HostName(i_) +
                     " is out of reach");
        return harness_.NoticeCut(host);
      case ChoiceKind::kReach:
        harness_.Log("host " + harness_.HostName(i_) + " is reached again");
        return harness_.Reach(host);
      case ChoiceKind::kUnitReport:
        harness_.Log("host " + harness_.HostName(i_) + " reports the process of " + name());
        return harness_.FeedUnitReport(i_);
      case ChoiceKind::kAwait:
        harness_.Log("the start of " + name() + " waits for host " + harness_.HostName(i_));
        return harness_.FeedWaits(i_);
      default:
        harness_.Log("heartbeats of " + name() + " arrive again");
        return harness_.FeedHeartbeat(i_);
    }
  }

  void HangWorkThread() {
    harness_.Log("FAULT: the work thread of " + name() + " hangs");
    harness_.HangWorkThread(i_);
  }

  void AfterHang() {
    switch (choice_.kind) {
      case ChoiceKind::kHangReport:
        harness_.Log("the controller notices that " + name() + " hangs");
        return harness_.FeedHang(i_);
      case ChoiceKind::kBacktrace:
        harness_.Log("the backtrace of " + name() + " is taken");
        return harness_.TakeBacktrace(i_);
      default:
        harness_.Log("the work thread of " + name() + " makes progress again");
        return harness_.MakeProgress(i_);
    }
  }

  void Battery() {
    const bool falls = choice_.kind == ChoiceKind::kBatteryFalls;
    if (falls) world_.battery = BatteryLevels(harness_.config())[choice_.index];
    harness_.Log((falls ? "FAULT: the battery falls to " : "the battery is at ") +
                 std::to_string(*world_.battery) + " %");
    harness_.FeedBattery();
  }

  void LoseHost() {
    const std::size_t host = harness_.HostOf(i_);
    if (choice_.kind == ChoiceKind::kRebootHost) {
      harness_.Log("FAULT: host " + harness_.HostName(i_) + " goes down, and boots again");
      return harness_.RebootHost(host);
    }
    harness_.Log("FAULT: the link to host " + harness_.HostName(i_) + " is cut");
    harness_.CutLink(host);
  }

  void PassTime() {
    const Time next = *NextDeadline(harness_.config(), world_.machine);
    harness_.Log(std::to_string(ToMilliseconds(next - world_.now)) + " ms pass");
    world_.now = std::max(world_.now, next);
    for (const ActuatorIndex k : world_.actuators.Indices()) {
      if (world_.actuators[k].work != Work::kRunning || !IsOverdueAt(k, next)) continue;
      harness_.Log("FAULT: " + harness_.Name(k) + "'s callback is overdue");
      world_.actuators[k].work = Work::kOverdue;
    }
    harness_.Feed(event::TimePassed{});
  }

  bool IsOverdueAt(ActuatorIndex k, Time now) const {
    const auto own = OverdueAt(world_, k);
    return choice_.index == 0 || (own && *own <= now);
  }

  void ReceiveLate() {
    const Late late = actuator().late[choice_.index];
    actuator().late.erase(actuator().late.begin() + choice_.index);
    harness_.Log("a delayed message arrives: " + Text(late));
    if (const auto* message = std::get_if<Message>(&late)) return harness_.DeliverLate(*message);
    if (const auto* reply = std::get_if<event::Replied>(&late)) return harness_.Feed(*reply);
    if (const auto* seen = std::get_if<event::StatusSeen>(&late)) return harness_.FeedStatus(*seen);
    harness_.ReceiveStop(i_);
  }

  std::string Text(const Late& late) const {
    if (const auto* message = std::get_if<Message>(&late)) return Text(*message);
    if (const auto* reply = std::get_if<event::Replied>(&late)) return Text(*reply);
    if (std::holds_alternative<StopMessage>(late)) return "the emergency stop to " + name();
    return name() + "'s status, " + std::get<event::StatusSeen>(late).report.state;
  }
  std::string Text(const Message& message) const {
    if (const auto* command = std::get_if<SwitchCommand>(&message.what)) {
      return "command " + ToString(command->number) + " to " + harness_.Name(message.to) + ", " +
             command->target;
    }
    return "the query to " + harness_.Name(message.to) + " about " +
           ToString(std::get<QueryCommand>(message.what).number);
  }
  std::string Text(const event::Replied& reply) const {
    return name() + "'s reply to " + (reply.query ? "the query about " : "") +
           ToString(reply.number);
  }

  void Sent() {
    const Message message = world_.outbox.front();
    world_.outbox.erase(world_.outbox.begin());
    switch (choice_.kind) {
      case ChoiceKind::kLose:
        return harness_.Log("FAULT: lost: " + Text(message));
      case ChoiceKind::kHold:
        actuator().late.emplace_back(message);
        return harness_.Log("FAULT: delayed: " + Text(message));
      case ChoiceKind::kDuplicate:
        actuator().late.emplace_back(message);
        harness_.Log("FAULT: duplicated: " + Text(message));
        return harness_.Transmit(message);
      case ChoiceKind::kUnannounced:
        harness_.Log("FAULT: before the controller was announced: " + Text(message));
        return harness_.Deliver(message, false);
      default:
        harness_.Log(Text(message) +
                     (harness_.IsOut(i_) ? ", while its host is out of reach" : ""));
        return harness_.Transmit(message);
    }
  }

  // The code of the callback that ends.
  std::int32_t Code() {
    const ActuatorConfig& own = harness_.config().actuators[i_];
    if (choice_.kind == ChoiceKind::kEndTolerated) return ToleratedFailureOf(own);
    const bool failed =
        choice_.kind == ChoiceKind::kEndFailed || choice_.kind == ChoiceKind::kEndOnRequest;
    return failed ? FailureOf(own, target()) : kCodeOk;
  }

  void End() {
    const bool tolerated = choice_.kind == ChoiceKind::kEndTolerated;
    const bool failed = choice_.kind == ChoiceKind::kEndFailed || tolerated;
    const bool requested = choice_.kind == ChoiceKind::kEndOnRequest;
    const bool overtaken = !actuator().replies.empty();
    harness_.Log((failed ? "FAULT: " : "") + name() + "'s callback of " + target() +
                 (tolerated   ? " fails, with a code that is not critical"
                  : failed    ? " fails"
                  : requested ? " ends because it was requested to stop"
                              : " ends"));
    harness_.EndCallback(i_, Code(), requested ? "requested to stop" : "");
    if (choice_.kind == ChoiceKind::kEndCrash) {
      harness_.Log("FAULT: and its process, which is detected before its reply");
      Move(true);
      return harness_.Crash(i_);
    }
    if (choice_.kind == ChoiceKind::kEndFirst) {
      harness_.Log("and its process, which is detected before its reply");
      if (actuator().end) harness_.FeedEnd(i_);
      actuator().status_due = false;  // a status after the end is ignored
      return;
    }
    if (!actuator().replies.empty() && !overtaken) Reply();
  }

  // Delays or drops the first reply.
  void Move(bool keep) {
    auto& replies = actuator().replies;
    if (keep) actuator().late.emplace_back(replies.front());
    replies.erase(replies.begin());
  }

  void Reply() {
    const std::string text = Text(actuator().replies.front());
    switch (choice_.kind) {
      case ChoiceKind::kReplyLost:
      case ChoiceKind::kEndReplyLost:
        harness_.Log("FAULT: lost: " + text);
        return Move(false);
      case ChoiceKind::kReplyHeld:
      case ChoiceKind::kEndReplyHeld:
        harness_.Log("FAULT: delayed: " + text);
        return Move(true);
      case ChoiceKind::kReplyDuplicated:
      case ChoiceKind::kEndReplyDuplicated:
        harness_.Log("FAULT: duplicated: " + text);
        actuator().late.emplace_back(actuator().replies.front());
        return harness_.FeedReply(i_);
      default:
        harness_.Log(text + " arrives");
        return harness_.FeedReply(i_);
    }
  }

  void Status() {
    const std::string text = name() + "'s status, " + actuator().core.report.state;
    if (choice_.kind == ChoiceKind::kStatus) {
      harness_.Log(text);
      return harness_.FeedStatus(i_);
    }
    const bool twice = choice_.kind == ChoiceKind::kStatusDuplicated;
    const bool lost = choice_.kind == ChoiceKind::kStatusLost;
    harness_.Log((lost    ? "FAULT: lost: "
                  : twice ? "FAULT: duplicated: "
                          : "FAULT: delayed: ") +
                 text);
    actuator().status_due = false;
    if (lost) return;
    const event::StatusSeen seen{i_, harness_.Report(i_)};
    actuator().late.emplace_back(seen);
    if (twice) harness_.FeedStatus(seen);
  }

  Harness& harness_;
  World& world_;
  const Choice& choice_;
  ActuatorIndex i_;
};

}  // namespace

void Make(const Model& model, World& world, const Choice& choice, Notes& notes) {
  Harness harness(model, world, notes);
  ChoiceMaker(harness, choice).Make();
  Tidy(harness);
  harness.CheckTimedRules();
}

Model::Model(MachineConfig machine, State wanted, Rules decisions)
    : config(std::move(machine)),
      target(std::move(wanted)),
      rules(std::move(decisions)),
      kinds(config.actuators.size()) {
  MUSHER_CHECK(config.actuators.size() <= kMostSearchedActuators, "too many actuators to search");
  for (const ActuatorIndex i : config.actuators.Indices()) {
    host_of.push_back(kHere);
    if (const std::string& host = config.actuators[i].host; !host.empty()) {
      host_of[i] = static_cast<std::size_t>(std::ranges::find(hosts, host) - hosts.begin());
      if (host_of[i] == hosts.size()) hosts.push_back(host);
    }
    kinds[i] = i;
    for (ActuatorIndex k; k < i && kinds[i] == i; ++k) {
      if (AreAlike(config, k, i)) kinds[i] = k;
    }
  }
}

World NewWorld(const Model& model) {
  World world;
  world.machine = MakeMachine(model.config);
  world.actuators.resize(model.config.actuators.size());
  world.links.resize(model.hosts.size());
  return world;
}

void Begin(const Model& model, World& world, bool by_hand, Notes& notes) {
  Harness harness(model, world, notes);
  for (const ActuatorIndex i : world.actuators.Indices()) {
    if (model.config.actuators[i].command.empty()) harness.StartActuator(i);
  }
  harness.BeginController(by_hand);
  Tidy(harness);
}

void RequestSwitch(const Model& model, World& world, const State& target, Notes& notes) {
  Harness harness(model, world, notes);
  harness.RequestSwitch(target);
  Tidy(harness);
}

bool RunUntilStable(const Model& model, World& world, Notes& notes) {
  for (int made = 0; made < kMostChoices; ++made) {
    const std::vector<Choice> choices = Choices(model, world);
    const auto next = std::find_if(choices.begin(), choices.end(), [](const Choice& choice) {
      return choice.cost == 0 && choice.kind != ChoiceKind::kRequest;
    });
    if (next == choices.end()) return true;
    Make(model, world, *next, notes);
  }
  return false;
}

}  // namespace musher::search
