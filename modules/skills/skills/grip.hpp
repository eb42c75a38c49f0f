#pragma once
// The hand of a robot as its skills use it: which object it holds, one request at a time, and the
// checks that all of them make.
//
// Metres; positions in the frame of the map. Threads: the loop on which skills are stepped.

#include <optional>
#include <string>

#include "musher/behavior/skill/skill.hpp"
#include "musher/modules/skills/robot/robot.hpp"

namespace musher::skills {

// Shared by the skills of one robot.
class Grip {
 public:
  explicit Grip(Robot& robot) : robot_(robot) {}

  // The held object; empty: none. By the objects of the world, where they are known: that also
  // counts after a restart. For 1 s after a change by a skill, which objects may not show yet, and
  // without objects: by what the skills did.
  std::string Held() const;
  void Changed(const std::string& held);

 private:
  Robot& robot_;
  std::string held_;
  std::optional<Time> changed_at_;
};

// A request to the hand.
class HandCall {
 public:
  enum class Kind : std::uint8_t {
    kPending,
    kDone,
    kTooFar,   // "Too far: 3.20m > 2.00m"
    kRefused,  // another attempt does not help
    kLost,     // no reply comes; it may have been executed
  };
  struct Answer {
    Kind kind = Kind::kPending;
    std::string message{};
    double distance_m = -1;  // from hand to object; negative: not known
  };

  // Sends the request when `begin`, or when none is on its way: after a restore.
  Answer Poll(Robot& robot, const HandRequest& request, bool begin);
  bool pending() const { return reply_.valid(); }
  void Drop() { reply_.Drop(); }

 private:
  skill::Future<HandReply> reply_;
};

// "Too far: 3.20m > 2.00m".
std::string TooFarText(double distance_m, double limit_m);

// Why skills of the hand are not paused.
inline constexpr const char* kHandGoesOn =
    "its hand cannot be stopped halfway; wait for its end, or cancel it";

// The parameters of pick_up and grasp.
void DeclareGrasping(skill::Table& table);
// Why they cannot be executed, or why the robot cannot: it has no hand.
std::optional<std::string> GraspingFault(const Robot& robot, const skill::Values& parameters);
HandRequest GraspingRequest(HandAction action, const skill::Values& parameters);
// "jetbot_0 has no hand".
std::optional<std::string> NoHand(const Robot& robot);

// The object that put_down and place give away: the one that is named by object_prim_path or
// joint_path, else the held one. Empty: none is named, and the robot holds none.
std::string GivenObject(const skill::Values& parameters, const std::string& held);
// Why this object cannot be given away.
std::optional<std::string> GivingFault(const Robot& robot, const std::string& object,
                                       const std::string& held);

// "Timeout: the hand has not replied after 3 s".
std::string HandTimeout(const skill::Tick& tick);
// The time before another attempt.
bool WaitsForAttempt(const skill::Tick& tick);

}  // namespace musher::skills
