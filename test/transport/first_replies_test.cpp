// When a reply goes out to a ROS 2 client whose reader has just been matched, in virtual time.

#include "musher/transport/dds/first_replies.hpp"

#include <gmock/gmock.h>

#include <utility>
#include <vector>

#include "musher/transport/sim/sim_loop.hpp"

namespace musher::transport::first_replies_test {

using dds::FirstReplies;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr ParticipantId kNewcomer = 100;
constexpr ParticipantId kOther = 200;

// A reply to client 7, identified by its last byte.
msg::Bytes ReplyOf(int number) {
  msg::Bytes bytes(32, std::byte{0});
  bytes[4] = std::byte{7};
  bytes.back() = static_cast<std::byte>(number);
  return bytes;
}

class RepliesOfAServer : public ::testing::Test {
 protected:
  struct Sent {
    int number;
    int client;
    std::int64_t at_ms;
    friend bool operator==(const Sent&, const Sent&) = default;
  };

  void Write(int number, ParticipantId participant = kNewcomer) {
    EXPECT_TRUE(replies_.Write(ReplyOf(number), participant));
  }
  void Run(int ms) {
    sim::RunEventsUntil(
        scheduler_, [] { return false; }, scheduler_.now() + Milliseconds(ms));
  }

  sim::Scheduler scheduler_;
  sim::Links links_;
  sim::SimLoop loop_{scheduler_, scheduler_.AddProcess(), links_, links_.Host("robot")};
  const Time begin_ = loop_.Now();
  std::vector<Sent> sent_;
  FirstReplies replies_{
      loop_, [this](const msg::Bytes& bytes) {
        sent_.push_back({static_cast<int>(bytes.back()), static_cast<int>(bytes[4]),
                         ToMilliseconds(loop_.Now() - begin_)});
        return Ok();
      }};
};

TEST_F(RepliesOfAServer, AreSentTogetherBeforeMoreAreHeldThanAWriterKeeps) {
  replies_.OnNewReader(kNewcomer);
  for (int number = 1; number <= 7; ++number) Write(number);
  EXPECT_THAT(sent_, IsEmpty());
  Write(8);
  EXPECT_THAT(sent_, SizeIs(8)) << "a writer can repeat its last 10 samples";
}

TEST_F(RepliesOfAServer, AreSentAtOnceWhereNoReaderIsNew) {
  Write(1);
  EXPECT_THAT(sent_, ElementsAre(Sent{1, 7, 0}));
  Run(1000);
  EXPECT_THAT(sent_, SizeIs(1));
}

TEST_F(RepliesOfAServer, AreSentBeforeWhatWaitsForThem) {
  std::vector<std::size_t> sent;
  const auto note = [&] { sent.push_back(sent_.size()); };
  replies_.AfterHeld(note);
  EXPECT_THAT(sent, ElementsAre(0)) << "at once, where nothing is held";
  replies_.OnNewReader(kNewcomer);
  Write(1);
  replies_.AfterHeld(note);
  EXPECT_THAT(sent, SizeIs(1));
  Run(12);
  EXPECT_THAT(sent, ElementsAre(0, 1));
  for (int number = 2; number <= 9; ++number) Write(number);
  replies_.AfterHeld(note);
  EXPECT_THAT(sent, SizeIs(3)) << "also where they were sent early because they are many";
}

TEST_F(RepliesOfAServer, AreHeldForANewReaderAndFollowedByACopyForNoClient) {
  replies_.OnNewReader(kNewcomer);
  Write(1);
  EXPECT_THAT(sent_, IsEmpty());
  Run(1000);
  EXPECT_THAT(sent_, ElementsAre(Sent{1, 7, 12}, Sent{1, 0, 122}));
}

TEST_F(RepliesOfAServer, KeepTheirOrder) {
  replies_.OnNewReader(kNewcomer);
  Run(495);
  Write(1);
  Run(6);  // the reader is no longer new, but a reply is held
  Write(2);
  Run(1000);
  EXPECT_THAT(sent_, ElementsAre(Sent{1, 7, 507}, Sent{2, 7, 507}, Sent{2, 0, 617}));
}

TEST_F(RepliesOfAServer, GoOutWhenTheServerEnds) {
  replies_.OnNewReader(kNewcomer);
  Write(1);
  replies_.Release();
  EXPECT_THAT(sent_, ElementsAre(Sent{1, 7, 0}));
}

// Each new client of ROS 2 slowed all clients of the service: 10,000 calls took 19 s instead of 2
// s.
TEST_F(RepliesOfAServer, ToOthersAreNotHeldForANewReader) {
  replies_.OnNewReader(kNewcomer);
  Write(1, kNewcomer);
  for (int number = 2; number <= 20; ++number) Write(number, kOther);
  EXPECT_THAT(sent_, SizeIs(19));
  for (const Sent& sent : sent_) EXPECT_EQ(sent.at_ms, 0);
  Run(12);
  EXPECT_EQ(sent_.back(), (Sent{1, 7, 12}));
}

TEST_F(RepliesOfAServer, ToOthersThatANewReaderMayHaveMissedAreFollowedByACopyForNoClient) {
  replies_.OnNewReader(kNewcomer);
  for (int number = 1; number <= 3; ++number) Write(number, kOther);
  Run(1000);
  EXPECT_THAT(sent_, ElementsAre(Sent{1, 7, 0}, Sent{2, 7, 0}, Sent{3, 7, 0}, Sent{1, 0, 110}));
}

TEST_F(RepliesOfAServer, ThatAreLargeAreNotCopied) {
  replies_.OnNewReader(kNewcomer);
  msg::Bytes large(5000, std::byte{0});
  EXPECT_TRUE(replies_.Write(std::move(large), kNewcomer));
  Run(1000);
  EXPECT_THAT(sent_, SizeIs(1));
}

}  // namespace musher::transport::first_replies_test
