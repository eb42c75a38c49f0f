// A ring of segments on a disk, in a time that the test sets.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/resource.h>

#include <csignal>
#include <filesystem>

#include "musher/base/files.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/sim/network.hpp"
#include "musher/view/mcap/scan.hpp"
#include "musher/view/record/file_sink.hpp"

namespace musher::view::ring_files_test {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
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
  std::int64_t Now() const { return kBegin + (network_.now() - begin_ + clock_set_).count(); }
  void Write(std::size_t channel, const std::string& text) {
    msg::String message;
    message.data = text;
    EXPECT_TRUE(ring_->Write(channel, Now(), msg::Encode(message)) || full_);
  }
  // A message each second.
  void Run(int seconds) {
    for (int i = 0; i < seconds; ++i) {
      Write(chat_, std::to_string(count_++));
      network_.RunFor(std::chrono::seconds(1));
      ring_->Drain();
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
  Duration clock_set_{};  // by which the wall clock was set
  bool full_ = false;     // the disk
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

// Each took the segments of the other for those of a killed recorder, and deleted them.
TEST_F(RingFiles, OfTwoRecordersInOneFolderTheSecondIsRefused) {
  Open();
  Run(3);
  FileSinkOptions file;
  file.path = folder_.path();
  const auto second = RingSink::Open(
      node_->loop(), file, {}, [this] { return Now(); }, [](const std::string&) {});
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().message, HasSubstr("another recorder has its ring in " + file.path));
  EXPECT_THAT(Kept(), IsEmpty());
  EXPECT_TRUE(fs::exists(folder_ / "ring/00000001.mcap"));
  ASSERT_TRUE(ring_->Close());
  EXPECT_FALSE(fs::exists(folder_ / "ring"));
  Open();
}

TEST_F(RingFiles, OtherFilesOfTheFolderAreLeftAlone) {
  const auto write = [](const std::string& path) { ASSERT_TRUE(WriteFile(path, "mine")); };
  write(folder_ / "run.mcap");
  write(folder_ / "2025-01-01T00-00-00Z_mine.mcap");  // not of a recorder
  write(folder_ / "notes.txt");
  fs::create_directory(folder_ / "ring");
  write(folder_ / "ring/photo.jpg");
  write(folder_ / "ring/00000001.mcap");
  Open();
  for (const char* reason : {"a", "b", "c"}) {
    ring_->OnTrouble(reason);
    Run(60);
  }
  ASSERT_TRUE(ring_->Close());
  EXPECT_THAT(Kept(), SizeIs(5)) << "two of the recorder";
  for (const char* name : {"run.mcap", "2025-01-01T00-00-00Z_mine.mcap", "notes.txt",
                           "ring/photo.jpg", "ring/00000001.mcap"}) {
    EXPECT_EQ(ReadFile(folder_ / name), "mine") << name;
  }
}

TEST_F(RingFiles, AnEmptyFolderRingOfTheUserIsNotRemoved) {
  fs::create_directory(folder_ / "ring");
  Open();
  Run(20);
  ASSERT_TRUE(ring_->Close());
  EXPECT_TRUE(fs::is_empty(folder_ / "ring"));
}

TEST_F(RingFiles, AClockSetBackMakesNoSegmentLongerAndTheNewestIsKept) {
  Open();
  Run(100);
  ring_->OnTrouble("a");
  Run(40);
  ring_->OnTrouble("b");
  Run(40);
  clock_set_ = -std::chrono::hours(1);
  Run(100);
  EXPECT_THAT(EntriesOf(folder_ / "ring"), SizeIs(8)) << "with the lock";
  ring_->OnTrouble("c");
  Run(40);
  ASSERT_TRUE(ring_->Close());
  ASSERT_THAT(Kept(), SizeIs(2));
  EXPECT_THAT(Kept()[0], HasSubstr("T11-"));
  EXPECT_THAT(Kept()[0], HasSubstr("_c.mcap"));
  const auto texts = Texts(Kept()[0]);
  EXPECT_GE(std::stoi(texts.front()), 209);
}

// Each trouble of a boot without an RTC deleted the one before it, and the files of the years
// before stayed.
TEST_F(RingFiles, OfABootInTheYear1970TheNewestTroublesAreKept) {
  for (int files = 0; files < 2; ++files) {
    Open();
    Run(20);
    ring_->OnTrouble("before");
    Run(20);
    ASSERT_TRUE(ring_->Close());
  }
  ASSERT_THAT(Kept(), SizeIs(2));
  clock_set_ = -std::chrono::nanoseconds(Now());
  Open();
  for (const char* reason : {"first", "second", "third"}) {
    Run(60);
    ring_->OnTrouble(reason);
    Run(60);
  }
  ASSERT_TRUE(ring_->Close());
  EXPECT_THAT(Kept(), ElementsAre(HasSubstr("_second.mcap"), HasSubstr("_third.mcap")));
}

TEST_F(RingFiles, TwoTroublesOfOneSecondAreTwoFiles) {
  Open();
  Run(10);
  ring_->OnTrouble("a");
  Run(40);
  clock_set_ = -std::chrono::seconds(40);
  ring_->OnTrouble("a");
  Run(40);
  ASSERT_TRUE(ring_->Close());
  EXPECT_THAT(Kept(), SizeIs(2));
}

// Lets files grow to some size only, as a full disk.
class SizeLimit {
 public:
  explicit SizeLimit(rlim_t bytes) {
    signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~SizeLimit() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST_F(RingFiles, WhatADiskDoesNotTakeStaysAndIsKeptOnceItDoes) {
  Open();
  Run(30);
  ring_->OnTrouble("error");
  {
    const SizeLimit full(1);
    full_ = true;
    Run(65);
  }
  EXPECT_THAT(Kept(), IsEmpty());
  EXPECT_THAT(sentences_, Contains(HasSubstr("not kept yet: ")));
  Run(10);  // until the next segment
  full_ = false;
  Run(90);
  EXPECT_FALSE(ring_->Close()) << "of the time of the full disk nothing is there";
  ASSERT_THAT(Kept(), ElementsAre("2026-03-01T12-00-35Z_error.mcap"));
  EXPECT_EQ(Texts(Kept()[0]).front(), "0");
  EXPECT_THAT(sentences_, Contains(HasSubstr("lacks a part: ")));
  EXPECT_FALSE(fs::exists(folder_ / "ring"));
}

TEST_F(RingFiles, WhatCannotBeKeptAtTheEndStaysForTheNextRecorder) {
  Open();
  Run(30);
  ring_->OnTrouble("error");
  Run(5);
  {
    const SizeLimit full(1);
    const auto closed = ring_->Close();
    ASSERT_FALSE(closed);
    EXPECT_THAT(closed.error().message,
                AllOf(HasSubstr("_error.mcap is not kept: "), HasSubstr("/ring")));
  }
  EXPECT_THAT(Kept(), IsEmpty());
  Open();
  ASSERT_TRUE(ring_->Close());
  ASSERT_THAT(Kept(), SizeIs(1));
  EXPECT_THAT(Kept()[0], HasSubstr("_recorder-restarted.mcap"));
  EXPECT_EQ(Texts(Kept()[0]).front(), "0");
  EXPECT_FALSE(fs::exists(folder_ / "ring"));
}

}  // namespace musher::view::ring_files_test
