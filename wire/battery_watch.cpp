#include "musher/wire/battery_watch.hpp"

#include <utility>

#include "musher/messages/protocol/device.hpp"

namespace musher::transport {

constexpr std::uint8_t kFull = 100;

BatteryWatch::BatteryWatch(Node& node, OnChange on_change)
    : node_(node), on_change_(std::move(on_change)) {}

// Best effort matches every writer; a lost sample is followed by the next.
Result<std::unique_ptr<BatteryWatch>> BatteryWatch::Make(Node& node, const std::string& topic,
                                                         OnChange on_change) {
  std::unique_ptr<BatteryWatch> watch(new BatteryWatch(node, std::move(on_change)));
  auto samples = MakeSubscription<msg::BmsStatus>(
      node, topic,
      [self = watch.get()](const msg::BmsStatus& sample, const SampleInfo&) {
        if (sample.batt_soc <= kFull) self->Set(sample.batt_soc);
      },
      kSensorDataQos);
  if (!samples) return samples.error();
  watch->samples_ = std::move(samples).value();
  return watch;
}

void BatteryWatch::Set(std::optional<int> percent) {
  silence_ = nullptr;
  if (percent) {
    silence_ = node_.loop().At(node_.loop().Now() + kSilent, [this] { Set(std::nullopt); });
  }
  if (std::exchange(percent_, percent) != percent) on_change_(percent);
}

std::string BatteryTopic(const MachineConfig& config) {
  const bool has_policy = config.policy && config.policy->battery;
  const std::string name = has_policy ? config.policy->battery->topic : BatteryPolicy().topic;
  return ResolveName(config.name_space, name);
}

}  // namespace musher::transport
