// A bridge between domains, a router, or a recording that is replayed repeats the samples of a
// robot: what another participant repeats does not count.

#include <gmock/gmock.h>

#include "musher/lifecycle/health/health_monitor.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/test/controller/two_controllers.hpp"
#include "musher/transport/service.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing::repeated_samples_test {

using std::chrono::seconds;

class RepeatedSamples : public TwoControllers {
 protected:
  // A process that repeats on its own topics what it receives of an actuator.
  struct Bridge {
    std::unique_ptr<transport::Node> node;
    std::unique_ptr<transport::Publisher<msg::ActuatorStatus>> out;
    std::unique_ptr<transport::Publisher<msg::ActuatorHeartbeat>> heartbeats;
    std::unique_ptr<transport::Subscription> in;
    msg::ActuatorStatus last;
  };

  const KnownActuator& Arm() const { return first_.machine().actuators[0]; }
  const std::string& Name() const { return config_.actuators[0].name; }

  std::unique_ptr<Bridge> OpenBridge() {
    auto bridge = std::make_unique<Bridge>();
    bridge->node = network_.MakeNode("bridge");
    bridge->out = transport::MakePublisher<msg::ActuatorStatus>(
                      *bridge->node, transport::ActuatorStatusTopic(""), transport::kLatchedQos)
                      .value();
    bridge->heartbeats =
        transport::MakePublisher<msg::ActuatorHeartbeat>(
            *bridge->node, transport::ActuatorHeartbeatTopic(""), transport::kHeartbeatQos)
            .value();
    const auto own = bridge->node->participant();
    bridge->in = transport::MakeSubscription<msg::ActuatorStatus>(
                     *bridge->node, transport::ActuatorStatusTopic(""),
                     [this, own, to = bridge.get()](const msg::ActuatorStatus& status,
                                                    const transport::SampleInfo& info) {
                       if (info.participant == own || status.name != Name()) return;
                       to->last = status;
                       EXPECT_TRUE(to->out->Publish(status));
                     },
                     transport::kLatchedFromManyQos)
                     .value();
    EXPECT_TRUE(RunUntil([&] { return !bridge->last.name.empty(); }));
    network_.RunFor(seconds(1));
    return bridge;
  }
  msg::ActuatorHeartbeat Heartbeat(std::uint8_t work) const {
    msg::ActuatorHeartbeat heartbeat;
    heartbeat.name = Name();
    heartbeat.incarnation = Arm().report.incarnation.value();
    heartbeat.period_ns = HeartbeatPeriod(config_, 0).count();
    heartbeat.work = work;
    return heartbeat;
  }
};

TEST_F(RepeatedSamples, OfAStatusDoNotMakeItsActuatorLostWhenTheyEnd) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  auto bridge = OpenBridge();
  bridge.reset();
  network_.RunFor(seconds(1));
  EXPECT_EQ(Arm().presence, Presence::kPresent);
  EXPECT_EQ(Arm().health, Health::kWell);
}

TEST_F(RepeatedSamples, ThatSayHungKillNoProcess) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  const Incarnation before = Arm().report.incarnation;
  const auto bridge = OpenBridge();
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(bridge->heartbeats->Publish(Heartbeat(msg::ActuatorHeartbeat::kWorkHung)));
    network_.RunFor(Milliseconds(100));
  }
  EXPECT_EQ(Arm().health, Health::kWell);
  network_.RunFor(seconds(10));
  EXPECT_EQ(Arm().report.incarnation, before) << "the same process";
  EXPECT_EQ(Arm().presence, Presence::kPresent);
}

TEST_F(RepeatedSamples, OfAControllersHeartbeatFenceNoOther) {
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  const auto node = network_.MakeNode("bridge");
  const auto out = transport::MakePublisher<msg::ControllerHeartbeat>(
                       *node, transport::ControllerHeartbeatTopic(""), transport::kLatchedQos)
                       .value();
  msg::ControllerHeartbeat replayed;
  replayed.machine = config_.name;
  replayed.epoch = 9;
  replayed.host = "host of the recording";
  replayed.pid = 4711;
  replayed.participant = 4711;  // of the process that was recorded
  ASSERT_TRUE(out->Publish(replayed));
  network_.RunFor(seconds(3));
  EXPECT_EQ(first_.machine().phase, Phase::kRunning);
  replayed.participant = node->participant().value();
  ASSERT_TRUE(out->Publish(replayed));
  EXPECT_TRUE(RunUntil([this] { return first_.machine().phase == Phase::kFenced; }))
      << "a heartbeat of its own process counts";
}

// An actuator that is started by hand, whose status writer can be lost while its process runs on.
class ByHand {
 public:
  ByHand(transport::sim::Network& network, const std::string& name)
      : node_(network.MakeNode("hand")) {
    status_.name = name;
    status_.state = "DeActive";
    status_.incarnation = 77;
    status_.host = "hand";
    heartbeat_.name = name;
    heartbeat_.incarnation = status_.incarnation;
    heartbeat_.period_ns = Duration(kPeriod).count();
    server_ = transport::MakeServer<msg::ActuatorCommand>(
                  *node_, transport::CommandService("", name),
                  [this](const auto& request, const auto& reply) { reply(Answer(request)); })
                  .value();
    statuses_ = transport::MakePublisher<msg::ActuatorStatus>(
                    *node_, transport::ActuatorStatusTopic(""), transport::kLatchedQos)
                    .value();
    heartbeats_ = transport::MakePublisher<msg::ActuatorHeartbeat>(
                      *node_, transport::ActuatorHeartbeatTopic(""), transport::kHeartbeatQos)
                      .value();
    timer_ =
        node_->loop().Every(kPeriod, [this] { EXPECT_TRUE(heartbeats_->Publish(heartbeat_)); });
    EXPECT_TRUE(statuses_->Publish(status_));
  }
  void LoseStatusWriter() { statuses_ = nullptr; }

 private:
  static constexpr Duration kPeriod = Milliseconds(100);

  msg::ActuatorCommand::Response Answer(const msg::ActuatorCommand::Request& request) {
    status_.epoch = request.epoch;
    if (request.kind == msg::ActuatorCommand::kKindSwitch) {
      status_.state = request.target;
      status_.number = status_.outcome_number = request.number;
    }
    status_.stamp_ns = transport::ToNanoseconds(node_->loop().Now());
    msg::ActuatorCommand::Response response;
    response.status = status_;
    return response;
  }

  std::unique_ptr<transport::Node> node_;
  msg::ActuatorStatus status_;
  msg::ActuatorHeartbeat heartbeat_;
  std::unique_ptr<transport::Server<msg::ActuatorCommand>> server_;
  std::unique_ptr<transport::Publisher<msg::ActuatorStatus>> statuses_;
  std::unique_ptr<transport::Publisher<msg::ActuatorHeartbeat>> heartbeats_;
  transport::LoopHandlePtr timer_;
};

class LostWriter : public TwoControllers {};

TEST_F(LostWriter, DoesNotKeepAnActuatorLostWhoseHeartbeatsAreReceived) {
  config_.actuators[1].command.clear();
  ByHand by_hand(network_, config_.actuators[1].name);
  ASSERT_NO_FATAL_FAILURE(BringUpFirst());
  const KnownActuator& known = first_.machine().actuators[1];
  ASSERT_TRUE(RunUntil([&] { return known.presence == Presence::kPresent; }));
  by_hand.LoseStatusWriter();
  ASSERT_TRUE(RunUntil([&] { return known.presence == Presence::kLost; }));
  EXPECT_TRUE(RunUntil([&] { return known.presence == Presence::kPresent; }, seconds(5)));
}

}  // namespace musher::testing::repeated_samples_test
