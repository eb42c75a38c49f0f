#include "musher/modules/skills/robot/photo_folder.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <utility>
#include <vector>

#include "musher/base/files.hpp"

namespace musher::skills {
namespace {

namespace fs = std::filesystem;

bool IsInside(const fs::path& folder, const fs::path& path) {
  const fs::path relative = path.lexically_relative(folder);
  return !relative.empty() && *relative.begin() != ".." && relative != ".";
}

Error Refused(const std::string& name, const std::string& why) {
  constexpr std::size_t kLongest = 80;
  return {kCodeParametersInvalid, "photo '" + name.substr(0, kLongest) + "': " + why};
}

Result<std::string> WritePng(const Picture& picture, const std::string& folder,
                             const std::string& name) {
  Result<std::string> path = PhotoPath(folder, name);
  if (!path) return path;
  const std::size_t bytes = std::size_t{picture.width} * picture.height * 3;
  if (bytes == 0 || picture.bgr.size() != bytes) return Refused(name, "the picture is empty");
  std::error_code error;
  fs::create_directories(fs::path(path.value()).parent_path(), error);
  if (error)
    return Error{kCodeFailed, "cannot make the folder of " + path.value() + ": " + error.message()};
  std::vector<unsigned char> png;
  try {
    // OpenCV takes a pointer that is not const and does not write through it.
    const cv::Mat view(static_cast<int>(picture.height), static_cast<int>(picture.width), CV_8UC3,
                       const_cast<std::uint8_t*>(picture.bgr.data()));
    if (!cv::imencode(".png", view, png)) return Refused(name, "PNG could not be encoded");
  } catch (const cv::Exception& thrown) {
    return Refused(name, thrown.what());
  }
  const std::string_view content(reinterpret_cast<const char*>(png.data()), png.size());
  if (Result<> written = ReplaceFile(path.value(), content); !written) return written.error();
  return path.value();
}

}  // namespace

Result<std::string> PhotoPath(const std::string& folder, const std::string& name) {
  const bool printable = std::ranges::all_of(
      name, [](char c) { return c != 0x7f && static_cast<unsigned char>(c) >= 0x20; });
  if (name.empty() || !printable) {
    return Refused(printable ? name : "?", "expected a file name as in \"entrance.png\"");
  }
  const fs::path root = fs::path(folder).lexically_normal();
  const fs::path path = (root / name).lexically_normal();  // an absolute name replaces the root
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension != ".png") return Refused(name, "expected a name that ends with .png");
  const std::string outside = "the path leads out of the photo folder " + root.string();
  if (!IsInside(root, path)) return Refused(name, outside);
  std::error_code error;
  const fs::path real_root = fs::weakly_canonical(root, error);
  const fs::path real = error ? fs::path() : fs::weakly_canonical(path, error);
  if (error) return Refused(name, error.message());
  if (!IsInside(real_root, real)) return Refused(name, outside);
  return path.string();
}

skill::Future<std::string> PhotoFolder::Save(const Picture& picture, const std::string& name) {
  auto source = std::make_shared<skill::Source<std::string>>();
  skill::Future<std::string> future = source->future();
  writer_.Do([this, picture, name, source = std::move(source)]() mutable {
    Result<std::string> written = WritePng(picture, folder_, name);
    // The loop has the last reference: the result is set there.
    loop_.Post(
        [source = std::move(source), written = std::move(written)] { source->Set(written); });
  });
  return future;
}

}  // namespace musher::skills
