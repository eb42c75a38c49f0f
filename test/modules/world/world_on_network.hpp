#pragma once
// The fixture of tests that run a world on a simulated network, in virtual time, with a desk beside
// it that subscribes to its topics and publishes to it.

#include <gmock/gmock.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/world/process/world_host.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::world {

class WorldOnNetwork : public ::testing::Test {
 protected:
  // `name_space`: of the world's topics; "" for none.
  explicit WorldOnNetwork(std::string name_space = "") : name_space_(std::move(name_space)) {}

  // `shooter` draws the cameras' pictures.
  void StartWorld(const Scene& scene, Worker* shooter = nullptr, HostOptions options = {}) {
    options.shooter = shooter;
    options.name_space = name_space_;
    options.log = [this](const std::string& line) { log_.push_back(line); };
    host_ = WorldHost::Start(*world_node_, scene, options).value();
  }
  // The topic in the world's namespace.
  std::string Name(const std::string& topic) const {
    return name_space_.empty() ? topic : name_space_ + "/" + topic;
  }
  template <class M>
  std::unique_ptr<transport::Subscription> Listen(
      const std::string& topic, std::vector<M>& received,
      const transport::Qos& qos = transport::kDefaultQos) {
    return transport::MakeSubscription<M>(
               *desk_, topic,
               [&received](const M& message, const auto&) { received.push_back(message); }, qos)
        .value();
  }
  // The same until the end of the test, once the two have found each other.
  template <class M>
  std::vector<M>& Keep(const std::string& topic, std::vector<M>& received,
                       const transport::Qos& qos = transport::kDefaultQos) {
    kept_.push_back(Listen(topic, received, qos));
    network_.RunFor(Milliseconds(200));
    return received;
  }
  // Publishes it ten times a second, for that long.
  template <class M>
  void Send(const std::string& topic, const M& message, Duration time = Milliseconds(100)) {
    auto publisher = transport::MakePublisher<M>(*desk_, topic).value();
    network_.RunFor(Milliseconds(100));
    for (Duration done{}; done < time; done += Milliseconds(100)) {
      ASSERT_TRUE(publisher->Publish(message));
      network_.RunFor(Milliseconds(100));
    }
  }
  void InjectFault(const std::string& fault, Duration each = Milliseconds(500)) {
    const auto say = transport::MakePublisher<msg::String>(*desk_, Name("world/fault")).value();
    network_.RunFor(each);
    ASSERT_TRUE(say->Publish({fault}));
    network_.RunFor(each);
  }

  const std::string name_space_;
  PromptWorker shooter_;
  transport::sim::Network network_{3};
  std::vector<std::string> log_;
  std::unique_ptr<transport::Node> world_node_ = network_.MakeNode("world");
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  std::unique_ptr<WorldHost> host_;
  std::vector<std::shared_ptr<void>> kept_;
};

}  // namespace musher::world
