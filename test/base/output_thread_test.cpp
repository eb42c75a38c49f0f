// What is written on a thread, to a descriptor that may take nothing for a while.

#include "musher/base/output_thread.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <string>

#include "musher/test/support/full_pipe.hpp"

namespace musher::output_thread_test {

using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(Output, IsWrittenWhenWriteReturns) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const UniqueFd reader(ends[0]);
  const UniqueFd writer(ends[1]);
  OutputThread output(writer.get());
  output.Write("grips\n");
  char text[16];
  EXPECT_EQ(read(reader.get(), text, sizeof(text)), 6);
}

TEST(Output, ThatIsNotTakenIsWrittenInItsOrderOnceItIs) {
  const testing::FullPipe pipe;
  OutputThread output(pipe.writer());
  output.Write("one\n");
  output.Write("two\n");
  EXPECT_EQ(pipe.ReadUntil("two\n"), "one\ntwo\n");
}

TEST(Output, ThatIsTooMuchIsDroppedAndCounted) {
  const testing::FullPipe pipe;
  OutputThread output(pipe.writer());
  const std::string large(1 << 19, 'y');
  for (int i = 0; i < 4; ++i) output.Write(large + "\n");
  EXPECT_THAT(pipe.ReadUntil("\n"), StartsWith("yy"));
  output.Flush(std::chrono::seconds(60));
  output.Write("end\n");
  EXPECT_THAT(pipe.ReadUntil("end\n"), HasSubstr("bytes dropped here"));
}

}  // namespace musher::output_thread_test
