#include "musher/modules/sensor/sensor.hpp"

#include <cstdint>
#include <string>
#include <utility>

#include "musher/messages/before_iron.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/basic.hpp"

namespace musher::sensor {

Result<Phase> Sensor::PhaseAfter(std::uint8_t operation) const {
  if (exists()) return Operate(kind_, phase_, operation);
  return Error{CodeOf(kind_, KeyCode::kUnSupport),
               "there is no " + std::string(NameOf(kind_)) + " in the config"};
}

Result<> Sensor::SetPhase(Phase phase) {
  phase_ = phase;
  return Apply();
}

Result<> Sensor::SetAsleep(bool asleep) {
  asleep_ = asleep;
  return Apply();
}

Result<> Sensor::Apply() {
  const bool receives_now = started() && !asleep_;
  if (!receives_now) Forget();
  for (const auto& source : parts_.sources) {
    if (!receives_now) {
      source->Ignore();
    } else if (Result<> subscribed = source->Listen(); !subscribed) {
      return Error{CodeOf(kind_, KeyCode::kFailed), subscribed.error().message};
    }
  }
  return Ok();
}

Result<> Sensor::Check(KeyCode key) const {
  if (!started()) return Ok();
  std::string faults;
  for (std::size_t i = 0; i < parts_.sources.size(); ++i) {
    if (parts_.sources[i]->fault().empty()) continue;
    if (!faults.empty()) faults += ", ";
    if (kind_ == SensorKind::kTof) faults += std::string(kTofKeys.at(i)) + ": ";
    faults += parts_.sources[i]->fault();
  }
  if (faults.empty()) return Ok();
  return Error{CodeOf(kind_, key), faults};
}

void Sensor::OnTimeJumped() {
  Forget();
  for (const auto& source : parts_.sources) source->OnTimeJumped();
}

void Sensor::Forget() {
  for (const auto& forget : parts_.forget) forget();
}

namespace {

SourceOptions OptionsOf(SensorKind kind, const ManagerConfig& config, std::size_t index = 0) {
  const SensorConfig& sensor = config.Of(kind);
  SourceOptions options;
  options.kind = kind;
  options.name = std::string(NameOf(kind));
  if (kind == SensorKind::kTof) options.name += " " + std::string(kTofKeys.at(index));
  options.topic = sensor.sources.at(index);
  options.silence = sensor.silence;
  options.stamp_tolerance = config.stamp_tolerance;
  return options;
}

// A sensor with one source, whose readings are converted by `convert` and published.
template <msg::Message In, msg::Message Out, class Convert>
Sensor::Parts MakeOne(SensorKind kind, transport::Endpoints& endpoints,
                      const Dependencies& dependencies, const ManagerConfig& config,
                      const std::string& topic, Convert convert) {
  const auto rate = std::make_shared<RateLimit>(config.Of(kind).period);
  auto use = [publish = endpoints.PublishFunction<Out>(topic), convert, rate](const In& reading) {
    if (rate->Take(msg::FromStamp(reading.header.stamp))) publish(convert(reading));
  };
  Sensor::Parts parts;
  parts.sources.push_back(std::make_unique<SourceOf<In>>(
      dependencies, OptionsOf(kind, config), [](const In& reading) { return Validate(reading); },
      std::move(use)));
  parts.forget.emplace_back([rate] { rate->Forget(); });
  return parts;
}

// Two ToF sensors, published together.
template <msg::Message Out>
void AddTofs(transport::Endpoints& endpoints, const Dependencies& dependencies,
             const ManagerConfig& config, const std::string& topic, std::uint8_t left,
             Sensor::Parts& parts) {
  struct Shared {
    std::function<void(const Out&)> publish;
    TofPair pair;
    RateLimit rate;
  };
  auto shared =
      std::make_shared<Shared>(Shared{endpoints.PublishFunction<Out>(topic), TofPair(left),
                                      RateLimit(config.Of(SensorKind::kTof).period)});
  const auto use = [shared](const msg::SingleTofPayload& reading) {
    auto both = shared->pair.Take(reading);
    if (!both || !shared->rate.Take(msg::FromStamp(both->front().header.stamp))) return;
    shared->publish({std::move((*both)[0]), std::move((*both)[1])});
  };
  for (const std::uint8_t position : {left, static_cast<std::uint8_t>(left + 1)}) {
    parts.sources.push_back(std::make_unique<SourceOf<msg::SingleTofPayload>>(
        dependencies, OptionsOf(SensorKind::kTof, config, position),
        [position](const msg::SingleTofPayload& reading) { return Validate(reading, position); },
        use));
  }
  parts.forget.emplace_back([shared] {
    shared->pair.Forget();
    shared->rate.Forget();
  });
}

Sensor::Parts MakeTofs(transport::Endpoints& endpoints, const Dependencies& dependencies,
                       const ManagerConfig& config) {
  using Tof = msg::SingleTofPayload;
  Sensor::Parts parts;
  AddTofs<msg::HeadTofPayload>(endpoints, dependencies, config, "head_tof_payload", Tof::kLeftHead,
                               parts);
  AddTofs<msg::RearTofPayload>(endpoints, dependencies, config, "rear_tof_payload", Tof::kLeftRear,
                               parts);
  return parts;
}

// A Range has the field `variance` since Iron.
Sensor::Parts MakeUltrasonic(transport::Endpoints& endpoints, const Dependencies& dependencies,
                             const ManagerConfig& config) {
  constexpr SensorKind kKind = SensorKind::kUltrasonic;
  constexpr const char* kTopic = "ultrasonic_payload";
  if (config.ros_distro.value_or(RosDistro::kJazzy) < RosDistro::kIron) {
    return MakeOne<msg::Range, msg::RangeBeforeIron>(
        kKind, endpoints, dependencies, config, kTopic,
        [](const msg::Range& range) { return msg::BeforeIron(range); });
  }
  return MakeOne<msg::Range, msg::Range>(kKind, endpoints, dependencies, config, kTopic,
                                         [](const msg::Range& range) { return range; });
}

// The number of satellites of a fix, which a NavSatFix lacks; 0 if it is too old. Subscribed in
// every state: it wakes no sensor.
struct Satellites {
  std::uint8_t number = 0;
  Time received{};
};

Sensor::Parts MakeGps(transport::Endpoints& endpoints, const Dependencies& dependencies,
                      const ManagerConfig& config) {
  constexpr SensorKind kKind = SensorKind::kGps;
  const auto satellites = std::make_shared<Satellites>();
  if (const std::string& topic = config.Of(kKind).satellites; !topic.empty()) {
    endpoints.Subscribe<msg::UInt8>(
        topic,
        [satellites, &clock = dependencies.clock](const msg::UInt8& number) {
          satellites->number = number.data;
          satellites->received = clock.Now();
        },
        transport::kSensorDataQos);
  }
  const auto convert = [satellites, &clock = dependencies.clock,
                        silence = config.Of(kKind).silence](const msg::NavSatFix& fix) {
    msg::GpsPayload payload = ToGpsPayload(fix);
    if (clock.Now() - satellites->received <= silence) payload.num_sv = satellites->number;
    return payload;
  };
  return MakeOne<msg::NavSatFix, msg::GpsPayload>(kKind, endpoints, dependencies, config,
                                                  "gps_payload", convert);
}

Sensor::Parts MakeParts(SensorKind kind, transport::Endpoints& endpoints,
                        const Dependencies& dependencies, const ManagerConfig& config) {
  const auto as_it_is = [](const auto& reading) { return reading; };
  if (config.Of(kind).sources.empty()) return Sensor::Parts();
  switch (kind) {
    case SensorKind::kLidar:
      return MakeOne<msg::LaserScan, msg::LaserScan>(kind, endpoints, dependencies, config, "scan",
                                                     as_it_is);
    case SensorKind::kUltrasonic:
      return MakeUltrasonic(endpoints, dependencies, config);
    case SensorKind::kGps:
      return MakeGps(endpoints, dependencies, config);
    case SensorKind::kTof:
      break;
  }
  return MakeTofs(endpoints, dependencies, config);
}

}  // namespace

std::unique_ptr<Sensor> MakeSensor(SensorKind kind, transport::Endpoints& endpoints,
                                   const Dependencies& dependencies, const ManagerConfig& config) {
  return std::make_unique<Sensor>(kind, MakeParts(kind, endpoints, dependencies, config));
}

}  // namespace musher::sensor
