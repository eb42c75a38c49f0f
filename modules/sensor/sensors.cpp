#include "musher/modules/sensor/sensors.hpp"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "musher/cyberdog/codes/module_codes.hpp"

namespace musher::sensor {
namespace {

using Operation = msg::SensorOperation;

bool Sleeps(SensorKind kind, std::string_view state) {
  if (state == kTearDown) return true;
  return kind != SensorKind::kGps && (state == kLowPower || state == kOta);
}

}  // namespace

Result<std::unique_ptr<Sensors>> Sensors::Make(const Dependencies& dependencies,
                                               const ManagerConfig& config) {
  std::unique_ptr<Sensors> sensors(new Sensors(dependencies, config));
  if (Result<> connected = sensors->Connect(); !connected) return connected.error();
  return sensors;
}

Result<> Sensors::Connect() {
  for (const SensorKind kind : kSensorKinds) {
    sensors_.at(static_cast<std::size_t>(kind)) =
        MakeSensor(kind, endpoints_, dependencies_, config_);
  }
  endpoints_.Serve<Operation>("sensor_operation", [this](const auto& request, auto reply) {
    const Result<> done = Operate(request);
    if (!done) dependencies_.log("sensor_operation refused: " + done.error().message);
    reply({done.ok(), done ? kCodeOk : done.error().code});
  });
  return endpoints_.opened() ? Enter(kSelfCheck) : endpoints_.opened();
}

Result<> Sensors::Enter(std::string_view state) {
  Result<> entered;
  for (const SensorKind kind : kSensorKinds) {
    if (Result<> done = Of(kind).SetAsleep(Sleeps(kind, state)); !done) entered = done;
  }
  return entered;
}

std::vector<SensorResult> Sensors::Check() const {
  std::vector<SensorResult> findings;
  for (const SensorKind kind : kSensorKinds) {
    const auto& skip = config_.skip;
    if (std::find(skip.begin(), skip.end(), kind) != skip.end()) continue;
    findings.push_back({kind, Of(kind).Check(KeyCode::kSelfCheckFailed)});
  }
  return findings;
}

Result<> Sensors::CheckStarted() const {
  for (const SensorKind kind : config_.critical) {
    if (Result<> publishing = Of(kind).Check(KeyCode::kFailed); !publishing) {
      return Error{publishing.error().code,
                   std::string(NameOf(kind)) + " does not start: " + publishing.error().message};
    }
  }
  return Ok();
}

Result<> Sensors::Operate(const Operation::Request& request) {
  std::vector<SensorKind> kinds;
  if (const auto kind = KindOfId(request.sensor_id)) {
    kinds.push_back(*kind);
  } else if (request.sensor_id == Operation::kAll) {
    std::copy_if(kSensorKinds.begin(), kSensorKinds.end(), std::back_inserter(kinds),
                 [this](SensorKind each) { return Of(each).exists(); });
  }
  if (kinds.empty()) {
    return Error{MakeCode(cyberdog::module_code::kSensorManager, KeyCode::kParametersInvalid),
                 "unknown sensor " + std::to_string(request.sensor_id) +
                     "; 0 is all, 1 lidar, 2 ultrasonic, 3 tof, 4 gps"};
  }
  std::vector<std::pair<SensorKind, Phase>> steps;
  for (const SensorKind kind : kinds) {
    const Result<Phase> phase = Of(kind).PhaseAfter(request.operation);
    if (!phase) return phase.error();
    steps.emplace_back(kind, phase.value());
  }
  for (const auto& [kind, phase] : steps) {
    if (Result<> done = Of(kind).SetPhase(phase); !done) return done;
  }
  return Ok();
}

void Sensors::OnTimeJumped() {
  for (const auto& sensor : sensors_) sensor->OnTimeJumped();
}

}  // namespace musher::sensor
