#pragma once
// The fixture of tests that run the class of a module on a simulated network, in virtual time: the
// module's node and clock, and a desk that has its peers.

#include <gmock/gmock.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/messages/stamp.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/node.hpp"
#include "musher/transport/service.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::test {

template <class T>
T Must(Result<T> result) {
  if (!result) ADD_FAILURE() << result.error().message;
  return std::move(result).value();
}

class ModuleOnNetwork : public ::testing::Test {
 protected:
  void Run(Duration duration) { network_.RunFor(duration); }
  bool RunUntil(const std::function<bool()>& holds, Duration limit) {
    return network_.RunUntil(holds, network_.now() + limit);
  }
  msg::Stamp Stamp() const { return msg::ToStamp(network_.now().time_since_epoch()); }

  template <msg::Message M>
  std::unique_ptr<transport::Publisher<M>> Publisher(
      const std::string& topic, const transport::Qos& qos = transport::kDefaultQos) {
    return Must(transport::MakePublisher<M>(*desk_, topic, qos));
  }
  // Appends every received message to `received`.
  template <msg::Message M>
  std::unique_ptr<transport::Subscription> Listen(
      const std::string& topic, std::vector<M>& received,
      const transport::Qos& qos = transport::kDefaultQos) {
    return Must(transport::MakeSubscription<M>(
        *desk_, topic, [&received](const M& message, const auto&) { received.push_back(message); },
        qos));
  }
  // Fails the test when there is no reply.
  template <msg::Service S>
  typename S::Response Call(const std::string& service, const typename S::Request& request) {
    const auto client = Must(transport::MakeClient<S>(*desk_, service));
    std::optional<Result<typename S::Response>> answer;
    client->Call(request, Milliseconds(5000), [&answer](auto reply) { answer = std::move(reply); });
    EXPECT_TRUE(RunUntil([&] { return answer.has_value(); }, Milliseconds(6000))) << service;
    return Must(*answer);
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> robot_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  std::unique_ptr<transport::Clock> clock_ = transport::Clock::Steady(robot_->loop());
};

}  // namespace musher::test
