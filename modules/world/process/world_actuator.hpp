#pragma once
// The world as an actuator of a machine, usually its first: the others are `after` it. Its states
// have little effect: time runs in all of them, from SetUp to TearDown.
//
// Threads: the world runs on the loop of the actuator's node; pictures, and those of the cameras,
// are drawn on threads of its own.

#include <memory>
#include <string>
#include <thread>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/actuator/worker.hpp"
#include "musher/modules/world/process/world_host.hpp"

namespace musher::world {

class WorldActuator : public MachineActuator {
 public:
  WorldActuator(const std::string& actuator_name, Scene scene);
  ~WorldActuator() override;

 private:
  Result<> Run(const State& state);
  Result<> SetUp();
  Result<> TearDown();
  std::string PicturePath() const;

  Scene scene_;
  std::shared_ptr<transport::NodeThread> node_;
  std::unique_ptr<WorldHost> host_;  // on the loop
  std::thread drawer_;               // started by the loop, joined by the destructor
  WorkerThread shooter_;             // draws the cameras' pictures
};

}  // namespace musher::world
