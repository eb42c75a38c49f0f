#include "musher/modules/world/process/world_sensors.hpp"

#include <string>

namespace musher::world {
namespace {

template <msg::Message M, class Measure>
void Publish(transport::Publisher<M>* publisher, const World& world, double rate_hz,
             const std::string& fault, Measure measure) {
  if (publisher == nullptr || !IsDue(world.now(), rate_hz) || publisher->MatchedReaders() == 0)
    return;
  if (world.IsSilent(fault)) return;
  static_cast<void>(publisher->Publish(measure(world)));  // the next one follows soon
}

}  // namespace

WorldSensors::WorldSensors(transport::Endpoints& endpoints, const Scene& scene) {
  const auto open = [&]<msg::Message M>(transport::Publisher<M>*& publisher, bool enabled,
                                        const std::string& name) {
    if (enabled) publisher = endpoints.Advertise<M>("world/" + name, transport::kSensorDataQos);
  };
  const SensorSpecs& specs = scene.sensors;
  open(scan_, specs.lidar.enabled, "scan");
  open(ultrasonic_, specs.ultrasonic.enabled, "ultrasonic");
  for (std::size_t i = 0; i < kTofNames.size(); ++i) {
    open(tofs_[i], specs.tof.enabled, "tof/" + std::string(kTofNames[i]));
  }
  open(gps_, specs.gps.enabled, "gps");
  open(satellites_, specs.gps.enabled, "gps/satellites");
  open(uwb_, specs.uwb.enabled, "uwb");
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
  const bool wanted = uwb_ != nullptr && IsDue(world.now(), world.scene().sensors.uwb.rate_hz) &&
                      uwb_->MatchedReaders() > 0 && !world.IsSilent("uwb");
  if (!wanted) return;
  if (const auto tag = MeasureTag(world)) static_cast<void>(uwb_->Publish(*tag));
}

}  // namespace musher::world
