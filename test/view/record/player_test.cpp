// The player on the simulated transport, in virtual time.

#include "musher/view/record/player.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/messages/std_msgs/string.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::view::player_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::int64_t kFrom = 1'780'000'000'000'000'000;
constexpr std::int64_t kMs = 1'000'000;

std::int64_t NanosecondsOf(const msg::Stamp& stamp) {
  return std::int64_t{stamp.sec} * 1'000'000'000 + stamp.nanosec;
}

// "one", "two", "three" on /chat, 100 ms and 300 ms apart.
class Chat : public PlaySource {
 public:
  const std::vector<PlayedChannel>& channels() const override { return channels_; }
  Result<std::optional<PlayedMessage>> Next() override {
    constexpr std::int64_t kTimes[] = {0, 100, 400};
    constexpr const char* kTexts[] = {"one", "two", "three"};
    if (next_ == 3) return std::optional<PlayedMessage>();
    if (next_ == broken_at) return Error{kCodeFailed, "a chunk is cut off"};
    msg::String message;
    message.data = kTexts[next_];
    PlayedMessage played{0, kFrom + kTimes[next_] * kMs, msg::Encode(message)};
    ++next_;
    return std::optional<PlayedMessage>(std::move(played));
  }
  Result<> Rewind() override {
    next_ = 0;
    return Ok();
  }

  int broken_at = -1;

 private:
  std::vector<PlayedChannel> channels_ = {
      {"/chat", std::string(msg::String::kTypeName), transport::kDefaultQos}};
  int next_ = 0;
};

class Playing : public ::testing::Test {
 protected:
  Playing() {
    subscription_ = transport::MakeSubscription<msg::String>(
                        *dog_, "chat",
                        [this](const msg::String& message, const transport::SampleInfo&) {
                          texts_.push_back(message.data);
                          times_.push_back(network_.now());
                        })
                        .value();
    clock_ = transport::MakeSubscription<msg::Clock>(
                 *dog_, transport::kClockTopic,
                 [this](const msg::Clock& message, const transport::SampleInfo&) {
                   clock_ns_.push_back(NanosecondsOf(message.clock));
                 })
                 .value();
  }
  void Play(PlayOptions options) {
    player_ = Player::Start(*desk_, source_, std::move(options), [this](const Result<>& result) {
                end_ = result ? "done" : result.error().message;
              }).value();
  }
  double GapMs(std::size_t i) const {
    return std::chrono::duration<double, std::milli>(times_[i + 1] - times_[i]).count();
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> dog_ = network_.MakeNode("dog");
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  Chat source_;
  std::vector<std::string> texts_;
  std::vector<Time> times_;
  std::vector<std::int64_t> clock_ns_;
  std::string end_;
  std::unique_ptr<transport::Subscription> subscription_;
  std::unique_ptr<transport::Subscription> clock_;
  std::unique_ptr<Player> player_;
};

TEST_F(Playing, MessagesComeInTheirOrderWithTheirGaps) {
  Play({});
  network_.RunFor(std::chrono::seconds(3));
  EXPECT_THAT(texts_, ElementsAre("one", "two", "three"));
  EXPECT_NEAR(GapMs(0), 100, 10);
  EXPECT_NEAR(GapMs(1), 300, 10);
  EXPECT_EQ(end_, "done");
  EXPECT_EQ(player_->published(), 3U);
}

TEST_F(Playing, TwiceAsFastTheGapsAreHalf) {
  PlayOptions options;
  options.rate = 2;
  Play(options);
  network_.RunFor(std::chrono::seconds(3));
  EXPECT_NEAR(GapMs(0), 50, 10);
  EXPECT_NEAR(GapMs(1), 150, 10);
}

TEST_F(Playing, TheClockIsTheTimeOfTheRecording) {
  Play({});
  network_.RunFor(std::chrono::seconds(3));
  ASSERT_GT(clock_ns_.size(), 30U);
  EXPECT_LT(std::abs(clock_ns_.front() - kFrom), 20 * kMs);
  EXPECT_LT(std::abs(clock_ns_.back() - kFrom - 400 * kMs), 20 * kMs);
  EXPECT_TRUE(std::is_sorted(clock_ns_.begin(), clock_ns_.end()));
}

TEST_F(Playing, WithoutAClockNoneIsPublished) {
  PlayOptions options;
  options.clock = false;
  Play(options);
  network_.RunFor(std::chrono::seconds(3));
  EXPECT_THAT(clock_ns_, IsEmpty());
}

TEST_F(Playing, InALoopItBeginsAgain) {
  PlayOptions options;
  options.loop = true;
  Play(options);
  network_.RunFor(Milliseconds(500 + 400 + 250));
  EXPECT_THAT(texts_, ElementsAre("one", "two", "three", "one", "two"));
  EXPECT_EQ(end_, "");
}

TEST_F(Playing, ARemappedTopicHasItsOtherName) {
  PlayOptions options;
  options.remapping = TopicNames::Of({"/chat:=/old/chat"}).value();
  Play(options);
  network_.RunFor(std::chrono::seconds(3));
  EXPECT_THAT(texts_, IsEmpty());
}

TEST_F(Playing, CommandsThatAreWithheldAreLostAndNothingElseIs) {
  std::vector<std::string> commands;
  const auto wheels = transport::MakeSubscription<msg::String>(
      *dog_, "cmd_vel", [&](const msg::String& message, const transport::SampleInfo&) {
        commands.push_back(message.data);
      });
  int asked = 0;
  PlayOptions options;
  options.remapping = TopicNames::Of({"/chat:=/cmd_vel"}).value();
  options.withholds_commands = [&] { return ++asked == 2; };
  Play(options);
  network_.RunFor(std::chrono::seconds(3));
  EXPECT_THAT(commands, ElementsAre("one", "three"));
  EXPECT_EQ(player_->published(), 2U);
  options = {};
  options.withholds_commands = [] { return true; };
  ASSERT_TRUE(source_.Rewind());
  Play(options);
  network_.RunFor(std::chrono::seconds(3));
  EXPECT_THAT(texts_, ElementsAre("one", "two", "three"));
}

TEST_F(Playing, ADamagedRecordingIsPlayedUpToTheDamageAndTheReasonIsGiven) {
  source_.broken_at = 2;
  Play({});
  network_.RunFor(std::chrono::seconds(3));
  EXPECT_THAT(texts_, ElementsAre("one", "two"));
  EXPECT_EQ(end_, "a chunk is cut off");
}

}  // namespace musher::view::player_test
