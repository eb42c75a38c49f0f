// Photos as files.

#include "musher/modules/skills/robot/photo_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::skills::photo_folder_test {

using ::testing::HasSubstr;

namespace fs = std::filesystem;

const Picture kPicture{2, 1, {1, 2, 3, 4, 5, 6}};

class APhotoFolder : public ::testing::Test {
 protected:
  Result<std::string> Save(const std::string& name, const Picture& picture = kPicture) {
    const auto written = photos_.Save(picture, name);
    EXPECT_TRUE(
        loop_.RunUntil([&] { return written.done(); }, loop_.Now() + std::chrono::seconds(120)));
    return written.result();
  }

  const TempFolder temp_;
  const std::string folder_ = temp_ / "photos";
  transport::LinuxEventLoop loop_;
  PhotoFolder photos_{folder_, loop_};
};

TEST_F(APhotoFolder, WritesAPngThatHasThePicture) {
  const auto path = Save("day/one.png");
  ASSERT_TRUE(path) << path.error().message;
  EXPECT_EQ(path.value(), folder_ + "/day/one.png");
  const cv::Mat read = cv::imread(path.value());
  ASSERT_EQ(read.cols, 2);
  EXPECT_EQ(read.at<cv::Vec3b>(0, 1), cv::Vec3b(4, 5, 6));
  EXPECT_TRUE(Save(folder_ + "/two.png")) << "an absolute path inside";
  EXPECT_TRUE(Save("THREE.PNG")) << "take_photo takes it, too";
}

TEST_F(APhotoFolder, RefusesPathsThatLeadOutside) {
  for (const std::string name : {"../out.png", "/tmp/out.png", "a/../../out.png"}) {
    EXPECT_THAT(Save(name).error().message, HasSubstr("the path leads out of the photo folder"))
        << name;
  }
  fs::create_directories(folder_);
  fs::create_directory_symlink(temp_.path(), folder_ + "/link");
  EXPECT_THAT(Save("link/out.png").error().message,
              HasSubstr("the path leads out of the photo folder"));
  EXPECT_FALSE(fs::exists(temp_ / "out.png"));
}

TEST_F(APhotoFolder, RefusesWhatIsNoPhoto) {
  EXPECT_THAT(Save("").error().message, HasSubstr("expected a file name"));
  EXPECT_THAT(Save("a\nb.png").error().message, HasSubstr("expected a file name"));
  EXPECT_THAT(Save("one.jpg").error().message, HasSubstr("ends with .png"));
  EXPECT_THAT(Save("one.png", {2, 2, {1, 2, 3}}).error().message, HasSubstr("is empty"));
}

TEST_F(APhotoFolder, SaysWhyItCannotWrite) {
  std::ofstream(temp_ / "photos") << "a file in place of the folder";
  EXPECT_THAT(Save("one.png").error().message, HasSubstr("cannot make the folder"));
}

}  // namespace musher::skills::photo_folder_test
