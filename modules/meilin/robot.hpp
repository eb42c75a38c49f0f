#pragma once
// What the tree of a match uses of its robot: goals of four actions, the robot's pose and two
// signals. `RosRobot` (mission/) provides it over DDS, `FakeRobot` in tests.
//
//   waiting for the server -> sent -> accepted -> succeeded | failed | cancelled
//           |                  |         +-------> lost
//           +-> unavailable    +-> rejected, lost
//
// Units: metres, radians, millimetres (heights of wheels), seconds. Poses are in the frame map. A
// goal ends exactly once, and its state does not change any more. An error is the end of a goal,
// nothing here throws. A goal whose handle is destroyed goes on.
//
// Threads: the loop of the actuator, where the tree is ticked.

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "musher/base/time.hpp"

namespace musher::meilin {

struct MoveGoal {
  double x_m = 0;
  double y_m = 0;
  double yaw_rad = 0;
};

// Codes of r2_interfaces/SuspensionControl.
enum class SuspensionMode : std::uint8_t { kAuto = 0, kUp = 1, kDown = 2, kDirect = 3 };

struct SuspensionGoal {
  std::uint8_t mode = 0;
  std::uint8_t direction = 0;  // of the climb, in the frame of the body: see field/grid.hpp
  double height_mm = 0;        // of the step; with kDirect, of the wheels
  double timeout_s = 0;        // of the server
};

// Commands of the arm and of the spear that the nodes name; the codes are those of the actions.
inline constexpr std::uint8_t kArmGrasp = 1;
inline constexpr std::uint8_t kSpearDock = 3;

struct ArmGoal {
  std::uint8_t command = 0;
  bool wait_result = true;
  double timeout_s = 0;
};

struct SpearGoal {
  std::uint8_t command = 0;
  double timeout_s = 0;
};

enum class GoalState : std::uint8_t {
  kWaiting,      // for a server
  kSent,         // without a reply
  kAccepted,     // the server works on it
  kSucceeded,    // message(): the server's
  kFailed,       // the server has given up; message(): why
  kCancelled,    // after Cancel(), or by the server; message(): the server's
  kRejected,     // message(): why
  kLost,         // the server does not answer or has exited; message(): which
  kUnavailable,  // there was no server
};

constexpr bool HasEnded(GoalState state) {
  return state >= GoalState::kSucceeded;
}
std::string_view Name(GoalState state);  // "accepted"

class Goal {
 public:
  virtual ~Goal() = default;
  virtual GoalState state() const = 0;
  virtual const std::string& message() const = 0;
  virtual int final_state() const = 0;              // of the suspension and the arm; else 0
  virtual const std::string& feedback() const = 0;  // the last one, for people; "": none yet
  // Idempotent, and without effect on one that has ended. The end comes later.
  virtual void Cancel() = 0;
};

using GoalPtr = std::unique_ptr<Goal>;  // never null

// Where the robot was at a time. Only finite numbers.
struct PoseFix {
  double x_m = 0;
  double y_m = 0;
  double yaw_rad = 0;
  Time at{};
  // Of the underside of the body over the ground; NaN: not known.
  double z_m = std::numeric_limits<double>::quiet_NaN();

  // A limit that is not positive: it never grows old.
  bool IsFresh(Time now, double limit_s) const {
    return limit_s <= 0 || (now >= at && now - at <= std::chrono::duration<double>(limit_s));
  }
};

// The four wheels as they report: how far each reaches below the body.
struct Wheels {
  static constexpr std::size_t kCount = 4;  // front-left, front-right, rear-left, rear-right
  std::array<double, kCount> mm{};
  Time at{};
};

// A topic of a boolean.
struct Signal {
  std::optional<bool> value;  // the last one; nullopt: none came
  Time at{};                  // when it came
  std::uint64_t trues = 0;    // messages that were true
  std::uint64_t rises = 0;    // of them those after a false, or after none
};

class Robot {
 public:
  virtual ~Robot() = default;

  // `server` is the name of the action, as "move_to_pose". A goal waits for a server, and for the
  // end of an earlier goal of that server that is being cancelled.
  virtual GoalPtr MoveToPose(const std::string& server, const MoveGoal& goal) = 0;
  virtual GoalPtr ControlSuspension(const std::string& server, const SuspensionGoal& goal) = 0;
  virtual GoalPtr MoveArm(const std::string& server, const ArmGoal& goal) = 0;
  virtual GoalPtr MoveSpear(const std::string& server, const SpearGoal& goal) = 0;

  virtual std::optional<PoseFix> pose() const = 0;  // nullopt: none came
  virtual std::optional<Wheels> wheels()
      const = 0;                                    // nullopt: none came; they are not checked then
  virtual int suspension_state() const = 0;         // of the sequence; 0: nothing runs
  virtual const Signal& partner_ready() const = 0;  // of the partner robot
  virtual const Signal& arm_idle() const = 0;       // the arm's last command is done
  // For people: what a node wants to be in the log.
  virtual void Warn(const std::string& text) = 0;
};

}  // namespace musher::meilin
