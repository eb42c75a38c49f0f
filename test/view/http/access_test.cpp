#include "musher/view/http/access.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace musher::http::access_test {

using testing::HasSubstr;
using Headers = std::map<std::string, std::string>;

const Connection kConnection = {"192.168.1.5"};
const HostNames kNames = {"robot", {"Gateway.example", "https://app.foxglove.dev", "file://"}};

bool Accepts(const std::string& host) {
  return CheckHost(host, kConnection, kNames).ok();
}

TEST(Host, IsThisHost) {
  for (const std::string host :
       {"localhost", "LOCALHOST:8765", "127.0.0.1", "127.1.2.3:80", "[::1]:8765", "192.168.1.5",
        "[::ffff:192.168.1.5]:1", "robot", "robot.local:8765", "gateway.example"}) {
    EXPECT_TRUE(Accepts(host)) << host;
  }
}

TEST(Host, IsNotANameThatAnotherSitePointsHere) {
  for (const std::string host :
       {"evil.example", "localhost.evil.example", "evil.localhost", "192.168.1.6", "10.0.0.1",
        "127.0.0.1.evil.example", "2130706433", "0x7f.1", "0.0.0.0", "[::]", "robot.evil.example",
        "app.foxglove.dev", "", "a b", "localhost:x"}) {
    EXPECT_FALSE(Accepts(host)) << host;
  }
  const auto refused = CheckHost("evil.example", kConnection, kNames);
  EXPECT_THAT(refused.error().message, HasSubstr("'evil.example' is not a name of this host"));
}

bool Permits(OriginRule rule, const std::string& origin, const std::string& host) {
  return CheckOrigin({{"host", host}, {"origin", origin}}, rule, kConnection, kNames).ok();
}

TEST(Origin, OfAPostIsThePageItself) {
  const auto rule = OriginRule::kSamePage;
  EXPECT_TRUE(Permits(rule, "http://localhost:8765", "localhost:8765"));
  EXPECT_TRUE(Permits(rule, "http://Robot", "robot"));
  EXPECT_TRUE(Permits(rule, "https://gateway.example", "localhost"));
  EXPECT_TRUE(Permits(rule, "https://app.foxglove.dev", "localhost:8765"));
  for (const std::string origin :
       {"http://localhost:3000", "http://localhost", "http://127.0.0.1:8765", "null", "",
        "https://evil.example", "http://localhost:8765.evil.example", "ftp://localhost:8765",
        "http://app.foxglove.dev", "http://localhost:8765/x"}) {
    EXPECT_FALSE(Permits(rule, origin, "localhost:8765")) << origin;
  }
}

TEST(Origin, OfAWebSocketIsAPageOfThisHost) {
  const auto rule = OriginRule::kSameHost;
  for (const std::string origin : {"http://localhost:3000", "http://127.0.0.1:8765",
                                   "http://robot.local:8080", "http://192.168.1.5", "file://"}) {
    EXPECT_TRUE(Permits(rule, origin, "localhost:8765")) << origin;
  }
  for (const std::string origin : {"null", "https://evil.example", "http://192.168.1.6"}) {
    EXPECT_FALSE(Permits(rule, origin, "localhost:8765")) << origin;
  }
}

TEST(Origin, MayBeMissingInRequestsOfPrograms) {
  for (const auto rule : {OriginRule::kSamePage, OriginRule::kSameHost}) {
    const auto permits = [&](const Headers& headers) {
      return CheckOrigin(headers, rule, kConnection, kNames).ok();
    };
    EXPECT_TRUE(permits({{"host", "localhost"}}));
    EXPECT_TRUE(permits({{"host", "localhost"}, {"sec-fetch-site", "same-origin"}}));
    EXPECT_TRUE(permits({{"host", "localhost"}, {"sec-fetch-site", "none"}}));
    EXPECT_FALSE(permits({{"host", "localhost"}, {"sec-fetch-site", "cross-site"}}));
    EXPECT_FALSE(permits({{"host", "localhost"}, {"sec-fetch-site", "same-site"}}));
  }
}

TEST(Loopback, IsTheWholeNetOfIPv4) {
  EXPECT_TRUE(IsLoopback("127.0.0.1"));
  EXPECT_TRUE(IsLoopback("127.255.0.1"));
  EXPECT_TRUE(IsLoopback("::1"));
  EXPECT_TRUE(IsLoopback("::ffff:127.0.0.1"));
  EXPECT_FALSE(IsLoopback("128.0.0.1"));
  EXPECT_FALSE(IsLoopback("::2"));
  EXPECT_FALSE(IsLoopback("localhost"));
}

}  // namespace musher::http::access_test
