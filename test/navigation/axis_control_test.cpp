// The control of one axis: exact on its reference, within its bounds, and optimal.

#include "musher/navigation/controller/axis_control.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>

namespace musher::navigation::axis_control_test {

AxisReference Constant(double velocity) {
  AxisReference reference;
  for (double& step : reference.velocity) step = velocity;
  return reference;
}

// A body with the lag of the model, driven to a place at rest.
double AfterSeconds(const AxisRules& rules, double body_lag_s, double seconds, double* overshoot) {
  AxisControl control(rules);
  double place = -1, velocity = 0;
  const double share = body_lag_s > 0 ? 1 - std::exp(-rules.step_s / body_lag_s) : 1;
  for (double t = 0; t < seconds; t += rules.step_s) {  // NOLINT: a fixed number of steps
    const double command = control.Solve(place, velocity, {});
    EXPECT_LE(std::abs(command), rules.limit);
    velocity += share * (command - velocity);
    place += velocity * rules.step_s;
    if (overshoot) *overshoot = std::max(*overshoot, place);
  }
  return place;
}

TEST(AxisControl, GivesTheReferencesCommandToABodyOnIt) {
  AxisControl control({});
  EXPECT_NEAR(control.Solve(0, 0, Constant(0.7)), 0.7, 1e-6);
  AxisRules lagging;
  lagging.lag_s = 0.2;
  AxisReference accelerating = Constant(0.7);
  for (double& step : accelerating.acceleration) step = 0.5;
  EXPECT_NEAR(AxisControl(lagging).Solve(0, 0, accelerating), 0.7 + 0.2 * 0.5, 1e-6);
}

TEST(AxisControl, LeadsTheBodyBack) {
  EXPECT_NEAR(AfterSeconds({}, 0, 3, nullptr), 0, 1e-3);
  EXPECT_LT(AxisControl({}).Solve(0.1, 0, {}), -0.1);
  EXPECT_GT(AxisControl({}).Solve(-0.1, 0, {}), 0.1);
}

TEST(AxisControl, OvershootsLessWhenItKnowsTheLagOfTheBody) {
  AxisRules knows;
  knows.lag_s = 0.2;
  double known = 0, unknown = 0;
  EXPECT_NEAR(AfterSeconds(knows, 0.2, 4, &known), 0, 5e-3);
  EXPECT_NEAR(AfterSeconds({}, 0.2, 4, &unknown), 0, 2e-2);
  EXPECT_LT(known, 0.03);
  EXPECT_GT(unknown, 0.06);
}

TEST(AxisControl, KeepsItsBounds) {
  AxisControl control({});
  EXPECT_EQ(control.Solve(-100, 0, {}), 1.5);
  EXPECT_EQ(control.Solve(100, 0, Constant(1)), -1.5);
  EXPECT_EQ(control.Solve(0, 0, Constant(9)), 1.5) << "also for a reference beyond them";
}

// Twice the cost of the model, for a sequence of commands.
double CostOf(const AxisRules& rules, double place, double velocity, const double* commands) {
  const double v_v = rules.lag_s > 0 ? std::exp(-rules.step_s / rules.lag_s) : 0;
  const double p_v = rules.lag_s * (1 - v_v);
  double cost = 0;
  for (int k = 0; k < kHorizon; ++k) {
    place += p_v * velocity + (rules.step_s - p_v) * commands[k];
    velocity = v_v * velocity + (1 - v_v) * commands[k];
    cost += rules.state_weight * place * place + rules.control_weight * commands[k] * commands[k];
  }
  return cost;
}

// The same by coordinate descent, slowly.
double BestCommand(const AxisRules& rules, double place, double velocity) {
  double commands[kHorizon] = {};
  for (int round = 0; round < 200; ++round) {
    for (double& command : commands) {
      const auto at = [&](double value) {
        command = value;
        return CostOf(rules, place, velocity, commands);
      };
      // The cost is a parabola in one command.
      const double low = at(-1), middle = at(0), high = at(1);
      command =
          std::clamp((low - high) / (2 * (low + high - 2 * middle)), -rules.limit, rules.limit);
    }
  }
  return commands[0];
}

RC_GTEST_PROP(AxisControl, FindsTheOptimum, ()) {
  AxisRules rules;
  rules.lag_s = *rc::gen::element(0.0, 0.05, 0.3);
  const double place = *rc::gen::inRange(-2000, 2000) / 1000.0;
  const double velocity = *rc::gen::inRange(-1500, 1500) / 1000.0;
  const double found = AxisControl(rules).Solve(place, velocity, {});
  RC_ASSERT(std::abs(found - BestCommand(rules, place, velocity)) < 1e-4);
}

}  // namespace musher::navigation::axis_control_test
