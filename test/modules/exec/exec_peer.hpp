#pragma once
// The peer of a musher-exec process, which is the actuator "motion".

#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>

#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/test/modules/actuator_peer.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::exec {

class ExecPeer : public test::ActuatorPeer {
 public:
  ExecPeer()
      : ActuatorPeer("motion", {"SetUp", "TearDown", "SelfCheck", "Active", "LowPower"},
                     "musher-exec") {
    stops_ = transport::MakePublisher<msg::EmergencyStop>(node(), transport::EmergencyStopTopic(""),
                                                          transport::kLatchedQos)
                 .value();
    statuses_ = transport::MakeSubscription<msg::ActuatorStatus>(
                    node(), transport::ActuatorStatusTopic(""),
                    [this](const msg::ActuatorStatus& status, const transport::SampleInfo&) {
                      status_ = status;
                      const bool confirms = status.stop_trouble.empty();
                      if (status.emergency_stop != 0 && confirms) confirmed_.emplace(status.target);
                    },
                    transport::kLatchedFromManyQos)
                    .value();
  }

  void EngageStop(std::uint64_t id = 7) { PublishStop(true, id); }
  // As its controller.
  bool ReleaseStop() {
    PublishStop(false);
    return Until([this] { return status_.emergency_stop == 0; });
  }
  // Waits until it has the stop, with a trouble of which that holds: "" once it is confirmed.
  bool AwaitTrouble(const std::function<bool(const std::string&)>& holds) {
    return Until([&] {
      return status_.pid == pid() && status_.emergency_stop != 0 && holds(status_.stop_trouble);
    });
  }
  bool AwaitTrouble(const std::string& trouble) {
    return AwaitTrouble([&](const std::string& now) { return now == trouble; });
  }
  const std::string& trouble() const { return status_.stop_trouble; }
  // Whether a status has confirmed a stop while the callback of that state ran.
  bool HasConfirmedDuring(const State& target) const { return confirmed_.contains(target); }
  void ForgetConfirmations() { confirmed_.clear(); }

 private:
  void PublishStop(bool engaged, std::uint64_t id = 7) {
    msg::EmergencyStop stop;
    stop.id = id;
    stop.engaged = engaged;
    stop.by = "alice";
    static_cast<void>(stops_->Publish(stop));
  }

  msg::ActuatorStatus status_;
  std::set<State> confirmed_;
  std::unique_ptr<transport::Publisher<msg::EmergencyStop>> stops_;
  std::unique_ptr<transport::Subscription> statuses_;
};

}  // namespace musher::exec
