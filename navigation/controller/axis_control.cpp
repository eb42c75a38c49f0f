#include "musher/navigation/controller/axis_control.hpp"

#include <dlib/matrix.h>
#include <dlib/optimization/optimization_solve_qp_using_smo.h>

#include <algorithm>
#include <cmath>

namespace musher::navigation {
namespace {

using Square = dlib::matrix<double, kHorizon, kHorizon>;
using Column = dlib::matrix<double, kHorizon, 1>;

constexpr double kExact = 1e-9;         // of a solution, relative
constexpr unsigned long kRounds = 500;  // of the solver at most, some 0.2 ms

}  // namespace

struct AxisControl::Problem {
  AxisRules rules;
  Square cost;         // of the changes of the command, second order
  Column by_place;     // first order, for a place error of 1
  Column by_velocity;  // and for a velocity error of 1
  Column changes;      // the last solution
};

AxisControl::AxisControl(AxisControl&&) noexcept = default;
AxisControl& AxisControl::operator=(AxisControl&&) noexcept = default;
AxisControl::~AxisControl() = default;

AxisControl::AxisControl(const AxisRules& rules) : problem_(std::make_unique<Problem>()) {
  // place' = place + p_v * velocity + p_u * u, velocity' = v_v * velocity + (1 - v_v) * u.
  const double h = rules.step_s, lag = rules.lag_s;
  const double v_v = lag > 0 ? std::exp(-h / lag) : 0;
  const double p_v = lag * (1 - v_v), p_u = h - p_v;
  // Place after k + 1 steps by an impulse of the command in the first one, and by the errors now.
  double impulse[kHorizon], after_velocity[kHorizon];
  double place = p_u, velocity = 1 - v_v, free_place = 0, free_velocity = 1;
  for (int k = 0; k < kHorizon; ++k) {
    impulse[k] = place;
    place += p_v * velocity;
    velocity *= v_v;
    free_place += p_v * free_velocity;
    free_velocity *= v_v;
    after_velocity[k] = free_place;
  }
  problem_->rules = rules;
  Square effect = dlib::zeros_matrix<double>(kHorizon, kHorizon);
  Column ones, free;
  for (int row = 0; row < kHorizon; ++row) {
    for (int column = 0; column <= row; ++column) effect(row, column) = impulse[row - column];
    ones(row) = 1;
    free(row) = after_velocity[row];
  }
  problem_->cost = rules.state_weight * dlib::trans(effect) * effect;
  for (int i = 0; i < kHorizon; ++i) problem_->cost(i, i) += rules.control_weight;
  problem_->by_place = rules.state_weight * dlib::trans(effect) * ones;
  problem_->by_velocity = rules.state_weight * dlib::trans(effect) * free;
  Reset();
}

void AxisControl::Reset() {
  problem_->changes = dlib::zeros_matrix<double>(kHorizon, 1);
}

double AxisControl::Solve(double place_error, double velocity_error,
                          const AxisReference& reference) {
  const AxisRules& rules = problem_->rules;
  Column lower, upper;
  double now = 0;
  for (int i = 0; i < kHorizon; ++i) {
    // The command with which the model follows the reference.
    const double command = std::clamp(
        reference.velocity[i] + rules.lag_s * reference.acceleration[i], -rules.limit, rules.limit);
    if (i == 0) now = command;
    lower(i) = -rules.limit - command;
    upper(i) = rules.limit - command;
  }
  const Column slope = place_error * problem_->by_place + velocity_error * problem_->by_velocity;
  Column& changes = problem_->changes;
  for (int i = 0; i + 1 < kHorizon; ++i) changes(i) = changes(i + 1);
  for (int i = 0; i < kHorizon; ++i) changes(i) = std::clamp(changes(i), lower(i), upper(i));
  dlib::solve_qp_box_constrained(problem_->cost, slope, changes, lower, upper, kExact, kRounds);
  return std::clamp(now + changes(0), -rules.limit, rules.limit);
}

}  // namespace musher::navigation
