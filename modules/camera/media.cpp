#include "musher/modules/camera/media.hpp"

#include <dlfcn.h>

namespace musher::camera {

Result<Media*> LoadMedia() {
  // By its name alone: the loader looks where the program's RUNPATH says.
  static const Result<Media*> media = []() -> Result<Media*> {
    constexpr std::int32_t kCode = MakeCode(ModuleCode::kCameraServer, KeyCode::kUninitialized);
    void* library = dlopen("libmusher_camera_media.so", RTLD_NOW | RTLD_LOCAL);
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
