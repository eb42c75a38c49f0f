// Participants without permission: without keys, with keys of another robot, with revoked keys.
//
// That an unauthorized participant receives nothing is evidence only while others receive: each
// test waits until a permitted process has received many of the samples that the unauthorized one
// has not.

#include "musher/test/security/secured_machine.hpp"

namespace musher::testing::unauthorized_test {

using ::testing::HasSubstr;
using ::testing::Not;

class UnauthorizedParticipants : public SecuredMachine {
 protected:
  // What the participant publishes all the time, and all topics that it subscribes to.
  static std::vector<std::string> EverythingBad() {
    return {"announce", "pose:legs",  "pose:legs:legs", "command:legs",  "serve:voice",
            "stop",     "set:Active", "subscribe:chat", "publish:gossip"};
  }
  // Ends the participant; it has matched no other.
  static void ExpectWasAlone(Process& participant) {
    participant.Signal(SIGTERM);
    const std::string said = participant.Wait().out;
    EXPECT_THAT(said, HasSubstr("ready"));
    for (const char* word :
         {"machine ", "heartbeat ", "received ", "answered", "called", "refused"}) {
      EXPECT_THAT(said, Not(HasSubstr(word)));
    }
  }
  // A permitted process has received many samples of a friend, and none of the participant.
  void AwaitMuchTalk() const {
    const auto talker = Peer(keys_, "voice", {"publish:chat"});
    const auto subscriber = Peer(keys_, "operator", {"subscribe:chat", "subscribe:gossip"});
    for (int i = 0; i < 200; ++i) ASSERT_NE(subscriber->LineWith("received chat"), "");
    subscriber->Signal(SIGTERM);
    EXPECT_THAT(subscriber->Wait().out, Not(HasSubstr("received gossip")));
  }
};

TEST_F(UnauthorizedParticipants, WithoutKeysReceiveNothingAndChangeNothing) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const auto participant = Liar("-", "-", EverythingBad());
  ASSERT_NO_FATAL_FAILURE(AwaitMuchTalk());
  ExpectTheMachineIsSound();
  ExpectWasAlone(*participant);
}

TEST_F(UnauthorizedParticipants, WithoutKeysGetTheMissingKeyFromTheCommandLine) {
  ASSERT_NO_FATAL_FAILURE(Start());
  unsetenv("MUSHER_KEYS");
  const Ended status = Musher({"status"});
  EXPECT_EQ(status.exit, 3);
  EXPECT_THAT(
      status.err,
      HasSubstr("is unreachable without keys: the machine has [security]; use --keys FOLDER"));
  EXPECT_EQ(Musher({"set", "Active", "--timeout", "1"}).exit, 3);
  // The names that the actuators hold on this host are known without keys.
  EXPECT_EQ(Musher({"estop", "--timeout", "1"}).exit, 1);
  setenv("MUSHER_KEYS", keys_.c_str(), 1);
  EXPECT_EQ(Status()["state"], "LowPower");
}

TEST_F(UnauthorizedParticipants, OfAnotherRobotAreUnauthorizedHere) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const std::string foreign = folder_ / "foreign";
  ASSERT_EQ(Musher({"keys", "init", foreign}).exit, 0);
  const auto participant = Liar(foreign, "controller", EverythingBad());
  ASSERT_NO_FATAL_FAILURE(AwaitMuchTalk());
  ExpectTheMachineIsSound();
  ExpectWasAlone(*participant);
  const Ended status = Musher({"status", "--keys", foreign, "--timeout", "1"});
  EXPECT_EQ(status.exit, 3);
  EXPECT_THAT(status.err,
              HasSubstr("the keys of operator in " + foreign + " are not of its machine"));
}

// The revoked one keeps the folder as it was, so that nothing on its own side stops it.
TEST_F(UnauthorizedParticipants, AreThoseWithARevokedCertificateOnceTheMachineIsRestarted) {
  Identity("fired", "operator");
  const std::string kept = folder_ / "kept";
  std::filesystem::copy(keys_, kept, std::filesystem::copy_options::recursive);
  ASSERT_NO_FATAL_FAILURE(Start());
  EXPECT_EQ(Musher({"status", "--keys", kept, "--identity", "fired"}).exit, 0);
  const Ended revoke = Musher({"keys", "revoke", "fired"});
  EXPECT_EQ(revoke.exit, 0) << revoke.err;
  EXPECT_THAT(revoke.out, HasSubstr("copy it into the folder\nof credentials on every host"));
  ASSERT_EQ(Musher({"down"}).exit, 0);
  ASSERT_NO_FATAL_FAILURE(Start());

  const auto participant = Liar(kept, "fired", EverythingBad());
  ASSERT_NO_FATAL_FAILURE(AwaitMuchTalk());
  ExpectTheMachineIsSound();
  ExpectWasAlone(*participant);
  const Ended set =
      Musher({"set", "Active", "--keys", kept, "--identity", "fired", "--timeout", "1"});
  EXPECT_EQ(set.exit, 3) << set.out;
  const Ended own_side = As("fired", {"status"});
  EXPECT_EQ(own_side.exit, 2);
  EXPECT_THAT(own_side.err, HasSubstr("fired.cert is revoked in " + keys_ + "/revoked.crl"));
}

}  // namespace musher::testing::unauthorized_test
