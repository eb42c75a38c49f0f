#include "musher/modules/race/record_file.hpp"

#include <filesystem>
#include <system_error>

namespace musher::race {

Result<std::unique_ptr<RecordFile>> RecordFile::Open(const std::string& path) {
  std::error_code none;
  if (std::filesystem::is_regular_file(path, none)) {
    std::filesystem::rename(path, path + ".before", none);
  }
  std::unique_ptr<RecordFile> file(new RecordFile(path));
  if (!file->good()) return Error{kCodeFailed, "robot.record: " + path + " cannot be written to"};
  return file;
}

void RecordFile::Write(std::string_view line) {
  stream_ << line;
  if (line.starts_with("changed")) stream_.flush();
}

}  // namespace musher::race
