// Cyclone's log in a process of ours.

#include "musher/transport/dds/log_sink.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace musher::transport::log_sink_test {

using dds::LogKey;

TEST(LogOfCyclone, HasOneMessageForALostInterfaceWhateverTheAddress) {
  EXPECT_EQ(LogKey("ddsi_udp_conn_write to udp/10.77.0.2:32867 failed with retcode -1\n"),
            LogKey("ddsi_udp_conn_write to udp/239.255.0.1:7400 failed with retcode -1\n"));
  EXPECT_NE(LogKey("ddsi_udp_conn_write to udp/10.77.0.2:1 failed with retcode -1\n"),
            LogKey("ddsi_udp_conn_write to udp/10.77.0.2:1 failed with retcode -3\n"));
}

TEST(LogOfCyclone, KeepsOtherMessagesApart) {
  const std::string rejected = "participant 1:2:3 is rejected";
  EXPECT_EQ(LogKey(rejected), rejected);
  EXPECT_EQ(LogKey("x failed with retcode -1"), "x failed with retcode -1");
}

TEST(LogOfCyclone, IsWrittenOnceAMinuteForAllPacketsThatALostInterfaceDrops) {
  ::testing::internal::CaptureStderr();
  for (int port = 7400; port < 7500; ++port) {
    std::string line = "7.5 [0] tev: ddsi_udp_conn_write to udp/10.77.0.2:" + std::to_string(port) +
                       " failed with retcode -1\n";
    dds_log_data_t data{};
    data.message = line.c_str();
    data.size = line.size();
    data.hdrsize = line.find("ddsi");
    dds::LogOnceAMinute(nullptr, &data);
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(),
            "7.5 [0] tev: ddsi_udp_conn_write to udp/10.77.0.2:7400 failed with retcode -1\n");
}

}  // namespace musher::transport::log_sink_test
