#include "musher/cli/machine/silent_controller.hpp"

#include <gmock/gmock.h>

namespace musher::cli::silent_controller_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Silence : public ::testing::Test {
 protected:
  std::string Why() const { return WhySilent(controller_, global_); }

  SilentController controller_{4711, false, false, "/etc/musher/dog.toml"};
  GlobalOptions global_;
};

TEST_F(Silence, OfAStoppedControllerHasThatCauseAndNotMissingKeys) {
  controller_.stopped = true;
  controller_.security.reset();
  EXPECT_EQ(Why(),
            "process 4711 leads it on this host but does not answer: it is stopped; `kill -CONT "
            "4711` continues it, `musher up /etc/musher/dog.toml --takeover` replaces it");
}

TEST_F(Silence, IsDueToKeysWhereTheConfigHasThem) {
  controller_.security = true;
  EXPECT_THAT(Why(), HasSubstr("unreachable without keys: the machine has [security]; use --keys"));
  global_.keys = "/keys";
  global_.identity = "operator";
  EXPECT_THAT(Why(), HasSubstr("the keys of operator in /keys are not of its machine"));
  controller_.security = false;
  EXPECT_THAT(Why(), HasSubstr("unreachable with keys: the machine has no [security]"));
}

TEST_F(Silence, WithoutSecurityMeansAHangOrAnotherNetwork) {
  EXPECT_THAT(Why(), AllOf(HasSubstr("it hangs, or uses another transport"),
                           HasSubstr("`musher doctor`"), Not(HasSubstr("keys"))));
  controller_.security.reset();
  EXPECT_THAT(Why(), HasSubstr("or has [security] (--keys FOLDER)"));
}

}  // namespace musher::cli::silent_controller_test
