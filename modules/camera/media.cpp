#include "musher/modules/camera/media.hpp"

#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>

#include "musher/base/program_path.hpp"
#include "musher/modules/camera/camera_code.hpp"

namespace musher::camera {
namespace {

// Next to the program in the build tree; in the folder of libraries once installed.
std::string PathOfLibrary() {
  constexpr const char* kName = "libmusher_camera_media.so";
  const auto folder = OwnProgram().parent_path();
  const auto beside = folder / kName;
  std::error_code failed;
  if (std::filesystem::exists(beside, failed)) return beside;
  return folder / ".." / MUSHER_LIBRARY_FOLDER / kName;
}

}  // namespace

void SetUpCodecs() {
  setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);
  setenv("OPENCV_LOG_LEVEL", "SILENT", 0);
  setenv("OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT", "2", 0);
}

Result<Media*> LoadMedia() {
  static const Result<Media*> media = []() -> Result<Media*> {
    constexpr std::int32_t kCode = CameraCode(KeyCode::kUninitialized);
    void* library = dlopen(PathOfLibrary().c_str(), RTLD_NOW | RTLD_LOCAL);
    const auto failed = [] {
      const char* why = dlerror();
      return Error{kCode, std::string("no video and picture files: ") + (why ? why : "unknown")};
    };
    if (library == nullptr) return failed();
    const auto entry = reinterpret_cast<MediaEntry>(dlsym(library, kMediaEntry));
    if (entry == nullptr) return failed();
    return entry();
  }();
  return media;
}

}  // namespace musher::camera
