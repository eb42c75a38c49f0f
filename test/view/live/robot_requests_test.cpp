// In virtual time: what a page requests reaches the machine that it shows, and no other one.

#include "musher/view/live/robot_requests.hpp"

#include <gmock/gmock.h>

#include "musher/transport/sim/network.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::view::robot_requests_test {

using ::testing::ElementsAre;

class RequestsOfAPage : public ::testing::Test {
 protected:
  // A machine's controller, as a page sees it.
  struct Controller {
    std::unique_ptr<transport::Node> node;
    std::unique_ptr<transport::Publisher<msg::MachineStatus>> status;
    std::unique_ptr<transport::Server<msg::GetHistory>> history;
  };
  Controller Lead(const std::string& machine, const std::string& id) {
    Controller controller{network_.MakeNode(machine), nullptr, nullptr};
    controller.status =
        transport::MakePublisher<msg::MachineStatus>(
            *controller.node, transport::MachineStatusTopic(""), transport::kLatchedQos)
            .value();
    controller.history =
        transport::MakeServer<msg::GetHistory>(
            *controller.node, transport::MachineService("", "get_history"),
            transport::Server<msg::GetHistory>::Handler([machine](const auto&, auto reply) {
              reply({machine, {}});
            }))
            .value();
    msg::MachineStatus status;
    status.machine = machine;
    status.machine_id = id;
    status.host = machine;
    EXPECT_TRUE(controller.status->Publish(status).ok());
    network_.RunFor(Milliseconds(100));
    return controller;
  }
  http::Respond Collect() {
    return [this](http::Response response) { bodies_.push_back(*response.body); };
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  std::vector<std::string> bodies_;
  std::unique_ptr<LeaderWatch> leader_ =
      LeaderWatch::Make(
          *desk_, {"", "desk", {}}, [](const msg::MachineStatus&) {},
          [](const msg::MachineStatus&, const std::string&) {})
          .value();
  RobotRequests requests_{
      *desk_, {"", "desk", false}, [this]() -> const LeaderWatch& { return *leader_; }};
};

TEST_F(RequestsOfAPage, StopTheMachineThatItShows) {
  const auto dog = Lead("dog", "uuid-a");
  const auto cat = Lead("cat", "uuid-b");
  std::vector<std::string> stopped;
  const auto stops = transport::SubscribeToStops(
      *cat.node, "", [&](const msg::EmergencyStop& stop, const transport::SampleInfo&) {
        stopped.push_back(stop.machine + " " + stop.machine_id);
      });
  requests_.Stop("alice", "a person is near", Collect());
  network_.RunFor(Milliseconds(200));
  EXPECT_THAT(stopped, ElementsAre("dog uuid-a"));
}

TEST_F(RequestsOfAPage, AreAnsweredByTheMachineThatItShows) {
  const auto dog = Lead("dog", "uuid-a");
  const auto cat = Lead("cat", "uuid-b");
  for (int i = 0; i < 5; ++i) requests_.History(10, Collect());
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_THAT(bodies_, ::testing::Each(R"({"error":"dog","entries":[]})"));
  EXPECT_EQ(bodies_.size(), 5U);
}

}  // namespace musher::view::robot_requests_test
