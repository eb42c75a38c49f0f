#pragma once
// What a controller stores on disk for the next one. Plain values.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/lifecycle/field.hpp"
#include "musher/lifecycle/ids.hpp"
#include "musher/lifecycle/machine/report.hpp"

namespace musher {

// Another state folder of the machine that the user of this controller may not read: a stop may be
// engaged there.
struct UnreadFolder {
  std::string folder;
  std::string owner{};     // its user, for people; "" = not known
  std::uint64_t mark = 0;  // another one once a controller has begun with the folder
  bool answered = false;   // a person has requested a state since

  friend bool operator==(const UnreadFolder&, const UnreadFolder&) = default;
};

// The emergency stops that are stored for the next controller.
struct StoredStops {
  std::vector<EmergencyStop> engaged;  // oldest first
  std::vector<StopId> released;        // with stops that newer ones replaced; the last release last
  bool awaits_request = false;         // since the last stop no switch up has been requested
  std::vector<UnreadFolder> unread{};  // whose stops are not known
  std::vector<StopId> replaced{};      // of `released`, those that no release has covered since
  // How often a controller with this folder has engaged a stop, also one that it found engaged.
  std::uint64_t engagements = 0;
  // A controller of another host has replaced the last one with this folder. What it has engaged
  // since is in its own folder.
  bool led_elsewhere = false;

  friend bool operator==(const StoredStops&, const StoredStops&) = default;
};

// Adds a stop to the engaged stops. It replaces an older stop of the same source; one without a
// source replaces none. Where there are too many, it replaces the oldest without a source, or else
// the oldest. A replaced stop is over, and the next release ends it at the actuators. Returns
// whether the stop has new information.
bool AddStop(StoredStops& stops, const EmergencyStop& stop);
// A stop that a release has ended. It never engages again.
void AddReleased(StoredStops& stops, StopId id);

// The same for stops that are received before the disk says which of them are over. None replaces
// another one of its source: one that is over would end the engaged one, and be dropped itself.
// Where there are too many, the oldest of the source is forgotten, or else the oldest, and is not
// over: an actuator that has latched it reports it.
void AddReceived(StoredStops& received, EmergencyStop stop);
void AddReceivedRelease(StoredStops& received, StopId id);

// Merges the stops on disk with the stops that other controllers and panels have sent since. A stop
// that is released on one side is over.
StoredStops Merge(const StoredStops& stored, const StoredStops& received);
// Removes the stops from `received` that are released on the disk: the disk also has whether they
// wait for a request. A panel may publish such a stop for ever.
StoredStops WithoutReleased(const StoredStops& stored, StoredStops received);

// An actuator that runs on another host, as it is stored for the next controller.
struct RemoteActuator {
  std::string name;
  std::string host;  // "": not known

  friend bool operator==(const RemoteActuator&, const RemoteActuator&) = default;
};

// Why an actuator stays down until a person starts it again.
enum class StaysDown {
  kNo,
  kTornDown,  // a person has torn it down alone
  kGivenUp,   // its process has exited, and is not restarted
};

// What the next controller has to know of an actuator that does not say so itself, because its
// process has ended, or may have by then.
struct StoredActuator {
  std::string name;
  StaysDown stays_down = StaysDown::kNo;
  State lost_in{};  // in which its process was lost, with no successor in use; may be
                    // kUnknownState; "": in none
  State kept_in{};  // in which a person holds it; "": in none

  friend bool operator==(const StoredActuator&, const StoredActuator&) = default;
};

// What a controller stores on disk for the next one.
enum class Stored {
  kEpoch,
  kEmergencyStops,
  kPolicy,
  kStopIntent,  // the machine is to be torn down and to stay down
  kRemoteActuators,
  kActuators,
  kJournal,  // not by a save: its writer reports when writing begins to fail, and when it works
};
std::string_view StoredName(Stored what);  // "epoch", "emergency stop", …

// Data that was handed to the disk thread and is not known to be saved.
struct Unsaved {
  Stored what = Stored::kEpoch;
  SaveNumber save = 0;  // the number of the last save
  Time since{};         // of the first save that is not on disk
  std::string why;      // of a failure; empty: not ended yet

  friend bool operator==(const Unsaved&, const Unsaved&) = default;
};

}  // namespace musher

namespace musher::fields {

template <>
inline constexpr std::array<std::string_view, 7> kValueNames<Stored> = {
    "epoch",     "emergency stops", "policy", "stop intent", "remote actuators",
    "actuators", "journal"};
static_assert(EndsWith(Stored::kJournal));

template <>
inline constexpr std::array<std::string_view, 3> kValueNames<StaysDown> = {"no", "torn-down",
                                                                           "given-up"};
static_assert(EndsWith(StaysDown::kGivenUp));

template <>
inline constexpr std::tuple kFields<UnreadFolder> = {
    Field{"folder", &UnreadFolder::folder},
    Field{"owner", &UnreadFolder::owner},
    Field{"mark", &UnreadFolder::mark},
    Field{"answered", &UnreadFolder::answered},
};

template <>
inline constexpr std::tuple kFields<StoredStops> = {
    Field{"engaged", &StoredStops::engaged},
    Field{"released", &StoredStops::released},
    Field{"awaits_request", &StoredStops::awaits_request},
    Field{"unread", &StoredStops::unread},
    Field{"replaced", &StoredStops::replaced},
    Field{"engagements", &StoredStops::engagements},
    Field{"led_elsewhere", &StoredStops::led_elsewhere},
};

template <>
inline constexpr std::tuple kFields<RemoteActuator> = {
    Field{"name", &RemoteActuator::name},
    Field{"host", &RemoteActuator::host},
};

template <>
inline constexpr std::tuple kFields<StoredActuator> = {
    Field{"name", &StoredActuator::name},
    Field{"stays_down", &StoredActuator::stays_down},
    Field{"lost_in", &StoredActuator::lost_in},
    Field{"kept_in", &StoredActuator::kept_in},
};

template <>
inline constexpr std::tuple kFields<Unsaved> = {
    Field{"what", &Unsaved::what},
    Field{"save", &Unsaved::save},
    Field{"since", &Unsaved::since},
    Field{"why", &Unsaved::why},
};

}  // namespace musher::fields
