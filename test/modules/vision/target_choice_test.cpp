#include "musher/modules/vision/faces/target_choice.hpp"

#include <gtest/gtest.h>

#include "musher/test/modules/vision/faces.hpp"

namespace musher::vision::target_choice_test {

// Lost after 1 s, another has to be nearer by a quarter; a picture each 100 ms.
class TargetChoiceTest : public ::testing::Test {
 protected:
  std::optional<int> See(const std::vector<TargetChoice::Candidate>& frontal,
                         std::int64_t after_ms = 100) {
    now_ns_ += after_ms * kMs;
    return choice_.OnPicture(now_ns_, frontal);
  }

  TargetChoice choice_{{}};
  std::int64_t now_ns_ = 0;
};

TEST_F(TargetChoiceTest, IsEmptyWithoutAFrontalFace) {
  EXPECT_EQ(See({}), std::nullopt);
}

TEST_F(TargetChoiceTest, IsTheNearestOne) {
  EXPECT_EQ(See({{1, 0.1}, {2, 0.2}, {3, 0.15}}), 2);
}

TEST_F(TargetChoiceTest, IsKeptWhileAnotherIsOnlyALittleNearer) {
  See({{1, 0.2}});
  EXPECT_EQ(See({{1, 0.2}, {2, 0.26}}), 1);
  EXPECT_EQ(See({{1, 0.2}, {2, 0.27}}), 2) << "nearer by more than a quarter";
  EXPECT_EQ(See({{1, 0.26}, {2, 0.2}}), 2);
}

TEST_F(TargetChoiceTest, IsEmptyWhileTheChosenFaceIsMissed) {
  See({{1, 0.2}, {2, 0.19}});
  EXPECT_EQ(See({{2, 0.19}}), std::nullopt);
  EXPECT_EQ(See({{1, 0.2}, {2, 0.19}}), 1);
}

TEST_F(TargetChoiceTest, IsAnotherOneWhenTheChosenOneIsLost) {
  See({{1, 0.2}, {2, 0.1}});
  EXPECT_EQ(See({{2, 0.1}}, 1000), std::nullopt);
  EXPECT_EQ(See({{2, 0.1}}, 100), 2);
  EXPECT_EQ(See({{1, 0.12}, {2, 0.1}}), 2) << "a face that comes back has lost its place";
}

}  // namespace musher::vision::target_choice_test
