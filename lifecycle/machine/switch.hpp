#pragma once
// The switch under way, the switch that waits, and TearDown. Plain values. A switch has the goal
// of its plan (plan.hpp), and each leg has the goal of a step of the plan.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/lifecycle/event_name.hpp"
#include "musher/lifecycle/field.hpp"
#include "musher/lifecycle/ids.hpp"
#include "musher/lifecycle/machine/switch_result.hpp"

namespace musher {

// Where a switch leads.
struct SwitchGoal {
  State from;
  State target;
  std::optional<ActuatorIndex> only;  // one actuator instead of the machine
  Direction direction = Direction::kLevel;

  friend bool operator==(const SwitchGoal&, const SwitchGoal&) = default;
};

// Where it leads one actuator.
struct ActuatorGoal {
  ActuatorIndex actuator = 0;
  State from;
  State target;
  std::vector<ActuatorIndex> needs;  // actuators whose part must have ended before this one begins

  friend bool operator==(const ActuatorGoal&, const ActuatorGoal&) = default;
};

// One actuator's part in the switch under way.
struct Leg : ActuatorGoal {
  enum class Progress { kWaiting, kUnderWay, kEnded };

  Progress progress = Progress::kWaiting;
  ActuatorOutcome outcome = ActuatorOutcome::kSkipped;
  bool ran = false;       // its callback may have run, so that it has to be rolled back
  bool may_fail = false;  // was degraded before, or is skipped: does not undo the others
  std::int32_t code = kCodeOk;
  std::string message;
  EventName event = EventName::kNone;  // of the message
  Time started{};
  Duration duration{};

  bool failed() const { return progress == Progress::kEnded && outcome != ActuatorOutcome::kDone; }

  friend bool operator==(const Leg&, const Leg&) = default;
};

enum class Purpose {
  kRequested,        // by a person or an application
  kStartUpCheck,     // the self-check of the first stage
  kStartUpActivate,  // the first stage to Active
  kFallback,         // to on_lost of a critical actuator
  kStop,             // TearDown
  kPolicy,           // by a rule: the battery, or lying still
};

// The rollback of a switch in which an actuator failed.
struct Rollback {
  bool under_way = false;
  CommandNumber number = 0;  // of its commands
  std::vector<Leg> legs;

  friend bool operator==(const Rollback&, const Rollback&) = default;
};

struct Switch : SwitchGoal {
  CommandNumber number = 0;
  Purpose purpose = Purpose::kRequested;
  std::vector<RequestId> requests;  // answered at its end
  std::vector<Leg> legs;
  std::vector<ActuatorResult> others;  // the actuators not driven, and why
  bool stopped = false;                // by an emergency stop
  Rollback rollback;
  RecordId cause = 0;  // the record with the reason for this switch

  // The legs that are driven now, and the number of their commands.
  std::vector<Leg>& driven_legs() { return rollback.under_way ? rollback.legs : legs; }
  const std::vector<Leg>& driven_legs() const { return rollback.under_way ? rollback.legs : legs; }
  CommandNumber driven_number() const { return rollback.under_way ? rollback.number : number; }

  friend bool operator==(const Switch&, const Switch&) = default;
};

// What follows a TearDown of the machine.
enum class AfterTearDown {
  kStaysDown,    // until a person starts it
  kMayStart,     // a supervisor ends it, and may start it at any time once it is down
  kStartsAgain,  // the same controller starts it again, from another slot
};

// The origin of a request for a switch.
struct Requester {
  std::string name;      // for people: "alice@dog1", "/lifecycle_manager"; "" = not known
  bool manager = false;  // a lifecycle manager of ROS 2, which requests without a person

  friend bool operator==(const Requester&, const Requester&) = default;
};

// The name of the policy as a requester.
inline constexpr const char* kThePolicy = "the policy";

// The last switch of the machine that no manager has requested. A manager may not switch the
// machine to a more active state than that: a person's pause lasts until a person ends it.
struct StandingRequest {
  State target;
  std::string by;            // as in Requester
  CommandNumber number = 0;  // of the switch; 0: of an earlier controller

  friend bool operator==(const StandingRequest&, const StandingRequest&) = default;
};

// A switch that was requested while an actuator was being driven to the state of the machine on its
// own. Nothing has been sent for it; no other actuator is driven on its own before it.
struct WaitingSwitch {
  State target;
  std::optional<ActuatorIndex> only;
  Time until{};                     // then it begins or is refused
  std::vector<RequestId> requests;  // answered at its end
  RecordId cause = 0;               // the record of the request
  Requester by = {};

  friend bool operator==(const WaitingSwitch&, const WaitingSwitch&) = default;
};

// The end of the machine: when to escalate.
struct Shutdown {
  Time begun{};
  Time tear_down_by{};               // the deadline of TearDown
  std::optional<Time> terminate_at;  // SIGTERM to what is left
  Time kill_at{};                    // SIGKILL
  Time give_up_at{};                 // the end of the budget
  enum class Signal { kNone, kTerminate, kKill };
  Signal sent = Signal::kNone;  // to what is left
  enum class Look { kNotYet, kUnderWay, kDone };
  Look look = Look::kNotYet;  // for unknown processes, at the end
  AfterTearDown after = AfterTearDown::kStaysDown;
  std::optional<Time> intent_by;  // TearDown waits until its intent is on disk, at most until then
  // TearDown has not begun: until this time at most, it waits for the actuators that may run to
  // announce themselves.
  std::optional<Time> announced_by;
  RecordId cause = 0;  // of its switch
  Requester by = {};
  std::optional<SwitchResult> result;  // of TearDown, answered when the processes have exited
  std::vector<RequestId> requests;

  friend bool operator==(const Shutdown&, const Shutdown&) = default;
};

}  // namespace musher

namespace musher::fields {

template <>
inline constexpr std::array<std::string_view, 6> kValueNames<Purpose> = {
    "requested", "start-up check", "start-up activate", "fallback", "stop", "policy"};
static_assert(EndsWith(Purpose::kPolicy));

template <>
inline constexpr std::array<std::string_view, 3> kValueNames<Shutdown::Signal> = {
    "none", "terminate", "kill"};
static_assert(EndsWith(Shutdown::Signal::kKill));

template <>
inline constexpr std::array<std::string_view, 3> kValueNames<Shutdown::Look> = {
    "not-yet", "under-way", "done"};

template <>
inline constexpr std::array<std::string_view, 3> kValueNames<Leg::Progress> = {
    "waiting", "under-way", "ended"};
static_assert(EndsWith(Leg::Progress::kEnded));

template <>
inline constexpr std::array<std::string_view, 3> kValueNames<AfterTearDown> = {
    "stays down", "may start", "starts again"};
static_assert(EndsWith(AfterTearDown::kStartsAgain));

template <>
inline constexpr std::tuple kFields<Requester> = {
    Field{"name", &Requester::name},
    Field{"manager", &Requester::manager},
};

template <>
inline constexpr std::tuple kFields<ActuatorGoal> = {
    Field{"actuator", &ActuatorGoal::actuator},
    Field{"from", &ActuatorGoal::from},
    Field{"target", &ActuatorGoal::target},
    Field{"needs", &ActuatorGoal::needs},
};

template <>
inline constexpr std::tuple kFields<Leg> = {
    Base<ActuatorGoal>{},
    Field{"progress", &Leg::progress},
    Field{"outcome", &Leg::outcome},
    Field{"ran", &Leg::ran},
    Field{"may_fail", &Leg::may_fail},
    Field{"code", &Leg::code},
    Field{"message", &Leg::message},
    Field{"event", &Leg::event},
    Field{"started", &Leg::started},
    Field{"duration", &Leg::duration},
};

template <>
inline constexpr std::tuple kFields<SwitchGoal> = {
    Field{"from", &SwitchGoal::from},
    Field{"target", &SwitchGoal::target},
    Field{"only", &SwitchGoal::only},
    Field{"direction", &SwitchGoal::direction},
};

template <>
inline constexpr std::tuple kFields<Rollback> = {
    Field{"rolling_back", &Rollback::under_way},
    Field{"back_number", &Rollback::number},
    Field{"back", &Rollback::legs},
};

template <>
inline constexpr std::tuple kFields<Switch> = {
    Base<SwitchGoal>{},
    Field{"number", &Switch::number},
    Field{"purpose", &Switch::purpose},
    Field{"requests", &Switch::requests},
    Field{"legs", &Switch::legs},
    Field{"others", &Switch::others},
    Field{"stopped", &Switch::stopped},
    Part{&Switch::rollback},
    Field{"cause", &Switch::cause},
};

template <>
inline constexpr std::tuple kFields<WaitingSwitch> = {
    Field{"target", &WaitingSwitch::target}, Field{"only", &WaitingSwitch::only},
    Field{"until", &WaitingSwitch::until},   Field{"requests", &WaitingSwitch::requests},
    Field{"cause", &WaitingSwitch::cause},   Field{"by", &WaitingSwitch::by},
};

template <>
inline constexpr std::tuple kFields<StandingRequest> = {
    Field{"target", &StandingRequest::target},
    Field{"by", &StandingRequest::by},
    Field{"number", &StandingRequest::number},
};

template <>
inline constexpr std::tuple kFields<Shutdown> = {
    Field{"begun", &Shutdown::begun},
    Field{"after", &Shutdown::after},
    Field{"intent_by", &Shutdown::intent_by},
    Field{"announced_by", &Shutdown::announced_by},
    Field{"cause", &Shutdown::cause},
    Field{"by", &Shutdown::by},
    Field{"tear_down_by", &Shutdown::tear_down_by},
    Field{"terminate_at", &Shutdown::terminate_at},
    Field{"kill_at", &Shutdown::kill_at},
    Field{"give_up_at", &Shutdown::give_up_at},
    Field{"sent", &Shutdown::sent},
    Field{"look", &Shutdown::look},
    Field{"result", &Shutdown::result},
    Field{"requests", &Shutdown::requests},
};

}  // namespace musher::fields
