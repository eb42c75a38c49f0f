#include "musher/base/suggest.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "musher/lifecycle/state.hpp"

namespace musher::suggest_test {

TEST(Nearest, FindsAWordWithALetterMissingAddedOrWrong) {
  EXPECT_EQ(Nearest("Protcted", BuiltInStates()), "Protected");
  EXPECT_EQ(Nearest("Protectted", BuiltInStates()), "Protected");
  EXPECT_EQ(Nearest("Brotected", BuiltInStates()), "Protected");
}

TEST(Nearest, CountsSwappedNeighboursAsOneEdit) {
  EXPECT_EQ(Nearest("eno", std::vector<std::string>{"one"}), "");
  EXPECT_EQ(Nearest("oen", std::vector<std::string>{"one"}), "one");
}

TEST(Nearest, TakesNoNoticeOfCase) {
  EXPECT_EQ(Nearest("ACTIVE", BuiltInStates()), "Active");
  EXPECT_EQ(Nearest("deactive", BuiltInStates()), "DeActive");
}

// `musher set DeActive` on a robot without that state suggested Active.
TEST(Nearest, IsNeverTheOppositeOfTheWord) {
  const std::vector<std::string> states{"Active", "LowPower"};
  EXPECT_EQ(Nearest("DeActive", states), "");
  EXPECT_EQ(Nearest("inactive", states), "");
  EXPECT_EQ(Nearest("Aktive", states), "Active");
  EXPECT_EQ(Nearest("unlock", std::vector<std::string>{"lock"}), "");
}

TEST(Nearest, GivesTheNearestOfSeveral) {
  EXPECT_EQ(Nearest("motor_left", std::vector<std::string>{"motor_right", "motor_lift", "motor"}),
            "motor_lift");
}

TEST(Nearest, GivesTheFirstOfEquallyNearOnes) {
  EXPECT_EQ(Nearest("arm3", std::vector<std::string>{"arm2", "arm1"}), "arm2");
}

TEST(Nearest, GivesNothingWhereNothingIsNear) {
  EXPECT_EQ(Nearest("Dancing", BuiltInStates()), "");
  EXPECT_EQ(Nearest("ab", std::vector<std::string>{"xy"}), "");
  EXPECT_EQ(Nearest("", std::vector<std::string>{"a"}), "");
  EXPECT_EQ(Nearest("a", std::vector<std::string>{}), "");
}

TEST(Nearest, AllowsMoreErrorsInLongerWordsUpToThree) {
  EXPECT_EQ(Nearest("controller_lots_sm", std::vector<std::string>{"controller_lost_ms"}),
            "controller_lost_ms");
  EXPECT_EQ(Nearest("kontroler_lots_sm", std::vector<std::string>{"controller_lost_ms"}), "");
}

TEST(Nearest, NeverGivesTheWordItself) {
  EXPECT_EQ(Nearest("Active", std::vector<std::string>{"Active"}), "");
}

TEST(Nearest, LeavesVeryLongWordsAlone) {
  const std::string word(65, 'a');
  EXPECT_EQ(Nearest(word, std::vector<std::string>{word + "b"}), "");
}

TEST(DidYouMean, EndsAMessageWithTheNearestName) {
  EXPECT_EQ(DidYouMean("lags", {"arm", "legs"}), "; did you mean 'legs'?");
  EXPECT_EQ(DidYouMean("lags", std::vector<std::string>{"arm", "legs"}), "; did you mean 'legs'?");
  EXPECT_EQ(DidYouMean("lags", std::set<std::string>{"arm", "legs"}), "; did you mean 'legs'?");
}

TEST(DidYouMean, IsEmptyWhereNoNameIsNear) {
  EXPECT_EQ(DidYouMean("zzz", {"arm", "legs"}), "");
  EXPECT_EQ(DidYouMean("zzz", std::vector<std::string>{}), "");
}

TEST(DidYouMean, TakesTheQuotesOfTheMessage) {
  EXPECT_EQ(DidYouMean("lags", {"arm", "legs"}, "\"\""), "; did you mean \"legs\"?");
  EXPECT_EQ(DidYouMean("lags", {"arm", "legs"}, "<>"), "; did you mean <legs>?");
  EXPECT_EQ(DidYouMean("[legs]"), "; did you mean [legs]?");
}

TEST(NoSuch, NamesTheNearestOneAndTheKnownOnes) {
  EXPECT_EQ(NoSuch("actuator", "zzz", {"legs", "head", "arm"}),
            "there is no actuator 'zzz'; there are legs, head and arm");
  EXPECT_EQ(NoSuch("actuator", "lags", {"legs", "arm"}),
            "there is no actuator 'lags'; did you mean 'legs'? There are legs and arm");
  EXPECT_EQ(NoSuch("actuator", "zzz", {"legs"}), "there is no actuator 'zzz'; there is only legs");
  EXPECT_EQ(NoSuch("capability", "fly", {}), "there is no capability 'fly'");
  EXPECT_EQ(NoSuch("actuator", "zz", std::vector<std::string>(14, "a")),
            "there is no actuator 'zz'; there are a, a, a, a, a, a, a, a, a, a, a, a and 2 more");
}

}  // namespace musher::suggest_test
