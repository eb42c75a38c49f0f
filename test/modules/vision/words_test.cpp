#include "musher/modules/vision/course/words.hpp"

#include <gmock/gmock.h>

namespace musher::vision::words_test {

using ::testing::Eq;
using ::testing::Optional;

const std::vector<std::string> kWords{"A-1", "A-2", "B-1", "B-2"};

TEST(CodesText, IsAWordOnlyAsAWhole) {
  EXPECT_THAT(WordOfCode("A-1", kWords), Optional(Eq("A-1")));
  EXPECT_THAT(WordOfCode(" B-2\r\n", kWords), Optional(Eq("B-2")));
  for (const char* other : {"A-3", "a-1", "A1", "https://example.org/A-1", "", " \n", "A-1A-2"}) {
    EXPECT_EQ(WordOfCode(other, kWords), std::nullopt) << other;
  }
}

TEST(ReadText, ThatAreReadAlmostRightAreTheWord) {
  for (const char* text : {"A-2", "A2", "a - 2", "A—2\n", "A-Z", "(A-2.", "JA-2)", "A-25"}) {
    EXPECT_THAT(WordOfLetters(text, kWords), Optional(Eq("A-2"))) << text;
  }
  for (const char* text : {"A-1", "A-l", "A-I", "A1", "|A-1|"}) {
    EXPECT_THAT(WordOfLetters(text, kWords), Optional(Eq("A-1"))) << text;
  }
  EXPECT_EQ(WordOfLetters("8-2", kWords), std::nullopt) << "a board of its own";
}

TEST(ReadText, OfTwoWordsOrOfManyMoreAreNone) {
  for (const char* text : {"", "A", "2", "2-A", "A-12", "A-1 B-1", "AI", "Al", "AREA 51 B", "STOP",
                           "AB12", "PASSAGE 2"}) {
    EXPECT_EQ(WordOfLetters(text, kWords), std::nullopt) << text;
  }
}

TEST(Readings, ThatContradictEachOtherAreMoreThanOneWord) {
  using Words = std::set<std::string>;
  EXPECT_EQ(WordsOfReadings({"B-1", "B-1\n"}, kWords), Words{"B-1"});
  EXPECT_EQ(WordsOfReadings({"B-1", ""}, kWords), Words{"B-1"}) << "one is not sure";
  EXPECT_EQ(WordsOfReadings({"B-1", " .-"}, kWords), Words{"B-1"}) << "no letter and no digit";
  EXPECT_EQ(WordsOfReadings({"B-1", "R-1"}, kWords), (Words{"?", "B-1"}));
  EXPECT_EQ(WordsOfReadings({"A-1", "A-2"}, kWords), (Words{"A-1", "A-2"}));
  EXPECT_EQ(WordsOfReadings({"STOP", "STOP"}, kWords), Words{"?"});
}

TEST(ReadText, OfOtherScriptsAreComparedAsTheyAre) {
  const std::vector<std::string> words{"库位1", "库位2"};
  EXPECT_THAT(WordOfLetters("库位 2", words), Optional(Eq("库位2")));
  EXPECT_EQ(WordOfLetters("库2", words), std::nullopt);
}

TEST(Excerpt, IsShortAndPrintable) {
  EXPECT_EQ(Excerpt("A-3"), "A-3");
  EXPECT_EQ(Excerpt(std::string(4096, 'x')), std::string(64, 'x'));
  EXPECT_EQ(Excerpt(std::string("a\0b\n\x1b[31m", 9)), "a?b??[31m");
  EXPECT_EQ(Excerpt("库"), "???");
}

TEST(Word, IsConfirmedByPicturesInARow) {
  WordRepeats repeats(3);
  EXPECT_EQ(repeats.OnPicture("A-1"), std::nullopt);
  EXPECT_EQ(repeats.OnPicture("A-1"), std::nullopt);
  EXPECT_EQ(repeats.OnPicture("A-2"), std::nullopt);
  EXPECT_EQ(repeats.OnPicture("A-2"), std::nullopt);
  EXPECT_EQ(repeats.OnPicture(std::nullopt), std::nullopt);
  EXPECT_EQ(repeats.OnPicture("A-2"), std::nullopt);
  EXPECT_EQ(repeats.OnPicture("A-2"), std::nullopt);
  EXPECT_THAT(repeats.OnPicture("A-2"), Optional(Eq("A-2")));
  EXPECT_THAT(repeats.OnPicture("A-2"), Optional(Eq("A-2")));
  WordRepeats once(1);
  EXPECT_THAT(once.OnPicture("B-1"), Optional(Eq("B-1")));
}

}  // namespace musher::vision::words_test
