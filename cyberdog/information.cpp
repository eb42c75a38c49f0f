#include "musher/cyberdog/information.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "musher/base/version.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/cyberdog/interfaces.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/wire/battery_watch.hpp"

namespace musher::cyberdog {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr std::size_t kLongestName = 256;
constexpr Duration kSerialPeriod = Milliseconds(100);
constexpr int kSerialTimes = 600;

// In the order of DeviceInfo's `enables`.
constexpr std::array<const char*, 15> kKeys = {
    "sn",          "version",       "uid",   "nick_name",        "volume",
    "mic_state",   "voice_control", "wifi",  "bat_info",         "motor_temper",
    "audio_state", "device_model",  "stand", "lowpower_control", "charging"};

// As one line; bytes that are not UTF-8 become U+FFFD.
std::string Text(const OrderedJson& json) {
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

}  // namespace

Information::Information(transport::Endpoints& endpoints, const MachineConfig& config,
                         const Machine& machine, std::string serial_number)
    : loop_(endpoints.node().loop()),
      config_(config),
      machine_(machine),
      serial_number_(std::move(serial_number)) {
  endpoints.SubscribeResolved<msg::BmsStatus>(
      transport::BatteryTopic(config),
      [this](const msg::BmsStatus& sample) {
        battery_ = sample;
        battery_at_ = loop_.Now();
      },
      transport::kSensorDataQos);
  endpoints.Subscribe<msg::NodeError>(
      kNodeErrors, [publish = endpoints.PublishFunction<msg::String>(kManagerErrors)](
                       const msg::NodeError& error) {
        publish({Text({{"name", error.name.substr(0, kLongestName)}, {"code", error.code}})});
      });
  endpoints.Serve<msg::BmsInfo>(kBmsInfo,
                                [this](const auto&, const auto& reply) { reply(Battery()); });
  endpoints.Serve<msg::DeviceInfo>(
      kQueryDiviceInfo,
      [this](const auto& request, const auto& reply) { reply(About(request.enables)); });
  ServeIdentity(endpoints);
}

// The bridge to the app needs the serial number before anything else.
void Information::ServeIdentity(transport::Endpoints& endpoints) {
  endpoints.Subscribe<msg::String>(
      kUidSet, [this](const msg::String& uid) { uid_ = uid.data.substr(0, kLongestName); });
  endpoints.Serve<msg::UidSn>(kUidSn, [this](const auto&, const auto& reply) {
    reply({uid_, serial_number_, serial_number_.empty() ? kCodeUnSupport : kCodeOk});
  });
  endpoints.Serve<msg::Trigger>(kGetDogSn, [this](const auto&, const auto& reply) {
    const bool known = !serial_number_.empty();
    reply({known, known ? serial_number_ : "no serial number found on this computer"});
  });
  if (serial_number_.empty()) return;
  serial_timer_ =
      loop_.Every(kSerialPeriod, [this, publish = endpoints.PublishFunction<msg::String>(kDogSn)] {
        publish({serial_number_});
        if (++serials_published_ == kSerialTimes) serial_timer_ = nullptr;
      });
}

msg::BmsInfo::Response Information::Battery() const {
  if (!battery_) return {{}, MakeCode(module_code::kBms, KeyCode::kUninitialized)};
  const bool old = loop_.Now() - battery_at_ > transport::BatteryWatch::kSilent;
  return {*battery_, old ? MakeCode(module_code::kBms, KeyCode::kTimeout) : kCodeOk};
}

// Fields of an account or of another module, which this controller does not have, are null.
msg::DeviceInfo::Response Information::About(const std::vector<bool>& enables) const {
  if (enables.size() > kKeys.size()) return {"", kCodeParametersInvalid};
  OrderedJson known;
  known["version"] = Version();
  known["device_model"] = config_.name;
  if (!serial_number_.empty()) known["sn"] = serial_number_;
  if (!uid_.empty()) known["uid"] = uid_;
  known["lowpower_control"] = machine_.policy.low_power;
  if (battery_) {
    known["bat_info"] = {{"soc", battery_->batt_soc},
                         {"voltage_mv", battery_->batt_volt},
                         {"current_ma", battery_->batt_curr},
                         {"temperature", battery_->batt_temp}};
    known["charging"] = battery_->power_wired_charging || battery_->power_wp_charging;
  }
  OrderedJson answer = OrderedJson::object();
  for (std::size_t i = 0; i < enables.size(); ++i) {
    if (!enables[i]) continue;
    const auto found = known.find(kKeys[i]);
    answer[kKeys[i]] = found == known.end() ? OrderedJson() : *found;
  }
  return {Text(answer), kCodeOk};
}

}  // namespace musher::cyberdog
