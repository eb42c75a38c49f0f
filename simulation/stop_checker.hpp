#pragma once
// Checks emergency stops at the controllers and the actuators, and the permits to move.
//
// Invariants: kEmergencyStopHolds (in a state, by the hardware), kEmergencyStopLatched,
// kEmergencyStopReported, kStopIsConfirmed, kReleaseIsConfirmed, kStopsWithoutPermit,
// kReachesMeantMachine (stops).

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "musher/simulation/process_checker.hpp"
#include "musher/simulation/release_checker.hpp"
#include "musher/simulation/tear_down_checker.hpp"

namespace musher::simulation {

class StopChecker : public SubjectChecker {
 public:
  StopChecker(CheckerContext& context, const ProcessChecker& processes,
              const TearDownChecker& tear_down, ReleaseChecker& release)
      : SubjectChecker(context), processes_(processes), tear_down_(tear_down), release_(release) {}

  // As Checker's functions of the same names.
  void OnStopEngaged(std::size_t panel, StopId id);
  void TakeStopsOf(const StopChecker& other);
  void OnStopOfOther(StopId id) { stops_of_other_.insert(id); }
  void OnStopConfirmed(StopId id);
  void OnStopWithdrawn(StopId id) { withdrawn_.insert(id); }

  void OnStopPublished(const SimulatedController& controller, const msg::EmergencyStop& stop);
  void CheckStopped(const std::string& name, std::size_t host, const ActuatorReport& before,
                    const ActuatorReport& report);
  void CheckStaysStopped(const std::string& name, const ActuatorReport& before,
                         const ActuatorReport& report);
  void CheckReleased(const SimulatedController& controller, const Result<>& released);
  // The actuators that CheckStopped() has found idle and stopped.
  void CheckPower();
  void CheckStopsAtRest(const Machine& machine);
  // Permits to move.
  void OnPermit(Time stamp) { permits_[stamp] = robot_.network().now(); }
  void NotePermitStops(const ActuatorCore& core);
  void CheckPermits();

 private:
  enum class Open { kNo, kMaybe, kYes };

  bool ReleasedElsewhere() const;
  Open StopIsOpen() const;
  bool IsStopped(const std::string& name, std::size_t host, const ActuatorReport& report) const;
  bool HasArrived(StopId id) const;
  State LostOnIn(ActuatorIndex i) const;

  const ProcessChecker& processes_;
  const TearDownChecker& tear_down_;
  ReleaseChecker& release_;
  std::map<StopId, std::size_t> engaged_;  // emergency stops: the panel
  std::map<std::size_t, StopId> last_of_panel_;
  std::map<StopId, std::set<std::size_t>> accepted_stops_;  // by controllers of these hosts
  std::map<StopId, std::set<std::size_t>> released_;        // stop: folders that have the release
  std::vector<std::pair<std::string, std::size_t>> idle_and_stopped_;  // actuator, host
  std::set<StopId> latched_;                                           // by any actuator, ever
  std::set<StopId> stops_of_other_;
  std::set<StopId> withdrawn_;       // by the programs that engaged them
  std::optional<Time> released_at_;  // when a controller last published a release
  std::map<StopId, Time> engaged_at_;
  std::map<Time, Time> permits_;  // given: the stamp, by the console's clock; when
  Time check_permits_at_{};
};

}  // namespace musher::simulation
