#pragma once
// The devices on a simulated network, in virtual time, with their peers on a node of its own: the
// world that has battery, lights and pad, and the clients of the services.

#include <gmock/gmock.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/stamp.hpp"
#include "musher/modules/device/devices.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::device {

template <class T>
T Must(Result<T> result) {
  if (!result) ADD_FAILURE() << result.error().message;
  return std::move(result).value();
}

class DevicesOnANetwork : public ::testing::Test {
 protected:
  DevicesOnANetwork() {
    config_.battery.source = BatterySource::kWorld;
    config_.touch = true;
    config_.led = true;
  }

  void Start() {
    devices_ = Must(Devices::Make(Around(), config_));
    Run(Milliseconds(500));  // discovery
  }
  Dependencies Around() {
    return {*dog_,
            *clock_,
            "dog1",
            [this] { return msg::ToStamp(clock_->Now().time_since_epoch()); },
            [this](const std::string& line) { log_.push_back(line); },
            [this] { return state_; },
            [this] { return may_power_; }};
  }

  void Run(Duration duration) { network_.RunFor(duration); }

  template <msg::Message M>
  std::unique_ptr<transport::Publisher<M>> Publisher(
      const std::string& topic, const transport::Qos& qos = transport::kDefaultQos) {
    return Must(transport::MakePublisher<M>(*world_, topic, qos));
  }
  // Appends every received message to `received`.
  template <msg::Message M>
  std::unique_ptr<transport::Subscription> Listen(
      const std::string& topic, std::vector<M>& received,
      const transport::Qos& qos = transport::kDefaultQos) {
    return Must(transport::MakeSubscription<M>(
        *world_, topic, [&received](const M& message, const auto&) { received.push_back(message); },
        qos));
  }
  template <msg::Service S>
  typename S::Response Call(const std::string& service, const typename S::Request& request) {
    const auto client = Must(transport::MakeClient<S>(*world_, service));
    std::optional<Result<typename S::Response>> answer;
    client->Call(request, Milliseconds(5000), [&answer](auto reply) { answer = reply; });
    EXPECT_TRUE(
        network_.RunUntil([&] { return answer.has_value(); }, network_.now() + Milliseconds(6000)));
    return Must(*answer);
  }

  // The failing devices of the check.
  std::vector<std::int32_t> Failures() const {
    std::vector<std::int32_t> codes;
    for (const DeviceResult& finding : devices_->Check()) {
      if (!finding.result) codes.push_back(finding.result.error().code);
    }
    return codes;
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> dog_ = network_.MakeNode("dog");
  std::unique_ptr<transport::Node> world_ = network_.MakeNode("desk");
  std::unique_ptr<transport::Clock> clock_ = transport::Clock::Steady(dog_->loop());
  DeviceConfig config_;
  std::vector<std::string> log_;
  State state_ = "Active";
  Result<> may_power_;
  std::unique_ptr<Devices> devices_;
};

}  // namespace musher::device
