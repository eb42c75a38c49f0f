// How the decoder handles bytes of other encoders: other byte orders, truncated and hostile
// samples.

#include <gtest/gtest.h>

#include <initializer_list>

#include "musher/messages/builtin_interfaces/time.hpp"
#include "musher/messages/musher_msgs/actuator_command.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/contract/fill.hpp"
#include "musher/transport/sim/random.hpp"

namespace musher::msg::cdr_test {

Bytes MakeBytes(std::initializer_list<int> values) {
  Bytes bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

struct Mixed {
  bool flag = false;
  std::int16_t small = 0;
  std::uint32_t medium = 0;
  double large = 0;
  std::string text;
  std::vector<std::uint16_t> items;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.flag, m.small, m.medium, m.large, m.text, m.items);
  }
  friend bool operator==(const Mixed&, const Mixed&) = default;
};

TEST(Cdr, DecodesBigEndianSamples) {
  const Bytes bytes = MakeBytes({0,    0,    0,    0,                             // big-endian
                                 1,    0,    0xff, 0xfe, 0x01, 0x02, 0x03, 0x04,  //
                                 0x3f, 0xf8, 0,    0,    0,    0,    0,    0,     // 1.5
                                 0,    0,    0,    3,    'h',  'i',  0,    0,     // padded
                                 0,    0,    0,    2,    0x12, 0x34, 0x56, 0x78});
  const auto message = Decode<Mixed>(bytes);
  ASSERT_TRUE(message);
  EXPECT_EQ(*message, (Mixed{true, -2, 0x01020304, 1.5, "hi", {0x1234, 0x5678}}));
}

TEST(Cdr, EncodesLittleEndianWithPaddingBetweenFields) {
  const Bytes expected = MakeBytes({0, 1, 0,    0,                             // little-endian
                                    1, 0, 0xfe, 0xff, 0x04, 0x03, 0x02, 0x01,  //
                                    0, 0, 0,    0,    0,    0,    0xf8, 0x3f,  // 1.5
                                    3, 0, 0,    0,    'h',  'i',  0,    0,     // padded
                                    2, 0, 0,    0,    0x34, 0x12, 0x78, 0x56});
  EXPECT_EQ(Encode(Mixed{true, -2, 0x01020304, 1.5, "hi", {0x1234, 0x5678}}), expected);
}

struct Blocks {
  std::uint8_t before = 0;
  std::vector<double> numbers;
  std::vector<std::uint8_t> none;
  std::array<std::int16_t, 2> pair{};
  std::vector<std::int8_t> bytes;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.before, m.numbers, m.none, m.pair, m.bytes);
  }
  friend bool operator==(const Blocks&, const Blocks&) = default;
};

TEST(Cdr, SequencesOfNumbersAreAlignedLikeTheirItems) {
  const Blocks blocks{1, {1.5}, {}, {-2, 3}, {-1, 2}};
  const Bytes little = MakeBytes({0, 1, 0, 0,                          //
                                  1, 0, 0, 0, 1,    0,    0,    0,     //
                                  0, 0, 0, 0, 0,    0,    0xf8, 0x3f,  // 1.5
                                  0, 0, 0, 0, 0xfe, 0xff, 3,    0,     // none, the pair
                                  2, 0, 0, 0, 0xff, 2});
  EXPECT_EQ(Encode(blocks), little);
  EXPECT_EQ(Decode<Blocks>(little), blocks);
  const Bytes big = MakeBytes({0,    0,    0, 0,                    //
                               1,    0,    0, 0, 0,    0,    0, 1,  //
                               0x3f, 0xf8, 0, 0, 0,    0,    0, 0,  //
                               0,    0,    0, 0, 0xff, 0xfe, 0, 3,  //
                               0,    0,    0, 2, 0xff, 2});
  EXPECT_EQ(Decode<Blocks>(big), blocks);
  for (std::size_t size = 0; size < little.size(); ++size) {
    EXPECT_FALSE(Decode<Blocks>(std::span(little).first(size))) << size;
  }
}

TEST(Cdr, RefusesOtherEncapsulations) {
  Bytes bytes = Encode(String{"hello"});
  for (const int kind : {2, 3, 6, 7, 0x10, 0xff}) {  // parameter lists, XCDR2, nonsense
    bytes[1] = static_cast<std::byte>(kind);
    EXPECT_FALSE(Decode<String>(bytes)) << kind;
  }
  bytes[1] = std::byte{1};
  bytes[0] = std::byte{1};
  EXPECT_FALSE(Decode<String>(bytes));
}

TEST(Cdr, IgnoresBytesAfterTheLastField) {
  Bytes bytes = Encode(String{"hello"});
  bytes.resize(bytes.size() + 3);
  EXPECT_EQ(Decode<String>(bytes), String{"hello"});
}

TEST(Cdr, RefusesEveryTruncatedSample) {
  const Bytes bytes = Encode(Filled<PlanStep>());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(Decode<PlanStep>(std::span(bytes).first(size))) << size;
  }
}

struct Older {
  std::string name;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.name);
  }
};

struct Newer {
  std::string name;
  bool flag = false;
  std::vector<std::string> words;

  static constexpr std::size_t kAppended = 2;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.name, m.flag, m.words);
  }
  friend bool operator==(const Newer&, const Newer&) = default;
};

struct Reply {
  std::int32_t code = 0;
  Newer status;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.code, m.status);
  }
};

TEST(Cdr, ReadsWhatAnOlderPeerSendsWithoutTheFieldsThatWereAppendedSince) {
  Bytes bytes = Encode(Older{"dog"});
  EXPECT_EQ(Decode<Newer>(bytes), (Newer{"dog", false, {}}));
  bytes.resize((bytes.size() + 3) / 4 * 4);  // as some transports pad it
  EXPECT_EQ(Decode<Newer>(bytes), (Newer{"dog", false, {}}));
}

TEST(Cdr, IsReadByAnOlderPeerUpToItsLastField) {
  const auto older = Decode<Older>(Encode(Newer{"dog", true, {"sit"}}));
  ASSERT_TRUE(older);
  EXPECT_EQ(older->name, "dog");
}

TEST(Cdr, KeepsWhatWasAppendedAlsoAtTheEndOfAnotherMessage) {
  const auto reply = Decode<Reply>(Encode(Reply{7, {"dog", true, {"sit", "stay"}}}));
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->status, (Newer{"dog", true, {"sit", "stay"}}));
}

TEST(Cdr, RefusesWhatIsCutInTheMiddleOfAnAppendedField) {
  const Bytes bytes = Encode(Newer{"dog", true, {"sit", "stay"}});
  for (std::size_t size = bytes.size() - 1; size > bytes.size() - 10; --size) {
    EXPECT_FALSE(Decode<Newer>(std::span(bytes).first(size))) << size;
  }
}

TEST(Cdr, RefusesLengthsBeyondTheSample) {
  for (const int top : {0x00, 0x7f, 0xff}) {
    EXPECT_FALSE(Decode<String>(MakeBytes({0, 1, 0, 0, 9, 0, 0, top, 'h', 'i', 0, 0})));
    EXPECT_FALSE(Decode<Mixed>(MakeBytes({0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                                          0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 9, 0, 0, top})));
  }
}

TEST(Cdr, RefusesStringsThatDoNotEndAndTruthThatIsNeither) {
  EXPECT_FALSE(Decode<String>(MakeBytes({0, 1, 0, 0, 2, 0, 0, 0, 'h', 'i'})));
  EXPECT_FALSE(Decode<String>(MakeBytes({0, 1, 0, 0, 0, 0, 0, 0})));  // not even the zero
  Bytes mixed = Encode(Filled<Mixed>());
  mixed[4] = std::byte{2};
  EXPECT_FALSE(Decode<Mixed>(mixed));
}

TEST(Stamp, CountsNanosecondsForwardsAlsoBeforeZero) {
  using std::chrono::nanoseconds;
  EXPECT_EQ(ToStamp(nanoseconds(1'500'000'000)), (Stamp{1, 500'000'000}));
  EXPECT_EQ(ToStamp(nanoseconds(-1)), (Stamp{-1, 999'999'999}));
  for (const std::int64_t time : {-1'500'000'000LL, -1LL, 0LL, 1LL, 1'000'000'000LL}) {
    EXPECT_EQ(FromStamp(ToStamp(nanoseconds(time))), nanoseconds(time));
  }
}

// For the sanitizers: whatever is decoded, nothing is read beyond the buffer.
TEST(Cdr, SurvivesDamagedSamples) {
  transport::sim::Random random(1);
  const Bytes good = Encode(Filled<SetState::Response>());
  int decoded = 0;
  for (int i = 0; i < 20'000; ++i) {
    Bytes bad = good;
    for (std::uint64_t damage = 1 + random.Next() % 4; damage > 0; --damage) {
      bad[random.Next() % bad.size()] = static_cast<std::byte>(random.Next());
    }
    bad.resize(random.Next() % 2 == 0 ? bad.size() : random.Next() % bad.size());
    if (const auto message = Decode<SetState::Response>(bad)) {
      ++decoded;
      EXPECT_LE(message->degraded.size() + message->actuators.size(), bad.size());
    }
  }
  EXPECT_GT(decoded, 0);       // damage in a text is not noticed …
  EXPECT_LT(decoded, 20'000);  // … in a length it is
}

}  // namespace musher::msg::cdr_test
