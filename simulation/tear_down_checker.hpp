#pragma once
// Checks an accepted TearDown, of the machine or of one actuator, by the processes that each
// controller can know of.
//
// Invariants: kNoStartAfterTearDown, kTearDownIsComplete, kStaysDown.

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>

#include "musher/simulation/process_checker.hpp"

namespace musher::simulation {

class TearDownChecker : public SubjectChecker {
 public:
  TearDownChecker(CheckerContext& context, const ProcessChecker& processes)
      : SubjectChecker(context), processes_(processes) {}

  // An operator has started a controller, which begins to lead.
  void OnPersonsStart() { accepted_tear_down_.reset(); }
  void CheckStaysDown(const SimulatedController& controller);
  // Before a controller starts a process.
  void OnStart(const SimulatedController& controller, const std::string& name);
  // A person has started the controller: where nothing runs, it starts all.
  void OnBegunByPerson(const SimulatedController& controller);
  // Before a controller starts a process.
  void CheckMayStart(const SimulatedController& controller, const std::string& name);
  // The actuator runs, or a person has requested that.
  void OnStarted(const std::string& name) { torn_down_alone_.erase(name); }
  void NoteTornDownAlone(const SimulatedController& controller, const SwitchResult& result);
  void CheckTornDown(const SimulatedController& controller, const SwitchResult& result);
  // What each controller knows.
  void NoteReceived(const SimulatedController& controller);
  bool IsKnown(const SimulatedController& controller, ActuatorIndex i, std::size_t host,
               const ActuatorReport& report) const;

 private:
  struct AcceptedTearDown {
    std::uint64_t controller = 0;  // its serial
    std::size_t host = 0;
  };

  bool MustStayDown(const SimulatedController& controller) const;
  bool RunsForAnother(const SimulatedController& process, ActuatorIndex i, std::size_t host) const;

  const ProcessChecker& processes_;
  std::optional<AcceptedTearDown> accepted_tear_down_;  // a TearDown was accepted
  // By actuator: the host of the controller that has torn it down alone, as a person has requested.
  std::map<std::string, std::size_t> torn_down_alone_;
  // The processes of which controllers have received a report: the controller's host, actuator, the
  // host's id, incarnation.
  std::set<std::tuple<std::size_t, ActuatorIndex, std::string, Incarnation>> received_;
  // By the serial of the controller: of each actuator, the incarnation reported last.
  std::map<std::uint64_t, PerActuator<Incarnation>> last_received_;
};

}  // namespace musher::simulation
