#pragma once
// The sequence by which four wheels of variable height bring a body up or down a step, while the
// base drives. Pure: readings and the time are arguments; one update is a tick of 10 ms.
//
//   up    10 prepare ─▶ (11 lift) ─▶ 12 dock ─▶ 13 retract front ─▶ 14 land front
//                    ─▶ 15 dock and retract rear ─▶ 16 land rear ─▶ 17 recover ─▶ done
//   down  20 front over the edge, land front ─▶ 21 the same of the rear ─▶ 22 clear of the edge
//                    ─▶ 23 recover ─▶ done
//   direct  all wheels to one height ─▶ done
//
// 11 is only for a step of unknown height (0), which the distance ahead then decides; for one down
// it is the distance below, in 20. A wheel has reached its height within `tolerance_mm`.
//
// Each run ends: done, at its time limit, without feedback of the hardware, or by Stop(). At every
// end but done the wheels are commanded to hold their heights.
//
// Millimetres, seconds. One thread. The numbers are those of the robot's own software.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/modules/meilin/servers/chassis_sensors.hpp"

namespace musher::meilin::servers {

struct SuspensionSettings {
  double rest_mm = 20;   // of the wheels before and after a climb
  double low_mm = 205;   // of the wheels for steps of up to `low_step_mm`
  double high_mm = 410;  // and for higher ones
  double low_step_mm = 300;
  double highest_step_mm = 400;  // a higher one is refused
  double highest_mm = 420;       // of a wheel
  double tolerance_mm = 20;
  Duration time_limit = Milliseconds(10'000);  // of a goal without a limit
  Duration stale = Milliseconds(500);          // older readings end a run
};

enum class SuspensionMode : std::uint8_t { kAuto, kClimbUp, kClimbDown, kDirect };

struct SuspensionGoal {
  SuspensionMode mode = SuspensionMode::kAuto;
  ClimbDirection direction = ClimbDirection::kForward;
  double height_mm = 0;
  double limit_s = 0;  // 0 and less: that of the settings
};

// The state of the sequence, as the action reports it.
enum class SuspensionState : std::int32_t {
  kIdle = 0,
  kUpPrepare = 10,
  kUpLift = 11,
  kUpFrontDock = 12,
  kUpRetractFront = 13,
  kUpFrontLand = 14,
  kUpRearDock = 15,
  kUpRearLand = 16,
  kUpRecover = 17,
  kDownPrepare = 20,
  kDownRearLand = 21,
  kDownClear = 22,
  kDownRecover = 23,
};
// "UP_1_PREPARE" and so on, for people.
const char* SuspensionStateName(SuspensionState state);

class Suspension {
 public:
  explicit Suspension(const SuspensionSettings& settings);

  // Readings in the order of chassis_sensors.hpp; heights that are not finite are ignored.
  void OnChassis(const std::array<bool, kWheels>& switches, const WheelHeights& heights, Time now);
  void OnDistances(const std::array<double, kDistances>& mm, Time now);
  void Forget();

  // Begins; the text is why it cannot be done, empty if it can.
  std::string Begin(const SuspensionGoal& goal, Time now);
  // The run ends; the wheels stay where they are.
  void Stop();

  struct End {
    bool success = false;
    std::string message;
  };
  // Every 10 ms while it runs.
  std::optional<End> Update(Time now);

  bool running() const { return run_ != Run::kNone; }
  // Of the present run, or where the last one has ended; kIdle after a success.
  SuspensionState state() const { return state_; }
  double ElapsedSeconds(Time now) const;
  // What the wheels are to be set to; none before the first run.
  const std::optional<WheelHeights>& targets() const { return targets_; }
  const WheelHeights& heights() const { return heights_; }
  const std::array<double, kDistances>& distances() const { return distances_; }
  const std::array<bool, kWheels>& switches() const { return switches_; }
  // Why the hardware is not known now; empty: it is.
  std::string SilentChassis(Time now) const;
  std::string SilentDistances(Time now) const;

 private:
  enum class Run { kNone, kClimb, kDirect };

  std::string WhyImpossible(const SuspensionGoal& goal) const;
  bool Tick();  // true: done
  bool TickUp();
  bool TickDown();
  bool TickLift();
  bool TickFrontLand();
  bool TickRearDock();
  bool TickRearLand();
  bool TickDownFront();
  bool TickDownRear();
  void Enter(SuspensionState state);
  void SetAll(double mm);
  void SetFront(double mm);
  void SetRear(double mm);
  bool Reached(std::size_t first, std::size_t last, double mm) const;
  bool FrontReached() const;
  bool RearReached() const;
  bool AllReached() const { return FrontReached() && RearReached(); }
  std::optional<bool> Switch(std::size_t corner) const;
  bool BothSwitches(bool front, bool on) const;
  std::optional<double> Distance(std::size_t which) const;
  // Whether `holds` was true for `ticks` calls in a row.
  bool For(int ticks, bool holds);
  std::optional<End> Fail(const std::string& why);
  double HighFor(double step_mm) const;

  SuspensionSettings settings_;
  Run run_ = Run::kNone;
  SuspensionState state_ = SuspensionState::kIdle;
  ClimbView view_ = ViewOf(ClimbDirection::kForward);
  Time begun_;
  Duration limit_{};
  double step_mm_ = 0;   // 0: not known
  double high_mm_ = 0;   // of the wheels during the climb
  bool moving_ = false;  // the wheels of this state have been commanded to move
  int ticks_ = 0;        // in a row with the condition that this state waits for
  int other_ticks_ = 0;  // of the second condition of UP_2_LIFT
  std::optional<WheelHeights> targets_;
  WheelHeights heights_{};
  std::array<double, kDistances> distances_{};
  std::array<bool, kWheels> switches_{};
  std::array<DistanceFilter, kDistances> distance_filters_;
  std::array<SwitchFilter, kWheels> switch_filters_;
  std::optional<Time> chassis_at_;
  std::optional<Time> distances_at_;
};

}  // namespace musher::meilin::servers
