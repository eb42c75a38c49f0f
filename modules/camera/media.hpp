#pragma once
// Video files, devices and picture files, through OpenCV's codecs. These need two hundred shared
// libraries and some 55 MB of memory, so they are a library of their own that is loaded before the
// self-check of a camera that needs it, or on first use: a robot whose cameras are topics never
// loads it.
//
// Threads: LoadMedia() and the Media from any, each reader and recorder one at a time. All of it
// may block: never call it on a loop. No exception leaves it; codes are the camera server's
// (44xx).

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/messages/sensor_msgs/image.hpp"

namespace musher::camera {

// A source of one picture after the other.
class PictureReader {
 public:
  virtual ~PictureReader() = default;

  // The next one, bgr8 or mono8, without a header; nothing at the end.
  virtual Result<std::optional<msg::Image>> Next() = 0;
  // Back to the first one.
  virtual Result<> Rewind() = 0;
  // Its own pictures a second; 0: unknown, or the device paces itself.
  virtual double rate_hz() const = 0;
};

class Recorder {
 public:
  virtual ~Recorder() = default;
  // bgr8, all of one size.
  virtual Result<> Write(msg::Image& picture) = 0;
  // Ends the file.
  virtual Result<> Close() = 0;
};

// 0: as the device has it.
struct DeviceRequest {
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  double rate_hz = 0;
};

class Media {
 public:
  virtual ~Media() = default;

  virtual Result<std::unique_ptr<PictureReader>> OpenVideo(const std::string& path) = 0;
  // `from`: a path, "/dev/video0", or a number.
  virtual Result<std::unique_ptr<PictureReader>> OpenDevice(const std::string& from,
                                                            const DeviceRequest& requested) = 0;
  // The pictures in it, by name.
  virtual Result<std::unique_ptr<PictureReader>> OpenFolder(const std::string& path) = 0;

  // In the format of the ending of `path`: .jpg, .png, .bmp. The picture is bgr8 or mono8.
  virtual Result<> Save(msg::Image& picture, const std::string& path) = 0;
  // Motion JPEG in AVI.
  virtual Result<std::unique_ptr<Recorder>> Record(const std::string& path, std::uint32_t width_px,
                                                   std::uint32_t height_px, double rate_hz) = 0;
};

// Suppresses what OpenCV and FFmpeg would write to stderr, since errors are reported here; and
// sets the timeout of a device without pictures to 2 s. Call it in main(), before there are
// threads.
void SetUpCodecs();

// Stays loaded until the program exits. Fails when the library is not where it was installed.
Result<Media*> LoadMedia();

// The entry point of the library.
inline constexpr const char* kMediaEntry = "MusherCameraMedia";
using MediaEntry = Media* (*)();

}  // namespace musher::camera
