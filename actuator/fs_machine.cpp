#include "musher/actuator/fs_machine.hpp"

#include <utility>

#include "musher/base/code.hpp"

namespace musher {
namespace {

constexpr Duration kHeartbeatPeriod = Milliseconds(500);

// The library of CyberDog's own modules sends this code without the module's number, and its
// manager expects that.
std::int32_t OnTheWire(std::int32_t code) {
  return code == kCodeUnSupport ? static_cast<std::int32_t>(KeyCode::kUnSupport) : code;
}

}  // namespace

Result<std::unique_ptr<FsMachine>> FsMachine::Make(transport::Node& node,
                                                   const std::string& name_space,
                                                   const std::string& name, OnCommand on_command) {
  std::unique_ptr<FsMachine> machine(new FsMachine(node, name));
  FsMachine* self = machine.get();
  auto heartbeats = transport::MakePublisher<msg::Heartbeats>(
      node, transport::ResolveName(name_space, "manager_heartbeats"), transport::kSystemDefaultQos,
      {[self] { self->OnMatchChanged(); }});
  if (!heartbeats) return heartbeats.error();
  machine->heartbeats_ = std::move(heartbeats).value();
  auto server = transport::MakeServer<msg::FsMachine>(
      node, transport::ResolveName(name_space, name + "machine_service"),
      [on_command = std::move(on_command)](const msg::FsMachine::Request& request, auto reply) {
        on_command(State(request.target_state), [reply](const State& state, std::int32_t code) {
          reply({MachineStateNumber(state), OnTheWire(code)});
        });
      });
  if (!server) return server.error();
  machine->server_ = std::move(server).value();
  return machine;
}

void FsMachine::OnMatchChanged() {
  if (!heartbeats_ || heartbeats_->MatchedReaders() == 0) {
    heartbeat_ = nullptr;
  } else if (!heartbeat_) {
    heartbeat_ = node_.loop().Every(kHeartbeatPeriod, [this] {
      msg::Heartbeats heartbeat;
      heartbeat.name = name_;
      // A lost heartbeat is followed by the next.
      static_cast<void>(heartbeats_->Publish(heartbeat).ok());
    });
  }
}

}  // namespace musher
