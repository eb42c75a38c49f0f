#pragma once
// The world as an actuator of a machine, usually its first: the others are `after` it. Its states
// mean little: time goes on in all of them, from SetUp to TearDown.
//
// Threads: the world lives on the loop of the actuator's node; pictures, and what the cameras
// see, are drawn on threads of their own.

#include <memory>
#include <string>
#include <thread>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/actuator/worker.hpp"
#include "musher/modules/world/world_host.hpp"

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
  std::thread drawer_;               // the loop starts it, and the destructor waits for it
  WorkerThread shooter_;             // draws what the cameras see
};

}  // namespace musher::world
