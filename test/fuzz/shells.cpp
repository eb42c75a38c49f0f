// A whole robot on the simulated network, and an untrusted participant that publishes bytes on
// every topic with a subscription. The robot keeps working: no actuator becomes more active than
// requested, and a request gets a reply afterwards.

#include <memory>
#include <vector>

#include "musher/messages/lifecycle_msgs/services.hpp"
#include "musher/messages/lifecycle_msgs/transition_event.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/messages/protocol/fs_machine.hpp"
#include "musher/messages/protocol/heartbeats.hpp"
#include "musher/simulation/robot.hpp"
#include "musher/test/fuzz/untrusted.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/transport/raw_server.hpp"

namespace musher::fuzz {
namespace {

// a is a Musher actuator, b a CyberDog module, c a ROS 2 node; b and c reply with any bytes.
MachineConfig Config() {
  MachineConfig config = testing::MachineOf(3);
  for (ActuatorConfig& actuator : config.actuators) {
    actuator.command = {"run"};
    actuator.restart.policy = RestartPolicy::kOnFailure;
    actuator.restart.limit = 2;
  }
  config.actuators[1].protocol = Protocol::kCyberdog;
  config.actuators[1].heartbeat_name = "b";
  config.actuators[2].protocol = Protocol::kRos2Lifecycle;
  return config;
}

msg::Bytes ToBytes(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

// The services of another program. Each reply is correct, or the next bytes of the input.
class Peer {
 public:
  Peer(transport::Node& node, const std::string& name, std::shared_ptr<Input> input)
      : input_(std::move(input)) {
    if (name == "b") {
      Serve<msg::FsMachine>(node, name + "machine_service", {4, 0});
    } else {
      Serve<msg::ChangeState>(node, name + "/change_state", {true});
      Serve<msg::GetState>(node, name + "/get_state", {{2, "inactive"}});
    }
  }

 private:
  template <class S>
  void Serve(transport::Node& node, const std::string& service, typename S::Response truth) {
    auto server = transport::RawServer::Make(
        node, service, std::string(S::kTypeName),
        [this, truth](const msg::RequestId& id, std::span<const std::byte>,
                      const transport::RawServer::Reply& reply, transport::ParticipantId) {
          msg::Bytes bytes = msg::Encode(id);
          const msg::Bytes body = input_->Bool() ? ToBytes(input_->Text()) : BodyOf(truth);
          bytes.insert(bytes.end(), body.begin(), body.end());
          if (input_->Byte() != 1) reply(std::move(bytes));
          return true;
        });
    servers_.push_back(std::move(server).value());
  }

  template <class M>
  static msg::Bytes BodyOf(const M& message) {
    msg::Bytes bytes = msg::Encode(message);
    return {bytes.begin() + 4, bytes.end()};  // behind the encapsulation header
  }

  std::shared_ptr<Input> input_;
  std::vector<std::unique_ptr<transport::RawServer>> servers_;
};

class Harness {
 public:
  explicit Harness(const Input& input)
      : input_(std::make_shared<Input>(input)),
        robot_(1, Config(), [this](const std::string& name, const State& state) {
          const auto rank = BuiltInRank(state);
          Require(name != "a" || !rank || *rank <= allowed_,
                  "no switch up for an untrusted participant");
          return simulation::Act{};
        }) {
    for (const char* name : {"b", "c"}) {
      robot_.UseProgram(name, [this, name](transport::Node& node) {
        return std::make_shared<Peer>(node, name, input_);
      });
    }
    for (const auto& [topic, type] : Topics()) {
      writers_.push_back(
          untrusted_->MakeRawWriter(topic, type, transport::kLatchedQos, {}).value());
    }
    robot_.StartController();
    robot_.RunFor(std::chrono::seconds(2));
    robot_.Set(State(kDeActive));
    allowed_ = *BuiltInRank(kDeActive);
  }

  void Run() {
    for (int steps = 0; steps < 40 && !input_->empty(); ++steps) Next();
    *input_ = Input(nullptr, 0);
    robot_.RunFor(std::chrono::seconds(5));
    Require(robot_.Set(State(kLowPower)).has_value(), "a request gets a reply");
  }

 private:
  static std::vector<std::pair<std::string, std::string>> Topics() {
    const auto request = [](std::string_view type) { return std::string(type) + "Request_"; };
    const auto response = [](std::string_view type) { return std::string(type) + "Response_"; };
    return {
        {"rt/musher/actuator_status", std::string(msg::ActuatorStatus::kTypeName)},
        {"rt/musher/actuator_heartbeat", std::string(msg::ActuatorHeartbeat::kTypeName)},
        {"rt/musher/emergency_stop", std::string(msg::EmergencyStop::kTypeName)},
        {"rt/manager_heartbeats", std::string(msg::Heartbeats::kTypeName)},
        {"rt/c/transition_event", std::string(msg::TransitionEvent::kTypeName)},
        {"rq/a/musher_commandRequest", request(msg::ActuatorCommand::kTypeName)},
        {"rq/amachine_serviceRequest", request(msg::FsMachine::kTypeName)},
        {"rr/a/musher_commandReply", response(msg::ActuatorCommand::kTypeName)},
        {"rr/bmachine_serviceReply", response(msg::FsMachine::kTypeName)},
        {"rr/c/get_stateReply", response(msg::GetState::kTypeName)},
        {"rr/c/change_stateReply", response(msg::ChangeState::kTypeName)},
    };
  }

  void Next() {
    Input& input = *input_;
    switch (input.Below(8)) {
      case 0:
        return Send(input.Below(writers_.size()), ToBytes(input.Text()));
      case 1:
        return Send(0, msg::Encode(transport::ToMessage(
                           "a", AnyReport(input, robot_.ReportOf("a").value_or(ActuatorReport{}),
                                          robot_.network().now()))));
      case 2: {
        msg::ActuatorHeartbeat heartbeat;
        heartbeat.name = "a";
        heartbeat.incarnation = robot_.ReportOf("a").value_or(ActuatorReport{}).incarnation.value();
        heartbeat.work = input.Byte();
        heartbeat.period_ns = AnyTime(input, robot_.network().now());
        heartbeat.silent_ns = AnyTime(input, robot_.network().now());
        heartbeat.waited_ns = AnyTime(input, robot_.network().now());
        heartbeat.during = AnyState(input);
        return Send(1, msg::Encode(heartbeat));
      }
      case 3:
        return Send(2, msg::Encode(msg::EmergencyStop{input.Number(1, 2), input.Bool(),
                                                      std::string(input.Text()), ""}));
      case 4:
        return robot_.ReleaseEmergencyStop();
      case 5: {
        const char* const targets[] = {"DeActive", "LowPower", "SelfCheck", "OTA"};
        robot_.Set(State(targets[input.Below(std::size(targets))]));
        return;
      }
      case 6:
        return robot_.CrashActuator(input.Bool() ? "a" : input.Bool() ? "b" : "c");
      default:
        return robot_.RunFor(Milliseconds(input.Take<std::uint16_t>() % 4096));
    }
  }

  void Send(std::size_t writer, const msg::Bytes& bytes) {
    static_cast<void>(writers_[writer]->Write(bytes));
    robot_.RunFor(Milliseconds(input_->Byte()));
  }

  std::shared_ptr<Input> input_;
  Rank allowed_ = *BuiltInRank(kActive);
  simulation::SimRobot robot_;
  std::unique_ptr<transport::Node> untrusted_ = robot_.network().MakeNode("untrusted");
  std::vector<std::unique_ptr<transport::RawWriter>> writers_;
};

}  // namespace
}  // namespace musher::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  musher::fuzz::Harness(musher::fuzz::Input(data, size)).Run();
  return 0;
}
