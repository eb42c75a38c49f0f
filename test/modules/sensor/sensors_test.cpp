// The sensors of the module with their drivers, on a simulated network.

#include "musher/modules/sensor/sensors.hpp"

#include <limits>

#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/test/modules/sensor/sensors_fixture.hpp"

namespace musher::sensor::sensors_test {

using std::chrono::seconds;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Key;
using ::testing::Not;
using ::testing::Pair;
using ::testing::SizeIs;
using Operation = msg::SensorOperation;

class SensorsTest : public SensorsOnANetwork {
 protected:
  void Listen() {
    subscriptions_.push_back(SensorsOnANetwork::Listen("scan", scans_));
    subscriptions_.push_back(SensorsOnANetwork::Listen("ultrasonic_payload", ranges_));
    subscriptions_.push_back(SensorsOnANetwork::Listen("head_tof_payload", heads_));
    subscriptions_.push_back(SensorsOnANetwork::Listen("rear_tof_payload", rears_));
    subscriptions_.push_back(SensorsOnANetwork::Listen("gps_payload", gps_));
  }
  void StartAll() {
    Listen();
    Drive();
    Start();
    Forget();
  }
  void Forget() {
    scans_.clear();
    ranges_.clear();
    heads_.clear();
    rears_.clear();
    gps_.clear();
  }

  std::vector<msg::LaserScan> scans_;
  std::vector<msg::Range> ranges_;
  std::vector<msg::HeadTofPayload> heads_;
  std::vector<msg::RearTofPayload> rears_;
  std::vector<msg::GpsPayload> gps_;
  std::vector<std::unique_ptr<transport::Subscription>> subscriptions_;
};

TEST_F(SensorsTest, PublishWhatTheirDriversMeasure) {
  StartAll();
  Run(seconds(2));
  EXPECT_THAT(scans_, SizeIs(20));
  EXPECT_THAT(ranges_, SizeIs(20));
  EXPECT_THAT(heads_, SizeIs(20));
  EXPECT_THAT(rears_, SizeIs(20));
  EXPECT_THAT(gps_, SizeIs(20));
  EXPECT_EQ(scans_.back().ranges, ScanOf(3).ranges);
  EXPECT_EQ(scans_.back().header.frame_id, "laser_frame");
  EXPECT_EQ(heads_.back().right_head.tof_position, 1);
  EXPECT_EQ(rears_.back().left_rear.tof_position, 2);
  EXPECT_EQ(gps_.back().lat, 40);
  EXPECT_THAT(log_, IsEmpty());
  EXPECT_THAT(Failures(), IsEmpty());
}

TEST_F(SensorsTest, PublishNoMoreOftenThanConfigured) {
  config_.Of(SensorKind::kLidar).period = Milliseconds(250);
  config_.Of(SensorKind::kTof).period = Milliseconds(500);
  StartAll();
  Run(seconds(10));
  EXPECT_NEAR(static_cast<double>(scans_.size()), 40, 2);
  EXPECT_NEAR(static_cast<double>(heads_.size()), 20, 1);
  EXPECT_THAT(ranges_, SizeIs(100));
}

TEST_F(SensorsTest, SleepInLowPowerExceptForTheGps) {
  StartAll();
  ASSERT_TRUE(sensors_->Enter("LowPower"));
  EXPECT_THAT(SentIn(seconds(2)), ElementsAre(Pair("gps", 20)));
  Forget();
  ASSERT_TRUE(sensors_->Enter("Active"));
  const auto awake = SentIn(seconds(2));
  EXPECT_THAT(awake, SizeIs(7));
  EXPECT_THAT(awake, Contains(Pair("tof3", 20)));
  EXPECT_THAT(scans_, Not(IsEmpty()));
  EXPECT_THAT(log_, IsEmpty()) << "a sleeping sensor is not silent";
}

TEST_F(SensorsTest, SleepInOtaAndAreUnsubscribedAfterTearDown) {
  StartAll();
  ASSERT_TRUE(sensors_->Enter("OTA"));
  EXPECT_THAT(SentIn(seconds(1)), ElementsAre(Key("gps")));
  ASSERT_TRUE(sensors_->Enter("TearDown"));
  EXPECT_THAT(SentIn(seconds(1)), IsEmpty());
}

TEST_F(SensorsTest, AreAwakeInEveryOtherState) {
  StartAll();
  for (const char* state : {"Protected", "DeActive", "Error", "SelfCheck", "Dancing"}) {
    ASSERT_TRUE(sensors_->Enter("LowPower"));
    ASSERT_TRUE(sensors_->Enter(state));
    EXPECT_THAT(SentIn(seconds(1)), SizeIs(7)) << state;
  }
}

TEST_F(SensorsTest, ThatAnOperatorStoppedStayStoppedInEveryState) {
  StartAll();
  EXPECT_EQ(Operate(Operation::kLidar, Operation::kStop), 0);
  EXPECT_THAT(SentIn(seconds(1)), Not(Contains(Key("lidar"))));
  for (const char* state : {"LowPower", "Active"}) ASSERT_TRUE(sensors_->Enter(state));
  EXPECT_THAT(SentIn(seconds(1)), AllOf(SizeIs(6), Not(Contains(Key("lidar")))));
  EXPECT_THAT(Failures(), IsEmpty()) << "and have nothing to fail";
  EXPECT_EQ(Operate(Operation::kLidar, Operation::kStart), 0);
  EXPECT_THAT(SentIn(seconds(1)), Contains(Pair("lidar", 10)));
}

TEST_F(SensorsTest, ThatAnOperatorStartsInLowPowerSleepUntilItIsOver) {
  StartAll();
  EXPECT_EQ(Operate(Operation::kTof, Operation::kStop), 0);
  ASSERT_TRUE(sensors_->Enter("LowPower"));
  EXPECT_EQ(Operate(Operation::kTof, Operation::kStart), 0);
  EXPECT_THAT(SentIn(seconds(1)), ElementsAre(Key("gps")));
  ASSERT_TRUE(sensors_->Enter("Active"));
  EXPECT_THAT(SentIn(seconds(1)), Contains(Pair("tof0", 10)));
}

TEST_F(SensorsTest, AreOperatedAllOrNone) {
  StartAll();
  EXPECT_EQ(Operate(Operation::kAll, Operation::kClose), 2103) << "they are started";
  EXPECT_EQ(Operate(Operation::kAll, Operation::kStop), 0);
  EXPECT_THAT(SentIn(seconds(1)), IsEmpty());
  EXPECT_EQ(Operate(Operation::kUltrasonic, Operation::kClose), 0);
  EXPECT_EQ(Operate(Operation::kAll, Operation::kStart), 2303);
  EXPECT_THAT(SentIn(seconds(1)), IsEmpty()) << "refused for one, begun for none";
  EXPECT_EQ(Operate(Operation::kAll, Operation::kOpen), 0);
  EXPECT_EQ(Operate(Operation::kAll, Operation::kStart), 0);
  EXPECT_THAT(SentIn(seconds(1)), SizeIs(7));
}

TEST_F(SensorsTest, RefuseInvalidOperationsWithACodeAndALogLine) {
  config_.Of(SensorKind::kGps).sources.clear();
  StartAll();
  EXPECT_EQ(Operate(Operation::kGps, Operation::kStart), 2408);
  EXPECT_EQ(Operate(5, Operation::kStart), 2010);
  EXPECT_EQ(Operate(Operation::kLidar, 9), 2010);
  EXPECT_EQ(Operate(Operation::kAll, Operation::kStop), 0) << "of the sensors that the robot has";
  EXPECT_THAT(log_, ElementsAre(HasSubstr("there is no gps in the config"),
                                HasSubstr("unknown sensor 5"), HasSubstr("unknown operation 9")));
}

TEST_F(SensorsTest, ThatFallSilentAreLoggedOnceAndOnceWhenTheyAreBack) {
  StartAll();
  silent_["lidar"] = true;
  Run(seconds(10));
  EXPECT_THAT(log_, ElementsAre("lidar: silent for 1000 ms (2107 Lidar: Timeout)"));
  EXPECT_THAT(reported_, ElementsAre(2107));
  EXPECT_THAT(Failures(), ElementsAre(2109));
  silent_["lidar"] = false;
  Run(seconds(2));
  EXPECT_THAT(log_, ElementsAre(HasSubstr("silent"), "lidar: ok again"));
  EXPECT_THAT(Failures(), IsEmpty());
}

// A world that runs fast, and a module that is late: the clock is read before the readings.
TEST_F(SensorsTest, AreNotSilentBecauseTheModuleWasKeptFromRunning) {
  StartAll();
  network_.Pause(*robot_);
  Run(seconds(5));
  network_.Resume(*robot_);
  Run(seconds(2));
  EXPECT_THAT(log_, IsEmpty());
  EXPECT_THAT(Failures(), IsEmpty());
}

TEST_F(SensorsTest, WithOneSilentTofOfTwoPublishTheOtherAlone) {
  StartAll();
  silent_["tof1"] = true;
  Run(seconds(3));
  EXPECT_THAT(log_, ElementsAre("tof right_head: silent for 1000 ms (2207 ToF: Timeout)"));
  ASSERT_GT(heads_.size(), 25U);
  EXPECT_TRUE(heads_.back().left_head.data_available);
  EXPECT_FALSE(heads_.back().right_head.data_available);
  EXPECT_TRUE(rears_.back().right_rear.data_available);
  ASSERT_THAT(Failures(), ElementsAre(2209));
}

TEST_F(SensorsTest, WhoseDriverIsLostAreLoggedAtOnce) {
  StartAll();
  scan_ = nullptr;
  ticker_.reset();
  Run(Milliseconds(700));
  EXPECT_THAT(log_, Contains("lidar: no publisher of driver/scan (2107 Lidar: Timeout)"));
}

TEST_F(SensorsTest, RefuseImpossibleReadingsAndCountThem) {
  StartAll();
  const msg::LaserScan good = scan_as_;
  scan_as_.ranges[4] = std::numeric_limits<float>::quiet_NaN();
  Run(Milliseconds(200));
  Forget();
  Run(seconds(3));
  EXPECT_THAT(scans_, IsEmpty());
  EXPECT_THAT(log_, ElementsAre("lidar: its readings are refused: distance 4 is nan (2112 Lidar: "
                                "DeviceError)"));
  EXPECT_THAT(Failures(), ElementsAre(2109));
  scan_as_ = good;
  Run(seconds(3));
  EXPECT_THAT(log_, ElementsAre(HasSubstr("refused"),
                                ContainsRegex("lidar: ok again, 3[1-3] readings were refused")));
  EXPECT_THAT(Failures(), IsEmpty());
}

TEST_F(SensorsTest, WithAnOccasionalBadReadingLogItOnce) {
  StartAll();
  const msg::LaserScan good = scan_as_;
  for (int i = 0; i < 20; ++i) {
    scan_as_.ranges.clear();
    Run(Milliseconds(100));
    scan_as_ = good;
    Run(Milliseconds(400));
  }
  EXPECT_THAT(log_, SizeIs(1));
  EXPECT_NEAR(static_cast<double>(scans_.size()), 80, 2);
}

TEST_F(SensorsTest, PublishTheNumberOfSatellitesWhileItIsReceived) {
  config_.Of(SensorKind::kGps).satellites = "driver/satellites";
  const auto satellites = Publisher<msg::UInt8>("driver/satellites");
  StartAll();
  Run(seconds(1));
  ASSERT_FALSE(gps_.empty());
  EXPECT_EQ(gps_.back().num_sv, 0) << "not known yet";
  ASSERT_TRUE(satellites->Publish({11}));
  Run(seconds(1));
  EXPECT_EQ(gps_.back().num_sv, 11);
  Run(seconds(4));
  EXPECT_EQ(gps_.back().num_sv, 0) << "not received any more";
}

TEST_F(SensorsTest, RefuseReadingsFromAnotherTime) {
  StartAll();
  silent_["ultrasonic"] = true;
  Run(Milliseconds(200));
  Forget();
  const auto publish = [this](int off_s) {
    msg::Range range = RangeOf(0.5F);
    range.header.stamp = msg::ToStamp(msg::FromStamp(Stamp()) + seconds(off_s));
    ASSERT_TRUE(range_->Publish(range));
    Run(Milliseconds(100));
  };
  publish(-3);
  publish(3);
  EXPECT_THAT(log_, IsEmpty()) << "late ones may be caused by this subscriber";
  for (int i = 0; i < 15; ++i) publish(3);
  EXPECT_THAT(ranges_, IsEmpty());
  EXPECT_THAT(log_,
              ElementsAre("ultrasonic: silent for 1000 ms, its readings are refused: its stamp "
                          "is 3 s ahead (2307 Ultrasonic: Timeout)"));
  publish(0);
  EXPECT_THAT(ranges_, SizeIs(1));
  EXPECT_THAT(log_, Contains("ultrasonic: ok again, 17 readings were refused"));
}

TEST_F(SensorsTest, AreCheckedInTheirOrderExceptThoseThatAreSkipped) {
  config_.skip = {SensorKind::kUltrasonic};
  Start();
  EXPECT_THAT(Failures(), ElementsAre(2109, 2209, 2409)) << "they have no driver";
}

TEST_F(SensorsTest, ThatAreCriticalReportWhetherTheyHaveStarted) {
  config_.critical = {SensorKind::kTof};
  StartAll();
  EXPECT_TRUE(sensors_->CheckStarted());
  ASSERT_TRUE(sensors_->Enter("LowPower"));
  silent_["tof2"] = true;
  Run(seconds(1));
  ASSERT_TRUE(sensors_->Enter("Active"));
  Run(seconds(1));
  const Result<> started = sensors_->CheckStarted();
  EXPECT_EQ(started.error().code, 2201);
  EXPECT_THAT(started.error().message, HasSubstr("tof does not start: left_rear: "));
  silent_["tof2"] = false;
  Run(seconds(1));
  EXPECT_TRUE(sensors_->CheckStarted());
}

}  // namespace musher::sensor::sensors_test
