// The skills that ran when a process was killed, in the process after it.

#include "musher/application/saved_skills.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "musher/behavior/skill/compose.hpp"
#include "musher/behavior/skill/wait.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::saved_skills_test {

using skill::Status;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class ASavedSkill : public ::testing::Test {
 protected:
  static std::unique_ptr<skill::Manager> Skills() {
    skill::Registry registry;
    EXPECT_TRUE(registry.Add("wait", skill::Wait()));
    EXPECT_TRUE(registry.Add(
        "twice", skill::Compose(skill::Order::kInOrder, registry, {{"wait"}, {"wait"}})));
    return std::make_unique<skill::Manager>(registry.All());
  }
  static Time At(double seconds) { return Time{} + FromSeconds(seconds); }
  // Until the process is killed.
  void RunUntil(skill::Manager& manager, double seconds) {
    SavedSkills saved = Saved();
    for (double at_s = 0; at_s <= seconds; at_s += 0.1) {
      manager.RunOnce(At(at_s));
      EXPECT_TRUE(saved.Save(manager, At(at_s)));
    }
  }
  Result<std::vector<std::string>> Restore(skill::Manager& manager, bool continues) const {
    return Saved().Restore(manager, continues);
  }
  SavedSkills Saved() const {
    return SavedSkills(file_, [this] { return host_now_; });
  }
  // What the next process says of `wait`, which ran before; it runs none.
  std::string WhyItDoesNotGoOn() {
    const auto next = Skills();
    const auto lines = Restore(*next, true);
    EXPECT_TRUE(lines) << lines.error().message;
    EXPECT_FALSE(next->running());
    EXPECT_EQ(next->Find("wait")->feedback().status, Status::kFailed);
    return lines.value().at(0);
  }

  const TempFolder folder_;
  const std::string file_ = folder_ / "state/r_skills.toml";
  HostTime host_now_{"this boot", std::chrono::hours(5)};
  std::unique_ptr<skill::Manager> before_ = Skills(), after_ = Skills();
};

TEST_F(ASavedSkill, HasFailedWithTheReason) {
  ASSERT_TRUE(before_->Start("twice", {{"wait.duration_s", 5.0}}));
  RunUntil(*before_, 3);
  const auto lines = Restore(*after_, false);
  ASSERT_TRUE(lines) << lines.error().message;
  EXPECT_THAT(lines.value(), ElementsAre(HasSubstr("twice has failed: its process has ended")));
  const skill::Run* run = after_->Find("twice");
  ASSERT_NE(run, nullptr);
  EXPECT_EQ(run->feedback().status, Status::kFailed);
  EXPECT_THAT(run->feedback().message, HasSubstr("its process has ended while it ran (RUNNING"));
  EXPECT_EQ(run->errors().size(), 1U);
  EXPECT_FALSE(after_->running());
  EXPECT_TRUE(after_->Start("wait")) << "its parts are free";
}

TEST_F(ASavedSkill, GoesOnWhereItWas) {
  ASSERT_TRUE(before_->Start("wait", {{"duration_s", 5.0}}));
  RunUntil(*before_, 3);
  const auto lines = Restore(*after_, true);
  ASSERT_TRUE(lines) << lines.error().message;
  EXPECT_THAT(lines.value(), ElementsAre("wait goes on from WAITING once it is Active"));
  for (double at_s = 1000; at_s < 1001.5; at_s += 0.1) after_->RunOnce(At(at_s));
  EXPECT_TRUE(after_->running()) << "the time without a process does not count";
  for (double at_s = 1001.5; at_s < 1004; at_s += 0.1) after_->RunOnce(At(at_s));
  EXPECT_EQ(after_->Find("wait")->feedback().status, Status::kCompleted);
}

// A robot that was switched off in mid-patrol drove on days later, at the next Active.
TEST_F(ASavedSkill, DoesNotGoOnAfterARestartOfTheComputer) {
  ASSERT_TRUE(before_->Start("wait", {{"duration_s", 5.0}}));
  RunUntil(*before_, 3);
  for (const std::string host : {"another boot", ""}) {
    host_now_.host = host;
    EXPECT_EQ(WhyItDoesNotGoOn(),
              "wait has failed: its process has ended while it ran (WAITING); it does not go on: "
              "the computer or its container was restarted since then");
  }
}

TEST_F(ASavedSkill, DoesNotGoOnAfterALongTime) {
  ASSERT_TRUE(before_->Start("wait", {{"duration_s", 5.0}}));
  RunUntil(*before_, 3);
  host_now_.since_boot += SavedSkills::kMostAge;
  EXPECT_THAT(Restore(*Skills(), true).value(), ElementsAre(HasSubstr("goes on from WAITING")));
  host_now_.since_boot += Milliseconds(1000);
  EXPECT_THAT(WhyItDoesNotGoOn(), HasSubstr("it was saved 61 s ago, and 60 s are the limit"));
  host_now_.since_boot = {};
  EXPECT_THAT(WhyItDoesNotGoOn(), HasSubstr("the computer or its container was restarted"));
}

// It was restored within the minute, and the machine was in another state than Active: its pauses
// renewed the time in the file, and a set of Active hours later moved the robot.
TEST_F(ASavedSkill, DoesNotGoOnALongTimeAfterItWasRestored) {
  ASSERT_TRUE(before_->Start("wait", {{"duration_s", 5.0}}));
  RunUntil(*before_, 3);
  host_now_.since_boot += std::chrono::seconds(10);
  SavedSkills saved = Saved();
  ASSERT_TRUE(saved.Restore(*after_, true));
  host_now_.since_boot += std::chrono::seconds(40);
  after_->Pause();
  ASSERT_TRUE(saved.Save(*after_, At(50)));
  host_now_.since_boot += std::chrono::seconds(20);
  EXPECT_THAT(WhyItDoesNotGoOn(), HasSubstr("it was saved 70 s ago"))
      << "also in the process after the next";
  EXPECT_THAT(saved.TakeOver(), HasSubstr("it was saved 70 s ago"));
  EXPECT_EQ(saved.TakeOver(), "") << "what runs from now on is its own";
}

TEST_F(ASavedSkill, ThatHasMadeAStepInTimeIsThatOfTheNextProcess) {
  ASSERT_TRUE(before_->Start("wait", {{"duration_s", 5.0}}));
  RunUntil(*before_, 3);
  SavedSkills saved = Saved();
  ASSERT_TRUE(saved.Restore(*after_, true));
  host_now_.since_boot += SavedSkills::kMostAge;
  EXPECT_EQ(saved.TakeOver(), "");
  after_->RunOnce(At(100));
  ASSERT_TRUE(saved.Save(*after_, At(100)));
  host_now_.since_boot += SavedSkills::kMostAge;
  EXPECT_THAT(Restore(*Skills(), true).value(), ElementsAre(HasSubstr("goes on from WAITING")));
}

// The stop came and was released between the two processes: it would have cancelled what ran.
TEST_F(ASavedSkill, DoesNotGoOnAfterAnEmergencyStop) {
  ASSERT_TRUE(before_->Start("wait", {{"duration_s", 5.0}}));
  RunUntil(*before_, 3);
  const auto next = Skills();
  SavedSkills saved = Saved();
  ASSERT_TRUE(saved.Restore(*next, true));
  saved.NoteStop(17, false);
  EXPECT_EQ(saved.TakeOver(), "an emergency stop has come since it was saved");
}

// The clock of the computer whose program has stopped the robot was a minute behind: the stop was
// older than what was saved, which went on.
TEST_F(ASavedSkill, DoesNotGoOnAfterAnEmergencyStopWhateverTheClockOfTheOperator) {
  ASSERT_TRUE(before_->Start("wait", {{"duration_s", 5.0}}));
  SavedSkills first = Saved();
  first.NoteStop(17, true);
  first.NoteStop(17, false);
  before_->RunOnce(At(0));
  ASSERT_TRUE(first.Save(*before_, At(0)));

  const auto next = Skills();
  SavedSkills second = Saved();
  ASSERT_TRUE(second.Restore(*next, true));
  second.NoteStop(17, false);  // latched since before it was saved
  ASSERT_TRUE(second.Save(*next, At(1)));
  const auto third = Skills();
  SavedSkills of_third = Saved();
  ASSERT_TRUE(of_third.Restore(*third, true));
  of_third.NoteStop(17, false);
  of_third.NoteStop(18, false);
  EXPECT_EQ(of_third.TakeOver(), "an emergency stop has come since it was saved");
  EXPECT_EQ(second.TakeOver(), "");
}

// The disk was full when an emergency stop cancelled it: the next process would have gone on.
TEST_F(ASavedSkill, WhoseEndCannotBeSavedIsForgotten) {
  ASSERT_TRUE(before_->Start("wait", {{"duration_s", 5.0}}));
  SavedSkills saved = Saved();
  before_->RunOnce(At(0));
  ASSERT_TRUE(saved.Save(*before_, At(0)));
  std::filesystem::create_directory(file_ + ".new");  // where the next content would be written
  before_->CancelAllNow("emergency stop");
  EXPECT_FALSE(saved.Save(*before_, At(0.1)));
  EXPECT_FALSE(std::filesystem::exists(file_));
}

TEST_F(ASavedSkill, DoesNotGoOnFromAFileThatDoesNotSayWhenItWasWritten) {
  ASSERT_TRUE(before_->Start("wait", {{"duration_s", 5.0}}));
  RunUntil(*before_, 3);
  std::ifstream in(file_);
  std::string text((std::istreambuf_iterator<char>(in)), {});
  text.erase(0, text.find("[[run]]"));
  std::ofstream(file_) << text;
  EXPECT_THAT(WhyItDoesNotGoOn(), HasSubstr("its file does not say when it was written"));
}

TEST_F(ASavedSkill, ThatWasPausedStaysPaused) {
  ASSERT_TRUE(before_->Start("wait", {{"duration_s", 5.0}}));
  RunUntil(*before_, 3);
  SavedSkills saved = Saved();
  ASSERT_TRUE(saved.Save(*before_, At(3)));
  ASSERT_TRUE(before_->Pause("wait", "by a request"));
  ASSERT_TRUE(saved.Save(*before_, At(3.1)));  // at once
  const auto lines = Restore(*after_, true);
  ASSERT_TRUE(lines) << lines.error().message;
  EXPECT_THAT(lines.value(), ElementsAre("wait stays paused in WAITING until it is resumed"));
  for (double at_s = 1000; at_s < 1100; at_s += 0.1) after_->RunOnce(At(at_s));
  EXPECT_TRUE(after_->Find("wait")->pause_requested());
  const auto third = Skills();
  ASSERT_TRUE(Restore(*third, false));
  EXPECT_EQ(third->Find("wait")->feedback().status, Status::kFailed);
  EXPECT_FALSE(third->Find("wait")->feedback().paused);
}

TEST_F(ASavedSkill, IsNoneWhenNoneRan) {
  EXPECT_THAT(Restore(*after_, true).value(), IsEmpty()) << "there is no file";
  ASSERT_TRUE(before_->Start("wait", {{"duration_s", 0.5}}));
  RunUntil(*before_, 3);
  ASSERT_FALSE(before_->running());
  EXPECT_THAT(Restore(*after_, false).value(), IsEmpty()) << "it has ended before";
}

// It stayed in the file until another skill ran, and a config changed to "continue" went on with
// it.
TEST_F(ASavedSkill, ThatHasFailedIsForgottenOnceTheNextProcessSteps) {
  ASSERT_TRUE(before_->Start("wait", {{"duration_s", 5.0}}));
  RunUntil(*before_, 3);
  SavedSkills saved = Saved();
  ASSERT_TRUE(saved.Restore(*after_, false));
  after_->RunOnce(At(1000));
  ASSERT_TRUE(saved.Save(*after_, At(1000)));
  const auto third = Skills();
  const auto lines = Restore(*third, true);
  ASSERT_TRUE(lines) << lines.error().message;
  EXPECT_THAT(lines.value(), IsEmpty());
  EXPECT_FALSE(third->running());
}

TEST_F(ASavedSkill, IsNotRestoredFromAFileThatDoesNotFit) {
  ASSERT_TRUE(before_->Start("wait", {{"duration_s", 5.0}}));
  RunUntil(*before_, 1);
  for (const std::string text : {"[[run]]\nskill = \"fly\"\n", "run = 3\n", "[[run\n"}) {
    std::ofstream(file_) << text;
    EXPECT_FALSE(Restore(*after_, false)) << text;
    EXPECT_THAT(after_->Runs(), IsEmpty());
  }
}

// The pipe in the place of the draft has no reader.
TEST_F(ASavedSkill, HoldsNoSkillWhereTheDiskDoesNotAnswer) {
  std::filesystem::create_directories(folder_ / "state");
  ASSERT_EQ(mkfifo((file_ + ".new").c_str(), 0600), 0);
  ASSERT_TRUE(before_->Start("wait", {{"duration_s", 5.0}}));
  before_->RunOnce(At(0));
  SavedSkills saved = Saved();
  EXPECT_THAT(saved.Save(*before_, At(0)).error().message, HasSubstr("has not answered"));
  EXPECT_TRUE(saved.Save(*before_, At(2))) << "said once";
}

TEST_F(ASavedSkill, SaysOnceWhyItCannotBeSaved) {
  std::ofstream(folder_ / "state") << "a file, no folder";
  ASSERT_TRUE(before_->Start("wait", {{"duration_s", 5.0}}));
  before_->RunOnce(At(0));
  SavedSkills saved = Saved();
  EXPECT_THAT(saved.Save(*before_, At(0)).error().message, HasSubstr("are not saved"));
  EXPECT_TRUE(saved.Save(*before_, At(2)));
}

}  // namespace musher::saved_skills_test
