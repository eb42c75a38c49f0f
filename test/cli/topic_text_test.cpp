// What `musher topic` prints of samples and times.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/cli/render/topic.hpp"

namespace musher::cli::topic_text_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using transport::DiscoveredEndpoint;
using transport::Qos;

TEST(SampleText, HasNestedFieldsBelowEachOther) {
  EXPECT_EQ(
      SampleText(R"({"header":{"stamp":{"sec":3,"nanosec":0},"frame_id":"map"},"ok":true})", false),
      "header:\n"
      "  stamp:\n"
      "    sec: 3\n"
      "    nanosec: 0\n"
      "  frame_id: map\n"
      "ok: true\n");
}

TEST(SampleText, HasListsOfNumbersOnOneLineAndOfMessagesBelowEachOther) {
  EXPECT_EQ(SampleText(R"({"ranges":[1.5,null],"none":[],"poses":[{"x":1},{"x":2}]})", false),
            "ranges: [1.5, null]\n"
            "none: []\n"
            "poses:\n"
            "  -\n"
            "    x: 1\n"
            "  -\n"
            "    x: 2\n");
}

TEST(SampleText, CutsALongListUnlessTheWholeIsRequested) {
  std::string numbers = "0";
  for (int i = 1; i < 360; ++i) numbers += "," + std::to_string(i);
  const std::string json = R"({"ranges":[)" + numbers + "]}";
  EXPECT_THAT(SampleText(json, false), HasSubstr("14, 15, ... 360 in all]"));
  EXPECT_THAT(SampleText(json, true), HasSubstr("358, 359]"));
}

TEST(SampleText, QuotesTextsThatYamlWouldReadAsSomethingElse) {
  EXPECT_EQ(SampleText(R"({"a":"hello world","b":"","c":"true","d":"1.5","e":"x: 1"})", false),
            "a: hello world\nb: \"\"\nc: \"true\"\nd: \"1.5\"\ne: \"x: 1\"\n");
  EXPECT_EQ(SampleText(R"({"big":"1765432101234567890"})", false), "big: 1765432101234567890\n")
      << "an integer that JSON cannot hold";
}

TEST(SampleText, IsSafeForATerminal) {
  const std::string text = SampleText("{\"data\":\"\\u001b[2J\\u009b\"}", false);
  EXPECT_EQ(text.find('\x1b'), std::string::npos) << text;
}

TEST(SampleText, OfAMessageWithoutFieldsIsAnEmptyOne) {
  EXPECT_EQ(SampleText("{}", false), "{}\n");
}

TEST(SampleRateTest, HasTheTimesBetweenTheLastSamples) {
  SampleRate rate(3);
  EXPECT_FALSE(rate.Now().has_value());
  Time at{};
  for (const int gap_ms : {0, 500, 100, 300}) rate.Add(at += Milliseconds(gap_ms));
  const auto report = rate.Now();
  ASSERT_TRUE(report.has_value());
  EXPECT_EQ(report->samples, 3U);
  EXPECT_EQ(rate.all(), 4U);
  EXPECT_DOUBLE_EQ(report->rate_hz, 5.0) << "of the last three";
  EXPECT_DOUBLE_EQ(report->min_s, 0.1);
  EXPECT_DOUBLE_EQ(report->max_s, 0.3);
  EXPECT_DOUBLE_EQ(report->stddev_s, 0.1);
  EXPECT_EQ(RateText(rate),
            "5.00 Hz, between two samples 100.0 to 300.0 ms, standard deviation 100.00 ms "
            "(3 samples)");
}

TEST(TopicInfo, NamesAReaderThatReceivesNothingForItsQos) {
  DiscoveredEndpoint writer;
  writer.writer = true;
  writer.type = "std_msgs::msg::dds_::String_";
  writer.reliability = Qos::Reliability::kBestEffort;
  DiscoveredEndpoint reader = writer;
  reader.writer = false;
  EXPECT_THAT(QosMismatch(writer, reader), IsEmpty());
  reader.reliability = Qos::Reliability::kReliable;
  EXPECT_EQ(QosMismatch(writer, reader),
            "it requests reliable samples, which are offered as best effort");
  reader.reliability = Qos::Reliability::kBestEffort;
  reader.durability = Qos::Durability::kTransientLocal;
  EXPECT_THAT(QosMismatch(writer, reader), HasSubstr("offered as volatile"));
  reader.type = "std_msgs::msg::dds_::Int32_";
  EXPECT_EQ(QosMismatch(writer, reader),
            "it has the type std_msgs/msg/Int32, not std_msgs/msg/String");
  const std::string text =
      TopicInfoText("/chat", {{writer, "/talker", 7, "dog1"}, {reader, "", 8, "dog1"}}, false);
  EXPECT_THAT(text, HasSubstr("/chat  std_msgs/msg/String, std_msgs/msg/Int32\n"));
  EXPECT_THAT(text, HasSubstr("reader process 8 receives nothing of /talker: "));
}

}  // namespace musher::cli::topic_text_test
