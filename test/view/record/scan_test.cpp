// What Musher writes as MCAP it reads again, also when the file is cut or changed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "musher/test/support/temp_folder.hpp"
#include "musher/view/mcap/scan.hpp"
#include "musher/view/mcap/writer.hpp"

namespace musher::mcap::scan_test {

using ::testing::HasSubstr;

std::vector<std::byte> Text(const std::string& text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

std::string Slurp(const std::string& path) {
  std::ostringstream all;
  all << std::ifstream(path, std::ios::binary).rdbuf();
  return all.str();
}

void Spill(const std::string& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

// Ten messages in chunks of two.
void WriteTen(const std::string& path, Compression compression) {
  const auto writer = Writer::Open(path, {compression}).value();
  const auto schema = writer->AddSchema("std_msgs/msg/String", "ros2msg", "string data");
  const auto channel = writer->AddChannel(schema, "/chat", "cdr", {{"key", "value"}});
  for (int i = 0; i < 10; ++i) {
    const auto text = Text("message " + std::to_string(i));
    ASSERT_TRUE(writer->Write(channel, i, 1000 + i, 1000 + i, text));
    if (i % 2 == 1) {
      ASSERT_TRUE(writer->Flush());
    }
  }
  ASSERT_TRUE(writer->Close());
}

class OfCompression : public ::testing::TestWithParam<Compression> {};

TEST_P(OfCompression, EachMessageIsReadAsItWasWritten) {
  const TempFolder folder;
  WriteTen(folder / "a.mcap", GetParam());
  const auto scan = Scan::Open(folder / "a.mcap").value();
  EXPECT_EQ(scan->damage(), "");
  ASSERT_EQ(scan->messages().size(), 10U);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(scan->messages()[i].log_ns, 1000 + static_cast<std::int64_t>(i));
    EXPECT_EQ(scan->Read(scan->messages()[i]).value(), Text("message " + std::to_string(i)));
  }
  const ScannedChannel& channel = scan->channels().at(scan->messages()[0].channel);
  EXPECT_EQ(channel.topic, "/chat");
  EXPECT_EQ(channel.metadata.at("key"), "value");
  EXPECT_EQ(scan->schemas().at(channel.schema).data, "string data");
}

TEST_P(OfCompression, OfAFileCutAtAnyByteAllWholeChunksAreRead) {
  const TempFolder folder;
  WriteTen(folder / "a.mcap", GetParam());
  const std::string whole = Slurp(folder / "a.mcap");
  std::size_t read_before = 0;
  for (std::size_t size = 8; size < whole.size(); ++size) {
    Spill(folder / "cut.mcap", whole.substr(0, size));
    const auto scan = Scan::Open(folder / "cut.mcap");
    ASSERT_TRUE(scan) << size;
    const std::size_t read = scan.value()->messages().size();
    EXPECT_GE(read, read_before) << size;
    if (read < 10) {
      EXPECT_THAT(scan.value()->damage(), HasSubstr("could be read before it"));
    }
    read_before = read;
  }
  EXPECT_EQ(read_before, 10U);
}

TEST_P(OfCompression, AFileWithAnyByteChangedIsReadWithoutACrash) {
  const TempFolder folder;
  WriteTen(folder / "a.mcap", GetParam());
  const std::string whole = Slurp(folder / "a.mcap");
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ 0xff);
    Spill(folder / "changed.mcap", changed);
    const auto scan = Scan::Open(folder / "changed.mcap");
    if (!scan) continue;
    for (const auto& message : scan.value()->messages()) {
      static_cast<void>(scan.value()->Read(message).ok());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Mcap, OfCompression,
                         ::testing::Values(Compression::kNone, Compression::kLz4,
                                           Compression::kZstd));

TEST(Mcap, AnExistingFileIsNotOverwritten) {
  const TempFolder folder;
  Spill(folder / "a.mcap", "mine");
  const auto writer = Writer::Open(folder / "a.mcap", {});
  ASSERT_FALSE(writer);
  EXPECT_THAT(writer.error().message, HasSubstr("a.mcap cannot be created: File exists"));
  EXPECT_EQ(Slurp(folder / "a.mcap"), "mine");
}

}  // namespace musher::mcap::scan_test
