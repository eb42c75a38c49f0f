#include "musher/view/live/request_fields.hpp"

#include <gmock/gmock.h>

#include <string>
#include <utility>

#include "musher/base/code.hpp"
#include "musher/view/json/json.hpp"

namespace musher::view::request_fields_test {

using ::testing::HasSubstr;

std::string WhyWrong(const std::string& path, const std::string& body) {
  const Result<> known = CheckFields(path, Json::parse(body));
  return known ? "" : known.error().message;
}

// The whole robot went to Active, as the actuator of {"target":"Active","actuator":5} was missing.
TEST(RequestFields, OfAnotherTypeAreNoMissingOnes) {
  EXPECT_EQ(WhyWrong("/api/set", R"({"target":"Active","actuator":5})"),
            "the field 'actuator' has to be a text. Nothing was done");
  EXPECT_THAT(WhyWrong("/api/set", R"({"target":"Active","actuator":null})"),
              HasSubstr("'actuator' has to be a text"));
  EXPECT_THAT(WhyWrong("/api/set", R"({"target":"Active","machine":["dog"]})"),
              HasSubstr("'machine' has to be a text"));
  EXPECT_THAT(WhyWrong("/api/plan", R"({"target":7})"), HasSubstr("'target' has to be a text"));
  EXPECT_THAT(WhyWrong("/api/skill", R"({"skill":"goto","parameters":"x_m=1"})"),
              HasSubstr("'parameters' has to be an object"));
}

// Without ids all stops are released.
TEST(RequestFields, OfAReleaseAreAListOfIds) {
  for (const char* body :
       {R"({"stop_ids":"12"})", R"({"stop_ids":[12]})", R"({"stop_ids":null})"}) {
    EXPECT_THAT(WhyWrong("/api/release", body), HasSubstr("'stop_ids' has to be a list of texts"));
  }
  EXPECT_THAT(WhyWrong("/api/release", R"({"stop_id":["12"]})"),
              HasSubstr("there is no field 'stop_id'; did you mean 'stop_ids'?"));
  EXPECT_EQ(WhyWrong("/api/release", R"({"stop_ids":["12"],"machine":"dog"})"), "");
}

TEST(RequestFields, ThatAreMisspeltAreNamed) {
  EXPECT_THAT(WhyWrong("/api/set", R"({"target":"Active","actautor":"legs"})"),
              HasSubstr("there is no field 'actautor'; did you mean 'actuator'?"));
  EXPECT_THAT(WhyWrong("/api/set", R"({"target":"Active","machine-id":"5982c7ee"})"),
              HasSubstr("did you mean 'machine_id'?"));
  EXPECT_THAT(WhyWrong("/api/restart", R"({"actuator":"legs","target":"Active"})"),
              HasSubstr("there is no field 'target'"));
}

TEST(RequestFields, OfThePageAreKnown) {
  const std::string common = R"("machine":"dog","machine_id":"5982c7ee","seen_uptime_ms":8000})";
  for (const auto& [path, fields] : {
           std::pair{"/api/plan", R"({"target":"Active","actuator":"",)"},
           std::pair{"/api/set", R"({"target":"Active","actuator":"legs",)"},
           std::pair{"/api/restart", R"({"actuator":"legs",)"},
           std::pair{"/api/release", R"({"stop_ids":[],)"},
           std::pair{"/api/skill", R"({"action":"/a","actuator":"b","skill":"c","parameters":{},)"},
       }) {
    EXPECT_EQ(WhyWrong(path, fields + common), "") << path;
  }
}

TEST(RequestFields, HoldUpNoStopNoPauseAndNoCancellation) {
  for (const char* path : {"/api/estop", "/api/pause_skill", "/api/cancel_skill"}) {
    EXPECT_EQ(WhyWrong(path, R"({"reason":7,"machine":[],"more":null})"), "") << path;
  }
}

}  // namespace musher::view::request_fields_test
