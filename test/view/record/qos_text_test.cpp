#include "musher/view/record/qos_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace musher::view::qos_text_test {

using transport::kLatchedQos;
using transport::kSensorDataQos;
using transport::Qos;

TEST(QosText, WhatWasWrittenIsPublishedAgain) {
  EXPECT_EQ(QosFrom(QosText({kSensorDataQos})).reliability, Qos::Reliability::kBestEffort);
  const Qos latched = QosFrom(QosText({kLatchedQos}));
  EXPECT_EQ(latched.reliability, Qos::Reliability::kReliable);
  EXPECT_EQ(latched.durability, Qos::Durability::kTransientLocal);
  EXPECT_EQ(QosFrom(QosText({transport::kDefaultQos})), transport::kDefaultQos);
}

TEST(QosText, HasTheWordsAndFieldsOfRosbag2) {
  const std::string text = QosText({kSensorDataQos, kLatchedQos});
  EXPECT_THAT(text, ::testing::StartsWith("- history: unknown\n  depth: 0\n"
                                          "  reliability: best_effort\n  durability: volatile\n"
                                          "  deadline:\n    sec: 9223372036\n"));
  EXPECT_THAT(text, ::testing::HasSubstr("  durability: transient_local\n"));
  EXPECT_THAT(text, ::testing::HasSubstr("  avoid_ros_namespace_conventions: false\n"));
}

TEST(QosText, ReadsTheNumbersOfOlderRecordings) {
  const Qos latched = QosFrom("- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n");
  EXPECT_EQ(latched.durability, Qos::Durability::kTransientLocal);
  const Qos sensor = QosFrom("- history: 1\n  depth: 5\n  reliability: 2\n  durability: 2\n");
  EXPECT_EQ(sensor.reliability, Qos::Reliability::kBestEffort);
  EXPECT_EQ(sensor.durability, Qos::Durability::kVolatile);
}

TEST(QosText, WithoutARecordedQosTheDefaultIsPublished) {
  EXPECT_EQ(QosFrom(""), transport::kDefaultQos);
  EXPECT_EQ(QosFrom("- reliability:"), transport::kDefaultQos);
}

}  // namespace musher::view::qos_text_test
