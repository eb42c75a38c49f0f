// Faults of the base class of applications that were found and mended.

#include <future>

#include "musher/test/application/show.hpp"

namespace musher {
namespace {

using ::testing::HasSubstr;
using testing::Show;
using testing::Stage;

class AnFsmActuator : public ::testing::Test {
 protected:
  // In Active.
  void Begin(Show& show) {
    stage_.Open(show);
    ASSERT_TRUE(stage_.controller().SetState("SelfCheck"));
    ASSERT_TRUE(stage_.controller().SetState("Active"));
  }

  Stage stage_;
};

TEST_F(AnFsmActuator, FailsToBecomeActiveWhenItsResumeThrows) {
  Show show;
  show.data().throws = {{"resumes", "no"}};
  stage_.Open(show);
  ASSERT_TRUE(stage_.controller().SetState("SelfCheck"));
  const SwitchResult result = stage_.controller().Switch("Active");
  ASSERT_EQ(result.actuators.size(), 1U);
  EXPECT_THAT(result.actuators[0].message, HasSubstr("OnResume: no"));
  EXPECT_EQ(show.TakeLog().back(), "pauses");
  EXPECT_FALSE(show.Of([](Show& s) { return s.ticking(); }));
}

}  // namespace
}  // namespace musher
