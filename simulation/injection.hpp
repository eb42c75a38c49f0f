#pragma once
// What befalls a simulated robot: faults, and what people and applications ask for, each at its
// time. A list of them, with a seed, is a whole scenario; taking some away leaves the others as
// they are.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/lifecycle/config.hpp"
#include "musher/simulation/phase.hpp"

namespace musher::simulation {

enum class InjectionKind : std::uint8_t {
  kCrash,             // an actuator's process ends
  kWrongConfig,       // it ends with exit code 2, and so does each that starts meanwhile
  kFreeze,            // it is stopped for a while, as by SIGSTOP
  kHang,              // callbacks that begin meanwhile do not end
  kSlow,              // they take about as long as they may, or longer
  kFail,              // they end with a code
  kLie,               // an actuator says that it is in a state, and is not
  kLoss,              // messages are lost, everywhere, for a while
  kDelay,             // they come late
  kDuplication,       // they come twice
  kReordering,        // they overtake each other
  kPartition,         // an actuator and the controllers do not hear each other
  kDeaf,              // it does not hear them
  kMute,              // they do not hear it
  kControllerCrash,   // the controllers end; one is started again after a while
  kControllerFreeze,  // the one that leads is stopped for a while
  kRival,             // a second controller comes up, and refuses if it hears the first
  kTakeover,          // a second one takes over
  kFullDisk,          // the controllers can write nothing, for a while
  kWallClock,         // the wall clock jumps
  kSet,               // a person switches the machine
  kSetOne,            // a person switches one actuator
  kBattery,           // the battery comes to a level, maybe with its cable in
  kEmergencyStop,
  kRelease,  // of emergency stops
  kRestart,  // a person restarts an actuator
  // Where the config has [policy].
  kStillness,       // the body lies still, or moves again
  kWakeUp,          // somebody wakes the robot up
  kKeep,            // an application keeps the machine in a state, or ends that
  kOta,             // an application enters OTA, or leaves it
  kLowPowerSwitch,  // a person switches LowPower by lying still on or off
  kPowerOff,        // a person switches the robot off by its button
  // Of hosts.
  kReboot,         // a host is rebooted: its processes end, its clock begins again
  kHostPartition,  // two hosts are cut off from each other, for a while
  kHostOneWay,     // nothing gets from one host to another, for a while
  kStalledDisk,    // what the controllers write does not end, for a while
  kCrossingStops,  // two panels engage an emergency stop, and a release crosses them
  // By a client on a host.
  kClientSet,      // it requests a switch
  kClientStatus,   // it queries the status
  kClientRelease,  // it releases the emergency stops
  kClientRestart,  // it restarts an actuator
};
inline constexpr std::size_t kInjectionKinds = 41;

std::string_view KindName(InjectionKind kind);  // "crash", "controller-freeze", …

struct Injection {
  InjectionKind kind = InjectionKind::kCrash;
  Duration at{};                     // after the robot was switched on, at the earliest
  std::optional<MachinePhase> when;  // then it waits for this, but not for ever
  std::size_t actuator = 0;          // of the config; means nothing where everybody is concerned
  std::size_t host = 0;              // of the layout
  std::size_t other_host = 0;        // of what concerns two
  State state;                       // that is asked for, or lied about
  Duration lasts{};                  // of what lasts
  std::uint64_t chance = 0;          // for whatever else has to be drawn

  friend bool operator==(const Injection&, const Injection&) = default;
};
using Injections = std::vector<Injection>;

// Whether it is a fault, as against a request.
bool IsFault(InjectionKind kind);

// The same from the same seed, in the order of their time: some of them milliseconds apart, or
// aimed at a moment, so that they meet in one switch.
Injections SampleInjections(const MachineConfig& config, std::uint64_t seed);

// "the process of audio is killed"
std::string Describe(const MachineConfig& config, const Injection& injection);

// Of kBattery: the percentage, and whether the cable is in.
int BatteryOf(const Injection& injection);
bool ChargesIn(const Injection& injection);

}  // namespace musher::simulation
