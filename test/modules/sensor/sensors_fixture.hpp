#pragma once
// The sensors on a simulated network, in virtual time, with drivers and subscribers on a node of
// its own. The clock is the network's, and so are the stamps.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/modules/sensor/sensors.hpp"
#include "musher/test/modules/module_on_network.hpp"
#include "musher/test/modules/sensor/examples.hpp"

namespace musher::sensor {

class SensorsOnANetwork : public test::ModuleOnNetwork {
 protected:
  SensorsOnANetwork() {
    config_.Of(SensorKind::kLidar).sources = {"driver/scan"};
    config_.Of(SensorKind::kUltrasonic).sources = {"driver/ultrasonic"};
    config_.Of(SensorKind::kTof).sources = {"driver/tof0", "driver/tof1", "driver/tof2",
                                            "driver/tof3"};
    config_.Of(SensorKind::kGps).sources = {"driver/gps"};
  }

  void Start() {
    const Dependencies dependencies = {*robot_,
                                       *clock_,
                                       "dog1",
                                       [this] { return Stamp(); },
                                       [this](const std::string& line) { log_.push_back(line); },
                                       [this](std::int32_t code) { reported_.push_back(code); }};
    sensors_ = test::Must(Sensors::Make(dependencies, config_));
    Run(Milliseconds(500));  // discovery
  }

  // All drivers at 10 Hz, except those in `silent_`.
  void Drive() {
    scan_ = Publisher<msg::LaserScan>("driver/scan");
    range_ = Publisher<msg::Range>("driver/ultrasonic");
    for (int i = 0; i < 4; ++i) {
      tofs_.push_back(Publisher<msg::SingleTofPayload>("driver/tof" + std::to_string(i)));
    }
    fix_ = Publisher<msg::NavSatFix>("driver/gps");
    ticker_ = desk_->loop().Every(Milliseconds(100), [this] { Tick(); });
  }
  void Tick() {
    const auto send = [this](const char* name, auto& publisher, auto message) {
      if (silent_[name] || publisher->MatchedReaders() == 0) return;
      message.header.stamp = Stamp();
      EXPECT_TRUE(publisher->Publish(message));
      ++sent_[name];
    };
    send("lidar", scan_, scan_as_);
    send("ultrasonic", range_, RangeOf(0.5F));
    for (std::uint8_t i = 0; i < 4; ++i) {
      static constexpr const char* kNames[] = {"tof0", "tof1", "tof2", "tof3"};
      send(kNames[i], tofs_[i], TofOf(i));
    }
    send("gps", fix_, FixOf(40, 116));
  }
  template <msg::Message M>
  std::unique_ptr<transport::Publisher<M>> Publisher(const std::string& topic) {
    return ModuleOnNetwork::Publisher<M>("dog1/" + topic, transport::kSensorDataQos);
  }
  template <msg::Message M>
  std::unique_ptr<transport::Subscription> Listen(const std::string& topic,
                                                  std::vector<M>& received) {
    return ModuleOnNetwork::Listen("dog1/" + topic, received);
  }
  std::int32_t Operate(std::uint16_t id, std::uint8_t operation) {
    const auto response = Call<msg::SensorOperation>("dog1/sensor_operation", {id, operation});
    EXPECT_EQ(response.success, response.code == 0);
    return response.code;
  }
  std::vector<std::int32_t> Failures() const {
    std::vector<std::int32_t> codes;
    for (const SensorResult& finding : sensors_->Check()) {
      if (!finding.result) codes.push_back(finding.result.error().code);
    }
    return codes;
  }
  // How many readings each driver made in that time.
  std::map<std::string, int> SentIn(Duration duration) {
    Run(Milliseconds(500));
    sent_.clear();
    Run(duration);
    return sent_;
  }

  ManagerConfig config_;
  std::vector<std::string> log_;
  std::vector<std::int32_t> reported_;
  std::map<std::string, bool> silent_;
  std::map<std::string, int> sent_;
  msg::LaserScan scan_as_ = ScanOf(3);
  std::unique_ptr<Sensors> sensors_;
  std::unique_ptr<transport::Publisher<msg::LaserScan>> scan_;
  std::unique_ptr<transport::Publisher<msg::Range>> range_;
  std::vector<std::unique_ptr<transport::Publisher<msg::SingleTofPayload>>> tofs_;
  std::unique_ptr<transport::Publisher<msg::NavSatFix>> fix_;
  transport::LoopHandlePtr ticker_;
};

}  // namespace musher::sensor
