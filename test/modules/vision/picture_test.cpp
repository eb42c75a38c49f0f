#include "musher/modules/vision/picture/picture.hpp"

#include <gmock/gmock.h>

#include <functional>

#include "musher/test/modules/vision/faces.hpp"

namespace musher::vision::picture_test {

using ::testing::HasSubstr;
using Verdict = StampGate::Verdict;

std::string Said(const std::function<void(msg::Image&)>& spoil) {
  msg::Image picture = Picture();
  spoil(picture);
  const Result<> valid = CheckPicture(picture);
  return valid ? "" : valid.error().message;
}

TEST(CheckPicture, TakesWhatCamerasSend) {
  for (const auto& [encoding, channels] :
       {std::pair("rgb8", 3), std::pair("bgr8", 3), std::pair("rgba8", 4), std::pair("bgra8", 4),
        std::pair("mono8", 1)}) {
    EXPECT_EQ(Said([&](msg::Image& picture) {
                picture.encoding = encoding;
                picture.step = picture.width * static_cast<std::uint32_t>(channels);
                picture.data.resize(std::size_t{picture.step} * picture.height);
              }),
              "")
        << encoding;
  }
  EXPECT_EQ(Said([](msg::Image& picture) {
              picture.step += 5;  // rows may be longer than their pixels
              picture.data.resize(std::size_t{picture.step} * picture.height);
            }),
            "");
}

class StillPicturesTest : public ::testing::Test {
 protected:
  // A picture each 100 ms.
  Duration Still(const msg::Image& picture) { return still_.StillFor(picture, at_ns_ += kEveryNs); }

  static constexpr std::int64_t kEveryNs = 100'000'000;
  StillPictures still_;
  std::int64_t at_ns_ = 0;
};

TEST_F(StillPicturesTest, CountTheTimeOfEqualOnes) {
  msg::Image picture = Picture();
  EXPECT_EQ(Still(picture), Duration(0));
  EXPECT_EQ(Still(picture), Milliseconds(100));
  EXPECT_EQ(Still(picture), Milliseconds(200));
  ASSERT_FALSE(picture.data.empty());
  picture.data[0] ^= 1;
  EXPECT_EQ(Still(picture), Duration(0));
  EXPECT_EQ(Still(picture), Milliseconds(100));
  std::swap(picture.width, picture.height);
  picture.width += 1;
  EXPECT_EQ(Still(picture), Duration(0));
  at_ns_ = 0;  // time has jumped back
  EXPECT_EQ(Still(picture), Duration(0));
}

TEST_F(StillPicturesTest, CountARingOfUpToFourBuffers) {
  for (const int buffers : {2, 3, 4, 5}) {
    msg::Image picture = Picture();
    Duration still{};
    for (int i = 0; i < 20; ++i) {
      picture.data[0] = static_cast<std::uint8_t>(10 * buffers + i % buffers);
      still = Still(picture);
    }
    EXPECT_EQ(still, buffers > 4 ? Duration(0) : Milliseconds(100) * (20 - buffers)) << buffers;
  }
}

TEST(CheckPicture, RefusesAnInvalidPicture) {
  EXPECT_THAT(Said([](msg::Image& picture) { picture.encoding = "32FC1"; }),
              HasSubstr("this one is '32FC1'"));
  EXPECT_THAT(Said([](msg::Image& picture) { picture.encoding = std::string(100000, 'x'); }),
              HasSubstr("xxx'"));
  EXPECT_THAT(Said([](msg::Image& picture) { picture.encoding = "\x1b[2J\n"; }),
              HasSubstr("this one is '?[2J?'"))
      << "what a log may show";
  EXPECT_EQ(Said([](msg::Image& picture) { picture.width = 0; }), "a picture of 0 x 48 pixels");
  EXPECT_EQ(Said([](msg::Image& picture) { picture.height = 0; }), "a picture of 64 x 0 pixels");
  EXPECT_EQ(Said([](msg::Image& picture) { picture.step -= 1; }),
            "a row of 191 bytes in a picture of 64 x 48");
  EXPECT_EQ(Said([](msg::Image& picture) { picture.data.pop_back(); }),
            "9215 bytes of a picture of 64 x 48 with 192 in a row");
  EXPECT_EQ(Said([](msg::Image& picture) { picture.data.clear(); }),
            "0 bytes of a picture of 64 x 48 with 192 in a row");
  // 2^32 / 4 pixels in a row: the product of width and channels is 0 in 32 bits.
  EXPECT_NE(Said([](msg::Image& picture) {
              picture.encoding = "rgba8";
              picture.width = 1U << 30U;
              picture.step = 0;
              picture.data.clear();
            }),
            "");
}

TEST(StampGate, LetsNoPicturePassTwice) {
  StampGate gate(0);
  EXPECT_EQ(gate.Check(100 * kMs), Verdict::kLook);
  EXPECT_EQ(gate.Check(100 * kMs), Verdict::kNotNewer);
  EXPECT_EQ(gate.Check(100 * kMs + 999'999), Verdict::kNotNewer);
  EXPECT_EQ(gate.Check(60 * kMs), Verdict::kNotNewer);
  EXPECT_EQ(gate.Check(101 * kMs), Verdict::kLook);
}

TEST(StampGate, KeepsToItsRateWhateverThatOfTheCamera) {
  for (const std::int64_t camera_hz : {11, 15, 20, 30, 60}) {
    StampGate gate(10);
    int looked = 0;
    for (std::int64_t i = 1; i <= 10 * camera_hz; ++i) {
      looked += gate.Check(i * 1'000'000'000 / camera_hz) == Verdict::kLook ? 1 : 0;
    }
    EXPECT_NEAR(looked, 100, 1) << camera_hz << " Hz";
  }
}

TEST(StampGate, DetectsATimeJumpBack) {
  StampGate gate(10);
  gate.Check(100'000 * kMs);
  EXPECT_EQ(gate.Check(40 * kMs), Verdict::kLookAfterJump);
  EXPECT_EQ(gate.Check(50 * kMs), Verdict::kTooSoon);
  EXPECT_EQ(gate.Check(140 * kMs), Verdict::kLook);
}

}  // namespace musher::vision::picture_test
