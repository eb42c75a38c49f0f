// Videos, folders and devices on their own thread. The video is written by OpenCV.

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <vector>

#include "musher/modules/camera/media.hpp"
#include "musher/modules/camera/source.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::camera::capture_source_test {

using ::testing::HasSubstr;

class CaptureSourceTest : public ::testing::Test {
 protected:
  static constexpr int kFrames = 5;

  // Each picture is darker than the next.
  std::string Video(const std::string& name = "walk.avi") {
    const std::string path = folder_ / name;
    cv::VideoWriter writer(path, cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 100,
                           cv::Size(64, 48));
    EXPECT_TRUE(writer.isOpened());
    for (int i = 0; i < kFrames; ++i)
      writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(40 * i)));
    return path;
  }
  void Open(SourceKind kind, const std::string& from, bool loops) {
    CameraConfig camera;
    camera.source = kind;
    camera.from = from;
    camera.loops = loops;
    camera.rate_hz = 100;
    SourceEvents events;
    events.on_frame = [this](msg::Image picture) { frames_.push_back(std::move(picture)); };
    events.on_failed = [this](const Error& error) { failed_ = error; };
    events.on_ended = [this] { ended_ = true; };
    source_ = OpenCapture(loop_, threads_, camera, std::move(events));
  }
  bool Until(const std::function<bool()>& holds) {
    return loop_.RunUntil(holds, loop_.Now() + std::chrono::seconds(30));
  }

  const TempFolder folder_;
  transport::LinuxEventLoop loop_;
  CaptureThreads threads_;
  std::vector<msg::Image> frames_;
  std::optional<Error> failed_;
  bool ended_ = false;
  std::unique_ptr<Source> source_;
};

TEST_F(CaptureSourceTest, PlaysAVideoToItsEnd) {
  Open(SourceKind::kVideo, Video(), false);
  ASSERT_TRUE(Until([this] { return ended_ || failed_; }));
  EXPECT_FALSE(failed_) << failed_->message;
  ASSERT_FALSE(frames_.empty());
  EXPECT_EQ(frames_[0].width, 64u);
  EXPECT_EQ(frames_[0].height, 48u);
  EXPECT_EQ(frames_[0].encoding, "bgr8");
  EXPECT_NEAR(frames_.back().data[0], 40 * (kFrames - 1), 10) << "the last one has come";
}

TEST_F(CaptureSourceTest, BeginsAVideoAgainThatLoops) {
  Open(SourceKind::kVideo, Video(), true);
  ASSERT_TRUE(Until([this] { return frames_.size() > 3 * kFrames || failed_; }));
  EXPECT_FALSE(failed_);
  EXPECT_FALSE(ended_);
}

TEST_F(CaptureSourceTest, ShowsAFolderOfPictures) {
  std::ofstream(folder_ / "readme.txt") << "no picture";
  msg::Image picture;
  picture.width = picture.height = 2;
  picture.encoding = "mono8";
  picture.step = 2;
  for (const std::string name : {"b.png", "a.png"}) {
    picture.data.assign(4, name == "a.png" ? 10 : 20);
    ASSERT_TRUE(LoadMedia().value()->Save(picture, folder_ / name));
  }
  Open(SourceKind::kFolder, folder_.path(), false);
  ASSERT_TRUE(Until([this] { return ended_ || failed_; }));
  EXPECT_FALSE(failed_) << failed_->message;
  ASSERT_FALSE(frames_.empty());
  EXPECT_EQ(frames_.back().data[0], 20) << "by name; a slow loop may skip the first one";
}

TEST_F(CaptureSourceTest, ReportsWhatIsMissingOrBroken) {
  const struct {
    SourceKind kind;
    std::string from;
    std::string why;
  } kCases[] = {{SourceKind::kVideo, folder_ / "none.avi", "there is no such file"},
                {SourceKind::kDevice, "/dev/video99", "there is no device /dev/video99"},
                {SourceKind::kDevice, "99", "there is no device /dev/video99"},
                {SourceKind::kDevice, folder_.path(), "is no device"},
                {SourceKind::kFolder, folder_ / "none", "No such file or directory"},
                {SourceKind::kFolder, folder_.path(), "there is no picture in it"}};
  for (const auto& item : kCases) {
    failed_.reset();
    Open(item.kind, item.from, true);
    ASSERT_TRUE(Until([this] { return failed_.has_value(); }));
    EXPECT_EQ(failed_->code, 4412);
    EXPECT_THAT(failed_->message, HasSubstr(item.why));
  }
}

TEST_F(CaptureSourceTest, ReportsAFileThatIsNoVideo) {
  const std::string broken = folder_ / "broken.avi";
  std::ofstream(broken) << std::string(10'000, 'x');
  Open(SourceKind::kVideo, broken, true);
  ASSERT_TRUE(Until([this] { return failed_.has_value(); }));
  EXPECT_THAT(failed_->message, HasSubstr("is no video"));
}

TEST_F(CaptureSourceTest, PlaysTheCompletePartOfAVideoThatIsCutOff) {
  const std::string path = Video();
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  Open(SourceKind::kVideo, path, false);
  ASSERT_TRUE(Until([this] { return ended_ || failed_; }));
}

TEST_F(CaptureSourceTest, DeliversNothingAfterItsDestruction) {
  Open(SourceKind::kVideo, Video(), true);
  ASSERT_TRUE(Until([this] { return !frames_.empty(); }));
  source_.reset();
  const std::size_t count = frames_.size();
  loop_.RunUntil([] { return false; }, loop_.Now() + Milliseconds(50));
  EXPECT_EQ(frames_.size(), count);
}

}  // namespace musher::camera::capture_source_test
