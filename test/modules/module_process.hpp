#pragma once
// The fixture of tests that run the real program of a module over DDS, as a controller and the
// robot's other programs use it.

#include <gmock/gmock.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/test/modules/actuator_peer.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::test {

using ActuatorStates = std::vector<std::string>;
inline const ActuatorStates kAllStates = {"SetUp",    "TearDown", "SelfCheck",
                                          "Active",   "DeActive", "Protected",
                                          "LowPower", "OTA",      "Error"};

class ModuleProcess : public ::testing::Test {
 protected:
  ModuleProcess(const std::string& actuator, const std::string& program,
                const ActuatorStates& states = kAllStates);

  // Starts the program with this text of its file, and waits until it can be commanded.
  void Start(const std::string& file);
  // The same on the time of a world, which is not published yet.
  void StartOnWorldTime(const std::string& file);
  // musher-world with this scene, alone.
  void StartWorld(const std::string& scene);

  void ExpectDone(const State& state);
  // The code and the reason of a switch that has to fail: "5909 no publisher of image_rgb".
  std::string Failure(const State& state);
  // Tears it down, and it exits.
  void ExpectTornDown();
  // A program with this file exits with code 2 and says so.
  void ExpectRefused(const std::string& file, const std::string& sentence);
  // Waits until the program has printed it.
  bool AwaitOutput(const std::string& text);

  template <msg::Message M>
  std::unique_ptr<transport::Publisher<M>> Publisher(
      const std::string& topic, const transport::Qos& qos = transport::kDefaultQos) {
    return transport::MakePublisher<M>(peer_.node(), topic, qos).value();
  }
  // Until the end of the test.
  template <msg::Message M>
  void Subscribe(const std::string& topic, std::function<void(const M&)> take,
                 const transport::Qos& qos = transport::kDefaultQos) {
    subscriptions_.push_back(
        transport::MakeSubscription<M>(
            peer_.node(), topic,
            [take = std::move(take)](const M& message, const auto&) { take(message); }, qos)
            .value());
  }
  template <msg::Message M>
  void Listen(const std::string& topic, std::optional<M>& last,
              const transport::Qos& qos = transport::kDefaultQos) {
    Subscribe<M>(
        topic, [&last](const M& message) { last = message; }, qos);
  }
  // Fails the test when there is no reply.
  template <msg::Service S>
  typename S::Response Call(const std::string& name, const typename S::Request& request) {
    const auto client = transport::MakeClient<S>(peer_.node(), name).value();
    std::optional<Result<typename S::Response>> answer;
    client->Call(request, std::chrono::seconds(120),
                 [&](auto reply) { answer = std::move(reply); });
    EXPECT_TRUE(peer_.Until([&] { return answer.has_value(); }));
    EXPECT_TRUE(answer && *answer) << name;
    return answer && *answer ? answer->value() : typename S::Response{};
  }

  // Another program, in the test's folder; Said() is what the last one printed.
  exec::Child Launch(std::vector<std::string> words);
  // Its exit code or minus the signal, while this test's loop runs.
  int Await(exec::Child& program);
  int Run(std::vector<std::string> words);
  std::string Said() const;

  ActuatorPeer peer_;
  std::vector<std::unique_ptr<transport::Subscription>> subscriptions_;

 private:
  std::optional<exec::Child> world_;
};

}  // namespace musher::test
