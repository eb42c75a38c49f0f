#include "musher/modules/meilin/servers/pid.hpp"

#include <algorithm>
#include <utility>

namespace musher::meilin::servers {

Pid::Pid(const PidGains& gains, double integral_limit)
    : gains_(gains), integral_limit_(integral_limit) {}

double Pid::Update(double error, double dt_s) {
  const bool timed = dt_s > 0;
  if (timed) {
    integral_ = std::clamp(integral_ + error * dt_s, -integral_limit_, integral_limit_);
  }
  const double slope = first_ || !timed ? 0 : (error - last_error_) / dt_s;
  last_error_ = error;
  first_ = false;
  return gains_.p * error + gains_.i * integral_ + gains_.d * slope;
}

void Pid::Reset() {
  integral_ = 0;
  first_ = true;
}

}  // namespace musher::meilin::servers
