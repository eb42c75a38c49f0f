// The goals of a plan whose process was killed, in the process after it.

#include "musher/modules/skills/plan/saved_goals.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "musher/test/support/temp_folder.hpp"

namespace musher::skills::saved_goals_test {

using ::testing::HasSubstr;

transport::GoalId Id(std::uint8_t number) {
  transport::GoalId id{};
  id.front() = number;
  id.back() = 0xfe;
  return id;
}

class SavedGoalsOfAPlan : public ::testing::Test {
 protected:
  void Write(const std::string& text) const {
    std::filesystem::create_directories(folder_ / "state");
    std::ofstream(file_) << text;
  }
  std::string Read() const {
    std::ifstream file(file_);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  const TempFolder folder_;
  const std::string file_ = folder_ / "state/plan_dispatcher_goals.toml";
  const SavedGoals::Goals goals_ = {{Id(1), "dog1"}, {Id(2), "dog2"}};
  Time now_ = Time() + std::chrono::hours(1);
};

TEST_F(SavedGoalsOfAPlan, AreFoundByTheNextProcess) {
  SavedGoals before(file_);
  EXPECT_EQ(before.Found().value(), SavedGoals::Goals());
  EXPECT_TRUE(before.Save(goals_, now_));
  EXPECT_EQ(SavedGoals(file_).Found().value(), goals_);
}

TEST_F(SavedGoalsOfAPlan, LeaveNoFileWhenTheyHaveEnded) {
  EXPECT_TRUE(SavedGoals(file_).Save(goals_, now_));
  EXPECT_TRUE(SavedGoals(file_).Save({}, now_)) << "in the process after a crash";
  EXPECT_FALSE(std::filesystem::exists(file_));
}

TEST_F(SavedGoalsOfAPlan, AreNotSavedWithoutAFile) {
  EXPECT_TRUE(SavedGoals("").Save(goals_, now_));
  EXPECT_EQ(SavedGoals("").Found().value(), SavedGoals::Goals());
}

// A cancellation without an id would cancel every goal of the robot.
TEST_F(SavedGoalsOfAPlan, AreNotKnownFromAFileThatIsNotWhole) {
  EXPECT_TRUE(SavedGoals(file_).Save(goals_, now_));
  const std::string whole = Read();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    Write(whole.substr(0, size));
    const auto found = SavedGoals(file_).Found();
    if (!found) continue;
    for (const auto& goal : found.value()) EXPECT_TRUE(goals_.contains(goal.first)) << size;
  }
  for (const char* goal : {"robot = \"dog1\"", "id = \"01\"\nrobot = \"dog1\"",
                           "robot = \"../dog1\"\nid = \"010000000000000000000000000000fe\"",
                           "robot = \"dog1\"\nid = \"00000000000000000000000000000000\""}) {
    Write("[[goal]]\n" + std::string(goal) + "\n");
    const auto found = SavedGoals(file_).Found();
    ASSERT_FALSE(found) << goal;
    EXPECT_THAT(found.error().message, HasSubstr("a robot and an id"));
  }
}

TEST_F(SavedGoalsOfAPlan, SayOnceWhyTheyAreNotSaved) {
  std::filesystem::create_directories(file_);  // a folder in its place
  SavedGoals saved(file_);
  const auto failed = saved.Save(goals_, now_);
  ASSERT_FALSE(failed);
  EXPECT_THAT(failed.error().message, HasSubstr("the goals of the plan are not saved"));
  EXPECT_TRUE(saved.Save({{Id(1), "dog1"}}, now_));
}

// The plan went on for an hour, and nothing of it was saved: its goals had not changed.
TEST_F(SavedGoalsOfAPlan, AreSavedOnceTheDiskTakesThemAlsoWithoutAChange) {
  std::filesystem::create_directories(file_);  // a folder in its place
  SavedGoals saved(file_);
  EXPECT_FALSE(saved.Save(goals_, now_));
  EXPECT_TRUE(saved.failed());
  std::filesystem::remove(file_);
  now_ += SavedGoals::kRetry - Milliseconds(1);
  EXPECT_TRUE(saved.Save(goals_, now_));
  EXPECT_FALSE(std::filesystem::exists(file_)) << "a disk that fails is not written in each tick";
  EXPECT_TRUE(saved.failed());
  now_ += Milliseconds(1);
  EXPECT_TRUE(saved.Save(goals_, now_));
  EXPECT_FALSE(saved.failed());
  EXPECT_EQ(SavedGoals(file_).Found().value(), goals_);
}

TEST_F(SavedGoalsOfAPlan, SayAgainWhyTheyAreNotSavedAfterTheyWere) {
  SavedGoals saved(file_);
  for (std::uint8_t number = 1; number <= 2; ++number) {
    std::filesystem::create_directories(file_);
    EXPECT_FALSE(saved.Save({{Id(number), "dog1"}}, now_));
    std::filesystem::remove(file_);
    now_ += SavedGoals::kRetry;
    EXPECT_TRUE(saved.Save({{Id(number), "dog1"}}, now_));
    std::filesystem::remove(file_);
  }
}

}  // namespace musher::skills::saved_goals_test
