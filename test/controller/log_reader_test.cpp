// Log files as LogFiles leaves them: a live file and compressed parts.

#include "musher/controller/storage/log_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <filesystem>
#include <fstream>

#include "musher/test/support/temp_folder.hpp"

namespace musher::log_reader_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class Reading : public ::testing::Test {
 protected:
  void Append(const std::string& text) const { std::ofstream(log_, std::ios::app) << text; }
  void Part(int number, const std::string& text) const {
    gzFile file = gzopen((log_ + "." + std::to_string(number) + ".gz").c_str(), "wb");
    gzwrite(file, text.data(), static_cast<unsigned>(text.size()));
    gzclose(file);
  }
  // All lines, as the reader gives them from the end to the begin.
  std::vector<WrittenLine> AllLines() const {
    auto reader = LogReader::Open(log_);
    EXPECT_TRUE(reader);
    std::vector<WrittenLine> lines;
    for (auto piece = reader.value().Before(); !piece.empty(); piece = reader.value().Before()) {
      lines.insert(lines.begin(), piece.begin(), piece.end());
    }
    return lines;
  }
  std::vector<std::string> All() const {
    std::vector<std::string> texts;
    for (const WrittenLine& line : AllLines()) texts.push_back(line.text);
    return texts;
  }
  static std::vector<std::string> Numbered(int count) {
    std::vector<std::string> lines;
    for (int i = 0; i < count; ++i) lines.push_back("line " + std::to_string(i));
    return lines;
  }

  const TempFolder folder_;
  const std::string log_ = folder_ / "legs.log";
};

TEST_F(Reading, GivesTheLinesOfTheLiveFile) {
  Append("a\n\nb\nno end");
  EXPECT_THAT(All(), ElementsAre("a", "", "b", "no end"));
}

TEST_F(Reading, JoinsPartsThatWereCutInALine) {
  Part(9, "first\nsec");
  Part(10, "ond\nthi");
  Append("rd\nfourth\n");
  EXPECT_THAT(All(), ElementsAre("first", "second", "third", "fourth"));
}

TEST_F(Reading, OfALongFileComesInPieces) {
  const auto lines = Numbered(100'000);
  std::string text;
  for (const std::string& line : lines) text += line + '\n';
  Append(text);
  auto reader = LogReader::Open(log_);
  const auto newest = reader.value().Before();
  EXPECT_LT(newest.size(), lines.size());
  EXPECT_EQ(newest.back().text, lines.back());
  EXPECT_EQ(All(), lines);
}

TEST_F(Reading, SkipsADamagedPartAndSaysSo) {
  std::ofstream(log_ + ".1.gz") << "\x1f\x8b broken";
  Append("a\n");
  auto reader = LogReader::Open(log_);
  EXPECT_THAT(reader.value().Before(), ElementsAre(WrittenLine{"a", 0}));
  EXPECT_THAT(reader.value().damage(), ::testing::HasSubstr(".1.gz"));
}

TEST_F(Reading, FailsWithoutAFile) {
  const auto reader = LogReader::Open(log_);
  ASSERT_FALSE(reader);
  EXPECT_THAT(reader.error().message, ::testing::HasSubstr(log_));
}

TEST_F(Reading, GivesEachLineTheTimeOfTheMarkBehindItsEnd) {
  Part(1, "first\nsec");
  Append("ond\nthird\nfourth\nfifth\n");
  std::ofstream(log_ + ".times") << "1 6 100\n1 9 200\n0 10 300\n0 17 400\n";
  EXPECT_THAT(AllLines(), ElementsAre(WrittenLine{"first", 100}, WrittenLine{"second", 300},
                                      WrittenLine{"third", 300}, WrittenLine{"fourth", 400},
                                      WrittenLine{"fifth", 0}))
      << "what is not marked yet has no time";
}

TEST_F(Reading, DoesNotBelieveMarksOfALongerFile) {
  Append("a\n");
  std::ofstream(log_ + ".times") << "0 1 100\nnonsense\n0 50 200\n";
  EXPECT_THAT(AllLines(), ElementsAre(WrittenLine{"a", 0}));
}

class Following : public Reading {
 protected:
  LogTail TailOf(const std::string& text) const {
    Append(text);
    return LogTail(log_, static_cast<std::int64_t>(text.size()));
  }
};

TEST_F(Following, GivesEachLineOnceItIsComplete) {
  LogTail tail = TailOf("old\n");
  EXPECT_THAT(tail.Read(), IsEmpty());
  Append("new\nha");
  EXPECT_THAT(tail.Read(), ElementsAre("new"));
  Append("lf\n");
  EXPECT_THAT(tail.Read(), ElementsAre("half"));
}

TEST_F(Following, FindsItsPlaceWhenTheFrontOfTheFileIsRemoved) {
  LogTail tail = TailOf("one\ntwo\nthree\n");
  std::ofstream(log_, std::ios::trunc) << "one\ntwo\nthree\nfour\n";
  EXPECT_THAT(tail.Read(), ElementsAre("four"));
  std::string longer = "x\n";
  for (int i = 0; i < 300; ++i) longer += "filler " + std::to_string(i) + '\n';
  Append(longer);
  EXPECT_EQ(tail.Read().size(), 301U);
  // As FALLOC_FL_COLLAPSE_RANGE leaves it: the same file without its front.
  const std::string left = longer.substr(longer.size() - 1500);
  std::filesystem::resize_file(log_, 0);
  Append(left + "after\n");
  EXPECT_THAT(tail.Read(), ElementsAre("after"));
}

TEST_F(Following, BeginsAgainWhenTheFileWasTruncatedOrMadeAgain) {
  LogTail tail = TailOf("one\n");
  std::filesystem::resize_file(log_, 0);
  Append("two\n");
  EXPECT_THAT(tail.Read(), ElementsAre("two"));
  std::filesystem::remove(log_);
  EXPECT_THAT(tail.Read(), IsEmpty());
  Append("three\n");
  EXPECT_THAT(tail.Read(), ElementsAre("three"));
}

}  // namespace musher::log_reader_test
