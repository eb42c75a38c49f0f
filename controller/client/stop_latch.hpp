#pragma once
// Publishes an emergency stop and collects which actuators have latched it. Needs no controller:
// the actuators subscribe to the stop themselves and publish in their status what they latched.
//
//   published ──a controller of the machine that it names publishes its release──▶ withdrawn
//
// If the stop were published longer, a restarted module would latch it again. A release counts as
// it does for a controller (shell/controller_presence.hpp): only from a participant whose own
// heartbeat says that it is a controller of the machine. A panel, or a bridge that repeats the
// samples of other participants, withdraws nothing. The heartbeat may come after the release,
// within its period.
//
// A stop that names a machine without its id:
//
//   by the name ──one that has it was found, and the time to find others is over──▶ by the ids
//   found
//
// Then a robot of the name that is started or comes into range later is not stopped, unless its
// host is one of theirs: there the name decides which machine it is, as for commands. A controller
// that restarts has the same id. While none was found the name counts: the robot of the person may
// not be discovered yet.
//
// A stop that names no machine is for all, and is withdrawn once each machine that was found has
// released it, the time to find others is over, and one of them runs on this host: the person on a
// robot whose controller has ended means that one. Where none runs here, the robot that is meant
// may still be out of range: no release withdraws the stop.
//
// Threads: loop thread only.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/controller/client/detached_publisher.hpp"
#include "musher/controller/client/machine_here.hpp"
#include "musher/lifecycle/ids.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/transport/node.hpp"

namespace musher {

// Which actuators have latched an emergency stop so far.
struct EstopReport {
  struct Actuator {
    std::string name;
    bool stopped = false;
    bool before = false;       // by an earlier emergency stop
    Duration after{};          // since this one was published; 0 if it was stopped before
    std::string trouble;       // if not stopped: why, by itself or the controller: "hung"
    bool unsupported = false;  // its protocol has no emergency stop
    bool ended = false;        // its process has exited while it was on, and latches nothing
    bool found = true;         // else it is only known from a config or a state folder
  };
  // An emergency stop that was already engaged. Only a controller has its origin and reason.
  struct Earlier {
    std::string by;
    std::string reason;
  };

  std::string by;
  std::string reason;
  bool controller = false;          // a controller leads …
  bool controller_latched = false;  // … has latched the stop and publishes it to later actuators …
  // This stop itself is engaged: the controller lists it with its origin and reason, or every
  // stopped actuator has it. If not, perhaps only an earlier stop holds the machine, and the
  // release of the earlier stop would free it. Also true once a controller has reported that this
  // stop is over.
  bool held = false;
  std::optional<Earlier> earlier;
  std::vector<MachineIdentity> machines;  // found here, so that the stop was sent to them
  std::vector<Actuator> actuators;
  std::string silent_controller;  // of this host: why it does not answer, and what to do
  std::string not_on_disk;        // the controller has not saved it: "emergency stop (4 s): …"
  std::string unknown;  // why the machine may have more actuators than these; empty: it has not

  std::vector<std::string> Missing() const;  // the actuators that are not stopped
  // Why this stop itself is not known to be engaged, as a sentence; empty: it is.
  std::string WhyNotHeld() const;
  // There is something to stop.
  bool found() const;
  // Every actuator that can latch the stop has: no need to wait longer.
  bool settled() const;
  // Every actuator of the machine is stopped, and this stop holds it.
  bool complete() const {
    return Missing().empty() && controller == controller_latched && held && unknown.empty();
  }
};

// A stop to engage: with a random id, and the first kLongestStopReason bytes of the reason. `by`:
// the person or program.
inline constexpr std::size_t kLongestStopReason = 256;
msg::EmergencyStop NewEmergencyStop(std::string by, std::string_view reason);

// Hands the stop to the controller of this host, which publishes it: long before this process has
// discovered an actuator where the host is busy. Waits for nothing. Not for a machine with
// [security], whose credentials it does not check.
void HandOverStop(const msg::EmergencyStop& stop, int domain_id, const std::string& name_space);

// What the program that engages a stop knows of its machine.
struct StopView {
  std::optional<msg::MachineStatus> controller = {};  // the controller's last status, if it answers
  bool has_controller = false;  // it was discovered, or a controller runs on this host
  bool lan = false;             // there may be actuators on other hosts
  std::vector<std::string> running_here = {};  // names of the actuators on this host
  std::vector<MachineHere> machines = {};      // that this host has or had
};

// Where a program that engages a stop looks for its machine.
struct StopScope {
  std::string name_space;
  int domain_id = 0;
  bool lan = false;
  std::vector<MachineHere> machines = {};  // of this host, perhaps also others than the stopped one
};

// What this host knows at once: its controller and its actuators hold their names.
StopView ViewFromHere(const StopScope& scope, std::optional<msg::MachineStatus> controller);

struct StopOptions {
  bool with_keys = false;                // the machine has [security], and so has the node
  bool lan = false;                      // other hosts may take as long as a bad link to be found
  std::function<void()> on_change = {};  // the report has changed, or the stop is released
  // In the process of a DetachedPublisher: the notes of the latch that this one continues.
  DetachedPublisher::Notes notes = {};
};

class StopLatch {
 public:
  // How long the actuators of this host may take to be discovered, with keys, and of other hosts.
  static constexpr Duration kDiscovery = Milliseconds(1200);
  static constexpr Duration kSecuredDiscovery = Milliseconds(4000);
  static constexpr Duration kLanDiscovery = std::chrono::seconds(10);

  // Publishes the stop at once and, while this object exists and the stop is not released, to
  // actuators that join later. `node` must outlive it.
  static Result<std::unique_ptr<StopLatch>> Begin(transport::Node& node,
                                                  const std::string& name_space,
                                                  const msg::EmergencyStop& stop,
                                                  StopOptions options = {});

  // The stop is also for each machine whose id begins with `beginning`. It is published at once to
  // the `known` machines, to others as soon as a sample of them is received. For a word of a person
  // that may be the name of a machine, or the beginning of an id.
  void AddBeginningOfId(std::string beginning, const std::vector<MachineIdentity>& known = {});

  // The publisher outlives this object and continues the stop after it. It gets a note of each
  // machine that is found, and is cancelled once the stop is withdrawn, whichever process has
  // requested the release.
  void ContinueWith(DetachedPublisher& publisher);

  // The actuators whose status was received, and those that the controller's status lists as
  // present, in its order. `expected`: names of actuators that run, whether or not their status was
  // received.
  EstopReport Report(const std::optional<msg::MachineStatus>& controller,
                     const std::vector<std::string>& expected = {}) const;
  // The same, with why the machine may have more actuators. Without a controller the actuators of
  // the machine that may run on other hosts belong to it, too.
  EstopReport Report(const StopView& view) const;

  // Whether no second machine is known for which the stop is meant.
  bool IsForOneMachine() const { return addressed_.size() < 2 && Machines().size() < 2; }

  // The stop is released: it is published no longer.
  bool withdrawn() const { return withdrawn_; }

  // Whether there is nothing left to wait for: every actuator of the machine that can latch the
  // stop has done so. Without a controller no process lists the actuators. Then the time of
  // discovery has to be over, too: the first actuator that is found may not be the only one.
  bool IsOver(const EstopReport& report) const;

 private:
  // The last status of a process that publishes as an actuator.
  struct Received {
    transport::EndpointId writer = 0;
    StopId latched = 0;   // the first that is engaged
    bool has_it = false;  // this stop is engaged, too
    std::string trouble;  // what it has not done at the stop
    Duration after{};
    std::string host;  // of its process, as in msg::ActuatorStatus; "": not known
  };
  // A controller, or a release that its machine's controller may have published.
  struct Origin {
    transport::ParticipantId participant = 0;
    MachineIdentity machine;
  };

  // A machine that runs, by one of its processes.
  struct Found {
    MachineIdentity machine;
    std::string host;

    friend bool operator==(const Found&, const Found&) = default;
  };

  StopLatch(transport::Node& node, const std::string& name_space, msg::EmergencyStop stop,
            StopOptions options);
  static std::string NoteOf(const Found& found);
  bool ContinueFrom(const DetachedPublisher::Notes& notes);
  void OnStatus(const msg::ActuatorStatus& status, const transport::SampleInfo& info);
  static void Note(std::vector<MachineIdentity>& machines, const MachineIdentity& machine);
  std::vector<MachineIdentity> Machines() const;
  MachineIdentity given() const { return {stop_.machine, stop_.machine_id}; }
  bool named() const { return !stop_.machine.empty() || !stop_.machine_id.empty(); }
  Duration TimeToFind() const;
  // Whether the stop goes to machines by their ids alone.
  bool by_ids() const { return !stops_ || !stop_.machine_id.empty(); }
  bool IsMeant(const MachineIdentity& machine) const;
  bool IsHeld(const EstopReport& report, const std::optional<msg::MachineStatus>& controller) const;
  void Meet(const MachineIdentity& machine, const std::string& host);
  void Address(const MachineIdentity& machine);
  void Narrow();
  void FollowReleases(const std::string& name_space);
  void Note(std::vector<Origin>& origins, Origin origin);
  bool IsReleasedFor(const MachineIdentity& machine) const;
  bool IsReleased() const;
  void WithdrawIfReleased();
  std::vector<const MachineHere*> MachinesOf(const StopView& view) const;
  std::string WhyUnknown(const StopView& view) const;
  std::vector<std::string> UnlistedHere(const StopView& view) const;
  static std::vector<StoredActuator> Unlisted(std::vector<StoredActuator> actuators,
                                              const msg::MachineStatus& controller);
  static void AddLost(EstopReport& report, const std::vector<StoredActuator>& lost);
  static void AddElsewhere(EstopReport& report, const std::vector<std::string>& names);
  bool MayBeReleased(const Received& one,
                     const std::optional<msg::MachineStatus>& controller) const;
  EstopReport::Actuator& Take(EstopReport& report, const std::string& name,
                              const std::string& trouble,
                              const std::optional<msg::MachineStatus>& controller) const;

  transport::Node& node_;
  transport::EventLoop& loop_;
  const std::string topic_;
  const msg::EmergencyStop stop_;  // as it was given
  std::string id_begins_;
  const StopOptions options_;
  const Time begun_;
  bool withdrawn_ = false;
  DetachedPublisher* publisher_ = nullptr;
  // By actuator. Two processes of one actuator may run, on two hosts: each has to be stopped.
  std::map<std::string, std::vector<Received>> received_;
  // Actuators of this host whose last status neither confirms nor prevents: of another machine, or
  // torn down.
  std::map<std::string, transport::EndpointId> not_counted_;
  std::vector<MachineIdentity> machines_;   // of the received statuses; no two are the same
  std::vector<Found> found_;                // that are meant
  std::vector<MachineIdentity> addressed_;  // by their ids, whole
  std::vector<Origin> controllers_;         // the last ones
  std::vector<Origin> releases_;            // of this stop, the last ones
  // `stops_` publishes the stop as it was given, until Narrow(); `stops_by_id_` publishes it to the
  // addressed machines. The second one begins long before the first one ends: a reader on a bad
  // link needs time to discover it.
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> stops_;
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> stops_by_id_;
  transport::LoopHandlePtr narrow_at_;
  transport::LoopHandlePtr found_by_;  // of a stop that names no machine: the time is over
  std::unique_ptr<transport::Subscription> heartbeats_;
  std::unique_ptr<transport::Subscription> published_releases_;
  std::unique_ptr<transport::Subscription> statuses_;  // last: its callbacks use all of the above
};

}  // namespace musher
