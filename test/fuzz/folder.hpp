#pragma once
// A folder in memory, and files with given content in it.

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace musher::fuzz {

class Folder {
 public:
  Folder() {
    const char* const bases[] = {"/dev/shm", "/tmp"};
    for (const char* base : bases) {
      path_ = std::string(base) + "/musher_fuzz_XXXXXX";
      if (mkdtemp(path_.data()) != nullptr) return;
    }
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }

  const std::string& path() const { return path_; }

  std::string Write(const std::string& name, std::string_view content) const {
    std::ofstream file(path_ + "/" + name, std::ios::binary | std::ios::trunc);
    file.write(content.data(), static_cast<std::streamsize>(content.size()));
    return path_ + "/" + name;
  }

 private:
  std::string path_;
};

}  // namespace musher::fuzz
