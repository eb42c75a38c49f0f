// The sensor manager under injected faults: drivers that may sleep are never left awake. A driver
// measures as long as its topic has a subscriber.

#include "musher/messages/stamp.hpp"
#include "musher/modules/sensor/sensor_manager.hpp"
#include "musher/test/modules/module_fault_test.hpp"
#include "musher/test/modules/sensor/examples.hpp"

namespace musher::sensor::sensor_fault_test {

// Drivers of a lidar and of a GPS, at 20 Hz.
class Drivers {
 public:
  explicit Drivers(transport::Node& desk)
      : scan(transport::MakePublisher<msg::LaserScan>(desk, "driver/scan").value()),
        fix(transport::MakePublisher<msg::NavSatFix>(desk, "driver/gps").value()),
        ticker_(desk.loop().Every(Milliseconds(50), [this, &desk] {
          const msg::Stamp now = msg::ToStamp(desk.loop().Now().time_since_epoch());
          msg::LaserScan rays = ScanOf(3);
          msg::NavSatFix place = FixOf(40, 116);
          rays.header.stamp = place.header.stamp = now;
          static_cast<void>(scan->Publish(rays));
          static_cast<void>(fix->Publish(place));
        })) {}

  const std::unique_ptr<transport::Publisher<msg::LaserScan>> scan;
  const std::unique_ptr<transport::Publisher<msg::NavSatFix>> fix;

 private:
  transport::LoopHandlePtr ticker_;
};

TEST(TheSensorManager, LetsTheLidarSleepInLowPowerAndOtaUnderInjectedFaults) {
  testing::ModuleFaultTest<SensorManager, Drivers> test;
  test.make = [] {
    ManagerConfig config;
    config.stamp_tolerance = {};
    config.Of(SensorKind::kLidar).sources = {"driver/scan"};
    config.Of(SensorKind::kGps).sources = {"driver/gps"};
    config.critical = {SensorKind::kLidar};
    return std::make_unique<SensorManager>("sensor_manager", config);
  };
  int awake = 0;
  int asleep = 0;
  test.always = [&](const SensorManager&, const ActuatorReport& report) {
    test.Pass(Milliseconds(300));  // discovery
    const bool sleeps = report.state == kLowPower || report.state == kOta;
    const bool ends = report.state == kTearDown;
    ++(sleeps ? asleep : awake);
    EXPECT_EQ(test.peers->scan->MatchedReaders(), sleeps || ends ? 0 : 1) << report.state;
    EXPECT_EQ(test.peers->fix->MatchedReaders(), ends ? 0 : 1) << report.state;
  };
  test.Run();
  EXPECT_GT(awake, 100) << "or nothing has been tried";
  EXPECT_GT(asleep, 100) << "or nothing has been tried";
}

}  // namespace musher::sensor::sensor_fault_test
