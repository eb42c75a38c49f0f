#include "musher/modules/device/uwb_device.hpp"

#include <cmath>
#include <utility>

namespace musher::device {
namespace {

// Of the session with the simulated tag: the radio and its four antennas.
constexpr std::uint32_t kSessionId = 1;
constexpr std::uint16_t kMaster = 1;

}  // namespace

Result<std::unique_ptr<UwbDevice>> UwbDevice::Make(const Dependencies& dependencies, bool present) {
  std::unique_ptr<UwbDevice> device(new UwbDevice(dependencies, present));
  if (Result<> connected = device->Connect(); !connected) return connected.error();
  return device;
}

Result<> UwbDevice::Connect() {
  auto session = transport::MakeServer<msg::GetUWBMacSessionID>(
      dependencies_.node, dependencies_.Name("get_uwb_mac_session_id"),
      [this](const auto&, auto reply) {
        msg::GetUWBMacSessionID::Response response;
        response.code = MakeCode(ModuleCode::kUwb, KeyCode::kUnSupport);
        if (present_) {
          response = {kSessionId,  kMaster,     kMaster + 1, kMaster + 2,
                      kMaster + 3, kMaster + 4, kCodeOk};
        }
        reply(response);
      });
  if (!session) return session.error();
  session_ = std::move(session).value();
  if (!present_) return Ok();
  auto raw =
      transport::MakePublisher<msg::UwbRaw>(dependencies_.node, dependencies_.Name("uwb_raw"));
  if (!raw) return raw.error();
  raw_ = std::move(raw).value();
  auto connections = transport::MakeSubscription<msg::Bool>(
      dependencies_.node, dependencies_.Name("uwb_connected"),
      [this](const msg::Bool& connected, const auto&) { connected_ = connected.data; });
  if (!connections) return connections.error();
  connections_ = std::move(connections).value();
  auto readings = transport::MakeSubscription<msg::UwbRaw>(
      dependencies_.node, dependencies_.Name("world/uwb"),
      [this](const msg::UwbRaw& reading, const auto&) { OnReading(reading); },
      transport::kSensorDataQos);
  if (!readings) return readings.error();
  readings_ = std::move(readings).value();
  return Ok();
}

void UwbDevice::OnReading(const msg::UwbRaw& reading) {
  const bool bad = !(reading.dist >= 0) || !std::isfinite(reading.dist) ||
                   !(std::abs(reading.angle) <= 2 * M_PI);
  if (std::exchange(refused_, bad) != bad && bad) {
    dependencies_.log("uwb: readings are refused: invalid distance or angle");
  }
  if (!bad && connected_) static_cast<void>(raw_->Publish(reading));
}

Result<> UwbDevice::Check() const {
  if (!present_ || readings_->MatchedWriters() > 0) return Ok();
  return Error{MakeCode(ModuleCode::kUwb, KeyCode::kSelfCheckFailed), "no publisher of world/uwb"};
}

}  // namespace musher::device
