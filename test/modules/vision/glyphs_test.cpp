// The shapes of letters against what a reader of text says they are.

#include "musher/modules/vision/course/glyphs.hpp"

#include <gtest/gtest.h>

#include <array>
#include <opencv2/imgproc.hpp>

namespace musher::vision::glyphs_test {

constexpr double kLetterPx = 38;
constexpr std::array kFonts{cv::FONT_HERSHEY_SIMPLEX, cv::FONT_HERSHEY_DUPLEX};

// Ink on white, with a rim.
cv::Mat Line(const std::string& text, int font) {
  constexpr int kThick = 5;
  const double scale = cv::getFontScaleFromHeight(font, int(kLetterPx) - kThick, kThick);
  cv::Mat line(100, 300, CV_8UC1, cv::Scalar(255));
  cv::putText(line, text, {20, 60}, font, scale, 0, kThick, cv::LINE_8);
  return line;
}

TEST(Glyphs, FitTheirWord) {
  for (const int font : kFonts) {
    for (const std::string word : {"A-1", "A-2", "B-1", "B-2"}) {
      EXPECT_TRUE(GlyphsFit(Line(word, font), kLetterPx, word)) << word << " " << font;
    }
  }
}

TEST(Glyphs, OfAnEightAreNoB) {
  for (const int font : kFonts) {
    EXPECT_FALSE(GlyphsFit(Line("8-1", font), kLetterPx, "B-1")) << font;
    EXPECT_FALSE(GlyphsFit(Line("B-1", font), kLetterPx, "8-1")) << font;
  }
}

TEST(Glyphs, OfAOneAreNoTwo) {
  for (const int font : kFonts) {
    EXPECT_FALSE(GlyphsFit(Line("A-1", font), kLetterPx, "A-2")) << font;
    EXPECT_FALSE(GlyphsFit(Line("A-2", font), kLetterPx, "A-1")) << font;
  }
}

TEST(Glyphs, OfMoreOrFewerSignsAreAnotherWord) {
  EXPECT_FALSE(GlyphsFit(Line("A-12", kFonts[0]), kLetterPx, "A-1"));
  EXPECT_FALSE(GlyphsFit(Line("A", kFonts[0]), kLetterPx, "A-1"));
  EXPECT_FALSE(GlyphsFit(cv::Mat(60, 60, CV_8UC1, cv::Scalar(255)), kLetterPx, "A-1"));
}

TEST(Glyphs, OfOtherScriptsAreNotChecked) {
  EXPECT_TRUE(GlyphsFit(Line("A", kFonts[0]), kLetterPx, "库位2"));
}

}  // namespace musher::vision::glyphs_test
