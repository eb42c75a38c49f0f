#pragma once
// A PID controller of one axis. Units: those of the error and of the command, seconds. One thread.

namespace musher::meilin::servers {

struct PidGains {
  double p = 0;
  double i = 0;
  double d = 0;
};

class Pid {
 public:
  // The integral of the error stays within `integral_limit`, either way.
  Pid(const PidGains& gains, double integral_limit);

  // The command for `error`, `dt_s` after the last call; 0: the derivative does not count.
  double Update(double error, double dt_s);
  void Reset();

 private:
  PidGains gains_;
  double integral_limit_;
  double integral_ = 0;
  double last_error_ = 0;
  bool first_ = true;
};

}  // namespace musher::meilin::servers
