// LCM's datagrams and urls.

#include "musher/transport/lcm_packet.hpp"

#include <gmock/gmock.h>

#include <array>
#include <string_view>
#include <vector>

namespace musher::transport::lcm_packet_test {

using ::testing::HasSubstr;

constexpr std::array kData = {std::byte{1}, std::byte{0}, std::byte{3}};

TEST(LcmPacket, IsWrittenAsLcmDoesAndReadBack) {
  const auto bytes = WriteLcmPacket({0x01020304, "AB", kData}).value();
  const std::array expected = {'L',    'C', '0', '2',  '\x01', '\x02', '\x03',
                               '\x04', 'A', 'B', '\0', '\x01', '\0',   '\x03'};
  ASSERT_EQ(bytes.size(), expected.size());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    EXPECT_EQ(std::to_integer<char>(bytes[i]), expected.at(i)) << i;
  }
  const auto packet = ReadLcmPacket(bytes);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->sequence, 0x01020304U);
  EXPECT_EQ(packet->channel, "AB");
  EXPECT_TRUE(std::ranges::equal(packet->data, kData));
}

TEST(LcmPacket, OfAWrongShapeIsNone) {
  auto bytes = WriteLcmPacket({1, "AB", {}}).value();
  ASSERT_TRUE(ReadLcmPacket(bytes)) << "a message may be empty";
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(ReadLcmPacket(std::span(bytes).first(size))) << size;
  }
  bytes[3] = std::byte{'3'};
  EXPECT_FALSE(ReadLcmPacket(bytes)) << "a part of a message";
  const std::vector<std::byte> unending(100, std::byte{'L'});
  EXPECT_FALSE(ReadLcmPacket(unending));
}

std::vector<std::byte> BytesOf(std::string_view text) {
  std::vector<std::byte> bytes;
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

// As LCM's own library divides a message of more than 64 KiB.
TEST(LcmFragment, HasTheChannelOfItsMessageIfItIsTheFirst) {
  using std::string_view_literals::operator""sv;
  const auto first = BytesOf("LC03\1\2\3\4\0\x10\0\0\0\0\0\0\0\0\0\x11gait\0data"sv);
  ASSERT_TRUE(ReadLcmFragment(first));
  EXPECT_EQ(ReadLcmFragment(first)->channel, "gait");
  EXPECT_EQ(ReadLcmFragment(first)->message_size, 1U << 20);
  EXPECT_FALSE(ReadLcmPacket(first));
  for (std::size_t size = 0; size <= 24; ++size) {
    EXPECT_FALSE(ReadLcmFragment(std::span(first).first(size))) << size;
  }
  const auto later = BytesOf("LC03\1\2\3\4\0\x10\0\0\0\0\xFF\0\0\1\0\x11gait\0data"sv);
  ASSERT_TRUE(ReadLcmFragment(later));
  EXPECT_EQ(ReadLcmFragment(later)->channel, "") << "it has none";
  EXPECT_FALSE(ReadLcmFragment(WriteLcmPacket({1, "AB", kData}).value()));
}

TEST(LcmPacket, RefusesALongChannelAndALongMessage) {
  EXPECT_FALSE(WriteLcmPacket({0, "", {}}));
  EXPECT_TRUE(WriteLcmPacket({0, std::string(63, 'c'), {}}));
  EXPECT_FALSE(WriteLcmPacket({0, std::string(64, 'c'), {}}));
  const std::vector<std::byte> megabyte(1 << 20);
  EXPECT_THAT(WriteLcmPacket({0, "c", megabyte}).error().message, HasSubstr("1048576 bytes"));
}

TEST(LcmUrl, IsReadWithItsTtl) {
  const LcmUrl url = ReadLcmUrl("udpm://239.255.76.67:7671?ttl=0").value();
  EXPECT_EQ(url, (LcmUrl{"239.255.76.67", 7671, 0}));
  EXPECT_EQ(ToText(url), "udpm://239.255.76.67:7671");
  EXPECT_EQ(ReadLcmUrl("udpm://239.255.76.67:7671").value().ttl, std::nullopt);
}

TEST(LcmUrl, ThatIsWrongIsRefusedWithAnExample) {
  for (const char* wrong :
       {"", "239.255.76.67:7671", "tcpq://239.255.76.67:7671", "udpm://239.255.76.67",
        "udpm://192.168.44.1:7671", "udpm://239.255.76.67:0", "udpm://239.255.76.67:70000",
        "udpm://239.255.76.67:7671?ttl=256",
        "udpm://239.255.76.67:7671?ttl=", "udpm://239.255.76.67:7671?recv_buf_size=1",
        "udpm://239.255.76:7671", "udpm://239.255.76.67:7671x"}) {
    const auto read = ReadLcmUrl(wrong);
    ASSERT_FALSE(read) << wrong;
    EXPECT_THAT(read.error().message, HasSubstr("udpm://239.255.76.67:7671"));
  }
}

}  // namespace musher::transport::lcm_packet_test
