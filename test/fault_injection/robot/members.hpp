#pragma once
// The actuators of the fault-injection suite's robots, with the config values that the expected
// behaviour depends on.

#include <set>
#include <string>
#include <vector>

#include "musher/messages/musher_msgs/machine_status.hpp"

namespace musher::fault_injection {

enum class Shape {
  kHere,      // all on this host; the controller starts its actuators
  kTwoHosts,  // controller here, actuators on the other host, which starts them itself
  kStandby,   // the same, and a standby of the other host may lead
  kOnLan      // as kHere, with the profile lan; another robot on the other host
};

inline constexpr const char* kNameSpace = "fault_injection";
inline constexpr const char* kMachine = "robot";

// Whether the actuators are on the other host.
constexpr bool AreThere(Shape shape) {
  return shape == Shape::kTwoHosts || shape == Shape::kStandby;
}

struct Member {
  std::string name;
  bool critical = false;
  std::string restart = "on-failure";
  int checkpoint_ms = 0;  // 0: not watched
  std::string on_lost;    // the machine's state without it; "": unchanged
  std::string keys;       // further lines of its table
  bool wrapped = false;   // a musher-exec that runs a program without Musher
  bool ros2 = false;      // a ROS 2 managed node; only with Shape::kHere
};

const std::vector<Member>& Members();
const Member& MemberOf(const std::string& name);
// The actuators that run fault_injection_module.
std::vector<std::string> Modules();

// Whether a robot of this shape has the member.
bool IsOnBoard(const Member& member, Shape shape);

// Its command line; its board is in `folder`, `programs` is the folder of musher.
std::vector<std::string> CommandOf(const Member& member, const std::string& folder,
                                   const std::string& programs);

// The file of a member that is wrapped, NAME.toml.
std::string ProgramText();

// The state config of a robot whose files are in `folder`.
std::string ConfigText(Shape shape, const std::string& folder, const std::string& programs,
                       const std::string& machine = kMachine);

inline constexpr int kRestartLimit = 3;
// Longer than any next controller takes to start; between two hosts shorter than a DDS lease.
constexpr int ControllerLostMs(Shape shape) {
  return AreThere(shape) ? 1500 : 4000;
}
inline constexpr int kShutdownBudgetMs = 6000;
inline constexpr int kCallbackTimeMs = 2000;
inline constexpr const char* kOnControllerLost = "Protected";
// How often a module makes a checkpoint, each second.
inline constexpr int kHz = 50;

// How active a robot is in this state; -1 for those without a rank.
int RankOf(const std::string& state);

const msg::ActuatorInfo& Find(const msg::MachineStatus& status, const std::string& actuator);
// Whether the machine is settled in `state` and all actuators but `without` are available and well.
bool IsSettled(const msg::MachineStatus& status, const std::string& state,
               const std::set<std::string>& without = {});

}  // namespace musher::fault_injection
