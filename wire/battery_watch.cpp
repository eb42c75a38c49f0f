#include "musher/wire/battery_watch.hpp"

#include <utility>

#include "musher/messages/protocol/device.hpp"

namespace musher::transport {

constexpr std::uint8_t kFull = 100;

BatteryWatch::BatteryWatch(Node& node, Duration raise_after, OnChange on_change)
    : node_(node), on_change_(std::move(on_change)), reading_(raise_after, kSilent) {}

// Best effort matches every writer; a lost sample is followed by the next.
Result<std::unique_ptr<BatteryWatch>> BatteryWatch::Make(Node& node, const MachineConfig& config,
                                                         OnChange on_change) {
  const bool has_policy = config.policy && config.policy->battery;
  const Duration raise_after =
      has_policy ? config.policy->battery->raise_after : BatteryPolicy().raise_after;
  std::unique_ptr<BatteryWatch> watch(new BatteryWatch(node, raise_after, std::move(on_change)));
  auto samples = MakeSubscription<msg::BmsStatus>(
      node, BatteryTopic(config),
      [self = watch.get()](const msg::BmsStatus& sample, const SampleInfo& info) {
        if (sample.batt_soc > kFull) return;
        self->Set(
            self->reading_.Take(info.writer.value(), sample.batt_soc, self->node_.loop().Now()));
      },
      kSensorDataQos);
  if (!samples) return samples.error();
  watch->samples_ = std::move(samples).value();
  return watch;
}

void BatteryWatch::Set(std::optional<int> percent) {
  silence_ = nullptr;
  if (!percent) {
    reading_.Forget();
  } else {
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
