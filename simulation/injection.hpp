#pragma once
// The events that are injected into a simulated robot: faults, and requests of operators and
// applications, each at its time. A list of them, with a seed, is a whole scenario; removing some
// leaves the others as they are.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/lifecycle/config/config.hpp"
#include "musher/simulation/phase.hpp"

namespace musher::simulation {

enum class InjectionKind : std::uint8_t {
  // Events that last hold for Injection::lasts.
  kCrash,        // an actuator's process is killed
  kWrongConfig,  // it exits with code 2, as does each process of it that starts meanwhile; lasts
  kFreeze,       // it is frozen, as by SIGSTOP; lasts
  kHang,         // callbacks that begin meanwhile never return; lasts
  kSlow,         // callbacks take half their time limit or more, some exceed it; lasts
  kFail,         // callbacks fail; lasts
  kLie,          // an actuator publishes a state once that it is not in
  kLoss,         // messages are lost on all links; lasts
  kDelay,        // messages are delayed; lasts
  kDuplication,  // messages are duplicated; lasts
  kReordering,   // messages are reordered; lasts
  kPartition,    // the link between an actuator and the controllers is cut; lasts
  kDeaf,         // the same, only towards the actuator; lasts
  kMute,         // the same, only from the actuator; lasts
  kControllerCrash,   // the controllers are killed; one is started again afterwards
  kControllerFreeze,  // the leading controller is frozen; lasts
  kRival,             // a second controller starts, and refuses if it receives the first
  kTakeover,          // a second controller starts with --takeover
  kFullDisk,          // every write of the controllers fails; lasts
  kWallClock,         // the wall clock jumps
  kSet,               // an operator switches the machine
  kSetOne,            // an operator switches one actuator
  kBattery,           // the battery reaches a level, possibly while charging
  kEmergencyStop,     // an emergency stop is engaged
  kRelease,           // the emergency stops are released
  kRestart,           // an operator restarts an actuator
  // Only with a config that has [policy].
  kStillness,       // the body lies still, or moves again
  kWakeUp,          // the robot is woken up
  kKeep,            // an application keeps the machine in a state, or ends that
  kOta,             // an application enters OTA, or leaves it
  kLowPowerSwitch,  // an operator switches automatic LowPower on or off
  kPowerOff,        // an operator presses the power button
  kBatteryGlitch,   // one sample of the battery is wrong
  kBatteryWriter,   // a second program publishes the battery, with another level; lasts
  kBatteryWalk,     // the battery's level jitters by a random walk; lasts
  // Faults of hosts.
  kReboot,         // a host reboots: its processes end, its clock is reset
  kHostPartition,  // the link between two hosts is cut; lasts
  kHostOneWay,     // the link from one host to another is cut; lasts
  kStalledDisk,    // no write of the controllers ends; lasts
  kCrossingStops,  // two panels engage an emergency stop, and a release crosses them
  kTakeBack,       // the first controller starts again, with --takeover
  // Requests of a client on a host.
  kClientSet,      // a switch
  kClientStatus,   // the status
  kClientRelease,  // the release of the emergency stops
  kClientRestart,  // the restart of an actuator
  // What is around the robot.
  kOtherMachine,   // another machine comes into range, in the same namespace; lasts
  kOuterNetwork,   // a host's outer interface is gone, its loopback remains; lasts
  kLostFiles,      // the files of the controllers are removed while they run
  kBridge,         // a bridge repeats old statuses and heartbeats, and leaves; lasts
  kStopProgram,    // a program on a host engages a stop, over links that may be bad
  kManyStops,      // a panel engages stops by the hundred
  kUnnamedStop,    // a panel engages a stop without an id
  kSilentBattery,  // nothing publishes the battery; lasts
  kSlowDiscovery,  // a client on a host needs seconds to discover what it calls; lasts
  // A scenario with one of these has a machine that needs permits to move, which a console on
  // `host` gives, or whose policy follows /clock.
  kPermitFault,  // the permits to move are lost or late, or the console's program ends; lasts
  kClockFault,   // /clock pauses, jumps, or runs at another rate; lasts
  // From its next start on, a controller finds another state folder of the machine that its user
  // may
  // not read.
  kUnreadFolder,
  kClosedFolder,  // its own cannot be opened for writing, or not at all; lasts
  kOtherUser,     // another user starts the machine, with another state folder, mostly after a boot
  kFrozen,        // an actuator's process is frozen until it is ended
};
inline constexpr std::size_t kInjectionKinds = 60;

std::string_view KindName(InjectionKind kind);  // "crash", "controller-freeze", …
// The text of a kind with names in braces: "the process of {actuator} is killed"; see Describe().
std::string_view FormOf(InjectionKind kind);

struct Injection {
  InjectionKind kind = InjectionKind::kCrash;
  Duration at{};                     // after the robot was switched on, at the earliest
  std::optional<MachinePhase> when;  // then it waits for this phase, with a timeout
  ActuatorIndex actuator = 0;  // index in the config; unused where all actuators are concerned
  std::size_t host = 0;        // index in the layout
  std::size_t other_host = 0;  // of events that concern two hosts
  State state;                 // the requested, or falsely reported, state
  Duration lasts{};            // of events that last
  std::uint64_t random = 0;    // a random number for any other parameter

  friend bool operator==(const Injection&, const Injection&) = default;
};
using Injections = std::vector<Injection>;

// Whether it is a fault rather than a request.
bool IsFault(InjectionKind kind);

// Whether it comes from outside of the robot. These have a random generator of their own: the other
// events of a seed do not depend on them.
bool IsAround(InjectionKind kind);

// Samples the events of a scenario, the same from the same seed, in the order of their time. Some
// are milliseconds apart, or wait for a phase, so that they meet in one switch.
// `bridges`: also kBridge.
Injections SampleInjections(const MachineConfig& config, std::uint64_t seed, bool bridges = false);

// "the process of audio is killed"
std::string Describe(const MachineConfig& config, const Injection& injection);

// What happens to the permits to move, and to /clock.
enum class PermitFault : std::uint8_t { kConsoleEnds, kLost, kLate, kCut };
PermitFault PermitFaultOf(const Injection& injection);
enum class ClockFault : std::uint8_t { kRate, kPause, kBack, kForward, kRestart };
ClockFault ClockFaultOf(const Injection& injection);
std::int64_t ClockRateOf(const Injection& injection);  // permille
Duration ClockJumpOf(const Injection& injection);

// Percentage of the battery's kinds, and whether the battery is charging.
int BatteryOf(const Injection& injection);
bool ChargesIn(const Injection& injection);

}  // namespace musher::simulation
