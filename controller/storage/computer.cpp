#include "musher/controller/storage/computer.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>

#include "musher/base/files.hpp"

namespace musher {
namespace {

namespace fs = std::filesystem;

// The letters and digits of a file's first line, in lower case.
std::string WordIn(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  std::string word;
  for (const char c : line) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return word;
}

// Of many computers: what vendors leave in the place of a number.
bool IsUnset(const std::string& word) {
  constexpr std::size_t kShortest = 6;
  constexpr std::array<std::string_view, 4> kUnset = {"03000200040005000006000700080009",
                                                      "0123456789", "123456789", "1234567890"};
  const bool has_digit = std::ranges::any_of(word, [](char c) { return c >= '0' && c <= '9'; });
  const bool one_letter = word.find_first_not_of(word.substr(0, 1)) == std::string::npos;
  return word.size() < kShortest || !has_digit || one_letter ||
         std::ranges::count(kUnset, word) != 0;
}

std::string_view KindOf(std::string_view part) {
  return part.substr(0, part.find(':'));
}

}  // namespace

std::vector<std::string> ComputerParts(const std::string& root) {
  std::vector<std::string> parts;
  const auto add = [&](std::string_view kind, const fs::path& file) {
    const std::string word = WordIn(file);
    if (!IsUnset(word)) parts.push_back(std::string(kind) + word);
  };
  add("uuid:", root + "/sys/class/dmi/id/product_uuid");
  add("serial:", root + "/sys/class/dmi/id/product_serial");
  add("device-tree:", root + "/proc/device-tree/serial-number");
  for (const fs::path& card : EntriesOf(root + "/sys/class/net")) {
    std::error_code error;
    const bool is_device = fs::exists(card / "device", error);
    const bool is_permanent = WordIn(card / "addr_assign_type") == "0";
    if (is_device && is_permanent) add("mac:", card / "address");
  }
  std::ranges::sort(parts);
  return parts;
}

bool IsOtherComputer(const std::vector<std::string>& stored, const std::vector<std::string>& now) {
  if (stored.empty() || now.empty()) return false;
  return std::ranges::none_of(
      stored, [&](const std::string& part) { return std::ranges::count(now, part) != 0; });
}

std::vector<std::string> ComputerToStore(const std::vector<std::string>& stored,
                                         std::vector<std::string> now) {
  const std::vector<std::string> present = now;
  for (const std::string& part : stored) {
    const bool known = std::ranges::any_of(
        present, [&](const std::string& one) { return KindOf(one) == KindOf(part); });
    if (!known) now.push_back(part);
  }
  std::ranges::sort(now);
  return now;
}

}  // namespace musher
