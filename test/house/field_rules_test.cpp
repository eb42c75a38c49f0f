#include "musher/test/house/field_rules.hpp"

#include <gmock/gmock.h>

namespace musher::house::field_rules_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<std::string> ViolationsIn(const std::string& of_struct, const std::string& fields) {
  return UncommentedFields(
      {"a.idl",
       "module a { module msg { module dds_ {\n  // A struct.\n  @final struct " + of_struct +
           "_ {\n" + fields + "  };\n}; }; };\n",
       false});
}

TEST(FieldRules, AcceptACommentBehindOrAboveAField) {
  EXPECT_THAT(ViolationsIn("Battery",
                           "    float voltage;  // V\n"
                           "    // V, of each cell;\n"
                           "    // empty: not known\n"
                           "    @appended sequence<float> cells;\n"
                           "    @default(-1) int32 percent;  // -1: not known\n"
                           "    a::msg::dds_::Cell_ cell[4];  // front left first\n"
                           "    sequence<string<8>> names;    // of the cells\n"
                           "    string unit;                  // \"V\"\n"
                           "    uint8 charge;                 // %\n"
                           "    uint8 color;                  // red; or blue };\n"),
              IsEmpty());
}

TEST(FieldRules, ReportAFieldOfEachFormWithoutAComment) {
  EXPECT_THAT(ViolationsIn("Battery",
                           "    float voltage;\n"
                           "    @appended sequence<float> cells;\n"
                           "    @default(\"(a); // b\") @appended string<8> name;\n"
                           "    a::msg::dds_::Cell_ cell[4];\n"),
              ElementsAre("a.idl:4: Battery.voltage has no comment behind or above it",
                          "a.idl:5: Battery.cells has no comment behind or above it",
                          "a.idl:6: Battery.name has no comment behind or above it",
                          "a.idl:7: Battery.cell has no comment behind or above it"));
}

TEST(FieldRules, ACommentBelongsToOneFieldOnly) {
  EXPECT_THAT(ViolationsIn("Battery",
                           "    // V\n"
                           "    float voltage;\n"
                           "    float current;\n"
                           "    float charge;  // Ah\n"
                           "    float capacity;\n"
                           "    // above nothing\n"
                           "\n"
                           "    float percentage;\n"),
              ElementsAre("a.idl:6: Battery.current has no comment behind or above it",
                          "a.idl:8: Battery.capacity has no comment behind or above it",
                          "a.idl:11: Battery.percentage has no comment behind or above it"));
}

TEST(FieldRules, TheCommentOfAStructIsNotThatOfItsFirstField) {
  EXPECT_THAT(ViolationsIn("Flag", "    boolean data;\n"),
              ElementsAre("a.idl:4: Flag.data has no comment behind or above it"));
}

TEST(FieldRules, ReportACommentThatIsEmptyOrRepeatsTheName) {
  EXPECT_THAT(ViolationsIn("Actuator",
                           "    string name;        //\n"
                           "    string state_name;  // The name of the state\n"
                           "    int32 error_code;   // the error code\n"),
              ElementsAre("a.idl:4: Actuator.name has no comment behind or above it",
                          "a.idl:6: Actuator.error_code has a comment that only repeats its name"));
}

TEST(FieldRules, FieldsThatRos2AddsNeedNoComment) {
  const std::string envelope = "    uint64 client_id;\n    int64 sequence_number;\n";
  EXPECT_THAT(ViolationsIn("GetStatus_Request",
                           envelope + "    uint8 structure_needs_at_least_one_member;\n"),
              IsEmpty());
  EXPECT_THAT(ViolationsIn("Walk_SendGoal_Request",
                           envelope + "    a::UUID_ goal_id;\n    a::Walk_Goal_ goal;\n"),
              IsEmpty());
  EXPECT_THAT(ViolationsIn("Walk_SendGoal_Response",
                           envelope + "    boolean accepted;\n    a::Time_ stamp;\n"),
              IsEmpty());
  EXPECT_THAT(ViolationsIn("Walk_GetResult_Request", envelope + "    a::UUID_ goal_id;\n"),
              IsEmpty());
  EXPECT_THAT(ViolationsIn("Walk_FeedbackMessage",
                           "    a::UUID_ goal_id;\n    a::Walk_Feedback_ feedback;\n"),
              IsEmpty());
}

TEST(FieldRules, FieldsOfTheseNamesInOtherStructsNeedOne) {
  EXPECT_THAT(
      ViolationsIn("Walk_Goal", "    a::UUID_ goal_id;\n    boolean accepted;\n    string goal;\n"),
      ElementsAre("a.idl:4: Walk_Goal.goal_id has no comment behind or above it",
                  "a.idl:5: Walk_Goal.accepted has no comment behind or above it",
                  "a.idl:6: Walk_Goal.goal has no comment behind or above it"));
  EXPECT_THAT(
      ViolationsIn("Walk_GetResult_Response", "    int8 status;\n    a::R_ result;\n"),
      ElementsAre("a.idl:4: Walk_GetResult_Response.status has no comment behind or above it"));
}

TEST(FieldRules, ConstantsNeedNone) {
  EXPECT_THAT(UncommentedFields({"a.idl",
                                 "  module Led_Constants {\n    const uint8 HEAD = 1;\n  };\n"
                                 "  @final struct Led_ {\n    uint8 target;  // a constant\n  };\n",
                                 false}),
              IsEmpty());
}

}  // namespace musher::house::field_rules_test
