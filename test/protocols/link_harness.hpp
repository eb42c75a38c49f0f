#pragma once
// One link of the controller against one peer, in virtual time.

#include <gmock/gmock.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/controller/link/actuator_link.hpp"
#include "musher/cyberdog/extension.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::testing {

class LinkStage : public ::testing::Test {
 protected:
  explicit LinkStage(Protocol protocol) : config_(MachineOf(1)) {
    config_.actuators[0].protocol = protocol;
    config_.actuators[0].heartbeat_name = "a";
  }

  void OpenLink() {
    link_ = nullptr;
    link_ = MakeLink(
                *controller_, config_, 0, [this](Event event) { Note(std::move(event)); },
                cyberdog::Extension("").links)
                .value();
  }

  // A command as the coordinator gives it; its number.
  CommandNumber Switch(const State& target, Duration budget = Milliseconds(100)) {
    reply_.reset();
    link_->Switch({1, ++number_, target, budget, {}, {}, status_.incarnation});
    return number_;
  }
  // The answer to that command; none within the time is a failure.
  event::Replied Outcome(Duration limit = std::chrono::seconds(5)) {
    EXPECT_TRUE(Until([&] { return reply_.has_value(); }, limit)) << "there is no reply";
    return reply_.value_or(event::Replied{});
  }
  event::Replied Do(const State& target, Duration budget = Milliseconds(100)) {
    Switch(target, budget);
    return Outcome();
  }
  // Queries the last command, as after its deadline; nothing if there is no answer.
  std::optional<event::Replied> Query(bool stop = true) {
    answer_.reset();
    link_->Query({1, number_, stop});
    Until([&] { return answer_.has_value(); }, Milliseconds(300));
    return answer_;
  }

  bool Until(const std::function<bool()>& done, Duration limit = std::chrono::seconds(5)) {
    return network_.RunUntil(done, network_.now() + limit);
  }
  bool IsIn(const State& state) const { return status_.state == state && !status_.busy(); }

  MachineConfig config_;
  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> controller_ = network_.MakeNode("controller");
  std::unique_ptr<ActuatorLink> link_;
  ActuatorReport status_;  // the last that came by itself
  int statuses_ = 0;
  std::vector<std::string> losses_;
  std::optional<event::Replied> reply_;
  std::optional<event::Replied> answer_;
  CommandNumber number_ = 0;

 private:
  void Note(Event event) {
    if (const auto* seen = std::get_if<event::StatusSeen>(&event)) {
      status_ = seen->report;
      ++statuses_;
    } else if (const auto* lost = std::get_if<event::Vanished>(&event)) {
      losses_.push_back(lost->how);
    } else if (const auto* replied = std::get_if<event::Replied>(&event)) {
      (replied->query ? answer_ : reply_) = *replied;
    }
  }
};

}  // namespace musher::testing
