#include "musher/view/live/qr_code.hpp"

#include <ZXing/ReadBarcode.h>
#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

namespace musher::view::qr_code_test {

// What a camera reads of the code; "" if nothing.
std::string Read(const QrModules& modules) {
  const int size = static_cast<int>(modules.size());
  cv::Mat small(size + 8, size + 8, CV_8UC1, cv::Scalar(255));
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      if (modules[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)]) {
        small.at<unsigned char>(y + 4, x + 4) = 0;
      }
    }
  }
  cv::Mat picture;
  cv::resize(small, picture, {}, 8, 8, cv::INTER_NEAREST);
  const auto code =
      ZXing::ReadBarcode({picture.data, picture.cols, picture.rows, ZXing::ImageFormat::Lum});
  return code.format() == ZXing::BarcodeFormat::QRCode ? code.text() : "";
}

TEST(QrCode, IsReadByACameraAtEachSize) {
  std::string text = "http://192.168.1.23:8765/login?code=";
  while (text.size() < kMostQrBytes) text += "0123456789abcdef"[text.size() * 7 % 16];
  for (const std::size_t length : {5, 17, 18, 32, 33, 53, 54, 68, 78, 79, 100, 106}) {
    const auto code = QrCode(text.substr(0, length));
    ASSERT_TRUE(code.has_value()) << length;
    EXPECT_EQ(Read(*code), text.substr(0, length));
  }
}

TEST(QrCode, OfALongerTextIsNone) {
  EXPECT_EQ(QrCode(std::string(kMostQrBytes + 1, 'x')), std::nullopt);
}

TEST(QrCode, IsDrawnWithAMarginInColoursOfItsOwn) {
  const std::string text = QrText({{true, false, true}, {true, true, false}, {false, false, true}});
  const std::string line = "\033[30;107m";
  const std::string end = "\033[0m\n";
  const std::string empty = line + std::string(11, ' ') + end;
  EXPECT_EQ(text, empty + empty + line + "    █▄▀    " + end + line + "      ▀    " + end + empty +
                      line + std::string(11, ' ') + end);
}

}  // namespace musher::view::qr_code_test
