#include "musher/view/http/head.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace musher::http::head_test {

using Fields = std::vector<std::pair<std::string, std::string>>;
using testing::HasSubstr;

std::variant<CheckedHead, HttpError> Check(const std::string& method, const std::string& target,
                                           const Fields& more) {
  Head head{method, target, {{"Host", "localhost"}}};
  head.fields.insert(head.fields.end(), more.begin(), more.end());
  return CheckHead(head, {"127.0.0.1"}, {"robot", {}}, {"second.v1", "first.v1"});
}

unsigned StatusOf(const std::variant<CheckedHead, HttpError>& checked) {
  const auto* refusal = std::get_if<HttpError>(&checked);
  return refusal == nullptr ? 200 : refusal->status;
}

const Fields kUpgrade = {{"Connection", "keep-alive, Upgrade"},
                         {"Upgrade", "WebSocket"},
                         {"Sec-WebSocket-Version", "13"},
                         {"Sec-WebSocket-Key", "AAAAAAAAAAAAAAAAAAAAAA=="}};

Fields With(Fields fields, const std::string& name, const std::string& value) {
  for (auto& field : fields) {
    if (field.first == name) return field.second = value, fields;
  }
  fields.emplace_back(name, value);
  return fields;
}

TEST(Head, BecomesARequest) {
  const auto checked = std::get<CheckedHead>(
      Check("GET", "/a?b=c", {{"Cookie", "x=1"}, {"COOKIE", "y=2"}, {"Accept", "*/*"}}));
  EXPECT_EQ(checked.request.method, "GET");
  EXPECT_EQ(checked.request.path, "/a");
  EXPECT_EQ(checked.request.query.at("b"), "c");
  EXPECT_EQ(checked.request.cookies.at("x"), "1");
  EXPECT_EQ(checked.request.cookies.at("y"), "2");
  EXPECT_EQ(checked.request.headers.at("accept"), "*/*");
  EXPECT_TRUE(checked.request.local);
  EXPECT_FALSE(checked.websocket);
}

TEST(Head, OfAHeadRequestIsOneOfGetWithoutABody) {
  const auto checked = std::get<CheckedHead>(Check("HEAD", "/", {}));
  EXPECT_EQ(checked.request.method, "GET");
  EXPECT_TRUE(checked.without_body);
}

TEST(Head, ThroughAProxyIsNotLocal) {
  for (const std::string name : {"X-Forwarded-For", "X-Forwarded-Proto", "X-Forwarded-Host",
                                 "Forwarded", "Via", "X-Real-IP"}) {
    EXPECT_FALSE(std::get<CheckedHead>(Check("GET", "/", {{name, "x"}})).request.local) << name;
  }
}

TEST(Head, NamesTheNearestClientOfItsProxies) {
  const auto forwarded = [](std::vector<std::pair<std::string, std::string>> fields) {
    return ForwardedAddress(std::get<CheckedHead>(Check("GET", "/", std::move(fields))).request);
  };
  EXPECT_EQ(forwarded({}), "");
  EXPECT_EQ(forwarded({{"X-Real-IP", "10.1.2.3"}}), "10.1.2.3");
  EXPECT_EQ(forwarded({{"X-Forwarded-For", "192.168.1.1, 10.1.2.3"}}), "10.1.2.3");
  EXPECT_EQ(forwarded({{"X-Forwarded-For", "192.168.1.1"}, {"X-Forwarded-For", "fe80::1"}}),
            "fe80::1");
  EXPECT_EQ(forwarded({{"X-Forwarded-For", "anna"}}), "");
  EXPECT_EQ(forwarded({{"X-Forwarded-For", "10.1.2.3\x1b[31m"}}), "");
}

TEST(Head, IsRefusedWithItsStatus) {
  EXPECT_EQ(StatusOf(Check("GET", "/..", {})), 400u);
  EXPECT_EQ(StatusOf(Check("GET", "/" + std::string(5000, 'a'), {})), 414u);
  for (const std::string method : {"PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT", "get"}) {
    EXPECT_EQ(StatusOf(Check(method, "/", {})), 405u) << method;
  }
  EXPECT_EQ(StatusOf(Check("GET", "/", {{"host", "localhost"}})), 400u);
  EXPECT_EQ(StatusOf(Check("POST", "/", {{"Origin", "https://evil.example"}})), 403u);
  EXPECT_EQ(StatusOf(Check("GET", "/", {{"Origin", "https://evil.example"}})), 200u);
  EXPECT_EQ(StatusOf(Check("POST", "/", {{"Expect", "coffee"}})), 417u);
  EXPECT_EQ(StatusOf(CheckHead({"GET", "/", {}}, {}, {}, {})), 400u);
  EXPECT_EQ(StatusOf(CheckHead({"GET", "/", {{"Host", "evil.example"}}}, {}, {}, {})), 403u);
}

TEST(Head, OfAWebSocketChoosesTheSubprotocolThatTheServerPrefers) {
  const auto checked = std::get<CheckedHead>(Check(
      "GET", "/live", With(kUpgrade, "Sec-WebSocket-Protocol", "other, first.v1 ,second.v1")));
  EXPECT_TRUE(checked.websocket);
  EXPECT_EQ(checked.subprotocol, "second.v1");
  EXPECT_EQ(std::get<CheckedHead>(Check("GET", "/live", kUpgrade)).subprotocol, "");
}

TEST(Head, OfAWebSocketIsRefused) {
  const auto none = Check("GET", "/", With(kUpgrade, "Sec-WebSocket-Protocol", "other"));
  EXPECT_EQ(StatusOf(none), 400u);
  EXPECT_THAT(std::get<HttpError>(none).error.message, HasSubstr("second.v1, first.v1"));
  EXPECT_EQ(StatusOf(Check("POST", "/", kUpgrade)), 400u);
  EXPECT_EQ(StatusOf(Check("HEAD", "/", kUpgrade)), 400u);
  EXPECT_EQ(StatusOf(Check("GET", "/", With(kUpgrade, "Sec-WebSocket-Version", "8"))), 426u);
  EXPECT_EQ(StatusOf(Check("GET", "/", With(kUpgrade, "Sec-WebSocket-Key", "short"))), 400u);
  EXPECT_EQ(StatusOf(Check("GET", "/", With(kUpgrade, "Origin", "https://evil.example"))), 403u);
  EXPECT_EQ(StatusOf(Check("GET", "/", With(kUpgrade, "Origin", "http://localhost:3000"))), 200u);
}

}  // namespace musher::http::head_test
