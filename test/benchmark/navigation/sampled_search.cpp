#include "musher/test/benchmark/navigation/sampled_search.hpp"

#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/informedtrees/BITstar.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>

#include <ctime>

namespace musher::benchmark {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;
using navigation::Clearance;
using navigation::Point;

double CpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) / 1e9;
}

Point PointOf(const ob::State* state) {
  const double* values = state->as<ob::RealVectorStateSpace::StateType>()->values;
  return {values[0], values[1], 0};
}

class Motions final : public ob::MotionValidator {
 public:
  Motions(const ob::SpaceInformationPtr& space, const Clearance& clearance, double radius_m)
      : MotionValidator(space), clearance_(clearance), radius_m_(radius_m) {}

  bool checkMotion(const ob::State* from, const ob::State* to) const override {
    return clearance_.FitsAlong(PointOf(from), PointOf(to), radius_m_);
  }
  bool checkMotion(const ob::State* from, const ob::State* to,
                   std::pair<ob::State*, double>& last_valid) const override {
    last_valid.second = 0;
    return checkMotion(from, to);
  }

 private:
  const Clearance& clearance_;
  double radius_m_;
};

}  // namespace

std::optional<double> SampledLength(const std::string& planner, const Clearance& clearance,
                                    double radius_m, const Point& start, const Point& goal,
                                    double seconds) {
  ompl::msg::setLogLevel(ompl::msg::LOG_ERROR);
  auto space = std::make_shared<ob::RealVectorStateSpace>(2);
  space->setBounds(0, clearance.map().size_x * clearance.map().resolution_m);
  og::SimpleSetup setup(space);
  setup.setStateValidityChecker(
      [&](const ob::State* state) { return clearance.Fits(PointOf(state), radius_m); });
  const auto& information = setup.getSpaceInformation();
  information->setMotionValidator(std::make_shared<Motions>(information, clearance, radius_m));
  ob::ScopedState<ob::RealVectorStateSpace> from(space), to(space);
  from->values[0] = start.x_m;
  from->values[1] = start.y_m;
  to->values[0] = goal.x_m;
  to->values[1] = goal.y_m;
  setup.setStartAndGoalStates(from, to);
  if (planner == "RRTConnect") {
    setup.setPlanner(std::make_shared<og::RRTConnect>(information));
  } else if (planner == "RRT*") {
    setup.setPlanner(std::make_shared<og::RRTstar>(information));
  } else {
    setup.setPlanner(std::make_shared<og::BITstar>(information));
  }
  const double end_s = CpuSeconds() + seconds;
  setup.solve(ob::PlannerTerminationCondition([end_s] { return CpuSeconds() > end_s; }));
  if (!setup.haveExactSolutionPath()) return std::nullopt;
  return setup.getSolutionPath().length();
}

}  // namespace musher::benchmark
