#pragma once
// Runs a plan of faults. A robot is reused as long as it settles after each fault.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "musher/test/fault_injection/kind.hpp"
#include "musher/test/fault_injection/plan.hpp"

namespace musher::fault_injection {

struct Places {
  std::filesystem::path work;      // for the robots' files
  std::filesystem::path evidence;  // for copies of the files of failed runs
  bool own_mounts = false;
  bool own_network = false;
  std::vector<pid_t> helpers;  // children of this process that are not a robot's
};

class Suite {
 public:
  explicit Suite(Places places) : places_(std::move(places)) {}

  // Runs one fault after the other, and calls `ended` after each. Throws Interrupted.
  void Run(const std::vector<PlannedFault>& plan, const std::function<void(const Outcome&)>& ended);

 private:
  Outcome RunOne(const PlannedFault& fault);
  Robot& RobotOf(Shape shape);
  void Inject(const PlannedFault& fault, Outcome& outcome);
  void KeepEvidence(const Outcome& outcome);

  const Places places_;
  std::unique_ptr<Robot> robot_;
  int robots_ = 0;
  int runs_of_robot_ = 0;
};

}  // namespace musher::fault_injection
