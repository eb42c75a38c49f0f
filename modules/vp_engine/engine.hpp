#pragma once
// The actuator of musher-vp-engine: runs one program at a time while the robot is Active. A program
// is stopped when the robot leaves Active, or an emergency stop is engaged, and does not go on by
// itself.
//
// Interfaces: `<actuator>/manage_program` (musher_msgs/ManageProgram), and those of TreeActuator,
// which report the program that runs, or was the last to run. A thread checks and stores a program
// that is added: the loop, and with it the program that runs, goes on meanwhile.

#include <functional>
#include <memory>
#include <string>

#include "musher/application/tree_actuator.hpp"
#include "musher/messages/musher_msgs/tree.hpp"
#include "musher/modules/vp_engine/programs.hpp"
#include "musher/modules/vp_engine/service_robot.hpp"
#include "musher/modules/vp_engine/vp_config.hpp"

namespace musher::vp_engine {

class Engine : public TreeActuator {
 public:
  Engine(const std::string& actuator, const VpConfig& config);

 private:
  Result<> RegisterNodes(tree::Factory& factory) override;
  Result<tree::Document> LoadTree() override { return tree::Document{}; }  // none yet
  void OpenTopics(transport::Endpoints& topics) override;
  void AfterTick(Time now, tree::Status status) override;
  void OnPause() override;
  void OnBreak() override;
  // START is refused: the tree would run, and the table of programs would show none.
  Result<> OnStartCommand() override;

  struct Background;
  using Reply = std::function<void(const msg::ManageProgram::Response&)>;

  void AddProgram(const msg::ManageProgram::Request& request, Reply reply);
  msg::ManageProgram::Response Manage(const msg::ManageProgram::Request& request);
  Result<> RunProgram(const msg::ManageProgram::Request& request);
  Result<> StopProgram(const std::string& program);
  void StopLost();
  const VpConfig config_;
  ServiceRobot robot_;
  Programs programs_;
  std::weak_ptr<Background> background_;  // as long as its topics
};

}  // namespace musher::vp_engine
