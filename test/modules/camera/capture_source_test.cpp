// Videos, folders and devices on their own thread. The video is written by OpenCV.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <vector>

#include "musher/base/unique_fd.hpp"
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
    return loop_.RunUntil(holds, loop_.Now() + std::chrono::seconds(120));
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

// A virtual camera of the kernel, by the name of its driver: never a camera of this computer.
struct VirtualCamera {
  std::string file;  // "": there is none
  bool needs_writer = false;
};
VirtualCamera FindVirtualCamera() {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/sys/class/video4linux", error)) {
    const std::string file = "/dev/" + entry.path().filename().string();
    const UniqueFd fd(open(file.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
    v4l2_capability is{};
    if (!fd.valid() || ioctl(fd.get(), VIDIOC_QUERYCAP, &is) < 0) continue;
    const std::string driver = reinterpret_cast<const char*>(is.driver);
    if (driver == "v4l2 loopback") return {file, true};
    constexpr __u32 kOfACamera = V4L2_CAP_VIDEO_CAPTURE;  // its touch pad captures, too
    const bool is_camera = (is.device_caps & (kOfACamera | V4L2_CAP_TOUCH)) == kOfACamera;
    if (driver == "vivid" && is_camera) return {file, false};
  }
  return {};
}

TEST_F(CaptureSourceTest, ShowsWhatAVirtualCameraOfTheKernelDelivers) {
  const VirtualCamera camera = FindVirtualCamera();
  if (camera.file.empty()) GTEST_SKIP() << "this kernel has no camera of vivid or v4l2loopback";
  UniqueFd writer;
  transport::LoopHandlePtr writing;
  std::vector<unsigned char> picture;
  if (camera.needs_writer) {
    writer = UniqueFd(open(camera.file.c_str(), O_RDWR | O_CLOEXEC));
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    format.fmt.pix.width = 640;
    format.fmt.pix.height = 480;
    format.fmt.pix.pixelformat = V4L2_PIX_FMT_YUYV;
    format.fmt.pix.field = V4L2_FIELD_NONE;
    ASSERT_EQ(ioctl(writer.get(), VIDIOC_S_FMT, &format), 0) << std::strerror(errno);
    picture.assign(format.fmt.pix.sizeimage, 128);
    writing = loop_.Every(Milliseconds(33), [&] {
      EXPECT_EQ(write(writer.get(), picture.data(), picture.size()),
                static_cast<ssize_t>(picture.size()));
    });
  }
  Open(SourceKind::kDevice, camera.file, true);
  ASSERT_TRUE(Until([this] { return frames_.size() >= 3 || failed_; }));
  ASSERT_FALSE(failed_) << failed_->message;
  EXPECT_GT(frames_.back().width, 0U);
  EXPECT_EQ(frames_.back().data.size(),
            static_cast<std::size_t>(frames_.back().step) * frames_.back().height);
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
