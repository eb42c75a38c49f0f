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

// Whether vendors leave this word in the place of a number: many computers have it.
bool IsUnset(const std::string& word) {
  constexpr std::size_t kShortest = 6;
  constexpr std::array<std::string_view, 4> kUnset = {"03000200040005000006000700080009",
                                                      "0123456789", "123456789", "1234567890"};
  const bool has_digit = std::ranges::any_of(word, [](char c) { return c >= '0' && c <= '9'; });
  const bool one_letter = word.find_first_not_of(word.substr(0, 1)) == std::string::npos;
  return word.size() < kShortest || !has_digit || one_letter ||
         std::ranges::count(kUnset, word) != 0 ||
         (word.starts_with("0x") && word.find_first_not_of('0', 2) == std::string::npos);
}

// Whether the path in sysfs leads to something that is plugged into USB.
bool IsOnUsb(const fs::path& path) {
  std::error_code error;
  return fs::canonical(path, error).string().find("/usb") != std::string::npos;
}

// The number of a disk; empty: it has none, or can be unplugged, or is simulated: those have what
// their user has typed, or the same text for all of them. Of SATA only a world-wide name. `serial`
// of eMMC is a part of its `cid`.
std::string NumberOfDisk(const fs::path& disk) {
  if (WordIn(disk / "removable") == "1" || IsOnUsb(disk)) return {};
  const std::string model = WordIn(disk / "device/model");
  for (const char* simulated : {"qemu", "vmware", "vbox", "virtual"}) {
    if (model.find(simulated) != std::string::npos) return {};
  }
  for (const char* file : {"device/cid", "device/serial"}) {
    if (std::string word = WordIn(disk / file); !IsUnset(word)) return word;
  }
  const std::string name = WordIn(disk / "device/wwid");
  return name.starts_with("naa") && !IsUnset(name) ? name : std::string();
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
    if (is_device && is_permanent && !IsOnUsb(card / "device")) add("mac:", card / "address");
  }
  if (parts.empty()) return parts;
  for (const fs::path& disk : EntriesOf(root + "/sys/block")) {
    const std::string number = NumberOfDisk(disk);
    if (!number.empty()) parts.push_back("disk:" + number);
  }
  std::ranges::sort(parts);
  const auto repeated = std::unique(parts.begin(), parts.end());  // a disk has several devices
  parts.erase(repeated, parts.end());
  return parts;
}

bool IsOtherComputer(const std::vector<std::string>& stored, const std::vector<std::string>& now) {
  const bool comparable = std::ranges::any_of(stored, [&](const std::string& part) {
    return std::ranges::any_of(now,
                               [&](const std::string& one) { return KindOf(one) == KindOf(part); });
  });
  return comparable && std::ranges::none_of(stored, [&](const std::string& part) {
           return std::ranges::count(now, part) != 0;
         });
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
