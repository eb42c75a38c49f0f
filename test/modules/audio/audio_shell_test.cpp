// Topics and services of the audio module, on the simulated network, in virtual time.

#include <gmock/gmock.h>

#include <optional>
#include <string>
#include <vector>

#include "musher/test/modules/audio/voice_on_a_network.hpp"

namespace musher::audio::audio_shell_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

using testing::VoiceOnANetwork;

class ListeningOnANetwork : public VoiceOnANetwork {
 protected:
  ListeningOnANetwork() { network_.RunFor(Milliseconds(500)); }
  void Say(const std::string& text) {
    ASSERT_TRUE(said_->Publish({text}));
    network_.RunFor(Milliseconds(100));
  }

  std::vector<std::string> texts_;
  int wake_ups_ = 0;
  std::unique_ptr<transport::Publisher<msg::String>> said_ =
      transport::MakePublisher<msg::String>(*desk_, "dog1/world/speech_text").value();
  std::unique_ptr<transport::Subscription> text_subscription_ =
      transport::MakeSubscription<msg::String>(
          *desk_, "dog1/asr_text",
          [this](const msg::String& text, const auto&) { texts_.push_back(text.data); })
          .value();
  std::unique_ptr<transport::Subscription> wake_up_subscription_ =
      transport::MakeSubscription<msg::Bool>(*desk_, "dog1/dog_wakeup", [this](const auto&...) {
        ++wake_ups_;
      }).value();
};

TEST_F(ListeningOnANetwork, PublishesRecognisedTextsAndTheWakeWord) {
  Say("sit down");
  EXPECT_EQ(wake_ups_, 0);
  Say("铁蛋铁蛋, sit down");
  EXPECT_THAT(texts_, ElementsAre("sit down", "铁蛋铁蛋, sit down"));
  EXPECT_EQ(wake_ups_, 1);
  Say("\xff");
  EXPECT_EQ(texts_.size(), 2U);
  EXPECT_THAT(log_, HasSubstr("world/speech_text: refused"));
}

TEST_F(ListeningOnANetwork, PublishesWhenItSpeaksWhenItEndsAndWhenATextWasRecognised) {
  std::vector<int> states;
  const auto subscription =
      transport::MakeSubscription<msg::UInt8>(
          *desk_, "dog1/audio_board_state",
          [&](const msg::UInt8& state, const auto&) { states.push_back(state.data); })
          .value();
  network_.RunFor(Milliseconds(500));
  Answer answer;
  VoiceOnANetwork::Say("twenty characters...", answer);
  network_.RunFor(Milliseconds(3'000));
  Say("sit down");
  EXPECT_THAT(states, ElementsAre(3, 0, 2));
}

TEST_F(ListeningOnANetwork, PublishesNoTextWhileTheMicrophoneIsOff) {
  Call<msg::AudioExecute>("set_audio_state", {"app", {msg::AudioStatus::kOffMic}});
  Say("铁蛋铁蛋");
  EXPECT_THAT(texts_, ElementsAre());
  EXPECT_EQ(wake_ups_, 0);
}

// It stood up by a word that was said long before.
TEST_F(ListeningOnANetwork, PublishesNoTextThatWaitedWhileItsProcessWasStopped) {
  network_.Pause(*robot_);
  Say("铁蛋铁蛋");
  network_.RunFor(std::chrono::seconds(20));
  network_.Resume(*robot_);
  network_.RunFor(Milliseconds(2'500));
  EXPECT_THAT(texts_, ElementsAre());
  EXPECT_EQ(wake_ups_, 0);
  EXPECT_THAT(log_, HasSubstr("a recognised text is dropped: this process could not run for 2"));
  Say("铁蛋铁蛋");
  EXPECT_EQ(wake_ups_, 1);
}

TEST_F(ListeningOnANetwork, WakesByItsConfiguredName) {
  EXPECT_TRUE(Call<msg::AudioNickName>("set_nick_name", {"Rex", "hey Rex"}).success);
  Say("hey Rex, come");
  EXPECT_EQ(wake_ups_, 1);
  EXPECT_TRUE(Call<msg::SetBool>("nick_name_switch", {false}).success);
  Say("hey Rex, come");
  EXPECT_EQ(wake_ups_, 1) << "its own name is off";
  const auto refused = Call<msg::AudioNickName>("set_nick_name", {"Rex", ""});
  EXPECT_FALSE(refused.success);
  EXPECT_EQ(refused.code, 5010);
}

TEST_F(ListeningOnANetwork, RepliesThatThereIsNoAccount) {
  const auto answer = Call<msg::ProtocolTrigger>("audio_active_state", {"account 7"});
  EXPECT_FALSE(answer.success);
  EXPECT_EQ(answer.code, 5008);
}

TEST_F(VoiceOnANetwork, AnswersATextAtTheEndOfItsSound) {
  Answer answer;
  Say("twenty characters...", answer);
  network_.RunFor(Milliseconds(1'950));
  EXPECT_FALSE(answer);
  network_.RunFor(Milliseconds(100));
  ASSERT_TRUE(answer);
  EXPECT_EQ(*answer, (msg::AudioTextPlay::Response{0, 0}));
  EXPECT_THAT(reports_, ElementsAre(true, true, true, true, false));
}

TEST_F(VoiceOnANetwork, AnswersALongerTextAfterTenSeconds) {
  Answer answer;
  Say(std::string(200, 'a'), answer);
  network_.RunFor(Milliseconds(9'950));
  EXPECT_FALSE(answer);
  network_.RunFor(Milliseconds(100));
  ASSERT_TRUE(answer);
  EXPECT_EQ(*answer, (msg::AudioTextPlay::Response{1, 5007}));
}

TEST_F(VoiceOnANetwork, PlaysAPhraseWhereTheRequestIsNotOnline) {
  Answer answer;
  RequestText({"manager", false, {"manager", 60}, "not this"}, answer);
  network_.RunFor(Milliseconds(1'000));
  EXPECT_EQ(answer, (msg::AudioTextPlay::Response{0, 0}));
  EXPECT_THAT(log_, HasSubstr(R"(plays "all well" for "manager")"));
}

TEST_F(VoiceOnANetwork, IsInterruptedByBothTopics) {
  Answer first;
  Say(std::string(50, 'a'), first);
  network_.RunFor(Milliseconds(500));
  ASSERT_TRUE(play_->Publish({"app", 60}));
  network_.RunFor(Milliseconds(100));
  EXPECT_EQ(first, (msg::AudioTextPlay::Response{1, 5021}));
  ASSERT_TRUE(extended_->Publish({"app", true, {}, "hello"}));
  network_.RunFor(Milliseconds(300));
  EXPECT_THAT(log_, HasSubstr(R"(plays "hello" for "app")"));
  ASSERT_TRUE(extended_->Publish({"app", false, {"app", 60}, "not this"}));
  network_.RunFor(Milliseconds(2'000));
  EXPECT_THAT(log_, ::testing::Not(HasSubstr("not this")));
  EXPECT_FALSE(reports_.back());
}

TEST_F(VoiceOnANetwork, PlaysCuesOfAbsoluteTopicsAndOfThoseInItsNamespace) {
  const auto urgent = transport::MakePublisher<msg::String>(*desk_, "show/play").value();
  const auto publisher = transport::MakePublisher<msg::String>(*desk_, "dog1/show/say").value();
  network_.RunFor(Milliseconds(500));
  EXPECT_EQ(urgent->MatchedReaders(), 1);
  EXPECT_EQ(publisher->MatchedReaders(), 1);
  Answer first;
  Say(std::string(30, 'a'), first);
  network_.RunFor(Milliseconds(100));
  ASSERT_TRUE(publisher->Publish({"greeting"}));
  network_.RunFor(Milliseconds(2'500));
  EXPECT_THAT(log_, ::testing::Not(HasSubstr("welcome")));
  network_.RunFor(Milliseconds(1'000));
  EXPECT_THAT(log_, HasSubstr(R"(plays "welcome" for "greeting")"));
  Answer second;
  Say(std::string(30, 'b'), second);
  network_.RunFor(Milliseconds(1'000));
  ASSERT_TRUE(urgent->Publish({"shutter"}));
  network_.RunFor(Milliseconds(100));
  EXPECT_EQ(second, (msg::AudioTextPlay::Response{1, 5021}));
  EXPECT_THAT(log_, HasSubstr(R"(plays "/sounds/shutter.wav" for "shutter")"));
}

TEST_F(VoiceOnANetwork, FallsSilentByStopPlay) {
  Answer first;
  Answer second;
  Say(std::string(50, 'a'), first);
  Say(std::string(50, 'b'), second);
  network_.RunFor(Milliseconds(500));
  Call<msg::EmptyService>("stop_play", {});
  EXPECT_EQ(first, (msg::AudioTextPlay::Response{1, 5022}));
  EXPECT_EQ(second, (msg::AudioTextPlay::Response{1, 5022}));
  EXPECT_FALSE(reports_.back());
  network_.RunFor(Milliseconds(10'000));
  EXPECT_THAT(log_, ::testing::Not(HasSubstr("bbb")));
}

TEST_F(VoiceOnANetwork, KeepsItsVolumeAndRefusesOneOutOfRange) {
  EXPECT_EQ(Call<msg::AudioVolumeGet>("audio_volume_get", {}),
            (msg::AudioVolumeGet::Response{60, 0}));
  EXPECT_EQ(Call<msg::AudioVolumeSet>("audio_volume_set", {25}),
            (msg::AudioVolumeSet::Response{true, 0}));
  EXPECT_EQ(Call<msg::AudioVolumeSet>("audio_volume_set", {101}),
            (msg::AudioVolumeSet::Response{false, 5010}));
  EXPECT_EQ(Call<msg::AudioVolumeGet>("audio_volume_get", {}),
            (msg::AudioVolumeGet::Response{25, 0}));
}

TEST_F(VoiceOnANetwork, KeepsTheMicrophoneAndTheVoiceControl) {
  using Execute = msg::AudioExecute;
  EXPECT_EQ(Call<Execute>("get_audio_state", {}), (Execute::Response{false, 0}));
  EXPECT_EQ(Call<Execute>("set_audio_state", {"app", {msg::AudioStatus::kOffMic}}),
            (Execute::Response{true, 0}));
  EXPECT_EQ(Call<Execute>("get_audio_state", {}), (Execute::Response{true, 0}));
  EXPECT_EQ(Call<Execute>("set_audio_state", {"app", {9}}), (Execute::Response{false, 5010}));

  EXPECT_EQ(Call<msg::Trigger>("audio_action_get", {}), (msg::Trigger::Response{true, "on"}));
  shell_->Enter(State(kOta));
  EXPECT_EQ(Call<msg::Trigger>("audio_action_get", {}), (msg::Trigger::Response{false, "off"}));
  EXPECT_EQ(Call<msg::SetBool>("audio_action_set", {true}),
            (msg::SetBool::Response{false, "the state of the machine does not allow it"}));
  shell_->Enter(State(kActive));
  EXPECT_EQ(Call<msg::SetBool>("audio_action_set", {true}), (msg::SetBool::Response{true, ""}));
}

TEST_F(VoiceOnANetwork, ListsItsPhrases) {
  using Query = msg::SdcardPlayIdQuery;
  EXPECT_EQ(Call<Query>("sdcard_playid_query", {1042}), (Query::Response{true, 0}));
  EXPECT_EQ(Call<Query>("sdcard_playid_query", {1101}), (Query::Response{false, 0}));
}

TEST_F(VoiceOnANetwork, AnswersNoCallerAfterItsDestruction) {
  Answer answer;
  Say("hello", answer);
  network_.RunFor(Milliseconds(100));
  shell_.reset();
  network_.RunFor(Milliseconds(2'000));
  EXPECT_FALSE(answer);
}

}  // namespace musher::audio::audio_shell_test
