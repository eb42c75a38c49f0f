#include "musher/test/fault_injection/suite.hpp"

#include <signal.h>

#include <fstream>

#include "musher/test/fault_injection/host/isolation.hpp"
#include "musher/test/fault_injection/robot/processes.hpp"

namespace musher::fault_injection {
namespace {

namespace fs = std::filesystem;

constexpr int kRunsOfARobot = 60;  // then a new one is built
constexpr int kDiskKilobytes = 24 * 1024;

}  // namespace

void Suite::Run(const std::vector<PlannedFault>& plan,
                const std::function<void(const Outcome&)>& ended) {
  for (const PlannedFault& fault : plan) {
    ThrowIfInterrupted();
    ended(RunOne(fault));
  }
  robot_.reset();
}

Robot& Suite::RobotOf(Shape shape) {
  if (robot_ && (robot_->shape() != shape || runs_of_robot_ >= kRunsOfARobot)) robot_.reset();
  if (!robot_) {
    const fs::path folder = places_.work / ("robot" + std::to_string(robots_));
    fs::create_directories(folder / "disk");
    if (places_.own_mounts) MountMemory(folder / "disk", kDiskKilobytes);
    const int domain = places_.own_network ? robots_ % 100 : benchmark::Domain(robots_ % 8);
    ++robots_;
    runs_of_robot_ = 0;
    robot_ = std::make_unique<Robot>(shape, folder, domain);
    robot_->Up();
  }
  ++runs_of_robot_;
  return *robot_;
}

Outcome Suite::RunOne(const PlannedFault& fault) {
  Outcome outcome;
  outcome.kind = fault.kind->name;
  outcome.seed = fault.seed;
  try {
    Inject(fault, outcome);
  } catch (const std::exception& error) {
    outcome.failures.emplace_back(error.what());
  }
  if (!outcome.failures.empty()) {
    KeepEvidence(outcome);
    robot_.reset();
  }
  std::vector<pid_t> ours = places_.helpers;
  if (robot_) {
    for (const pid_t pid : robot_->OwnChildren()) ours.push_back(pid);
  }
  ReapOrphans(ours);
  return outcome;
}

void Suite::Inject(const PlannedFault& fault, Outcome& outcome) {
  Robot& robot = RobotOf(fault.kind->shape);
  FaultRun run(robot, fault.seed);
  run.outcome = outcome;
  try {
    run.Begin();
    fault.kind->inject(run);
    run.CheckAlways();
  } catch (const FaultRun::Over&) {
  } catch (const std::exception& error) {
    run.outcome.failures.emplace_back(error.what());
  }
  robot.observer().ForgetTriggers();
  outcome = run.outcome;
  if (outcome.failures.empty()) robot.Fix();
}

// Saves the robot's files, and the last status of each actuator.
void Suite::KeepEvidence(const Outcome& outcome) {
  const fs::path folder = places_.evidence / (outcome.kind + "-" + std::to_string(outcome.seed));
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  fs::create_directories(folder, ignored);
  if (robot_) fs::copy(robot_->folder(), folder, fs::copy_options::recursive, ignored);
  std::ofstream file(folder / "failures.txt");
  file << outcome.kind << ", seed " << outcome.seed << ", " << outcome.sampled << "\n";
  for (const std::string& failure : outcome.failures) file << failure << "\n";
  if (!robot_) return;
  for (const auto& [name, status] : robot_->observer().LatestOfActuators()) {
    file << name << ": last status " << status.state << ", target '" << status.target << "', epoch "
         << status.epoch << ", number " << status.number << "\n";
  }
}

}  // namespace musher::fault_injection
