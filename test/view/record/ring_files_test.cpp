// A ring of segments on a disk, in a time that the test sets.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/sim/network.hpp"
#include "musher/view/mcap/scan.hpp"
#include "musher/view/record/file_sink.hpp"

namespace musher::view::ring_files_test {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kBegin = 1'772'366'405 * kSecond;

class RingFiles : public ::testing::Test {
 protected:
  void Open() {
    FileSinkOptions file;
    file.path = folder_.path();
    ring_ = RingSink::Open(
                node_->loop(), file,
                {std::chrono::seconds(60), std::chrono::seconds(30), std::chrono::seconds(10), 2},
                [this] { return Now(); },
                [this](const std::string& sentence) { sentences_.push_back(sentence); })
                .value();
    state_ = ring_->AddChannel({"/state", std::string(msg::String::kTypeName), "", true});
    chat_ = ring_->AddChannel({"/chat", std::string(msg::String::kTypeName), "", false});
  }
  std::int64_t Now() const { return kBegin + (network_.now() - begin_).count(); }
  void Write(std::size_t channel, const std::string& text) {
    msg::String message;
    message.data = text;
    EXPECT_TRUE(ring_->Write(channel, Now(), msg::Encode(message)));
  }
  // A message each second.
  void Run(int seconds) {
    for (int i = 0; i < seconds; ++i) {
      Write(chat_, std::to_string(count_++));
      network_.RunFor(std::chrono::seconds(1));
    }
  }
  std::vector<std::string> Kept() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_.path())) {
      if (entry.is_regular_file()) names.push_back(entry.path().filename());
    }
    std::sort(names.begin(), names.end());
    return names;
  }
  std::vector<std::string> Texts(const std::string& name) const {
    std::vector<std::string> texts;
    const auto scan = mcap::Scan::Open(folder_ / name).value();
    EXPECT_EQ(scan->damage(), "");
    for (const auto& message : scan->messages()) {
      texts.push_back(msg::Decode<msg::String>(scan->Read(message).value())->data);
    }
    return texts;
  }

  TempFolder folder_;
  transport::sim::Network network_{1};
  const Time begin_ = network_.now();
  std::unique_ptr<transport::Node> node_ = network_.MakeNode("dog");
  std::vector<std::string> sentences_;
  int count_ = 0;
  std::size_t state_ = 0;
  std::size_t chat_ = 0;
  std::unique_ptr<RingSink> ring_;
};

TEST_F(RingFiles, TheTimeAroundTroubleIsOneFileWithTheLatchedSamplesOnce) {
  Open();
  Write(state_, "Active");
  Run(200);
  ring_->OnTrouble("emergency-stop");
  Run(40);
  ASSERT_TRUE(ring_->Close());
  ASSERT_THAT(Kept(), ElementsAre("2026-03-01T12-03-25Z_emergency-stop.mcap"));
  const auto texts = Texts(Kept()[0]);
  EXPECT_EQ(texts.front(), "Active");
  EXPECT_EQ(std::count(texts.begin(), texts.end(), "Active"), 1);
  EXPECT_LE(std::stoi(texts[1]), 140);
  EXPECT_GE(std::stoi(texts[1]), 129);
  EXPECT_GE(std::stoi(texts.back()), 229);
  for (std::size_t i = 2; i < texts.size(); ++i) {
    EXPECT_EQ(std::stoi(texts[i]), std::stoi(texts[i - 1]) + 1);
  }
  EXPECT_FALSE(fs::exists(folder_ / "ring"));
}

TEST_F(RingFiles, OfManyTroublesTheNewestAreKept) {
  Open();
  for (const char* reason : {"a", "b", "c"}) {
    ring_->OnTrouble(reason);
    Run(60);
  }
  ASSERT_TRUE(ring_->Close());
  ASSERT_THAT(Kept(), SizeIs(2));
  EXPECT_THAT(Kept()[0], HasSubstr("_b.mcap"));
  EXPECT_THAT(Kept()[1], HasSubstr("_c.mcap"));
}

TEST_F(RingFiles, WhatAKilledRecorderLeftBehindIsKept) {
  fs::create_directory(folder_ / "ring");
  const RecordedChannel chat{"/chat", std::string(msg::String::kTypeName), "", false};
  for (const char* segment : {"ring/00000001.mcap", "ring/00000002.mcap"}) {
    const auto file = RecordingFile::Open(folder_ / segment, mcap::Compression::kLz4).value();
    msg::String message;
    message.data = segment;
    ASSERT_TRUE(file->Write(chat, 0, Now(), Now(), msg::Encode(message)));
    ASSERT_TRUE(file->Flush());  // and no Close()
  }
  Open();
  ASSERT_THAT(Kept(), ElementsAre("2026-03-01T12-00-05Z_recorder-restarted.mcap"));
  EXPECT_THAT(Texts(Kept()[0]), ElementsAre("ring/00000001.mcap", "ring/00000002.mcap"));
}

}  // namespace musher::view::ring_files_test
