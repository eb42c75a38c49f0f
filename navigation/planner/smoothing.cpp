#include "musher/navigation/planner/smoothing.hpp"

#include <ompl/base/MotionValidator.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/PathSimplifier.h>
#include <ompl/util/Console.h>

#include <algorithm>
#include <array>

namespace musher::navigation {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

Point PointOf(const ob::State* state, bool flat) {
  const double* values = state->as<ob::RealVectorStateSpace::StateType>()->values;
  return {values[0], values[1], flat ? 0 : values[2]};
}

// The space between states by the clearance of the map.
class Motions final : public ob::MotionValidator {
 public:
  Motions(ob::SpaceInformation* space, const Clearance& clearance, double radius_m)
      : MotionValidator(space), clearance_(clearance), radius_m_(radius_m) {}

  bool checkMotion(const ob::State* from, const ob::State* to) const override {
    const bool flat = clearance_.map().flat();
    return clearance_.FitsAlong(PointOf(from, flat), PointOf(to, flat), radius_m_);
  }

  // With the last valid state, which no shortcut asks for.
  bool checkMotion(const ob::State* from, const ob::State* to,
                   std::pair<ob::State*, double>& /*last_valid*/) const override {
    return checkMotion(from, to);
  }

 private:
  const Clearance& clearance_;
  double radius_m_;
};

// OMPL takes the seeds of its generators from one sequence of the process.
class SeededSimplifier final : public og::PathSimplifier {
 public:
  SeededSimplifier(const ob::SpaceInformationPtr& space, std::uint32_t seed)
      : PathSimplifier(space) {
    rng_.setLocalSeed(seed);
  }
};

ob::SpaceInformationPtr MakeSpace(const Clearance& clearance, double radius_m,
                                  const std::vector<Point>& points) {
  const bool flat = clearance.map().flat();
  ompl::msg::setLogLevel(ompl::msg::LOG_ERROR);
  auto space = std::make_shared<ob::RealVectorStateSpace>(flat ? 2 : 3);
  ob::RealVectorBounds bounds(flat ? 2 : 3);
  bounds.low = {points[0].x_m, points[0].y_m};
  if (!flat) bounds.low.push_back(points[0].z_m);
  bounds.high = bounds.low;
  for (const Point& point : points) {
    const std::array<double, 3> values = {point.x_m, point.y_m, point.z_m};
    for (std::size_t i = 0; i < bounds.low.size(); ++i) {
      bounds.low[i] = std::min(bounds.low[i], values[i] - 1);
      bounds.high[i] = std::max(bounds.high[i], values[i] + 1);
    }
  }
  space->setBounds(bounds);
  auto information = std::make_shared<ob::SpaceInformation>(space);
  information->setStateValidityChecker([&clearance, radius_m, flat](const ob::State* state) {
    return clearance.Fits(PointOf(state, flat), radius_m);
  });
  information->setMotionValidator(
      std::make_shared<Motions>(information.get(), clearance, radius_m));
  information->setup();
  return information;
}

}  // namespace

std::vector<Point> Smoothed(const std::vector<Point>& points, const Clearance& clearance,
                            double radius_m, const SmoothingRules& rules) {
  if (points.size() < 3) return points;
  const bool flat = clearance.map().flat();
  const auto information = MakeSpace(clearance, radius_m, points);
  og::PathGeometric path(information);
  ob::ScopedState<ob::RealVectorStateSpace> state(information);
  for (const Point& point : points) {
    state->values[0] = point.x_m;
    state->values[1] = point.y_m;
    if (!flat) state->values[2] = point.z_m;
    path.append(state.get());
  }
  SeededSimplifier simplifier(information, rules.seed);
  if (rules.shortcuts > 0) {
    const auto attempts = static_cast<unsigned>(rules.shortcuts);
    simplifier.reduceVertices(path, attempts, attempts / 4, 1.0);
    simplifier.shortcutPath(path, attempts, attempts / 4, 1.0, 0);
    simplifier.reduceVertices(path, attempts, attempts / 4, 1.0);
  }
  if (rules.spline_steps > 0 && path.getStateCount() > 2) {
    path.interpolate(static_cast<unsigned>(path.length() / rules.spacing_m) + 2);
    simplifier.smoothBSpline(path, static_cast<unsigned>(rules.spline_steps), path.length() / 1e6);
  }
  std::vector<Point> smooth;
  for (const ob::State* point : path.getStates()) smooth.push_back(PointOf(point, flat));
  smooth.front() = points.front();
  smooth.back() = points.back();
  return smooth;
}

}  // namespace musher::navigation
