#pragma once
// The node RunSkill of a behaviour tree: it runs a skill of a skill actuator, of this machine's
// namespace, as `musher skill run` does.
//
//   class Patrol : public musher::TreeActuator {
//     Result<> RegisterNodes(tree::Factory& factory) override { return skills_.Register(factory); }
//     void OpenTopics(transport::Endpoints& topics) override { skills_.Open(topics); }
//     musher::SkillNodes skills_;
//   };
//
//   <RunSkill skill="navigate_to" actuator="jetbot_0" parameters="goal_pos=[2,1,0]; timeout=60"
//             progress="{percent}" message="{why}"/>
//
// clang-format off
//   idle ──▶ RUNNING ──▶ SUCCESS     the skill has completed
//              │    └──▶ FAILURE     it has failed, was refused, or was cancelled by another client;
//              │                     no actuator offers it; its actuator is lost. `message` says why
//              └─ halted ──▶ idle    its goal is cancelled, also before the actuator knows it
// clang-format on
//
// - The actuator is found by the topic `skills`, for 3 s at most; `actuator` chooses among several.
// - It is one of this machine, as far as the statuses of the actuators say, or, with security keys,
//   the processes that the controllers report. An action that another
//   machine serves, too, is refused: both would receive the goal.
// - `parameters` is a list of KEY=VALUE with ";" between them; one within brackets or quotes is
//   part of the value; quotes around a value are not.
// - A node that starts a skill while a goal of an earlier node for the same action is still being
//   cancelled waits for its end, 10 s at most.
// - A goal is lost when its actuator does not reply within 5 s, or is not connected for 3 s. Its
//   skill may still run, so it is cancelled as soon as the actuator replies, and counts as one that
//   is still being cancelled. A run that its actuator continues after a restart has no goal any
//   more: it is cancelled by its name, unless it has the goal of another client by then, or the
//   node's own goal was never accepted.
// - All nodes of a SkillNodes share their endpoints: one client for each action of an actuator.
// - Without topics, as in a fault-injection test, it fails.
//
// Threads: the loop's. It must outlive the trees; dropping the endpoints cancels its goals.

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/behavior/tree/factory.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher {

class SkillNodes {
 public:
  // The names of KEY=VALUE; ";" between them. Fails for a part without "=".
  using Parameters = std::vector<std::pair<std::string, std::string>>;
  static Result<Parameters> ReadParameters(const std::string& text);

  Result<> Register(tree::Factory& factory);
  // As long as the endpoints.
  void Open(transport::Endpoints& endpoints);

  class Wire;  // of skill_node.cpp

 private:
  std::weak_ptr<Wire> wire_;
};

}  // namespace musher
