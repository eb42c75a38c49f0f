// Real files, and processes that print into them. The tests read at any time; the loop does
// not run unless a test is about that.

#include "musher/controller/storage/log_files.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <thread>

#include "musher/controller/storage/log_reader.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::log_files_test {

namespace fs = std::filesystem;
using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;
using ::testing::UnorderedElementsAre;

constexpr std::int64_t kBound = 5 << 20;  // of which 1 MiB is for the live file

std::string ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string ReadCompressed(const std::string& path) {
  gzFile file = gzopen(path.c_str(), "rb");
  std::string text;
  std::array<char, 64 << 10> buffer{};
  for (int got = 0; (got = gzread(file, buffer.data(), buffer.size())) > 0;) {
    text.append(buffer.data(), static_cast<std::size_t>(got));
  }
  EXPECT_EQ(gzclose(file), Z_OK) << path;
  return text;
}

std::int64_t WallNow() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

class Logs : public ::testing::Test {
 protected:
  // Whether the beginning of a file can be removed: not on tmpfs, which /tmp is on some systems.
  bool Collapses() const {
    const std::string path = folder_ / "probe";
    std::ofstream(path) << std::string(1 << 20, '.');
    const int file = open(path.c_str(), O_RDWR | O_CLOEXEC);
    const bool can = fallocate(file, FALLOC_FL_COLLAPSE_RANGE, 0, 1 << 16) == 0;
    close(file);
    fs::remove(path);
    return can;
  }
  void Make(std::int64_t max_total = 500 << 20, bool may_collapse = true) {
    LogFilesOptions options;
    options.logs = {{"legs", legs_, kBound}, {"eyes", eyes_, kBound}};
    options.max_total_bytes = max_total;
    options.may_collapse = may_collapse;
    options.on_trouble = [this](const std::string& text) { troubles_.push_back(text); };
    logs_ = std::make_unique<LogFiles>(loop_, options);
  }
  int Output(const std::string& name = "legs") const {
    const auto output = logs_->Output(name);
    return output ? output->get() : -1;
  }
  // Lines "legs 000000017 ...", 50 bytes each, that continue from the last call.
  void Print(std::int64_t bytes, const std::string& name = "legs") {
    const int output = Output(name);
    ASSERT_GE(output, 0);
    for (std::int64_t done = 0; done < bytes; done += 50) {
      const std::string line = Line(name, next_[name]++);
      ASSERT_EQ(write(output, line.data(), line.size()), 50);
    }
  }
  static std::string Line(const std::string& name, int number) {
    std::string line = std::to_string(number);
    line.insert(0, 9 - line.size(), '0');
    line = name + " " + line;
    return line.append(49 - line.size(), '.') + "\n";
  }
  // All that can be read, in order: the parts by their numbers, then the live file.
  std::string All(const std::string& path) const {
    std::string text;
    for (const std::string& part : Parts(path)) text += ReadCompressed(part);
    return text + ReadFile(path);
  }
  static std::vector<std::string> Parts(const std::string& path) {
    std::vector<std::string> parts;
    for (int number = 1; number < 1000; ++number) {
      std::string part = path + "." + std::to_string(number) + ".gz";
      if (fs::exists(part)) parts.push_back(std::move(part));
    }
    return parts;
  }
  std::string Expected(const std::string& name = "legs") {
    std::string text;
    for (int number = 0; number < next_[name]; ++number) text += Line(name, number);
    return text;
  }
  std::int64_t FolderSize() const {
    std::int64_t bytes = 0;
    for (const auto& entry : fs::directory_iterator(folder_ / "logs")) {
      if (entry.path().extension() != ".times") bytes += entry.file_size();
    }
    return bytes;
  }

  TempFolder folder_;
  const std::string legs_ = folder_ / "logs/legs.log";
  const std::string eyes_ = folder_ / "logs/eyes.log";
  transport::LinuxEventLoop loop_;
  std::vector<std::string> troubles_;
  std::map<std::string, int> next_;
  std::unique_ptr<LogFiles> logs_;
};

TEST_F(Logs, AreMadeAtOnceInAFolderForTheirOwnerOnly) {
  Make();
  EXPECT_GE(Output(), 0);
  EXPECT_EQ(logs_->Output("hands"), nullptr);
  struct stat info {};
  ASSERT_EQ(stat((folder_ / "logs").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0700U);
}

// As another user could have left it before the state folder became ours. Files there were written,
// and cut.
TEST_F(Logs, OfAFolderThatIsALinkAreNeitherWrittenNorCut) {
  const std::string elsewhere = folder_ / "elsewhere";
  fs::create_directory(elsewhere);
  std::ofstream(elsewhere + "/legs.log") << std::string(2 * kBound, 'x');
  std::ofstream(elsewhere + "/legs.log.1.gz") << std::string(2 * kBound, 'x');
  fs::create_directory_symlink(elsewhere, folder_ / "logs");
  Make();
  logs_->LookNow();
  EXPECT_EQ(Output("legs"), -1);
  EXPECT_EQ(Output("eyes"), -1);
  EXPECT_THAT(troubles_, ElementsAre(HasSubstr("actuator output is lost: can't write " + legs_ +
                                               ": Too many levels of symbolic links")));
  std::vector<std::string> files;
  for (const auto& file : fs::directory_iterator(elsewhere)) {
    files.push_back(file.path().filename());
    EXPECT_EQ(file.file_size(), static_cast<std::uintmax_t>(2 * kBound)) << file.path();
  }
  EXPECT_THAT(files, UnorderedElementsAre("legs.log", "legs.log.1.gz"));
}

TEST_F(Logs, OfTheControllerAreCutThroughALinkOnlyWhereAPersonMayHavePutIt) {
  const std::string target = folder_ / "target";
  std::ofstream(target) << std::string(2 * kBound, 'x');
  const std::string link = folder_ / "controller.log";
  fs::create_symlink(target, link);
  for (const bool may_be_link : {false, true}) {
    LogFilesOptions options;
    options.logs = {{"the controller", link, kBound, /*open=*/false, may_be_link}};
    logs_ = std::make_unique<LogFiles>(loop_, options);
    logs_->LookNow();
    EXPECT_EQ(fs::file_size(target) < static_cast<std::uintmax_t>(kBound), may_be_link);
  }
}

TEST_F(Logs, ThatAreSmallAreLeftAlone) {
  Make();
  Print(1'000'000);
  logs_->LookNow();
  EXPECT_THAT(Parts(legs_), IsEmpty());
  EXPECT_TRUE(ReadFile(legs_) == Expected());
}

TEST_F(Logs, KeepEveryByteWhileTheyAreRotated) {
  if (!Collapses()) GTEST_SKIP() << "the filesystem of " << folder_.path();
  Make();
  for (int i = 0; i < 6; ++i) {
    Print(1'200'000);
    logs_->LookNow();
    EXPECT_LE(fs::file_size(legs_), 1U << 20);
  }
  EXPECT_EQ(Parts(legs_).size(), 6U);
  EXPECT_TRUE(All(legs_) == Expected());
  EXPECT_THAT(troubles_, IsEmpty());
}

TEST_F(Logs, LoseNoLineOfAProcessThatPrintsMeanwhile) {
  if (!Collapses()) GTEST_SKIP() << "the filesystem of " << folder_.path();
  Make();
  const int output = Output();
  std::atomic<bool> stop = false;
  std::thread printer([&] {
    while (!stop) {
      struct stat live {};
      fstat(output, &live);
      if (live.st_size > kBound / 3) {  // of more than 2 / 5 a part is dropped
        std::this_thread::yield();
        continue;
      }
      const std::string line = Line("legs", next_["legs"]++);
      static_cast<void>(write(output, line.data(), line.size()));
    }
  });
  while (Parts(legs_).size() < 8) logs_->LookNow();
  stop = true;
  printer.join();
  const std::string all = All(legs_);
  EXPECT_EQ(all.find("[musher:"), std::string::npos) << "something was dropped";
  EXPECT_TRUE(all == Expected()) << "lines are missing, double or in another order";
}

TEST_F(Logs, AreCopiedAndCutWhereTheFilesystemCannotCollapseAndSaySo) {
  Make(500 << 20, false);
  for (int i = 0; i < 3; ++i) {
    Print(1'200'000);
    logs_->LookNow();
    EXPECT_THAT(ReadFile(legs_), AllOf(StartsWith("[musher: "), HasSubstr("are missing]")));
  }
  std::string all = All(legs_);
  const std::string note = ReadFile(legs_);
  for (std::size_t at = 0; (at = all.find(note)) != std::string::npos;) all.erase(at, note.size());
  EXPECT_TRUE(all == Expected());
}

TEST_F(Logs, OfAFloodAreCutInTheMiddleWithALineThatReportsHowMuch) {
  if (!Collapses()) GTEST_SKIP() << "the filesystem of " << folder_.path();
  Make();
  Print(9 << 20);
  logs_->LookNow();
  ASSERT_EQ(Parts(legs_).size(), 1U);
  const std::string part = ReadCompressed(Parts(legs_)[0]);
  EXPECT_THAT(part, StartsWith(Line("legs", 0)));
  EXPECT_THAT(part, HasSubstr("bytes dropped here: output exceeded the log rate limit]\n"));
  EXPECT_THAT(ReadFile(legs_), EndsWith(Line("legs", next_["legs"] - 1)));
  // The lines on disk and the lines reported as dropped are all printed lines.
  const std::size_t note = part.find("\n[musher: ");
  const std::int64_t dropped = std::stoll(part.substr(note + 10));
  EXPECT_EQ(static_cast<std::int64_t>(note + fs::file_size(legs_)) + dropped,
            next_["legs"] * std::int64_t{50});
  ASSERT_EQ(troubles_.size(), 1U);
  EXPECT_THAT(troubles_[0], AllOf(HasSubstr("the log of legs: "), HasSubstr(" MB dropped")));
  Print(9 << 20);
  logs_->LookNow();
  EXPECT_EQ(troubles_.size(), 1U) << "reported again within a minute";
}

TEST_F(Logs, StayBelowTheirBoundHoweverMuchIsPrinted) {
  Make();
  for (int i = 0; i < 40; ++i) {
    Print(1 << 20);
    logs_->LookNow();
    EXPECT_LE(FolderSize(), kBound);
  }
  const auto parts = Parts(legs_);
  EXPECT_LE(parts.size(), 20U);
  EXPECT_FALSE(fs::exists(legs_ + ".1.gz")) << "the oldest goes first";
}

TEST_F(Logs, TogetherStayBelowTheBoundOfAll) {
  Make();
  for (int i = 0; i < 3; ++i) {
    Print(1'200'000);
    Print(1'200'000, "eyes");
    logs_->LookNow();
  }
  const std::int64_t all = FolderSize();
  const auto oldest = fs::file_size(legs_ + ".1.gz");
  logs_.reset();
  Make(all - 1);
  logs_->LookNow();
  EXPECT_EQ(FolderSize(), all - static_cast<std::int64_t>(oldest));
  EXPECT_FALSE(fs::exists(legs_ + ".1.gz"));
  EXPECT_TRUE(fs::exists(eyes_ + ".1.gz"));
}

TEST_F(Logs, ThatWereRemovedAreMadeAgain) {
  Make();
  fs::remove_all(folder_ / "logs");
  logs_->LookNow();
  Print(50);
  EXPECT_EQ(ReadFile(legs_), Line("legs", 0));
  EXPECT_THAT(troubles_, IsEmpty());
}

TEST_F(Logs, ThatCannotBeOpenedAreReportedOnceAndTriedAgain) {
  std::ofstream(folder_ / "logs") << "in the way";
  Make();
  EXPECT_EQ(logs_->Output("legs"), nullptr);
  for (int i = 0; i < 3; ++i) logs_->LookNow();
  EXPECT_THAT(troubles_, ElementsAre(AllOf(StartsWith("actuator output is lost: "),
                                           HasSubstr("Not a directory"))));
  fs::remove(folder_ / "logs");
  logs_->LookNow();
  EXPECT_NE(logs_->Output("legs"), nullptr);
}

TEST_F(Logs, OnAFullDiskAreDroppedWithALineThatReportsIt) {
  if (!Collapses()) GTEST_SKIP() << "the filesystem of " << folder_.path();
  Make();
  Print(1'200'000);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto ignored = signal(SIGXFSZ, SIG_IGN);
  const rlimit none{1, before.rlim_max};  // as on a full disk: no part can be written
  setrlimit(RLIMIT_FSIZE, &none);
  logs_->LookNow();
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_THAT(Parts(legs_), IsEmpty());
  EXPECT_TRUE(ReadFile(legs_) == Expected()) << "nothing is lost as long as there is room";
  ASSERT_EQ(troubles_.size(), 1U);
  EXPECT_THAT(troubles_[0], StartsWith("the log of legs is not rotated: can't write"));
  Print(1'200'000);
  setrlimit(RLIMIT_FSIZE, &none);
  logs_->LookNow();
  logs_->LookNow();
  setrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, ignored);
  EXPECT_LE(fs::file_size(legs_), 1'100'000U);
  EXPECT_THAT(ReadFile(legs_), EndsWith(Line("legs", next_["legs"] - 1)));
  ASSERT_EQ(troubles_.size(), 2U);
  EXPECT_THAT(troubles_[1], HasSubstr("MB dropped: it cannot be saved"));
  for (const auto& entry : fs::directory_iterator(folder_ / "logs")) {
    EXPECT_THAT(entry.path().extension(), AnyOf(".log", ".times")) << "half a part was left";
  }
}

TEST_F(Logs, AreRotatedPeriodically) {
  Make();
  Print(1'200'000);
  EXPECT_TRUE(loop_.RunUntil([&] { return fs::exists(legs_ + ".1.gz"); },
                             loop_.Now() + std::chrono::seconds(120)));
}

// With the loop's help, within a tenth of a second; of a part as of the live file.
TEST_F(Logs, KnowWhenEachLineWasWritten) {
  if (!Collapses()) GTEST_SKIP() << "the filesystem of " << folder_.path();
  const std::int64_t begun_ns = WallNow();
  Make();
  Print(1'200'000);
  ASSERT_TRUE(loop_.RunUntil([&] { return fs::exists(legs_ + ".1.gz"); },
                             loop_.Now() + std::chrono::seconds(120)));
  Print(50);
  const auto newest = [&] {
    auto reader = LogReader::Open(legs_);
    const auto lines = reader.value().Before();
    return lines.empty() ? WrittenLine{} : lines.back();
  };
  ASSERT_TRUE(loop_.RunUntil([&] { return newest().written_ns != 0; },
                             loop_.Now() + std::chrono::seconds(120)));
  auto reader = LogReader::Open(legs_);
  int lines = 0;
  for (auto piece = reader.value().Before(); !piece.empty(); piece = reader.value().Before()) {
    for (const WrittenLine& line : piece) {
      ++lines;
      EXPECT_GE(line.written_ns, begun_ns) << line.text;
      EXPECT_LE(line.written_ns, WallNow()) << line.text;
    }
  }
  EXPECT_EQ(lines, next_["legs"]);
}

}  // namespace musher::log_files_test
