#pragma once
// A body of a scene that goes from point to point by itself. The seed selects its speed on each
// way, and how long it waits at each point. Pure; time and what is in its way are arguments.

#include <Eigen/Core>
#include <functional>

#include "musher/base/time.hpp"
#include "musher/modules/world/scene/robot_specs.hpp"
#include "musher/transport/sim/random.hpp"

namespace musher::world {

class Mover {
 public:
  Mover(const MoverSpec& spec, std::uint64_t seed);

  // `is_free` reports whether its middle can be at a point now. It waits until it is, at most 10 s:
  // then it turns round, so that it and a robot do not wait for each other for ever.
  void Step(const MoverSpec& spec, const std::function<bool(const Eigen::Vector2d&)>& is_free,
            Duration dt);

  const Eigen::Vector2d& position_m() const { return position_m_; }
  double yaw_rad() const { return yaw_rad_; }      // of its way
  double speed_m_s() const { return speed_m_s_; }  // along it, in the last step

 private:
  void Choose(const MoverSpec& spec);
  std::size_t After(const MoverSpec& spec, std::size_t point) const;  // in its direction
  void TurnRound(const MoverSpec& spec);
  double Sample();  // from 0 to 1

  transport::sim::Random random_;
  Eigen::Vector2d position_m_;
  double yaw_rad_ = 0;
  double speed_m_s_ = 0;
  std::size_t next_ = 1;  // the point it goes to
  bool back_ = false;     // it goes through the points backwards
  double leg_m_s_ = 0;
  double wait_s_ = 0;
  double blocked_s_ = 0;  // so far
};

}  // namespace musher::world
