#include "musher/controller/shell/capability_board.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/actuator/capability.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

constexpr Duration kPeriod = Milliseconds(50);

}  // namespace

CapabilityBoard::CapabilityBoard(transport::Node& node, const MachineConfig& config,
                                 const Machine& machine)
    : node_(node), config_(config), machine_(machine) {}

Result<std::unique_ptr<CapabilityBoard>> CapabilityBoard::Make(transport::Node& node,
                                                               const MachineConfig& config,
                                                               const Machine& machine) {
  std::unique_ptr<CapabilityBoard> board(new CapabilityBoard(node, config, machine));
  if (auto opened = board->Open(); !opened) return opened.error();
  return board;
}

Result<> CapabilityBoard::Open() {
  auto publisher = transport::MakePublisher<msg::Capabilities>(
      node_, transport::CapabilitiesTopic(config_.name_space), transport::kLatchedQos);
  if (!publisher) return publisher.error();
  publisher_ = std::move(publisher).value();
  const bool needs_battery =
      std::any_of(config_.capabilities.begin(), config_.capabilities.end(),
                  [](const CapabilityConfig& c) { return c.min_battery.has_value(); });
  if (!needs_battery) return Ok();
  auto watch = transport::BatteryWatch::Make(node_, config_, [this](std::optional<int> percent) {
    battery_ = percent;
    Refresh();
  });
  if (!watch) return watch.error();
  battery_watch_ = std::move(watch).value();
  return Ok();
}

void CapabilityBoard::Refresh() {
  const bool never_changes = published_ && config_.capabilities.empty();
  if (later_ || never_changes) return;
  const Time now = node_.loop().Now();
  later_ = node_.loop().At(std::max(now, evaluated_at_ + kPeriod), [this] {
    later_ = nullptr;
    Publish();
  });
}

void CapabilityBoard::Publish() {
  evaluated_at_ = node_.loop().Now();
  msg::Capabilities now = Now();
  if (published_ == now) return;
  // A failed publish is repeated with the next change.
  static_cast<void>(publisher_->Publish(now));
  published_ = std::move(now);
}

msg::Capabilities CapabilityBoard::Now() const {
  msg::Capabilities now;
  const auto verdicts = EvaluateCapabilities(config_, machine_, battery_);
  for (std::size_t i = 0; i < verdicts.size(); ++i) {
    const CapabilityConfig& declared = config_.capabilities[i];
    const CapabilityVerdict& verdict = verdicts[i];
    now.capabilities.push_back({declared.name,
                                declared.description,
                                verdict.allowed,
                                verdict.code,
                                verdict.reason,
                                declared.actuators,
                                {declared.states.begin(), declared.states.end()}});
  }
  return now;
}

}  // namespace musher
