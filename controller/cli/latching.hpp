#pragma once
// An emergency stop on its way to everybody who listens, and who has latched it. Needs no
// controller: the actuators hear it themselves, and say in their status what they have latched.
//
// Threads: loop thread only.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/transport/node.hpp"

namespace musher::cli {

// How an emergency stop has been taken so far.
struct EstopReport {
  struct Actuator {
    std::string name;
    bool stopped = false;
    bool before = false;  // by an earlier emergency stop
    Duration after{};     // since this one was told; 0 when it was stopped before
    std::string trouble;  // what the controller knows of one that is not stopped: "hung"
    bool deaf = false;    // its protocol knows no emergency stop
  };
  // One that was engaged already. Who and why is known to a controller.
  struct Earlier {
    std::string by;
    std::string reason;
  };

  std::string by;
  std::string reason;
  bool controller = false;       // there is one …
  bool controller_took = false;  // … and it will tell those who come later …
  bool knows_who = false;        // … by whom and why, unless that was lost with an earlier one
  std::optional<Earlier> earlier;
  std::vector<Actuator> actuators;

  std::vector<std::string> Missing() const;  // who is not stopped
  // Everybody who can take it has it: nothing more is to be waited for.
  bool settled() const;
  // Everybody who is known has it.
  bool complete() const { return Missing().empty() && controller == controller_took; }
};

class Latching {
 public:
  // Tells the stop at once, and again to whoever comes as long as this lives. `node` must outlive
  // it.
  // `with_keys`: the machine has [security], and so has `node`.
  static Result<std::unique_ptr<Latching>> Begin(transport::Node& node,
                                                 const std::string& name_space,
                                                 const msg::EmergencyStop& stop,
                                                 bool with_keys = false);

  // Those who were heard, and those of whom the controller's status says that they are there, in
  // its order.
  EstopReport Report(const std::optional<msg::MachineStatus>& controller) const;

 private:
  struct Heard {
    transport::PeerId writer = 0;
    std::uint64_t latched = 0;
    Duration after{};
  };

  Latching(transport::Node& node, msg::EmergencyStop stop);
  void OnStatus(const msg::ActuatorStatus& status, const transport::SampleInfo& info);
  EstopReport::Actuator& Take(EstopReport& report, const std::string& name,
                              const std::string& trouble) const;

  transport::EventLoop& loop_;
  const msg::EmergencyStop stop_;
  const Time begun_;
  std::map<std::string, Heard> heard_;
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> stops_;
  std::unique_ptr<transport::Subscription> statuses_;  // last: its callbacks use all of the above
};

}  // namespace musher::cli
