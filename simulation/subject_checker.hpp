#pragma once
// What the checkers of the subjects (authority, stops, policy …) have in common: the robot, the
// first violation, and the facts that excuse a controller in more than one subject.
//
// Threads: the one of the network.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "musher/simulation/invariant.hpp"
#include "musher/simulation/robot.hpp"

namespace musher::simulation {

struct CheckerContext {
  // The robot must outlive it.
  explicit CheckerContext(SimRobot& checked) : robot(checked) {}
  // Keeps the first one only.
  void ReportViolation(Invariant invariant, const std::string& what);

  SimRobot& robot;
  std::optional<Violation> violation;  // the first one
  bool state_lost = false;  // a disk was full: a controller may have stored outdated state
  std::optional<Time> link_faults_until;         // of all links; max: they are under way
  std::map<std::string, State> false_reporters;  // by actuator: the false state published last
  std::map<std::pair<std::string, std::string>, ActuatorReport> reports;  // by actuator, host
  std::uint64_t order = 0;  // of stops, requests and commands; it grows with each
};

class SubjectChecker {
 public:
  SubjectChecker(const SubjectChecker&) = delete;
  SubjectChecker& operator=(const SubjectChecker&) = delete;

 protected:
  // The context must outlive it.
  explicit SubjectChecker(CheckerContext& context);
  ~SubjectChecker() = default;

  void ReportViolation(Invariant invariant, const std::string& what) {
    context_.ReportViolation(invariant, what);
  }
  // The serial of the controller whose machine it is; 0: none.
  std::uint64_t SerialOf(const Machine& machine) const;
  // The state in which the process of the actuator that the controller has controlled last has
  // ended without its TearDown; "": it has not, or was not seen to.
  State LostIn(const SimulatedController& controller, ActuatorIndex i) const;
  // Whether the actuator's process on that host, the controller, or a link between the two has had
  // a fault within that time.
  bool WasDisturbed(const SimulatedController& controller, const std::string& name,
                    std::size_t host, Duration within) const;

  CheckerContext& context_;
  SimRobot& robot_;
  const MachineConfig& config_;
};

// After this long with a working link a controller has received a process's status.
inline constexpr Duration kReceivedAfter = std::chrono::seconds(2);

// By an operator or a client, or a part of the start.
bool IsRequested(const Switch& s);
State TargetOf(const action::Record& record);

}  // namespace musher::simulation
