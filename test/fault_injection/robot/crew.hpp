#pragma once
// The actuators of the fault-injection suite's robots, and what is promised of each: the
// fault-injection suite judges by it.

#include <set>
#include <string>
#include <vector>

#include "musher/messages/musher_msgs/machine_status.hpp"

namespace musher::fault_injection {

enum class Shape {
  kHere,     // all on this host; the controller starts its actuators
  kTwoHosts  // controller here, actuators behind a link, where their own host starts them
};

inline constexpr const char* kNameSpace = "fault-injection suite";

struct Member {
  std::string name;
  bool critical = false;
  std::string restart = "on-failure";
  int checkpoint_ms = 0;  // 0: not watched
  std::string on_lost;    // where the machine goes without it; "": nowhere
  std::string keys;       // more of its table
  bool wrapped = false;   // a musher-exec around a program that knows nothing of Musher
  bool ros2 = false;      // a ROS 2 managed node; only where all are on this host
};

const std::vector<Member>& Crew();
const Member& MemberOf(const std::string& name);
// Those that are a fault_injection_module.
std::vector<std::string> Modules();

// Whether a robot of this shape has it.
bool IsOnBoard(const Member& member, Shape shape);

// What starts it; its board is in `folder`, `programs` is the folder of musher.
std::vector<std::string> CommandOf(const Member& member, const std::string& folder,
                                   const std::string& programs);

// The state config of a robot whose files are in `folder`.
std::string ConfigText(Shape shape, const std::string& folder, const std::string& programs);

inline constexpr int kRestartLimit = 3;
// Longer than any next controller takes to come; between two hosts shorter than a lease of DDS.
constexpr int ControllerLostMs(Shape shape) {
  return shape == Shape::kHere ? 4000 : 1500;
}
inline constexpr int kShutdownBudgetMs = 6000;
inline constexpr int kCallbackTimeMs = 2000;
inline constexpr const char* kOnControllerLost = "Protected";
// So many times a second the modules give a checkpoint.
inline constexpr int kHz = 50;

// How active a robot is in this state; -1 for those without a rank.
int RankOf(const std::string& state);

const msg::ActuatorInfo& Find(const msg::MachineStatus& status, const std::string& actuator);
// Whether the machine rests in `state` and everybody is there and well, but for `without`.
bool IsSettled(const msg::MachineStatus& status, const std::string& state,
               const std::set<std::string>& without = {});

}  // namespace musher::fault_injection
