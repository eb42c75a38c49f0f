// Where a flyer was in the air when its process was killed, in the process after it.

#include "musher/modules/skills/robot/saved_flight.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "musher/test/support/temp_folder.hpp"

namespace musher::skills::saved_flight_test {

class ASavedFlight : public ::testing::Test {
 protected:
  SavedFlight Process() const {
    return SavedFlight(file_, [this] { return now_; });
  }
  void Write(const std::string& text) const { std::ofstream(file_) << text; }
  std::string Read() const {
    std::ifstream file(file_);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  const TempFolder folder_;
  const std::string file_ = folder_ / "state/r_flight.toml";
  HostTime now_{"this boot", std::chrono::hours(5)};
};

TEST_F(ASavedFlight, IsFoundByTheNextProcessWithinTenSeconds) {
  SavedFlight before = Process();
  EXPECT_FALSE(before.Found());
  EXPECT_TRUE(before.Save(navigation::Point{1, -2, 0.8}));
  now_.since_boot += SavedFlight::kMostAge;
  EXPECT_EQ(Process().Found(), (navigation::Point{1, -2, 0.8}));
  now_.since_boot += Milliseconds(1);
  EXPECT_FALSE(Process().Found());
}

TEST_F(ASavedFlight, IsNotFoundAfterAnotherBoot) {
  EXPECT_TRUE(Process().Save(navigation::Point{1, -2, 0.8}));
  now_.host = "the next boot";
  EXPECT_FALSE(Process().Found());
  now_.host = "";
  EXPECT_TRUE(Process().Save(navigation::Point{1, -2, 0.8}));
  EXPECT_FALSE(Process().Found()) << "the host is not known";
}

TEST_F(ASavedFlight, IsTheLastOneOfASecondBeforeAndEndsWithTheFlight) {
  SavedFlight flight = Process();
  EXPECT_TRUE(flight.Save(navigation::Point{0, 0, 1}));
  now_.since_boot += Milliseconds(900);
  EXPECT_TRUE(flight.Save(navigation::Point{1, 0, 1}));
  EXPECT_EQ(Process().Found(), (navigation::Point{0, 0, 1})) << "written once a second";
  now_.since_boot += Milliseconds(100);
  EXPECT_TRUE(flight.Save(navigation::Point{2, 0, 1}));
  EXPECT_EQ(Process().Found(), (navigation::Point{2, 0, 1}));
  EXPECT_TRUE(flight.Save(std::nullopt));
  EXPECT_FALSE(Process().Found());
  EXPECT_TRUE(flight.Save(navigation::Point{2, 0, 1})) << "at once, in the next flight";
  EXPECT_TRUE(Process().Found());
}

// The loop that waited for the disk held the flyer no more: the wind had it. The pipe in the place
// of the draft has no reader.
TEST_F(ASavedFlight, IsNotAwaitedFromADiskThatDoesNotAnswer) {
  std::filesystem::create_directories(folder_ / "state");
  ASSERT_EQ(mkfifo((file_ + ".new").c_str(), 0600), 0);
  SavedFlight flight = Process();
  EXPECT_THAT(flight.Save(navigation::Point{0, 0, 1}).error().message,
              ::testing::HasSubstr("the disk has not answered"));
  now_.since_boot += std::chrono::seconds(1);
  EXPECT_TRUE(flight.Save(navigation::Point{1, 0, 1})) << "said once";
}

TEST_F(ASavedFlight, OfTheProcessBeforeEndsWhereTheNextOneFindsItOnTheGround) {
  EXPECT_TRUE(Process().Save(navigation::Point{0, 0, 1}));
  EXPECT_TRUE(Process().Save(std::nullopt));
  EXPECT_FALSE(Process().Found());
}

TEST_F(ASavedFlight, IsNoneInAFileThatIsNotWhole) {
  EXPECT_TRUE(Process().Save(navigation::Point{1, -2, 0.8}));
  const std::string whole = Read();
  for (std::size_t size = 0; size + 1 < whole.size(); ++size) {
    Write(whole.substr(0, size));
    static_cast<void>(Process().Found());
  }
  Write("written_host = \"this boot\"\nx_m = 1\n");
  EXPECT_FALSE(Process().Found());
  Write("x_m = nan\n" + whole.substr(0, whole.find("x_m")) + "y_m = 0\nz_m = 1\n");
  EXPECT_FALSE(Process().Found());
}

TEST_F(ASavedFlight, SaysOnceWhyItIsNotSaved) {
  std::filesystem::create_directories(folder_ / "state");
  std::filesystem::create_directories(file_);  // a folder in its place
  SavedFlight flight = Process();
  const auto failed = flight.Save(navigation::Point{1, -2, 0.8});
  ASSERT_FALSE(failed);
  EXPECT_THAT(failed.error().message,
              ::testing::HasSubstr("where it is in the air is not saved: "));
  now_.since_boot += std::chrono::seconds(2);
  EXPECT_TRUE(flight.Save(navigation::Point{1, -2, 0.8}));
}

}  // namespace musher::skills::saved_flight_test
