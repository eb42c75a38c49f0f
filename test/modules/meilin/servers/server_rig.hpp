#pragma once
// One server on a simulated network with a client, in virtual time.

#include <gmock/gmock.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/messages/std_msgs/multi_array.hpp"
#include "musher/modules/meilin/servers/server_config.hpp"
#include "musher/test/transport/suspended_node.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::meilin::servers::testing {

inline msg::Float32MultiArray ArrayOf(std::vector<float> data) {
  msg::Float32MultiArray array;
  array.data = std::move(data);
  return array;
}

template <msg::Action A>
class ServerRig : public ::testing::Test {
 protected:
  using Outcome = transport::GoalOutcome<A>;

  // Before Start(). The result is the time for which the server's computer was suspended, and the
  // test adds to it.
  Duration& MakeSuspendable() {
    auto node = std::make_unique<musher::testing::SuspendedNode>(network_.MakeNode("robot"));
    Duration& suspended = node->loop().suspended;
    clock_ = transport::Clock::Steady(node->loop());
    node_ = std::move(node);
    return suspended;
  }
  void Start(const std::string& file) {
    const Parsed<ServerConfig> reading = ReadServerText(file, "server.toml");
    ASSERT_TRUE(reading.config) << FormatDiagnostic(reading.diagnostics.at(0));
    config_ = *reading.config;
    server_ = Must(
        Make({*node_, *clock_, "",
              [this](LogLevel, const std::string& line) { log_.push_back(line); }, others_.get()},
             config_));
    client_ = Must(transport::MakeActionClient<A>(*peer_, action_));
    Run(1000);  // discovery
    server_->Permit(true, "");
  }
  template <class T>
  static T Must(Result<T> result) {
    if (!result) ADD_FAILURE() << result.error().message;
    return std::move(result).value();
  }
  void Run(std::int64_t ms) { network_.RunFor(Milliseconds(ms)); }
  bool RunUntil(const std::function<bool()>& holds, std::int64_t ms = 60'000) {
    return network_.RunUntil(holds, network_.now() + Milliseconds(ms));
  }

  // The index of the goal in `ends_`.
  std::size_t Send(const typename A::Goal& goal) {
    const std::size_t index = ends_.size();
    ends_.emplace_back();
    transport::GoalEvents<A> events;
    events.on_end = [this, index](const Outcome& outcome) { ends_[index] = outcome; };
    events.on_feedback = [this](const typename A::Feedback& value) { feedback_.push_back(value); };
    ids_.push_back(client_->SendGoal(goal, Milliseconds(2000), std::move(events)));
    return index;
  }
  void Cancel(std::size_t index) {
    client_->Cancel(ids_[index], Milliseconds(1000), [](const auto&) {});
  }
  Outcome Await(std::size_t index, std::int64_t ms = 60'000) {
    EXPECT_TRUE(RunUntil([&] { return ends_[index].has_value(); }, ms)) << "no end";
    return ends_[index].value_or(Outcome{});
  }
  void ExpectEnd(std::size_t index, transport::GoalEnd end, const std::string& message) {
    const Outcome outcome = Await(index);
    EXPECT_EQ(outcome.end, end) << outcome.result.message;
    EXPECT_EQ(outcome.result.message, message);
    EXPECT_EQ(outcome.result.success, end == transport::GoalEnd::kSucceeded);
  }
  void ExpectRejected(const typename A::Goal& goal, const std::string& why) {
    log_.clear();
    EXPECT_EQ(Await(Send(goal)).end, transport::GoalEnd::kRejected);
    EXPECT_THAT(log_, ::testing::Contains(::testing::HasSubstr("a goal is rejected: " + why)));
    Run(2500);  // lines of one kind are logged at most every 2 s
  }

  std::string action_;
  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> node_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> peer_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Clock> clock_ = transport::Clock::Steady(node_->loop());
  std::vector<std::string> log_;
  ServerConfig config_;
  std::unique_ptr<transport::OtherMachines> others_;  // null: it is not checked who sends a goal
  std::unique_ptr<Server> server_;
  std::unique_ptr<transport::ActionClient<A>> client_;
  std::vector<std::optional<Outcome>> ends_;
  std::vector<transport::GoalId> ids_;
  std::vector<typename A::Feedback> feedback_;
};

}  // namespace musher::meilin::servers::testing
