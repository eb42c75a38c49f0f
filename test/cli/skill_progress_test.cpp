#include "musher/cli/commands/skill/skill_progress.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "musher/transport/linux_event_loop.hpp"

namespace musher::cli::skill_progress_test {

class ProgressOfASkill : public ::testing::Test {
 protected:
  // What is printed for three reports, two of which are equal.
  std::string Printed(const Console::Mode& mode) {
    Console console(out_, err_, mode);
    SkillProgress progress(loop_, "rise", console);
    progress.Show({"processing", "Rising", 10});
    progress.Show({"processing", "Rising", 10});
    progress.Show({"processing", "Almost there", 90});
    progress.Clear();
    EXPECT_EQ(err_.str(), "");
    return out_.str();
  }

  transport::LinuxEventLoop loop_;
  std::ostringstream out_;
  std::ostringstream err_;
};

TEST_F(ProgressOfASkill, IsOneLineOnATerminalWhichIsErasedAtTheEnd) {
  const std::string first = "\r\x1b[Krise  [##..................]   10 %  Rising  0 s";
  EXPECT_EQ(Printed({.terminal = true}),
            first + first +
                "\r\x1b[Krise  [##################..]   90 %  Almost there  0 s"
                "\r\x1b[K");
}

TEST_F(ProgressOfASkill, IsALineForEachChangeInAPipe) {
  EXPECT_EQ(Printed({}), " 10 %  Rising\n 90 %  Almost there\n");
}

TEST_F(ProgressOfASkill, IsNotPartOfTheJsonDocument) {
  EXPECT_EQ(Printed({.json = true, .terminal = true}), "");
}

}  // namespace musher::cli::skill_progress_test
