// The name of an actuator that the machine does not have, at every command that takes one.

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::unknown_actuator_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

class UnknownActuator : public MachineByCli {};

TEST_F(UnknownActuator, IsAWrongCommandLineEverywhere) {
  ASSERT_EQ(UpDetached().exit, 0);
  const std::vector<std::vector<std::string>> commands = {{"set", "Active", "lgs"},
                                                          {"plan", "Active", "lgs"},
                                                          {"wait", "Active", "lgs"},
                                                          {"restart", "lgs"},
                                                          {"describe", "lgs"},
                                                          {"logs", "lgs"},
                                                          {"history", "--actuator", "lgs"},
                                                          {"behavior", "lgs"},
                                                          {"behavior", "lgs", "--tree"},
                                                          {"graph", "--behavior", "lgs"},
                                                          {"skill", "list", "--actuator", "lgs"}};
  for (std::vector<std::string> words : commands) {
    const Ended text = Musher(words);
    EXPECT_EQ(text.exit, 2) << words.front() << ": " << text.err;
    EXPECT_THAT(text.err, AllOf(HasSubstr("'lgs'"), HasSubstr("did you mean 'legs'?")))
        << words.front();
    words.emplace_back("--json");
    const Ended ended = Musher(words);
    EXPECT_EQ(ended.exit, 2) << words.front();
    const auto json = Json(ended.out);
    const char* key = words.front() == "set" || words.front() == "plan" ? "reason" : "error";
    EXPECT_THAT(json[key].get<std::string>(), HasSubstr("did you mean 'legs'?")) << ended.out;
    EXPECT_EQ(json["code"], 110) << ended.out;
  }
}

}  // namespace musher::testing::unknown_actuator_test
