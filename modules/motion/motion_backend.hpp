#pragma once
// The interface between the motion manager and a body: a motion board's link, or a simulated body.
//
//   MotionShell ── Send(command) ──▶ MotionBackend ──▶ board
//   MotionShell ◀── OnBody(state) ── MotionBackend ◀── board
//
// A backend decides nothing. The decision code sends a command when it changes, at most every 2 ms
// apart from what must happen at once, and repeats it every 50 ms while it holds. The life count
// in a report shows which command the board has taken. A board that receives nothing for a while
// must stop walking by itself: the motion manager may have crashed.
//
// Threads: the loop's only.

#include <Eigen/Geometry>
#include <functional>
#include <string>

#include "musher/base/result.hpp"
#include "musher/modules/motion/motion_code.hpp"
#include "musher/modules/motion/motion_command.hpp"
#include "musher/modules/motion/user_gait.hpp"

namespace musher::motion {

// The body in the frame of its odometry (O) at a point in time of its own clock; B is
// base_link_leg.
struct BodyMotion {
  Duration stamp{};
  Eigen::Isometry3d X_OB = Eigen::Isometry3d::Identity();
  Eigen::Vector3d v_B = Eigen::Vector3d::Zero();  // m/s
  Eigen::Vector3d w_B = Eigen::Vector3d::Zero();  // rad/s
  Eigen::Vector3d a_B = Eigen::Vector3d::Zero();  // m/s^2, gravity included
  bool has_acceleration = true;                   // false: the board does not measure it
};

struct BodyState {
  BodyReport report;
  BodyMotion motion;
  bool has_new_motion = true;  // false: `motion` is that of an earlier report
  // Since this computer received the report: one from before a stop does not confirm it.
  Duration age{};
};

class MotionBackend {
 public:
  // The backend calls it on the loop for each report of the body, some 50 times a second, never
  // inside Send(). Reports may stop at any time and resume.
  using OnBody = std::function<void(const BodyState&)>;

  virtual ~MotionBackend() = default;

  // Called by the shell. Returns at once; a failure to send shows in what the body reports.
  virtual void Send(const BodyCommand& command) = 0;

  // Whether the board takes gaits of users.
  virtual bool TakesGaits() const { return false; }

  // Gives the board a gait, which motions with gait 110 then execute. `then` runs on the loop,
  // once, unless the backend is destroyed before. It moves nothing.
  using OnDefined = std::function<void(const Result<>&)>;
  virtual void DefineGait(const UserGait& /*gait*/, OnDefined then) {
    then(Error{MotionCode(KeyCode::kUnSupport), "this motion board takes no gaits"});
  }

  // Whether the board can be reached, as far as this computer is concerned; the Error says what to
  // type. It may change at any time.
  virtual Result<> Reachable() const { return Ok(); }

  // Whether it has received for long enough to know of another program that commands the board.
  virtual bool KnowsCommanders() const { return true; }

  // Where the body's reports come from, in messages: "world/body_state".
  virtual std::string Source() const { return "world/body_state"; }
};

}  // namespace musher::motion
