#include "musher/view/topics/reader_qos.hpp"

#include <gtest/gtest.h>

namespace musher::view::reader_qos_test {

using transport::kDefaultQos;
using transport::kLatchedQos;
using transport::kSensorDataQos;
using transport::Qos;

TEST(ReaderQos, OneReaderMatchesWritersOfDifferentQos) {
  const Qos both = QosMatchingAll({kSensorDataQos, kLatchedQos});
  EXPECT_EQ(both.reliability, Qos::Reliability::kBestEffort);
  EXPECT_EQ(both.durability, Qos::Durability::kVolatile);
  EXPECT_EQ(both.partition, "");
  const Qos latched = QosMatchingAll({kLatchedQos, kLatchedQos});
  EXPECT_EQ(latched.durability, Qos::Durability::kTransientLocal);
  Qos in_partition = kLatchedQos;
  in_partition.partition = "audio";
  EXPECT_EQ(QosMatchingAll({in_partition}).partition, transport::kEveryPartition);
}

TEST(ReaderQos, OfAReaderThatExistsBecomesLessDemandingOnly) {
  const Qos loose = QosMatchingAll({kSensorDataQos});
  EXPECT_EQ(QosMatchingAll({kLatchedQos}, loose), loose)
      << "the writers that it matched may come back";
  const Qos latched = QosMatchingAll({kLatchedQos});
  EXPECT_EQ(QosMatchingAll({kLatchedQos, kDefaultQos}, latched).durability,
            Qos::Durability::kVolatile);
}

}  // namespace musher::view::reader_qos_test
