// Checks and preparation of a text before it is spoken.

#include "musher/modules/audio/speech_text.hpp"

#include <gtest/gtest.h>

#include <string>

namespace musher::audio::speech_text_test {

constexpr Language kEn = Language::kEnglish;
constexpr Language kZh = Language::kChinese;

TEST(SpeechText, IsChineseAsSoonAsOneCharacterIs) {
  EXPECT_EQ(LanguageOf("hello", kZh), kEn);
  EXPECT_EQ(LanguageOf("hello 你", kEn), kZh);
  EXPECT_EQ(LanguageOf("你好", kEn), kZh);
  EXPECT_EQ(LanguageOf("𠀋", kEn), kZh) << "beyond the first plane";
}

TEST(SpeechText, IsInTheLanguageOfTheConfigWhereThereAreOnlyNumbersAndSigns) {
  for (const Language language : {kEn, kZh}) {
    EXPECT_EQ(LanguageOf("42 %", language), language);
    EXPECT_EQ(LanguageOf("", language), language);
    EXPECT_EQ(LanguageOf("🐕", language), language);
  }
  EXPECT_EQ(LanguageOf("über", kZh), kEn);
  EXPECT_EQ(LanguageOf("é", kZh), kEn);
}

TEST(SpeechText, CountsCharactersAndDetectsInvalidUtf8) {
  EXPECT_EQ(CharactersIn(""), 0U);
  EXPECT_EQ(CharactersIn("a你🐕"), 3U);
  EXPECT_EQ(CharactersIn("a\xFF"), std::nullopt);
  EXPECT_EQ(CharactersIn("\xE4\xBD"), std::nullopt) << "cut off";
  EXPECT_EQ(CharactersIn("\xED\xA0\x80"), std::nullopt) << "half of a pair";
  EXPECT_EQ(CharactersIn("\xC0\xAF"), std::nullopt) << "longer than need be";
}

TEST(SpeechText, HasNothingToSayInBlanksAndControlCharacters) {
  for (const char* nothing : {"", " ", "\t\r\n", "\x01\x1F\x7F", "\xC2\xA0", "　"}) {
    EXPECT_FALSE(HasSomethingToSay(nothing)) << nothing;
  }
  EXPECT_FALSE(HasSomethingToSay(std::string("\0", 1)));
  EXPECT_TRUE(HasSomethingToSay(" 1 "));
}

TEST(SpeechText, HasBlanksForControlCharacters) {
  EXPECT_EQ(Speakable(std::string("a\0b\nc\x7F你", 9)), "a b c 你");
}

}  // namespace musher::audio::speech_text_test
