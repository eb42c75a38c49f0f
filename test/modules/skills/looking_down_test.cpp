// A flyer with a range sensor that looks down, behind its topics: what its skills, its hold and its
// landing with a low battery do above a person.

#include <gmock/gmock.h>

#include "musher/messages/sensor_msgs/range.hpp"
#include "musher/test/modules/skills/robot_on_network.hpp"

namespace musher::skills {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

class AFlyerThatLooksDown : public ARosRobot {
 protected:
  AFlyerThatLooksDown() : ARosRobot(Config()) {
    sees_m_ = 8;
    range_ = peers_->endpoints.Advertise<msg::Range>("r/range_down", transport::kSensorDataQos);
    Run(300);
  }
  static SkillsConfig Config() {
    SkillsConfig config = ConfigOfR();
    config.flies = true;
    config.gate.blind_m_s = navigation::kFlyerBlindMS;
    config.gate.down.topic = "r/range_down";
    config.low_battery_percent = 10;
    return config;
  }
  // So long, by its commands; returns its height.
  double Fly(double seconds) {
    constexpr double kStepS = 0.02, kLagS = 0.1;
    for (int i = 0; i < seconds / kStepS; ++i) {
      const double wanted = peers_->commands.empty() ? 0 : peers_->commands.back().linear.z;
      climb_m_s_ += kStepS / kLagS * (wanted - climb_m_s_);
      if (moves_aside_ && !peers_->commands.empty()) {
        at_.x_m += peers_->commands.back().linear.x * kStepS;
        at_.y_m += peers_->commands.back().linear.y * kStepS;
      }
      const double surface_m = std::hypot(at_.x_m, at_.y_m) < 0.5 ? surface_m_ : 0;
      z_m_ = std::max(surface_m, z_m_ + climb_m_s_ * kStepS);
      msg::Odometry odometry;
      odometry.pose.pose =
          ToMessage(navigation::Pose{{at_.x_m, at_.y_m, z_m_ + drift_m_}, 0}, {}).pose;
      odometry.twist.twist.linear.z = climb_m_s_;
      EXPECT_TRUE(peers_->odometry->Publish(odometry));
      if (measures_ && ++steps_ % 3 == 0) {
        msg::Range range;
        range.header.stamp = msg::ToStamp(Now().time_since_epoch());
        range.min_range = 0.05F;
        range.max_range = 4;
        range.field_of_view = 1;
        range.range = static_cast<float>(z_m_ - surface_m + 0.001 * (steps_ % 2));
        EXPECT_TRUE(range_->Publish(range));
      }
      Run(20);
    }
    return z_m_;
  }
  void ReportBattery(float share) {
    for (int i = 0; i < 10; ++i) {
      msg::BatteryState battery;
      battery.percentage = share;
      battery.present = true;
      EXPECT_TRUE(peers_->battery->Publish(battery));
      Fly(0.5);
    }
  }
  void Hover(double height_m) {
    z_m_ = height_m;
    Fly(0.5);
    robot_.SetVelocity({0.01, 0, 0, 0});
    Fly(0.5);
    robot_.StopMotion();
    Fly(1);
  }

  transport::Publisher<msg::Range>* range_ = nullptr;
  double z_m_ = 2.5, climb_m_s_ = 0;
  double surface_m_ = 0;  // the head of a person, or the ground
  navigation::Point at_;
  bool moves_aside_ = false;
  double drift_m_ = 0;  // of its odometry
  bool measures_ = true;
  int steps_ = 0;
};

TEST_F(AFlyerThatLooksDown, DescendsNoNearerToAPersonAndGoesOnOnceThatHasGone) {
  Fly(0.5);
  surface_m_ = 1.6;
  robot_.SetVelocity({0, 0, -0.5, 0});
  EXPECT_GT(Fly(5), 1.6 + 0.3);
  EXPECT_LT(z_m_, 1.6 + 0.95);
  EXPECT_THAT(robot_.WhyNotDescending(), HasSubstr("something 1.6 m high or higher is below it"));
  EXPECT_EQ(robot_.HeldBy(), robot_.WhyNotDescending());
  surface_m_ = 0;
  EXPECT_LT(Fly(5), 1.9);
  EXPECT_EQ(robot_.WhyNotDescending(), "") << "it descends slowly, and that is no reason to fail";
}

TEST_F(AFlyerThatLooksDown, LandsOnATableOnlyWhereItsHeightIsGiven) {
  z_m_ = 2;
  surface_m_ = 0.8;
  robot_.SetVelocity({0, 0, -0.5, 0});
  EXPECT_GT(Fly(5), 1.1);
  robot_.ExpectGround(0.8);
  EXPECT_LT(Fly(12), 0.85);
  robot_.StopMotion();
  robot_.SetVelocity({0, 0, 0.5, 0});
  EXPECT_GT(Fly(3), 2);
  robot_.SetVelocity({0, 0, -0.5, 0});
  EXPECT_GT(Fly(5), 1.1) << "that was for one landing";
}

TEST_F(AFlyerThatLooksDown, LandsWithALowBatteryOnceThePersonBelowHasGone) {
  Hover(2.5);
  surface_m_ = 1.6;
  ReportBattery(0.05F);
  EXPECT_GT(Fly(20), 1.6 + 0.3);
  EXPECT_THAT(lines_, Contains(HasSubstr("r lands with a low battery: something 1.6 m high")));
  surface_m_ = 0;
  EXPECT_LT(Fly(40), 0.02);
}

// It flew aside to where no scan sees.
TEST_F(AFlyerThatLooksDown, StaysAboveAPersonWithALowBatteryWithoutAScanAndSaysSo) {
  sees_m_.reset();
  Hover(2.5);
  moves_aside_ = true;
  surface_m_ = 1.6;
  ReportBattery(0.05F);
  EXPECT_GT(Fly(60), 1.6 + 0.3);
  EXPECT_LT(std::hypot(at_.x_m, at_.y_m), 0.2);
  EXPECT_THAT(lines_, Contains(HasSubstr("; without a scan it does not go aside")));
  surface_m_ = 0;
  EXPECT_LT(Fly(40), 0.02);
}

TEST_F(AFlyerThatLooksDown, LandsAsideWithALowBatteryWhereAPersonStaysBelow) {
  Hover(2.5);
  moves_aside_ = true;
  surface_m_ = 1.6;
  ReportBattery(0.05F);
  EXPECT_LT(Fly(60), 0.02);
  EXPECT_NEAR(std::hypot(at_.x_m, at_.y_m), 0.7, 0.25);
}

TEST_F(AFlyerThatLooksDown, LandsWithALowBatteryAlsoWithoutItsSensorAndSlowly) {
  Hover(1);
  measures_ = false;
  Fly(1);
  robot_.SetVelocity({0, 0, -0.5, 0});
  EXPECT_GT(Fly(5), 0.95) << "a skill does not descend blindly";
  EXPECT_EQ(robot_.WhyNotDescending(),
            "no recent range on r/range_down: it does not descend blindly");
  robot_.StopMotion();
  ReportBattery(0.05F);
  const double from_m = z_m_;
  EXPECT_NEAR(from_m - Fly(3), 0.3, 0.1);
  EXPECT_LT(Fly(20), 0.02);
}

// It holds its place by an odometry that says that it climbs.
TEST_F(AFlyerThatLooksDown, IsNotHeldDownOntoAPersonByAHeightThatDrifts) {
  Hover(2.2);
  surface_m_ = 1.6;
  for (int i = 0; i < 60; ++i) {
    drift_m_ += 0.02;
    EXPECT_GT(Fly(0.5), 1.6 + 0.25);
  }
}

TEST_F(AFlyerThatLooksDown, MissesThePublisherOfItsSensor) {
  EXPECT_THAT(robot_.Look().others, Not(Contains("no publisher of r/range_down")));
  range_ = nullptr;
  sees_m_.reset();
  peers_.reset();
  Run(3000);
  EXPECT_THAT(robot_.Look().others, Contains("no publisher of r/range_down"));
}

}  // namespace
}  // namespace musher::skills
