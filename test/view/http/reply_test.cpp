#include "musher/view/http/reply.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace musher::http::reply_test {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

Response Text(const std::string& body) {
  Response response;
  response.content_type = "text/plain";
  response.body = std::make_shared<std::string>(body);
  return response;
}

TEST(Reply, HasLengthTypeAndDate) {
  ReplyContext context;
  context.unix_s = 784'111'777;
  const std::string head = ReplyHead(Text("abc"), context);
  EXPECT_THAT(head, StartsWith("HTTP/1.1 200 OK\r\nDate: Sun, 06 Nov 1994 08:49:37 GMT\r\n"));
  EXPECT_THAT(head, HasSubstr("Content-Length: 3\r\nContent-Type: text/plain\r\n"));
  EXPECT_TRUE(head.ends_with("\r\n\r\n"));
  EXPECT_THAT(head, Not(HasSubstr("Connection: close")));
}

TEST(Reply, WithoutABodyHasNoLength) {
  Response response;
  response.status = 204;
  EXPECT_THAT(ReplyHead(response, {}), Not(HasSubstr("Content-Length")));
  response.status = 200;
  EXPECT_THAT(ReplyHead(response, {}), HasSubstr("Content-Length: 0\r\n"));
}

TEST(Reply, IsKeptInNoCacheUnlessItSaysSo) {
  Response response = Text("x");
  EXPECT_THAT(ReplyHead(response, {}), HasSubstr("Cache-Control: no-store\r\n"));
  response.headers = {{"Cache-Control", "max-age=60"}};
  EXPECT_THAT(ReplyHead(response, {}), HasSubstr("Cache-Control: max-age=60\r\n"));
  ReplyContext api;
  api.path = "/api/history";
  EXPECT_THAT(ReplyHead(response, api), HasSubstr("Cache-Control: no-store\r\n"));
  EXPECT_THAT(ReplyHead(response, api), Not(HasSubstr("max-age")));
  response.headers = {{"ETag", "\"1\""}};
  EXPECT_THAT(ReplyHead(response, {}), HasSubstr("Cache-Control: no-cache\r\n"));
}

TEST(Reply, WithALineBreakInAHeaderIsAnError) {
  Response response = Text("x");
  response.headers = {{"X-Name", "a\r\nSet-Cookie: b"}};
  EXPECT_THAT(ReplyHead(response, {}), StartsWith("HTTP/1.1 500 "));
  EXPECT_THAT(ReplyHead(response, {}), Not(HasSubstr("Set-Cookie")));
  response.headers = {{"X Name", "a"}};
  EXPECT_THAT(ReplyHead(response, {}), StartsWith("HTTP/1.1 500 "));
}

TEST(Reply, OfAnErrorIsJson) {
  const Response response = ErrorResponse(404, 111, "no \"a\\b\"\n\xff");
  EXPECT_EQ(response.status, 404u);
  EXPECT_EQ(*response.body,
            "{\"error\":{\"code\":111,\"message\":\"no \\\"a\\\\b\\\"\\u000a?\"}}\n");
  EXPECT_EQ(JsonText("é"), "\"é\"");
}

TEST(ETag, ThatTheClientHasGives304) {
  Request request;
  EXPECT_EQ(WithETag(request, Text("x"), "\"1\"").status, 200u);
  for (const std::string known : {"\"1\"", "W/\"1\"", "\"0\", \"1\"", "*"}) {
    request.headers["if-none-match"] = known;
    const Response response = WithETag(request, Text("x"), "\"1\"");
    EXPECT_EQ(response.status, 304u) << known;
    EXPECT_EQ(response.body, nullptr);
  }
  request.headers["if-none-match"] = "\"2\", 1";
  EXPECT_EQ(WithETag(request, Text("x"), "\"1\"").status, 200u);
}

}  // namespace musher::http::reply_test
