#pragma once
// Receding-horizon control of one axis: x, y, z and yaw do not influence each other in the cost, in
// the model or in the bounds, so four small problems replace a large one, with the same solution.
//
// The model: the body's velocity follows the command with a lag (0: at once). It is written for the
// differences to a reference that it can follow exactly, so a body on its reference gets the
// reference's command, however the costs are chosen. Minimised over the horizon:
//
//   state_weight * (place - reference)² + control_weight * (command - reference command)²
//
// with bounds on the command of each step; solved exactly by dlib. Metres or radians, seconds. One
// thread at a time.

#include <memory>

namespace musher::navigation {

inline constexpr int kHorizon = 20;

struct AxisRules {
  double step_s = 1.0 / 60;
  double lag_s = 0;
  double state_weight = 10;
  double control_weight = 0.5;
  double limit = 1.5;  // of the command, either way

  friend bool operator==(const AxisRules&, const AxisRules&) = default;
};

// The reference of one axis at each step of the horizon, from now on.
struct AxisReference {
  double velocity[kHorizon] = {};
  double acceleration[kHorizon] = {};
};

class AxisControl {
 public:
  explicit AxisControl(const AxisRules& rules);
  AxisControl(AxisControl&&) noexcept;
  AxisControl& operator=(AxisControl&&) noexcept;
  ~AxisControl();

  // The command for now. `place_error`, `velocity_error`: of the body now, minus the reference.
  double Solve(double place_error, double velocity_error, const AxisReference& reference);

  // Forgets the last solution, from which the next one starts.
  void Reset();

 private:
  struct Problem;
  std::unique_ptr<Problem> problem_;
};

}  // namespace musher::navigation
