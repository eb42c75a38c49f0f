#include "musher/view/live/log_text.hpp"

#include <gmock/gmock.h>

#include <fstream>

#include "musher/test/support/temp_folder.hpp"

namespace musher::view::log_text_test {

using ::testing::HasSubstr;

class LogText : public ::testing::Test {
 protected:
  void Write(const std::string& text) { std::ofstream(path_, std::ios::binary) << text; }

  const TempFolder folder_;
  const std::string path_ = folder_.path() + "/motion.log";
};

TEST_F(LogText, IsReadFromAByteToTheEnd) {
  Write("one\ntwo\nthree\n");
  const LogPiece piece = ReadLog(path_, 4).value();
  EXPECT_EQ(piece.text, "two\nthree\n");
  EXPECT_EQ(piece.from, 4);
  EXPECT_EQ(piece.to, 14);
  EXPECT_EQ(piece.size, 14);
  EXPECT_EQ(ReadLog(path_, 14).value().text, "");
}

TEST_F(LogText, FromTheEndBeginsWithAWholeLine) {
  Write("one\ntwo\nthree\n");
  const LogPiece piece = ReadLog(path_, -8).value();
  EXPECT_EQ(piece.text, "three\n");
  EXPECT_EQ(piece.from, 8);
  EXPECT_EQ(ReadLog(path_, -1000).value().text, "one\ntwo\nthree\n");
}

TEST_F(LogText, OfARotatedFileIsReadFromItsBegin) {
  Write("new\n");
  EXPECT_EQ(ReadLog(path_, 5000).value().text, "new\n");
}

TEST_F(LogText, IsReadInPiecesOfLimitedSize) {
  Write(std::string(3 * kMostLogBytes, 'x'));
  const LogPiece piece = ReadLog(path_, 0).value();
  EXPECT_EQ(piece.to, kMostLogBytes);
  EXPECT_EQ(ReadLog(path_, piece.to).value().to, 2 * kMostLogBytes);
}

TEST_F(LogText, ThatIsMissingIsAnErrorWithItsPath) {
  const auto piece = ReadLog(path_, 0);
  ASSERT_FALSE(piece);
  EXPECT_THAT(piece.error().message, HasSubstr(path_ + " cannot be read: No such file"));
}

}  // namespace musher::view::log_text_test
