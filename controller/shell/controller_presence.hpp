#pragma once
// Publishes this controller's heartbeat with its epoch, receives the heartbeats of other
// controllers, and publishes emergency stops. Only a controller of the same machine is a rival; one
// of another machine in the namespace and domain is reported, and never fences this one.
//
// Threads: loop thread only.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/break_watch.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/coordinator/coordinator.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/transport/node.hpp"

namespace musher {

// Long enough to receive the heartbeat of a controller of another host.
Duration ListenTime(const MachineConfig& config);

class ControllerPresence {
 public:
  using Emit = std::function<void(Event)>;
  struct Identity {
    Incarnation incarnation = 0;
    std::int32_t pid = 0;
    std::string host;
    std::string host_name{};   // for people; may be empty
    std::string machine_id{};  // of this controller's machine; empty: not known yet
  };
  // Another controller whose heartbeat was received.
  struct Rival {
    std::string process;  // "process 4711 of this host"
    Epoch epoch = 0;
    MachineIdentity machine;
    // No switch up was requested since its last emergency stop, or the controller may not read
    // whether a stop is engaged in another folder.
    bool awaits_request = false;
    bool here = false;  // on this host
  };
  // Called with its controller when another machine appears in the namespace and domain, and now
  // and then while the machine stays. Called with null when a machine is no longer received, or is
  // received again a short time after it was reported.
  using OnOtherMachine = std::function<void(const Rival*)>;

  // `node` and `config` must outlive it.
  static Result<std::unique_ptr<ControllerPresence>> Make(transport::Node& node,
                                                          const MachineConfig& config,
                                                          Identity identity, Emit emit,
                                                          OnOtherMachine on_other = {});

  // Before Announce(): the id of this controller's machine.
  // With it a rival of the same name may be another machine's.
  void SetMachineId(std::string id);
  MachineIdentity machine() const { return {config_.name, identity_.machine_id}; }
  // Rival::awaits_request of this controller, for a controller of another host that takes over.
  // Published at once: a successor that listens may see neither the stop nor its release.
  void SetAwaitsRequest(bool awaits);
  // Publishes the heartbeat at once and periodically from now on.
  void Announce(Epoch epoch);
  // Publishes the heartbeat once more, for an actuator that may not have received it.
  void Repeat();
  // Time from which this controller may start processes. After a silence, because its own process
  // was stopped or its computer suspended, it must listen first: a controller of another host may
  // have taken over and started them.
  Time MayStartProcessesAt();
  // How long this controller could not run just now: a request that arrives may be as old. See
  // BreakWatch.
  std::optional<Duration> RecentBreak();
  // Another controller of this machine, if any.
  const std::optional<Rival>& rival() const { return rival_; }
  // The controllers of other machines whose heartbeats still arrive.
  std::vector<Rival> OtherMachines() const;
  // Stops publishing: another controller leads, or the machine is stopped.
  void FallSilent();

  // An emergency stop was received, from a program without a participant if `from` is 0. A stop of
  // another machine is ignored, and so is a release that no controller has published: it counts
  // once a heartbeat of its participant has arrived.
  void OnStop(const msg::EmergencyStop& stop, transport::ParticipantId from = 0);
  void Publish(const action::PublishEmergencyStop& published);
  // No stop is engaged any more: an actuator that joins from now on receives releases only.
  void ForgetEngaged() { engaged_stops_ = nullptr; }

 private:
  ControllerPresence(transport::Node& node, const MachineConfig& config, Identity identity,
                     Emit emit, OnOtherMachine on_other);
  Result<> Open();
  void OnHeartbeat(const msg::ControllerHeartbeat& heartbeat);
  void NoteController(transport::ParticipantId participant);
  void NoteOtherMachine(Rival other);
  void NoteOtherSilence();
  void NoteSilence();
  std::string HostOf(const msg::ControllerHeartbeat& heartbeat) const;

  transport::Node& node_;
  const MachineConfig& config_;
  Identity identity_;
  const Emit emit_;
  const OnOtherMachine on_other_;
  Epoch epoch_ = 0;
  bool awaits_request_ = false;
  std::optional<Rival> rival_;
  struct Release {
    transport::ParticipantId from = 0;
    msg::EmergencyStop stop;
  };
  std::vector<transport::ParticipantId> controllers_;  // the latest of this machine but ours
  std::vector<Release> unproven_;  // perhaps of such a controller, the last ones
  struct OtherMachine {
    Rival controller;
    Time received{};
    std::optional<Time> reported{};
    bool present = true;
  };
  std::map<std::pair<std::string, std::string>, OtherMachine> others_;  // by name and id
  Time last_heartbeat_{};
  Duration suspended_then_{};  // at the last heartbeat
  Time listens_until_{};
  BreakWatch breaks_;
  std::unique_ptr<transport::Publisher<msg::ControllerHeartbeat>> heartbeats_;
  // Both latch their last stops for actuators that join later. engaged_stops_ exists only while a
  // stop is engaged: an actuator must not receive a stop that is over.
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> engaged_stops_;
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> released_stops_;
  transport::LoopHandlePtr timer_;
  std::unique_ptr<transport::Subscription> rivals_;
  std::unique_ptr<transport::Subscription> received_stops_;
};

}  // namespace musher
