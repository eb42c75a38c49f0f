#include "musher/controller/storage/log_parts.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>

#include "musher/base/files.hpp"

namespace musher {
namespace {

namespace fs = std::filesystem;

// The number of "<file>.<n>.gz"; nullopt: another file.
std::optional<std::uint64_t> PartNumber(const std::string& name, const std::string& file) {
  if (!name.starts_with(file + ".") || !name.ends_with(".gz")) return std::nullopt;
  const char* begin = name.data() + file.size() + 1;
  const char* end = name.data() + name.size() - 3;
  std::uint64_t number = 0;
  const auto [rest, error] = std::from_chars(begin, end, number);
  if (error != std::errc() || rest != end) return std::nullopt;
  return number;
}

}  // namespace

std::string LogPartPath(const std::string& path, std::uint64_t number) {
  return path + "." + std::to_string(number) + ".gz";
}

std::vector<LogPart> LogPartsOf(const std::string& path) {
  std::vector<LogPart> parts;
  const std::string file = fs::path(path).filename();
  for (const fs::path& entry : EntriesOf(fs::path(path).parent_path())) {
    const auto number = PartNumber(entry.filename(), file);
    struct stat info {};
    if (!number || stat(entry.c_str(), &info) != 0) continue;
    parts.push_back({*number, info.st_size,
                     std::int64_t{info.st_mtim.tv_sec} * 1'000'000'000 + info.st_mtim.tv_nsec});
  }
  std::sort(parts.begin(), parts.end(),
            [](const LogPart& a, const LogPart& b) { return a.number < b.number; });
  return parts;
}

}  // namespace musher
