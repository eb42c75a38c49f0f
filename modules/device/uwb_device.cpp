#include "musher/modules/device/uwb_device.hpp"

#include <cmath>
#include <utility>

#include "musher/cyberdog/codes/module_codes.hpp"

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
  endpoints_.Serve<msg::GetUWBMacSessionID>("get_uwb_mac_session_id", [this](const auto&,
                                                                             auto reply) {
    msg::GetUWBMacSessionID::Response response;
    response.code = MakeCode(cyberdog::module_code::kUwb, KeyCode::kUnSupport);
    if (present_) {
      response = {kSessionId, kMaster, kMaster + 1, kMaster + 2, kMaster + 3, kMaster + 4, kCodeOk};
    }
    reply(response);
  });
  if (!present_) return endpoints_.opened();
  raw_ = endpoints_.Advertise<msg::UwbRaw>("uwb_raw");
  endpoints_.Subscribe<msg::Bool>(
      "uwb_connected", [this](const msg::Bool& connected) { connected_ = connected.data; });
  readings_ = endpoints_.Subscribe<msg::UwbRaw>(
      "world/uwb", [this](const msg::UwbRaw& reading) { OnReading(reading); },
      transport::kSensorDataQos);
  return endpoints_.opened();
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
  return Error{MakeCode(cyberdog::module_code::kUwb, KeyCode::kSelfCheckFailed),
               "no publisher of world/uwb"};
}

}  // namespace musher::device
