#include "musher/view/http/target.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace musher::http::target_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

TEST(Target, HasADecodedPathAndParameters) {
  const auto target = ParseTarget("/api/log%20book/%C3%A9?name=motion+left&from=-100&empty&a=%26");
  ASSERT_TRUE(target.ok());
  EXPECT_EQ(target.value().path, "/api/log book/é");
  EXPECT_THAT(target.value().query, ElementsAre(Pair("a", "&"), Pair("empty", ""),
                                                Pair("from", "-100"), Pair("name", "motion left")));
}

TEST(Target, HasOneSlashForSeveralAndKeepsTheLast) {
  EXPECT_EQ(ParseTarget("//a///b").value().path, "/a/b");
  EXPECT_EQ(ParseTarget("/a/").value().path, "/a/");
  EXPECT_EQ(ParseTarget("/").value().path, "/");
  EXPECT_EQ(ParseTarget("//").value().path, "/");
}

TEST(Target, TakesTheFirstOfAName) {
  EXPECT_EQ(ParseTarget("/?a=1&a=2").value().query.at("a"), "1");
}

TEST(Target, DoesNotLeaveAFolder) {
  for (const std::string target :
       {"/..", "/../etc/passwd", "/a/../b", "/a/./b", "/%2e%2e/etc", "/%2E./x", "/a/..%2fb",
        "/a%2f..%2f..%2fetc", "/a\\..\\b", "/a%5c..", "/a%00.html", "/a%0ab", "/%7f"}) {
    EXPECT_FALSE(ParseTarget(target).ok()) << target;
  }
}

TEST(Target, IsRefusedInOtherForms) {
  for (const std::string target : {"", "a", "http://robot/", "*", "/%", "/%1", "/%zz", "/?a=%g0",
                                   "/%ff", "/%c0%af", "/?a=%ed%a0%80", "/?a=%00"}) {
    EXPECT_FALSE(ParseTarget(target).ok()) << target;
  }
}

TEST(Target, HasLimits) {
  EXPECT_TRUE(ParseTarget("/" + std::string(kMaxTarget - 1, 'a')).ok());
  EXPECT_THAT(ParseTarget("/" + std::string(kMaxTarget, 'a')).error().message,
              HasSubstr("4096 bytes"));
  std::string many = "/?";
  for (std::size_t i = 0; i <= kMaxParameters; ++i) many += "a" + std::to_string(i) + "=&";
  EXPECT_THAT(ParseTarget(many).error().message, HasSubstr("64 parameters"));
}

std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const unsigned char c : text) {
    escaped += '%';
    escaped += "0123456789abcdef"[c >> 4];
    escaped += "0123456789ABCDEF"[c & 15];
  }
  return escaped;
}

RC_GTEST_PROP(Target, IsRefusedOrStaysInsideAndIsText, (const std::vector<std::string>& parts)) {
  std::string text;
  for (const std::string& part : parts) {
    text += *rc::gen::element<std::string>("/", "/..", "%2e", "%2F", "\\", "%00", "/a", "?", "=");
    text += *rc::gen::arbitrary<bool>() ? Escaped(part) : part;
  }
  const auto target = ParseTarget(text);
  if (!target) return;
  const std::string& path = target.value().path;
  RC_ASSERT(path.starts_with('/'));
  RC_ASSERT((path + "/").find("/../") == std::string::npos);
  RC_ASSERT((path + "/").find("/./") == std::string::npos);
  RC_ASSERT(path.find("//") == std::string::npos);
  RC_ASSERT(path.find_first_of(std::string("\\\0\n\r", 4)) == std::string::npos);
  RC_ASSERT(IsUtf8(path));
}

RC_GTEST_PROP(Target, HasTheParametersThatWereEscaped, (const std::string& value)) {
  const auto target = ParseTarget("/?v=" + Escaped(value));
  const bool text = IsUtf8(value) && value.find('\0') == std::string::npos;
  RC_ASSERT(target.ok() == text);
  if (text) RC_ASSERT(target.value().query.at("v") == value);
}

TEST(Cookies, AreNamesAndValues) {
  EXPECT_THAT(ParseCookies("a=1; musher_session=\"x y\" ;broken;=3; b=; a=2"),
              ElementsAre(Pair("a", "1"), Pair("b", ""), Pair("musher_session", "x y")));
  EXPECT_TRUE(ParseCookies("").empty());
}

TEST(Utf8, IsShortestFormWithoutSurrogates) {
  EXPECT_TRUE(IsUtf8("a é 水 🐕"));
  for (const std::string text : {"\x80", "\xc3", "\xc0\x80", "\xe0\x80\x80", "\xed\xa0\x80",
                                 "\xf4\x90\x80\x80", "\xf0\x80\x80\x80", "\xff"}) {
    EXPECT_FALSE(IsUtf8(text));
  }
}

TEST(Authority, IsANameAndAPort) {
  EXPECT_EQ(ParseAuthority("Robot.Local:8765").value().host, "robot.local");
  EXPECT_EQ(ParseAuthority("Robot.Local:8765").value().port, "8765");
  EXPECT_EQ(ParseAuthority("[::1]").value().host, "::1");
  EXPECT_EQ(ParseAuthority("[::1]:80").value().port, "80");
  for (const std::string text :
       {"", ":80", "a b", "a:", "a:b", "a:123456", "[::1", "[::1]x", "a/b", "a@b", "[]"}) {
    EXPECT_FALSE(ParseAuthority(text).ok()) << text;
  }
}

}  // namespace musher::http::target_test
