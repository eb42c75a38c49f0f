#pragma once
// An actuator that is a behaviour tree, as the network sees it: what `musher behavior --tree` uses
// of one. Its tree is a sequence of a condition, which has succeeded, and of an action that runs.

#include <memory>
#include <string>
#include <utility>

#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/messages/musher_msgs/tree.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::cli {

inline msg::GetTree::Response PatrolReport() {
  using msg::TreeState;
  msg::GetTree::Response report;
  report.state.tree = "Patrol";
  report.state.revision = 1;
  report.state.ticking = true;
  report.state.ticks = 250;
  report.state.time_s = 12.5;
  report.state.status = {TreeState::kRunning, TreeState::kSuccess, TreeState::kRunning};
  report.nodes = {{"Patrol", "Sequence", "Control", -1, "patrol.xml", 3, 12.5, 1},
                  {"BatteryOk", "BatteryOk", "Condition", 0, "patrol.xml", 4, 0, 0},
                  {"there", "Move", "Action", 0, "patrol.xml", 5, 12.25, 2}};
  report.entries = {{"", "goal_m", "number", "5"}, {"Drive", "way", "text", "a\nb"}};
  report.history = {{0, 0, TreeState::kIdle, TreeState::kRunning},
                    {0, 1, TreeState::kIdle, TreeState::kSuccess},
                    {0.25, 2, TreeState::kIdle, TreeState::kRunning}};
  return report;
}

class FakeTree {
 public:
  explicit FakeTree(std::string actuator)
      : actuator_(std::move(actuator)), thread_(transport::NodeThread::Start().value()) {
    thread_->RunOnLoop([this] {
      endpoints_ = std::make_unique<transport::Endpoints>(thread_->node(), "");
      endpoints_->Serve<msg::GetTree>(
          actuator_ + "/get_tree",
          [this](const auto& request, const auto& reply) { reply(Answer(request)); });
      endpoints_->Serve<msg::SendCommand>(
          actuator_ + "/send_command", [](const auto& request, const auto& reply) {
            const bool known = request.command == "START";
            reply({known, known ? "" : "there is no command '" + request.command + "'"});
          });
      publish_ = endpoints_->PublishFunction<msg::TreeState>(actuator_ + "/tree_state",
                                                             transport::kLatchedQos);
      publish_(report_.state);
    });
  }
  ~FakeTree() {
    thread_->RunOnLoop([this] { endpoints_.reset(); });
  }
  FakeTree(const FakeTree&) = delete;
  FakeTree& operator=(const FakeTree&) = delete;

  // The action ends with the status.
  void End(std::uint8_t status) {
    thread_->RunOnLoop([&] {
      report_.history.push_back({report_.state.time_s, 2, report_.state.status[2], status});
      report_.state.status[2] = status;
      publish_(report_.state);
    });
  }
  void Refuse(const std::string& error) {
    thread_->RunOnLoop([&] { report_.error = error; });
  }

 private:
  msg::GetTree::Response Answer(const msg::GetTree::Request& request) const {
    msg::GetTree::Response answer = report_;
    if (!request.entries) answer.entries.clear();
    if (answer.history.size() > request.history) {
      answer.history.erase(answer.history.begin(), answer.history.end() - request.history);
    }
    return answer;
  }

  const std::string actuator_;
  std::shared_ptr<transport::NodeThread> thread_;
  msg::GetTree::Response report_ = PatrolReport();
  std::function<void(const msg::TreeState&)> publish_;
  std::unique_ptr<transport::Endpoints> endpoints_;
};

}  // namespace musher::cli
