#include "musher/view/record/recorded_text.hpp"

#include <gtest/gtest.h>

namespace musher::view::recorded_text_test {

TEST(RecordedText, HasSizeTimeAndRate) {
  EXPECT_EQ(RecordedText(0, 0, 0), "0 B in 0.0 s, 0 B/s");
  EXPECT_EQ(RecordedText(999, 1, 999), "999 B in 1.0 s, 999 B/s");
  EXPECT_EQ(RecordedText(12'345'678, 10.24, 1'205'632), "12.3 MB in 10.2 s, 1.2 MB/s");
  EXPECT_EQ(RecordedText(123'456'789'012, 3600, 34'293'552), "123 GB in 3600.0 s, 34.3 MB/s");
}

}  // namespace musher::view::recorded_text_test
