// Nodes of older and newer ROS 2 distributions beside the sensors: sensor_msgs/Range has the field
// `variance` since Iron.

#include "musher/messages/before_iron.hpp"
#include "musher/test/modules/sensor/sensors_fixture.hpp"

namespace musher::sensor::ros_distro_test {

using ::testing::Each;
using ::testing::Field;
using ::testing::IsEmpty;
using ::testing::Not;

// A node of Iron or later: it refuses a Range without `variance`.
struct RangeOfIron {
  static constexpr std::string_view kTypeName = msg::Range::kTypeName;
  msg::RangeBeforeIron older;
  float variance = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.older, m.variance);
  }
};

struct Row {
  const char* name;
  RosDistro distro;
  bool has_variance;
};

class Distributions : public SensorsOnANetwork, public ::testing::WithParamInterface<Row> {};

TEST_P(Distributions, ReadTheUltrasonicPayloadInTheirOwnLayout) {
  const std::string text = std::string("ros_distro = \"") + GetParam().name + "\"\n";
  const Parsed<ManagerConfig> reading = ReadManagerText(text, "sensors.toml");
  ASSERT_TRUE(reading.config);
  config_.ros_distro = reading.config->ros_distro;
  EXPECT_EQ(config_.ros_distro, GetParam().distro);
  std::vector<RangeOfIron> iron;
  std::vector<msg::RangeBeforeIron> older;
  const auto iron_subscription = Listen("ultrasonic_payload", iron);
  const auto older_subscription = Listen("ultrasonic_payload", older);
  Drive();
  Start();
  Run(std::chrono::seconds(1));
  EXPECT_THAT(older, Not(IsEmpty()));
  EXPECT_THAT(older, Each(Field(&msg::RangeBeforeIron::range, 0.5F)));
  EXPECT_EQ(!iron.empty(), GetParam().has_variance);
}

INSTANTIATE_TEST_SUITE_P(Ros2, Distributions,
                         ::testing::Values(Row{"galactic", RosDistro::kGalactic, false},
                                           Row{"humble", RosDistro::kHumble, false},
                                           Row{"iron", RosDistro::kIron, true},
                                           Row{"jazzy", RosDistro::kJazzy, true},
                                           Row{"kilted", RosDistro::kKilted, true}),
                         [](const auto& row) { return row.param.name; });

TEST_F(SensorsOnANetwork, UnderstandARangeOfAGalacticDriver) {
  std::vector<msg::Range> received;
  const auto subscription = Listen("ultrasonic_payload", received);
  Drive();
  silent_["ultrasonic"] = true;
  const auto galactic = Publisher<msg::RangeBeforeIron>("driver/ultrasonic");
  Start();
  msg::RangeBeforeIron reading = msg::BeforeIron(RangeOf(0.25F));
  reading.header.stamp = Stamp();
  ASSERT_TRUE(galactic->Publish(reading));
  Run(Milliseconds(100));
  ASSERT_EQ(received.size(), 1U);
  EXPECT_EQ(received[0].range, 0.25F);
  EXPECT_EQ(received[0].variance, 0) << "not known";
}

}  // namespace musher::sensor::ros_distro_test
