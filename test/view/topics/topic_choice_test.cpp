#include "musher/view/topics/topic_choice.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace musher::view::topic_choice_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(TopicChoice, AStarStandsForAnyCharactersAndAQuestionMarkForOne) {
  EXPECT_TRUE(Matches("/camera/*", "/camera/left/image"));
  EXPECT_TRUE(Matches("*image", "/camera/left/image"));
  EXPECT_TRUE(Matches("/a*b*c", "/a-b-b-c"));
  EXPECT_TRUE(Matches("/leg?", "/leg1"));
  EXPECT_FALSE(Matches("/leg?", "/leg"));
  EXPECT_FALSE(Matches("/camera", "/camera/left"));
  EXPECT_FALSE(Matches("", "/camera"));
}

TEST(TopicChoice, OnlyTopicsAreRecordedAndNoService) {
  EXPECT_EQ(RosTopic("rt/dog1/chat"), "/dog1/chat");
  EXPECT_EQ(RosTopic("rq/musher/set_stateRequest"), "");
  EXPECT_EQ(RosTopic("ros_discovery_info"), "");
  TopicChoice all = TopicChoice::Of({}, {}, "").value();
  EXPECT_TRUE(all.Takes("/chat"));
  EXPECT_FALSE(all.Takes(""));
}

TEST(TopicChoice, AnExcludedTopicIsNotTakenThoughItIsWanted) {
  TopicChoice choice = TopicChoice::Of({"/camera/*"}, {"*/depth"}, "").value();
  EXPECT_TRUE(choice.Takes("/camera/image"));
  EXPECT_FALSE(choice.Takes("/camera/depth"));
  EXPECT_FALSE(choice.Takes("/chat"));
}

TEST(TopicChoice, ARelativePatternIsBelowTheNamespace) {
  TopicChoice choice = TopicChoice::Of({"chat"}, {}, "dog1").value();
  EXPECT_TRUE(choice.Takes("/dog1/chat"));
  EXPECT_FALSE(choice.Takes("/chat"));
}

TEST(TopicChoice, NamesThePatternsThatNoTopicHasMatched) {
  TopicChoice choice = TopicChoice::Of({"/chat", "/caht"}, {"/nothing"}, "").value();
  EXPECT_TRUE(choice.Takes("/chat"));
  EXPECT_THAT(choice.Unmatched(), ElementsAre("/caht", "/nothing"));
  EXPECT_THAT(TopicChoice::Of({}, {}, "").value().Unmatched(), IsEmpty());
}

TEST(TopicChoice, RefusesAPatternThatNoTopicCanMatch) {
  const auto choice = TopicChoice::Of({"/a b"}, {}, "");
  ASSERT_FALSE(choice);
  EXPECT_THAT(choice.error().message, HasSubstr("invalid topic pattern '/a b'; expected letters"));
  EXPECT_FALSE(TopicChoice::Of({""}, {}, ""));
  EXPECT_FALSE(TopicChoice::Of({}, {"rt:chat"}, ""));
}

}  // namespace musher::view::topic_choice_test
