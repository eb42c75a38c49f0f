// The library described in media.hpp.

#include <sys/stat.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <optional>
#include <utility>

#include "musher/modules/camera/camera_code.hpp"
#include "musher/modules/camera/media.hpp"

namespace musher::camera {
namespace {

Error Failure(const std::string& what, KeyCode key = KeyCode::kDeviceError) {
  return {CameraCode(key), what};
}

// Runs code in which OpenCV may throw.
template <class F>
auto Guarded(const std::string& about, const F& work) -> decltype(work()) {
  try {
    return work();
  } catch (const std::exception& error) {
    std::string why = error.what();
    why = why.substr(0, why.find('\n'));
    return Failure(about + ": " + why);
  }
}

std::optional<msg::Image> Picture(const cv::Mat& mat) {
  if (mat.empty() || mat.depth() != CV_8U || (mat.channels() != 1 && mat.channels() != 3)) {
    return std::nullopt;
  }
  msg::Image picture;
  picture.width = static_cast<std::uint32_t>(mat.cols);
  picture.height = static_cast<std::uint32_t>(mat.rows);
  picture.encoding = mat.channels() == 1 ? "mono8" : "bgr8";
  picture.step = picture.width * static_cast<std::uint32_t>(mat.channels());
  picture.data.reserve(std::size_t{picture.step} * picture.height);
  for (int row = 0; row < mat.rows; ++row) {
    const std::uint8_t* begin = mat.ptr<std::uint8_t>(row);
    picture.data.insert(picture.data.end(), begin, begin + picture.step);
  }
  return picture;
}

cv::Mat View(msg::Image& picture) {
  return {static_cast<int>(picture.height), static_cast<int>(picture.width),
          picture.encoding == "mono8" ? CV_8UC1 : CV_8UC3, picture.data.data(), picture.step};
}

// OpenCV's objects are handles: a copy is the same video or device.
class VideoReader : public PictureReader {
 public:
  VideoReader(std::string path, const cv::VideoCapture& capture)
      : path_(std::move(path)), capture_(capture) {}

  Result<std::optional<msg::Image>> Next() override {
    using Next = Result<std::optional<msg::Image>>;
    return Guarded(path_, [this]() -> Next {
      cv::Mat mat;
      if (capture_.read(mat)) {
        given_ = true;
        return Picture(mat);
      }
      if (!given_) return Failure(path_ + ": no picture can be read from it");
      return std::optional<msg::Image>();
    });
  }
  Result<> Rewind() override {
    return Guarded(path_, [this]() -> Result<> {
      given_ = false;
      // Not every container can seek.
      if (!capture_.open(path_, cv::CAP_FFMPEG)) return Failure(path_ + ": cannot be opened again");
      return Ok();
    });
  }
  double rate_hz() const override { return capture_.get(cv::CAP_PROP_FPS); }

 private:
  const std::string path_;
  cv::VideoCapture capture_;
  bool given_ = false;  // a picture since the start
};

class DeviceReader : public PictureReader {
 public:
  DeviceReader(std::string device, const cv::VideoCapture& capture)
      : device_(std::move(device)), capture_(capture) {}

  Result<std::optional<msg::Image>> Next() override {
    using Next = Result<std::optional<msg::Image>>;
    return Guarded(device_, [this]() -> Next {
      cv::Mat mat;
      if (!capture_.read(mat)) return Failure(device_ + " gives no more pictures");
      return Picture(mat);
    });
  }
  Result<> Rewind() override { return Ok(); }
  double rate_hz() const override { return 0; }

 private:
  const std::string device_;
  cv::VideoCapture capture_;
};

class FolderReader : public PictureReader {
 public:
  explicit FolderReader(std::vector<std::string> files) : files_(std::move(files)) {}

  Result<std::optional<msg::Image>> Next() override {
    using Next = Result<std::optional<msg::Image>>;
    if (at_ >= files_.size()) return std::optional<msg::Image>();
    const std::string& file = files_[at_++];
    return Guarded(file, [&file]() -> Next {
      auto picture = Picture(cv::imread(file, cv::IMREAD_COLOR));
      if (!picture) return Failure(file + " is no picture");
      return picture;
    });
  }
  Result<> Rewind() override {
    at_ = 0;
    return Ok();
  }
  double rate_hz() const override { return 0; }

 private:
  const std::vector<std::string> files_;
  std::size_t at_ = 0;
};

class VideoRecorder : public Recorder {
 public:
  VideoRecorder(std::string path, const cv::VideoWriter& writer)
      : path_(std::move(path)), writer_(writer) {}

  Result<> Write(msg::Image& picture) override {
    return Guarded(path_, [&]() -> Result<> {
      writer_.write(View(picture));
      return Ok();
    });
  }
  // The writer does not report a full disk: check the file.
  Result<> Close() override {
    return Guarded(path_, [this]() -> Result<> {
      writer_.release();
      cv::VideoCapture again(path_, cv::CAP_FFMPEG);
      if (!again.isOpened() || !again.grab()) {
        return Failure(path_ + ": the video cannot be read back; is the disk full?");
      }
      return Ok();
    });
  }

 private:
  const std::string path_;
  cv::VideoWriter writer_;
};

class OpenCvMedia : public Media {
 public:
  Result<std::unique_ptr<PictureReader>> OpenVideo(const std::string& path) override {
    using Reader = Result<std::unique_ptr<PictureReader>>;
    if (!std::filesystem::exists(path)) {
      return Failure(path + ": there is no such file");
    }
    return Guarded(path, [&]() -> Reader {
      cv::VideoCapture capture(path, cv::CAP_FFMPEG);
      if (!capture.isOpened()) return Failure(path + " is no video");
      return std::unique_ptr<PictureReader>(new VideoReader(path, capture));
    });
  }

  Result<std::unique_ptr<PictureReader>> OpenDevice(const std::string& from,
                                                    const DeviceRequest& requested) override {
    using Reader = Result<std::unique_ptr<PictureReader>>;
    const bool number = from.find_first_not_of("0123456789") == std::string::npos;
    const std::string path = number ? "/dev/video" + from : from;
    // Checked before OpenCV, which only reports that it failed.
    struct stat found {};
    if (stat(path.c_str(), &found) != 0) {
      return Failure("there is no device " + path);
    }
    if (!S_ISCHR(found.st_mode)) return Failure(path + " is no device");
    return Guarded(path, [&]() -> Reader {
      cv::VideoCapture capture(path, cv::CAP_V4L2);
      if (!capture.isOpened()) return Failure(path + " is no camera, or another program uses it");
      const auto request_property = [&](int property, double value) {
        if (value > 0) capture.set(property, value);
      };
      request_property(cv::CAP_PROP_FRAME_WIDTH, requested.width_px);
      request_property(cv::CAP_PROP_FRAME_HEIGHT, requested.height_px);
      request_property(cv::CAP_PROP_FPS, requested.rate_hz);
      return std::unique_ptr<PictureReader>(new DeviceReader(path, capture));
    });
  }

  Result<std::unique_ptr<PictureReader>> OpenFolder(const std::string& path) override {
    std::vector<std::string> files;
    std::error_code failed;
    std::filesystem::directory_iterator entry(path, failed);
    for (; !failed && entry != std::filesystem::directory_iterator(); entry.increment(failed)) {
      std::string ending = entry->path().extension();
      std::transform(ending.begin(), ending.end(), ending.begin(),
                     [](unsigned char c) { return std::tolower(c); });
      const bool picture = ending == ".png" || ending == ".jpg" || ending == ".jpeg" ||
                           ending == ".bmp" || ending == ".webp";
      std::error_code removed;
      if (picture && entry->is_regular_file(removed)) files.push_back(entry->path());
    }
    if (failed) return Failure(path + ": " + failed.message());
    if (files.empty()) return Failure(path + ": there is no picture in it");
    std::sort(files.begin(), files.end());
    return std::unique_ptr<PictureReader>(new FolderReader(std::move(files)));
  }

  Result<> Save(msg::Image& picture, const std::string& path) override {
    return Guarded(path, [&]() -> Result<> {
      if (!cv::imwrite(path, View(picture))) {
        return Failure(path + ": cannot be written", KeyCode::kFailed);
      }
      return Ok();
    });
  }

  Result<std::unique_ptr<Recorder>> Record(const std::string& path, std::uint32_t width_px,
                                           std::uint32_t height_px, double rate_hz) override {
    using Made = Result<std::unique_ptr<Recorder>>;
    return Guarded(path, [&]() -> Made {
      cv::VideoWriter writer(path, cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                             rate_hz,
                             cv::Size(static_cast<int>(width_px), static_cast<int>(height_px)));
      if (!writer.isOpened()) return Failure(path + ": cannot be written", KeyCode::kFailed);
      return std::unique_ptr<Recorder>(new VideoRecorder(path, writer));
    });
  }
};

}  // namespace
}  // namespace musher::camera

extern "C" __attribute__((visibility("default"))) musher::camera::Media* MusherCameraMedia() {
  static musher::camera::OpenCvMedia media;
  return &media;
}
