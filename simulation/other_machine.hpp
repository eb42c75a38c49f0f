#pragma once
// Another machine in the network of a simulated robot: another robot of the same namespace and
// domain, on a host of its own. It has the same actuators, an id of its own and perhaps the same
// name. A checker of its own holds it to the same invariants.
//
// Threads: the one of the network.

#include <functional>
#include <set>
#include <string>

#include "musher/simulation/checker.hpp"
#include "musher/simulation/robot.hpp"
#include "musher/transport/sim/random.hpp"

namespace musher::simulation {

class OtherMachine {
 public:
  // It runs on `host`, out of range. `beside` and its checker must outlive it.
  OtherMachine(SimRobot& beside, Checker& beside_checker, std::size_t host,
               transport::sim::Random random);
  ~OtherMachine();
  OtherMachine(const OtherMachine&) = delete;
  OtherMachine& operator=(const OtherMachine&) = delete;

  void SetInRange(bool in_range);
  // A request of its operator or of a client, or a fault of it.
  void Act();
  void StartController(Starter starter);

  std::function<void(const action::Record&)> on_record;  // may be empty

  const SimRobot& robot() const { return robot_; }
  Checker& checker() { return checker_; }

 private:
  static Layout LayoutOn(const SimRobot& beside, std::size_t host);
  static MachineConfig ConfigOf(const SimRobot& beside, bool same_name);
  void EngageStop();
  State SampleState();

  SimRobot& beside_;
  Checker& beside_checker_;
  const std::size_t host_;
  transport::sim::Random random_;
  bool in_range_ = true;
  std::uint64_t stops_ = 0;
  std::set<StopId> stops_by_name_;
  SimRobot robot_;
  Checker checker_;
};

}  // namespace musher::simulation
