#include "musher/simulation/permit_console.hpp"

#include <utility>

#include "musher/wire/lifecycle_wire.hpp"

namespace musher::simulation {
namespace {

constexpr Duration kPermitEvery = Milliseconds(50);  // of `musher permit`

}  // namespace

PermitConsole::PermitConsole(transport::sim::Network& network, Hosts& hosts,
                             const std::string& endpoint, std::size_t host,
                             const std::string& name_space, const MachineIdentity& machine,
                             std::function<void(Time stamp)> on_permit)
    : network_(network), endpoint_(endpoint), host_(host), on_permit_(std::move(on_permit)) {
  hosts.Attach(endpoint_, host_);
  node_ = network_.MakeNode(endpoint_);
  permit_.machine = machine.name;
  permit_.machine_id = machine.id;
  permit_.participant = network_.ParticipantOf(*node_).value();
  permit_.by = "a person";
  publisher_ = transport::MakePublisher<msg::Permit>(*node_, transport::PermitTopic(name_space),
                                                     transport::kHeartbeatQos)
                   .value();
  timer_ = node_->loop().Every(kPermitEvery, [this] { Give(); });
}

PermitConsole::~PermitConsole() {
  network_.Crash(*node_);
}

void PermitConsole::Give() {
  const Time now = node_->loop().Now();
  permit_.stamp_ns = transport::ToNanoseconds(now);
  on_permit_(now);
  static_cast<void>(publisher_->Publish(permit_));
}

}  // namespace musher::simulation
