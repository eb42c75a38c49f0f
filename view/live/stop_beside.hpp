#pragma once
// The emergency stop of a page for a machine of this host in another namespace than the page's: the
// person on the page may mean that one. It goes to every actuator there.
//
// Threads: loop thread only.

#include <memory>
#include <string>

#include "musher/controller/client/leader_watch.hpp"
#include "musher/controller/client/stop_latch.hpp"
#include "musher/controller/storage/machine_places.hpp"

namespace musher::view {

class StopBeside {
 public:
  struct Options {
    MachinePlace own;  // of the page
    std::string host;  // HostId()
    std::string word;  // by which the person has chosen a machine; empty: none
    bool with_keys = false;
    bool lan = false;
  };

  // Published at once, and as long as this exists. The node must outlive it.
  StopBeside(transport::Node& node, const MachinePlace& place, msg::EmergencyStop stop,
             const Options& options);

  // Why the machine there is not known to be stopped: "the machine of this host in namespace
  // 'dogA': not stopped: legs"; empty: its controller and all of its actuators have confirmed it.
  std::string WhyNot() const;

 private:
  const MachinePlace place_;
  const std::string text_;
  const bool lan_;
  std::string error_;
  std::unique_ptr<StopLatch> latch_;     // null: the stop could not be published by DDS
  std::unique_ptr<LeaderWatch> leader_;  // null: no status is received
};

// Why not all is stopped, as a sentence; empty: all is.
std::string WhyNotStopped(const EstopReport& report);

}  // namespace musher::view
