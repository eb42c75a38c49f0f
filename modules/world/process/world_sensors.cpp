#include "musher/modules/world/process/world_sensors.hpp"

#include <utility>

namespace musher::world {
namespace {

template <msg::Message M, class Measure>
void Publish(const std::unique_ptr<transport::Publisher<M>>& publisher, const World& world,
             double rate_hz, const std::string& fault, Measure measure) {
  if (!publisher || !IsDue(world.now(), rate_hz) || publisher->MatchedReaders() == 0) return;
  if (world.IsSilent(fault)) return;
  static_cast<void>(publisher->Publish(measure(world)));  // the next one follows soon
}

}  // namespace

Result<std::unique_ptr<WorldSensors>> WorldSensors::Make(transport::Node& node, const Scene& scene,
                                                         const std::string& name_space) {
  auto sensors = std::make_unique<WorldSensors>();
  const auto make = [&]<msg::Message M>(PublisherPtr<M>& publisher, bool enabled,
                                        const std::string& name) -> Result<> {
    if (!enabled) return Ok();
    auto made = transport::MakePublisher<M>(
        node, transport::ResolveName(name_space, "world/" + name), transport::kSensorDataQos);
    if (!made) return made.error();
    publisher = std::move(made).value();
    return Ok();
  };
  const SensorSpecs& specs = scene.sensors;
  if (auto made = make(sensors->scan_, specs.lidar.enabled, "scan"); !made) return made.error();
  if (auto made = make(sensors->ultrasonic_, specs.ultrasonic.enabled, "ultrasonic"); !made) {
    return made.error();
  }
  for (std::size_t i = 0; i < kTofNames.size(); ++i) {
    auto made = make(sensors->tofs_[i], specs.tof.enabled, "tof/" + std::string(kTofNames[i]));
    if (!made) return made.error();
  }
  if (auto made = make(sensors->gps_, specs.gps.enabled, "gps"); !made) return made.error();
  if (auto made = make(sensors->satellites_, specs.gps.enabled, "gps/satellites"); !made) {
    return made.error();
  }
  if (auto made = make(sensors->uwb_, specs.uwb.enabled, "uwb"); !made) return made.error();
  return sensors;
}

void WorldSensors::OnStep(const World& world) {
  const SensorSpecs& specs = world.scene().sensors;
  Publish(scan_, world, specs.lidar.reach.rate_hz, "lidar", MeasureScan);
  Publish(ultrasonic_, world, specs.ultrasonic.reach.rate_hz, "ultrasonic", MeasureUltrasonic);
  for (std::size_t i = 0; i < kTofNames.size(); ++i) {
    if (world.IsSilent("tof")) break;
    Publish(tofs_[i], world, specs.tof.reach.rate_hz, "tof_" + std::string(kTofNames[i]),
            [i](const World& seen) { return MeasureTof(seen, i); });
  }
  Publish(satellites_, world, specs.gps.rate_hz, "gps", CountSatellites);  // before their fix
  Publish(gps_, world, specs.gps.rate_hz, "gps", MeasureFix);
  PublishTag(world);
}

void WorldSensors::PublishTag(const World& world) {
  const bool wanted = uwb_ && IsDue(world.now(), world.scene().sensors.uwb.rate_hz) &&
                      uwb_->MatchedReaders() > 0 && !world.IsSilent("uwb");
  if (!wanted) return;
  if (const auto tag = MeasureTag(world)) static_cast<void>(uwb_->Publish(*tag));
}

}  // namespace musher::world
