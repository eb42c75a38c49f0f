// The file that an actuator records its trees into.

#include "musher/application/tree_recording.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <mutex>
#include <thread>

#include "musher/base/unique_fd.hpp"
#include "musher/behavior/tree/build.hpp"
#include "musher/behavior/tree/recording.hpp"
#include "musher/behavior/tree/xml/tree_xml.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::tree_recording_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kBlink = R"(<root BTCPP_format="4"><BehaviorTree ID="Blink">
  <Sequence><Script code="n := 1"/><AlwaysSuccess/></Sequence>
</BehaviorTree></root>)";

// Ends with success in each tick: seven changes and three resets.
class ARecording : public ::testing::Test {
 protected:
  std::unique_ptr<TreeRecording> Open(std::size_t most_bytes = std::size_t{1} << 20) {
    auto opened = TreeRecording::Open("show", {.file = file_, .most_bytes = most_bytes},
                                      [this](const std::string& line) {
                                        const std::lock_guard lock(mutex_);
                                        log_.push_back(line);
                                      });
    EXPECT_TRUE(opened) << opened.error().message;
    return std::move(opened).value();
  }
  TreeView View() {
    return {.tree = tree_.get(),
            .document = &document_,
            .revision = 1,
            .ticking = true,
            .ticks = 0,
            .result = result_,
            .last_fault = &fault_,
            .time = &time_};
  }
  void Tick(TreeRecording& recording, int times) {
    for (int i = 0; i < times; ++i) {
      now_ += Milliseconds(10);
      time_.Continue(now_);
      result_ = tree_->TickOnce(now_).value();
      recording.Note(View());
    }
  }
  static std::string TextOf(const std::string& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  static tree::Recording Read(const std::string& text) {
    const auto read = tree::ReadRecording(text, "show.tree");
    EXPECT_TRUE(read) << read.error().message;
    return read ? read.value() : tree::Recording{};
  }
  std::vector<std::string> Log() {
    const std::lock_guard lock(mutex_);
    return log_;
  }

  const TempFolder folder_;
  std::string file_ = folder_ / "new/show.tree";
  tree::Factory factory_;
  tree::Document document_ = tree::ReadTree(kBlink, "b.xml").document;
  std::unique_ptr<tree::Tree> tree_ = tree::Build(document_, factory_).tree;
  TreeTime time_;
  Time now_{};
  tree::Status result_ = tree::Status::kIdle;
  std::string fault_;
  std::mutex mutex_;
  std::vector<std::string> log_;
};

TEST_F(ARecording, HasWhatTheTreeDid) {
  auto recording = Open();
  recording->Begin(View(), factory_);
  Tick(*recording, 3);
  recording.reset();
  const tree::Recording read = Read(TextOf(file_));
  EXPECT_EQ(read.actuator, "show");
  ASSERT_EQ(read.trees.size(), 1U);
  tree::Playback playback(read.trees.front());
  playback.To(Milliseconds(20));
  EXPECT_EQ(playback.runs(0).starts, 3U) << "tree time begins with the first tick";
  EXPECT_EQ(playback.entries().at(0).value, "1");
  EXPECT_THAT(Log(), IsEmpty());
}

TEST_F(ARecording, IsBoundedAndTheLastFilesAreReadableAlone) {
  constexpr std::size_t kMost = 32'000;
  auto recording = Open(kMost);
  recording->Begin(View(), factory_);
  Tick(*recording, 1000);
  recording.reset();
  const std::string now = TextOf(file_);
  const std::string before = TextOf(file_ + ".before");
  EXPECT_LT(now.size() + before.size(), kMost + 2000U);
  EXPECT_GT(before.size(), kMost / 3);
  const tree::Recording early = Read(before);
  const tree::Recording late = Read(now);
  EXPECT_FALSE(early.cut_at);
  EXPECT_FALSE(late.cut_at);
  EXPECT_LE(early.trees.back().End(), late.trees.front().events.front().at);
  EXPECT_EQ(late.trees.back().End(), Milliseconds(9990));
}

TEST_F(ARecording, KeepsTheFileOfTheRunBefore) {
  std::filesystem::create_directories(folder_ / "new");
  std::ofstream(file_) << "the run before\nits tree\n";
  Open().reset();
  EXPECT_EQ(TextOf(file_ + ".before"), "the run before\nits tree\n");
}

TEST_F(ARecording, OfARunWithoutATreeReplacesNone) {
  std::filesystem::create_directories(folder_ / "new");
  std::ofstream(file_ + ".before") << "the crash\nits tree\n";
  std::ofstream(file_) << "musher-tree-recording 2 show\n";
  Open();
  EXPECT_EQ(TextOf(file_ + ".before"), "the crash\nits tree\n");
}

TEST_F(ARecording, OfATreeThatDoesNotFitIsNotWrittenAndIsLogged) {
  auto recording = Open(1000);
  recording->Begin(View(), factory_);
  Tick(*recording, 3);
  recording.reset();
  EXPECT_THAT(Log(), ElementsAre(HasSubstr("the tree is not recorded: its description has ")));
  EXPECT_TRUE(Read(TextOf(file_)).trees.empty());
}

TEST_F(ARecording, OfAFullDiskIsLoggedOnceAndTheTreeGoesOn) {
  file_ = "/dev/full";
  auto recording = Open();
  recording->Begin(View(), factory_);
  Tick(*recording, 100);
  recording.reset();
  EXPECT_THAT(Log(), ElementsAre("the recording ends here: /dev/full cannot be written to"));
}

TEST_F(ARecording, ThatCannotBeOpenedNamesTheFile) {
  const auto opened = TreeRecording::Open("show", {.file = "/proc/none/show.tree"}, {});
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().message,
              HasSubstr("the recording /proc/none/show.tree cannot be written to: No such file"));
}

// A pipe without a reader blocks like a disk that hangs.
TEST_F(ARecording, OfADiskThatHangsDelaysNoTickAndSaysWhatIsMissing) {
  file_ = folder_ / "pipe";
  ASSERT_EQ(mkfifo(file_.c_str(), 0600), 0);
  const UniqueFd reader(open(file_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  ASSERT_TRUE(reader.valid());
  auto recording = Open(std::size_t{1} << 30);
  recording->Begin(View(), factory_);
  const auto start = std::chrono::steady_clock::now();
  Tick(*recording, 10'000);  // several MB
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));

  // The disk recovers.
  std::string text;
  bool ends = false;
  std::thread draining([&] {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(120);
    std::array<char, 65536> bytes{};
    while (std::chrono::steady_clock::now() < deadline) {
      const ssize_t got = read(reader.get(), bytes.data(), bytes.size());
      if (got > 0) {
        const std::lock_guard lock(mutex_);
        text.append(bytes.data(), static_cast<std::size_t>(got));
      } else if (got == 0) {
        return;  // the writer has closed it
      } else {
        std::this_thread::yield();
      }
    }
  });
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(120);
  while (!ends && std::chrono::steady_clock::now() < deadline) {
    Tick(*recording, 1);
    std::this_thread::yield();
    const std::lock_guard lock(mutex_);
    ends = text.find("\nlost ") != std::string::npos;
  }
  recording.reset();
  draining.join();
  EXPECT_TRUE(ends);
  const tree::Recording read = Read(text);
  ASSERT_EQ(read.trees.size(), 2U) << "and the tree again";
  EXPECT_EQ(read.trees.front().events.back().kind, tree::RecordedEvent::Kind::kLost);
  EXPECT_GT(read.trees.front().events.back().lines, 1000U);
  EXPECT_THAT(Log(), IsEmpty());
}

}  // namespace musher::tree_recording_test
