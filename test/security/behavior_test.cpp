// The state of an application's state machine, queried in a machine with [security].

#include <filesystem>

#include "musher/test/security/secured_machine.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::testing::behavior_test {

using ::testing::HasSubstr;

class SecuredApplication : public SecuredMachine {
 protected:
  SecuredApplication() {
    const std::string states = R"(["SetUp", "TearDown", "SelfCheck", "Active"])";
    std::ofstream(config_) << "[controller]\nname = \"robot\"\nactuators = [\"show\"]\nstates = "
                           << states << "\ndefault_time = 5000\nnamespace = \"" << name_space_
                           << "\"\ndefault_state = \"Uninitialized\"\nstate_dir = \"state\"\n"
                           << "[actuator.show]\nstates = " << states
                           << "\ntimes = [9000, 5000, 5000, 5000]\ncritical = true\n"
                           << "command = [\"" + BinDir() + "/application_peer\"]\n"
                           << "[security]\nkeys = \"keys\"\n";
    std::filesystem::remove_all(keys_);
    EXPECT_EQ(Musher({"keys", "init", config_}).exit, 0);
  }
};

TEST_F(SecuredApplication, ShowsItsStateToParticipantsWithKeysAlsoToObservers) {
  const Ended up = UpDetached();
  ASSERT_EQ(up.exit, 0) << up.out << up.err;
  Identity("visitor", "observer");
  for (const char* identity : {"operator", "visitor"}) {
    const Ended shown = As(identity, {"behavior", "show"});
    EXPECT_EQ(shown.exit, 0) << shown.err;
    EXPECT_THAT(shown.out, HasSubstr("show  WORK  NORMAL"));
  }
  const Ended sent = As("operator", {"behavior", "show", "--send", "go"});
  EXPECT_EQ(sent.exit, 0) << sent.err;
  EXPECT_EQ(sent.out, "sent go to show\n");
  const Ended observer = As("visitor", {"behavior", "show", "--send", "go", "--timeout", "2"});
  EXPECT_NE(observer.exit, 0) << "an observer commands nothing";
  EXPECT_THAT(observer.err, HasSubstr("visitor may not do that"));
  const Ended unknown = As("operator", {"behavior", "shwo"});
  EXPECT_THAT(unknown.err, HasSubstr("did you mean 'show'?"));
  unsetenv("MUSHER_KEYS");
  EXPECT_EQ(Musher({"behavior", "show"}).exit, 3)
      << "an unauthenticated participant receives nothing";
}

}  // namespace musher::testing::behavior_test
