// GPIO lines of Linux: changes as the kernel has them, by a pipe, and a chip of gpio-sim where this
// kernel has it.

#include "musher/modules/device/gpio_chip.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <linux/gpio.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>

#include "musher/base/files.hpp"
#include "musher/test/support/wait.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::device::gpio_chip_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Direction = GpioLine::Direction;

TEST(GpioPlace, IsAChipAndANumber) {
  EXPECT_EQ(ReadGpioPlace("gpiochip0:5"), (GpioPlace{"gpiochip0", 5}));
  EXPECT_EQ(ReadGpioPlace("gpiochip12:127"), (GpioPlace{"gpiochip12", 127}));
  for (const char* name : {"BUMPER", "gpiochip0", "gpiochip0:", "gpiochip:1", "gpiochipa:1",
                           "gpiochip0:x", "gpiochip0:-1", "gpiochip0:99999999999", "../x:1", ""}) {
    EXPECT_EQ(ReadGpioPlace(name), std::nullopt) << name << " is the name of a line";
  }
}

// Collects what a line reports.
struct Watcher {
  GpioLine::Events Events() {
    return {[this](bool active) { levels.push_back(active); }, [this] { ++gaps; },
            [this](const std::string& why) { lost.push_back(why); }};
  }
  std::vector<bool> levels;
  int gaps = 0;
  std::vector<std::string> lost;
};

class GpioChanges : public ::testing::Test {
 protected:
  GpioChanges() {
    int ends[2] = {-1, -1};
    EXPECT_EQ(pipe2(ends, O_NONBLOCK | O_CLOEXEC), 0);
    writer_ = UniqueFd(ends[1]);
    line_ = std::make_unique<GpioFile>(loop_, "gpiochip0:5", UniqueFd(ends[0]), Direction::kInput,
                                       watcher_.Events());
  }
  gpio_v2_line_event Change(bool rising, Duration ago = {}) {
    gpio_v2_line_event change{};
    const Duration at = loop_.Now().time_since_epoch() - ago;
    change.timestamp_ns = static_cast<std::uint64_t>(at.count());
    change.id = rising ? GPIO_V2_LINE_EVENT_RISING_EDGE : GPIO_V2_LINE_EVENT_FALLING_EDGE;
    change.line_seqno = ++number_;
    return change;
  }
  void Write(const std::vector<gpio_v2_line_event>& changes) {
    const std::size_t size = changes.size() * sizeof(gpio_v2_line_event);
    ASSERT_EQ(write(writer_.get(), changes.data(), size), static_cast<ssize_t>(size));
  }
  bool Until(const std::function<bool()>& holds) {
    return loop_.RunUntil(holds, musher::testing::In(std::chrono::seconds(120)));
  }

  transport::LinuxEventLoop loop_;
  Watcher watcher_;
  std::uint32_t number_ = 0;
  UniqueFd writer_;
  std::unique_ptr<GpioFile> line_;
};

TEST_F(GpioChanges, AreReportedInTheirOrder) {
  Write({Change(true), Change(false)});
  ASSERT_TRUE(Until([this] { return watcher_.levels.size() == 2; }));
  EXPECT_THAT(watcher_.levels, ElementsAre(true, false));
  EXPECT_EQ(watcher_.gaps, 0);
}

TEST_F(GpioChanges, ThatTheKernelHasDroppedAreAGap) {
  Write({Change(true)});
  ASSERT_TRUE(Until([this] { return watcher_.levels.size() == 1; }));
  number_ += 3;
  Write({Change(true)});
  ASSERT_TRUE(Until([this] { return watcher_.levels.size() == 2; }));
  EXPECT_EQ(watcher_.gaps, 1);
}

// The loop hung: two touches that are read at once may have been seconds apart.
TEST_F(GpioChanges, ThatAreReadLateAreAGap) {
  const auto seconds = [](int count) { return std::chrono::seconds(count); };
  Write({Change(true, seconds(4)), Change(false, seconds(3)), Change(true, seconds(2))});
  ASSERT_TRUE(Until([this] { return !watcher_.levels.empty(); }));
  EXPECT_EQ(watcher_.gaps, 1);
  EXPECT_THAT(watcher_.levels, ElementsAre(true)) << "the present one only";
}

TEST_F(GpioChanges, EndWithTheirChip) {
  writer_ = UniqueFd();
  ASSERT_TRUE(Until([this] { return !watcher_.lost.empty(); }));
  EXPECT_THAT(watcher_.lost, ElementsAre(HasSubstr("gpiochip0:5: ")));
}

TEST(GpioLineOfThisComputer, ThatDoesNotExistIsNamed) {
  transport::LinuxEventLoop loop;
  GpioSpec spec;
  spec.line = "gpiochip987:1";
  auto opened = OpenGpioLine(loop, spec, Direction::kInput, {});
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().message, "/dev/gpiochip987: No such file or directory");
  spec.line = "no line has this name";
  opened = OpenGpioLine(loop, spec, Direction::kInput, {});
  ASSERT_FALSE(opened);
}

// A chip of gpio-sim with four lines, of which the first two have a name. Its other end is in
// /sys/devices/platform.
class SimulatedChip : public ::testing::Test {
 protected:
  void SetUp() override {
    static_cast<void>(std::system("modprobe -q gpio-sim 2>/dev/null"));
    if (!std::filesystem::exists("/sys/kernel/config/gpio-sim")) {
      GTEST_SKIP() << "no gpio-sim in /sys/kernel/config: this kernel has no such module, or "
                      "configfs is not mounted";
    }
    std::error_code error;
    std::filesystem::create_directory(folder_, error);
    if (error) GTEST_SKIP() << folder_ << ": " << error.message();
    std::filesystem::create_directory(folder_ / "bank0");
    Put(folder_ / "bank0/num_lines", "4");
    for (const auto& [line, name] :
         {std::pair("line0", "MUSHER-BUMPER"), std::pair("line1", "MUSHER-LAMP")}) {
      std::filesystem::create_directory(folder_ / "bank0" / line);
      Put(folder_ / "bank0" / line / "name", name);
    }
    Put(folder_ / "live", "1");
    chip_ = FirstLine(folder_ / "bank0/chip_name");
    device_ =
        std::filesystem::path("/sys/devices/platform") / FirstLine(folder_ / "dev_name") / chip_;
    ASSERT_TRUE(std::filesystem::exists("/dev/" + chip_)) << chip_;
  }
  void TearDown() override {
    if (chip_.empty()) return;
    Put(folder_ / "live", "0");
    for (const char* part : {"bank0/line0", "bank0/line1", "bank0", ""}) {
      std::error_code error;
      std::filesystem::remove(folder_ / part, error);
    }
  }
  static void Put(const std::filesystem::path& file, const std::string& text) {
    std::ofstream stream(file);
    stream << text << std::flush;
    EXPECT_TRUE(stream.good()) << file;
  }
  static std::string FirstLine(const std::filesystem::path& file) {
    const std::string text = ReadFile(file);
    return text.substr(0, text.find('\n'));
  }
  // The voltage of an input.
  void Pull(int line, bool up) {
    Put(device_ / ("sim_gpio" + std::to_string(line)) / "pull", up ? "pull-up" : "pull-down");
  }
  std::string Voltage(int line) {
    return FirstLine(device_ / ("sim_gpio" + std::to_string(line)) / "value");
  }
  Result<std::unique_ptr<GpioLine>> Open(const std::string& name, Direction direction,
                                         bool active_low = false) {
    GpioSpec spec;
    spec.line = name;
    spec.active_low = active_low;
    spec.debounce = Milliseconds(1);
    return OpenGpioLine(loop_, spec, direction, watcher_.Events());
  }
  static std::string Why(const Result<std::unique_ptr<GpioLine>>& opened) {
    return opened ? "it is open" : opened.error().message;
  }
  bool Until(const std::function<bool()>& holds) {
    return loop_.RunUntil(holds, musher::testing::In(std::chrono::seconds(120)));
  }

  const std::filesystem::path folder_ =
      "/sys/kernel/config/gpio-sim/musher-" + std::to_string(getpid());
  transport::LinuxEventLoop loop_;
  Watcher watcher_;
  std::string chip_;
  std::filesystem::path device_;
};

TEST_F(SimulatedChip, HasAnInputThatIsFoundByItsName) {
  Pull(0, false);
  auto line = Open("MUSHER-BUMPER", Direction::kInput);
  ASSERT_TRUE(line) << Why(line);
  EXPECT_FALSE(line.value()->IsActive().value());
  Pull(0, true);
  ASSERT_TRUE(Until([this] { return watcher_.levels.size() == 1; }));
  Pull(0, false);
  ASSERT_TRUE(Until([this] { return watcher_.levels.size() == 2; }));
  EXPECT_THAT(watcher_.levels, ElementsAre(true, false));
  EXPECT_EQ(watcher_.gaps, 0);
}

TEST_F(SimulatedChip, HasAnInputThatIsActiveAt0V) {
  Pull(2, false);
  auto line = Open(chip_ + ":2", Direction::kInput, true);
  ASSERT_TRUE(line) << Why(line);
  EXPECT_TRUE(line.value()->IsActive().value());
  Pull(2, true);
  ASSERT_TRUE(Until([this] { return !watcher_.levels.empty(); }));
  EXPECT_THAT(watcher_.levels, ElementsAre(false));
}

TEST_F(SimulatedChip, HasAnOutputThatIsOffOnceItsProgramHasEnded) {
  auto line = Open("MUSHER-LAMP", Direction::kOutput);
  ASSERT_TRUE(line) << Why(line);
  EXPECT_EQ(Voltage(1), "0");
  EXPECT_TRUE(line.value()->Set(true));
  EXPECT_EQ(Voltage(1), "1");
  line.value().reset();
  EXPECT_EQ(Voltage(1), "0");
}

TEST_F(SimulatedChip, NamesWhatHasALine) {
  const auto first = Open("MUSHER-LAMP", Direction::kOutput);
  ASSERT_TRUE(first) << Why(first);
  EXPECT_EQ(Why(Open(chip_ + ":1", Direction::kInput)),
            chip_ + ":1 'MUSHER-LAMP' is in use by 'musher-device-manager'");
}

TEST_F(SimulatedChip, SaysWhichLinesItHas) {
  EXPECT_EQ(Why(Open(chip_ + ":4", Direction::kInput)),
            chip_ + " has 4 lines, from 0 on: 4 is none of them");
  EXPECT_EQ(Why(Open("MUSHER-NONE", Direction::kInput)),
            "no GPIO line is named 'MUSHER-NONE'; `gpioinfo` lists them");
}

// Not of an input: Linux 6.1 warns of its own interrupt then.
TEST_F(SimulatedChip, ThatIsGoneIsNoticed) {
  auto output = Open("MUSHER-LAMP", Direction::kOutput);
  ASSERT_TRUE(output) << Why(output);
  Put(folder_ / "live", "0");
  const Result<> set = output.value()->Set(true);
  ASSERT_FALSE(set);
  EXPECT_EQ(set.error().message, chip_ + ":1 'MUSHER-LAMP': No such device");
  EXPECT_FALSE(output.value()->IsActive());
  output.value().reset();
  Put(folder_ / "live", "1");
}

}  // namespace musher::device::gpio_chip_test
