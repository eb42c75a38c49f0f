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

  // `is_free` reports whether its middle can be at a point now; it waits until it is.
  void Step(const MoverSpec& spec, const std::function<bool(const Eigen::Vector2d&)>& is_free,
            Duration dt);

  const Eigen::Vector2d& position_m() const { return position_m_; }
  double yaw_rad() const { return yaw_rad_; }      // of its way
  double speed_m_s() const { return speed_m_s_; }  // along it, in the last step

 private:
  void Choose(const MoverSpec& spec);
  double Sample();  // from 0 to 1

  transport::sim::Random random_;
  Eigen::Vector2d position_m_;
  double yaw_rad_ = 0;
  double speed_m_s_ = 0;
  std::size_t next_ = 1;  // the point it goes to
  bool back_ = false;     // from the last point to the first
  double leg_m_s_ = 0;
  double wait_s_ = 0;
};

}  // namespace musher::world
