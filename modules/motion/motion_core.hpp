#pragma once
// The motion manager's decision code: which client moves the body, with which motion, and what
// each client is answered. Pure: Step(rules, core, event, now) changes the core and returns the
// actions; the shell around it (motion_shell.hpp) turns messages and timers into events and
// actions into messages.
//
// clang-format off
//                a servo frame                     END, or 200 ms without a frame: WALK_STAND
//   idle ─────────────────────────────▶ servo ───────────────────────────────────────────▶ idle
//     │                                   ▲  through recovery stand where the body's motion
//     │ a result command                  │  may not go to the wanted one
//     ▼                                   │
//    job:  taken? ──▶ settle ──▶ transition ──▶ execution ──▶ next motion, or answered: idle
//          200 ms     15 ms      3000 ms        its time
// clang-format on
//
// Rules:
//   - Emergency stop (motion 0) is taken in every state, at once, from every source. It is a
//     latch: until recovery stand (111) is taken, no other motion is. A body that is stopped, off
//     or in damping, and was not before, sets it as well: by remote control, by its board, or by an
//     earlier process. Otherwise the body would stand up by the recovery stand put before the next
//     motion.
//   - A servo frame is taken from a source with the same or a higher priority than the source that
//     controls the body.
//   - A servo frame that differs from the last one is sent at once, 500 a second at most, of which
//     the newest, apart from begins and stops; one that does not is repeated 20 times a second.
//   - A result command (one motion or several) is taken when the body is idle; get-down also
//     during a dance; the machine's own lie-down always.
//   - The capability of a motion is checked when a command arrives and again when its motion
//     begins: the state may have changed in between.
//   - A servo motion ends when the body lies, by a rule of its board, is lifted or is stopped: it
//     neither stands up again nor walks on, once it is put down or has stood up by recovery stand,
//     for a stream that only goes on.
//   - The machine's own lie-down stands no body up that is stopped: it waits until the body lies,
//     and commands it from a normal motion only. The progress that a board reports while it damps
//     the body may be that of the motion before: a body lies that was damped for as long as a
//     lie-down takes (101 in the table: 5 s), in a mode of lying down and with the same progress.
//   - Nor is a body laid down while the board is held (BoardHeld): it may be another commander's. The
//     lie-down waits, and fails with the reason.
//   - A frame that may have waited while this process could not run begins no servo motion: its
//     stream may be over.
//   - A refused request moves nothing and is answered with a code and the reason.

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/modules/motion/motion_code.hpp"
#include "musher/modules/motion/motion_command.hpp"
#include "musher/modules/motion/motion_config.hpp"
#include "musher/modules/motion/motion_table.hpp"

namespace musher::motion {

inline constexpr Duration kServoWatchdog = Milliseconds(200);
inline constexpr Duration kLiesTime = Milliseconds(300);       // until a servo motion ends
inline constexpr Duration kOtherModeTime = Milliseconds(500);  // until a stream gets a code
inline constexpr Duration kBoardPeriod = Milliseconds(50);     // of a repeated command: 20 Hz
// Of the commands of a stream: a board takes 500 a second. Two may come together, because the
// frames of a stream of 500 Hz do not come in time.
inline constexpr Duration kLeastBoardPeriod = Milliseconds(2);
inline constexpr Duration kLate =
    Milliseconds(50);  // a turn this late waits for one more before a timeout
inline constexpr Duration kSettleTime = Milliseconds(15);
inline constexpr Duration kTransitionTime = Milliseconds(3000);
inline constexpr Duration kLieDownPause = Milliseconds(500);  // between two tries
inline constexpr Duration kStopRepeat =
    Milliseconds(1000);  // a stop is repeated for this long, or until it is accepted
inline constexpr Duration kLogPause = std::chrono::seconds(180);  // for the same code
inline constexpr Duration kSayPause = std::chrono::seconds(30);   // for the same sentence
inline constexpr const char* kChargeFirst = "The battery is low. Charge me first.";
inline constexpr std::int8_t kDoneBar = 95;  // %; more is done

// A request, which gets exactly one reply; the shell has its caller. 0: no caller.
using RequestToken = std::uint64_t;

// Whether a capability may be used now; the Error has the code of the motion manager.
using Gate = std::function<Result<>(const std::string& capability)>;

// What the decision depends on; all outlive the step.
struct MotionRules {
  const MotionTable& table;
  const MotionConfig& config;
  const Gate& allowed;
};

struct ServoCommand {
  enum Type : std::int32_t { kStart = 0, kData = 1, kEnd = 2 };
  std::int32_t type = kData;
  std::int32_t source = 0;
  MotionRequest requested;

  friend bool operator==(const ServoCommand&, const ServoCommand&) = default;
};

namespace motion_event {
struct BoardReported {
  BodyReport report;
  Duration age{};  // since it was received
};
struct ServoArrived {
  ServoCommand command;
  std::optional<Duration> could_not_run{};  // this process, until just now: it may have waited
};
// Motions one after the other: all of them are taken or none.
struct PlayArrived {
  RequestToken token = 0;
  std::int32_t source = 0;
  std::vector<MotionRequest> requests;
};
// The machine requests that the body lies down; `tries` 0: until it does, or it is cancelled.
struct LieDown {
  RequestToken token = 0;
  std::int32_t id = kGetDown;
  int tries = 0;
};
// The caller no longer waits for this.
struct Cancelled {
  RequestToken token = 0;
};
// A state callback begins in which no motion is permitted: a running motion is stopped.
struct Closed {
  State state;
};
// From now on only the state of the machine decides what is allowed.
struct Opened {};
// The machine's emergency stop is engaged.
struct EmergencyStop {};
// The world and its time started again: what was known of the body is void.
struct WorldRestarted {
  std::string why = "the world was restarted";  // for people
};
// The board was switched off and on: what it was commanded is void. A servo stream has to end, or
// to pause, before the body follows it again.
struct BoardRestarted {};
// Why only stops may be sent to the board: another program commands it, or there are two boards;
// "": no longer.
struct BoardHeld {
  std::string why;
};
// Another program has given the board a gait: the motion that would execute that one ends.
struct OtherGait {
  std::string why;
};
// The link to the board has one; it reports each of them rarely.
struct BoardFault {
  std::int32_t code = 0;
  std::string text;
};
struct TimePassed {};
}  // namespace motion_event

using MotionEvent =
    std::variant<motion_event::BoardReported, motion_event::ServoArrived, motion_event::PlayArrived,
                 motion_event::LieDown, motion_event::Cancelled, motion_event::Closed,
                 motion_event::Opened, motion_event::EmergencyStop, motion_event::WorldRestarted,
                 motion_event::BoardRestarted, motion_event::BoardHeld, motion_event::OtherGait,
                 motion_event::BoardFault, motion_event::TimePassed>;

namespace motion_action {
struct Send {
  BodyCommand command;
  friend bool operator==(const Send&, const Send&) = default;
};
struct ServoResponse {
  std::int32_t motion_id = kNoMotion;
  std::int32_t cmd_id = 0;
  std::int8_t bar = -1;
  std::int8_t status = -1;
  bool result = false;
  std::int32_t code = 0;
  friend bool operator==(const ServoResponse&, const ServoResponse&) = default;
};
struct Answer {
  RequestToken token = 0;
  std::int32_t motion_id = 0;
  std::int32_t code = 0;
  std::string message;
  friend bool operator==(const Answer&, const Answer&) = default;
};
struct Log {
  std::string text;
  friend bool operator==(const Log&, const Log&) = default;
};
// For the machine's manager: a fault of the body, or the begin of an emergency stop.
struct ReportError {
  std::int32_t code = 0;
  friend bool operator==(const ReportError&, const ReportError&) = default;
};
// Spoken to people beside the robot.
struct Say {
  std::string text;
  friend bool operator==(const Say&, const Say&) = default;
};
}  // namespace motion_action

using MotionAction =
    std::variant<motion_action::Send, motion_action::ServoResponse, motion_action::Answer,
                 motion_action::Log, motion_action::ReportError, motion_action::Say>;
using MotionActions = std::vector<MotionAction>;

// A motion in execution, or queued.
struct JobMotion {
  BodyCommand command;
  Duration time{};        // that its execution may take
  bool requested = true;  // false: a recovery stand put before the requested one
  bool prepared = false;  // its preparation has been done

  friend bool operator==(const JobMotion&, const JobMotion&) = default;
};

struct Job {
  enum class Wait { kFeedback, kSettle, kTransition, kExecution, kRetry };
  RequestToken token = 0;
  std::int32_t motion_id = 0;          // named in the answer
  bool own = false;                    // the machine's: not gated
  std::optional<std::int32_t> way_of;  // the source whose servo commands wait behind it
  bool for_servo = false;              // servo commands wait behind it
  std::optional<int> tries;            // of a lie-down: how many more; 0: no limit
  std::deque<JobMotion> todo;          // the first is in execution
  Wait wait = Wait::kFeedback;
  Time wait_end{};

  friend bool operator==(const Job&, const Job&) = default;
};

struct Servo {
  std::int32_t source = 0;
  BodyCommand command;
  bool moving = false;  // false: waits for a recovery stand
  Time last_frame{};
  Time next_report{};
  std::optional<Time> down_since;   // the body lies although it is moving
  std::optional<Time> other_since;  // the board reports another mode although it is moving
  bool limit_logged = false;        // that the speed is too high

  friend bool operator==(const Servo&, const Servo&) = default;
};

// Why the frames of a stream are refused that only goes on: it has to end, or to pause.
struct Interruption {
  Time last_frame{};
  std::int32_t code = 0;
  std::string why;
  std::set<std::int32_t> sources;  // of the streams that have not ended: it ends with the last one

  friend bool operator==(const Interruption&, const Interruption&) = default;
};

// What is sent to the board.
struct BoardLink {
  BodyCommand command;
  bool active = false;              // the command is repeated
  std::optional<BodyCommand> sent;  // the command that was sent last, while it is repeated
  std::optional<Time> until;        // repeated until then, or until it is taken
  Time begun_at{};                  // when the command was new
  Time sent_at = Time::min();
  Time next_change{};  // of a stream, were its frames sent every kLeastBoardPeriod

  // Whether the command differs from the one that was sent last.
  bool IsChanged() const;
  // When the next frame is due, while `active`.
  Time NextFrame() const;

  friend bool operator==(const BoardLink&, const BoardLink&) = default;
};

// A plain value.
struct MotionCore {
  std::optional<BodyReport> body;
  Time body_reported_at{};    // received, not handled
  bool board_silent = false;  // since its last report
  // Since when the board has damped a body that lies down, with the same progress.
  std::optional<Time> damped_since;
  std::string time_jumped;  // why nothing is known of the body; "": it has reported since
  std::string board_held;   // why only stops may be sent to it; "": free
  std::optional<Interruption> interrupted_stream;
  std::optional<std::int32_t> last_source;  // of the last frame, unless its stream has ended
  std::optional<Time> second_look;          // of a turn that came late: timeouts are checked then
  std::optional<State> closed = State(kUninitialized);  // the state in which no motion is permitted
  bool emergency_stop = false;                          // the latch
  bool stopped_at_board = false;                        // it was set by a report, not by a command
  Time stop_sent_at{};                                  // of the last stop that is not of the board
  std::optional<Job> job;
  std::optional<Servo> servo;
  BoardLink link;
  std::int32_t servo_commands = 0;            // received so far
  std::map<std::int32_t, Time> logged;        // by code
  std::optional<Time> battery_low_announced;  // when the low battery was announced

  bool Idle() const { return !job && !servo; }
  // Changed by TimePassed alone, so that a report which still waits to be read counts.
  bool BoardSilent() const { return !body || board_silent; }

  friend bool operator==(const MotionCore&, const MotionCore&) = default;
};

MotionActions Step(const MotionRules& rules, MotionCore& core, const MotionEvent& event, Time now);

// Whether the motions would begin now; else the refusal. Changes nothing.
Result<> MayPlay(const MotionRules& rules, const MotionCore& core,
                 const motion_event::PlayArrived& event);

// When to step next with TimePassed, unless another event comes first; nullopt: never.
std::optional<Time> NextDeadline(const MotionRules& rules, const MotionCore& core);

// The motion that the body executes: an id of the table, kNoMotion when the board is silent or
// reports another motion.
std::int32_t PresentMotion(const MotionRules& rules, const MotionCore& core);

// Why an emergency stop that is set has not stopped the body, as far as its board reports; "": it
// has, or none is set.
std::string StopTrouble(const MotionRules& rules, const MotionCore& core);

// "the motion manager could not run for 9 s".
std::string CouldNotRunText(Duration length);

}  // namespace musher::motion
