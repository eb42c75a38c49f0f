#include "musher/controller/storage/slot_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <sstream>

#include "musher/base/checksum.hpp"
#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/unique_fd.hpp"

namespace musher {
namespace {

constexpr std::size_t kSlotCount = 2;
constexpr std::size_t kLongestPlain = 4 << 20;  // bytes, of a file without slots

struct Slot {
  std::uint64_t number = 0;  // 0: empty or damaged
  bool damaged = false;
  std::string text;
};

std::uint64_t ChecksumOf(std::uint64_t number, std::string_view text) {
  return Fnv1a(std::to_string(number) + " " + std::string(text));
}

std::string Encoded(std::uint64_t number, std::string_view text) {
  return "slot " + std::to_string(number) + " " + std::to_string(text.size()) + " " +
         std::to_string(ChecksumOf(number, text)) + "\n" + std::string(text);
}

std::string BytesAt(int fd, std::size_t offset, std::size_t size) {
  std::string bytes(size, '\0');
  const ssize_t got = pread(fd, bytes.data(), size, static_cast<off_t>(offset));
  bytes.resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
  return bytes;
}

Slot ReadSlot(int fd, std::size_t which, std::size_t slot_size) {
  const std::string bytes = BytesAt(fd, which * slot_size, slot_size);
  Slot slot;
  const bool all_there = bytes.size() == slot_size;
  if (all_there && bytes.find_first_not_of('\0') == std::string::npos) return slot;
  const std::size_t line = std::min(bytes.find('\n'), bytes.size());
  std::istringstream words(bytes.substr(0, line));
  std::string kind;
  std::size_t size = 0;
  std::uint64_t checksum = 0;
  const bool read = static_cast<bool>(words >> kind >> slot.number >> size >> checksum);
  slot.damaged = !read || kind != "slot" || line + 1 + size > bytes.size();
  if (!slot.damaged) {
    slot.text = bytes.substr(line + 1, size);
    slot.damaged = ChecksumOf(slot.number, slot.text) != checksum || slot.number == 0;
  }
  if (slot.damaged) slot = {0, true, ""};
  return slot;
}

bool HasSlots(int fd, std::size_t size) {
  struct stat info {};
  return fstat(fd, &info) == 0 && info.st_size == static_cast<off_t>(size);
}

// Zero where the blocks are taken; posix_fallocate() writes them where the file system has no call
// for it. A file that has them keeps its time, by which other folders know whether it was written.
int TakeBlocks(int fd, std::size_t size) {
  constexpr std::size_t kUnit = 512;  // of st_blocks
  struct stat info {};
  if (fstat(fd, &info) == 0 && static_cast<std::size_t>(info.st_blocks) * kUnit >= size) return 0;
  return posix_fallocate(fd, 0, static_cast<off_t>(size));
}

}  // namespace

bool SlotFile::Fits(std::string_view text) const {
  return Encoded(UINT64_MAX, text).size() <= slot_size_;
}

std::size_t SlotFile::size() const {
  return kSlotCount * slot_size_;
}

Result<> SlotFile::Reserve(std::string_view text) const {
  if (!Fits(text)) return Error{kCodeFailed, path_ + " has no room for it"};
  {
    const UniqueFd file(open(path_.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW));
    if (file.valid() && HasSlots(file.get(), size())) {
      const int error = TakeBlocks(file.get(), size());
      return error == 0 ? Ok() : Result<>(SystemError("can't reserve " + path_, error));
    }
  }
  const std::string draft = path_ + ".new";
  const auto failed = [&](int error) {
    unlink(draft.c_str());
    return SystemError("can't reserve " + path_, error);
  };
  UniqueFd file(open(draft.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!file.valid()) return SystemError("can't reserve " + path_);
  if (!text.empty() && !WriteAll(file.get(), Encoded(1, text))) return failed(errno);
  if (const int error = TakeBlocks(file.get(), size()); error != 0) return failed(error);
  if (fsync(file.get()) != 0) return failed(errno);
  if (!file.Close() || rename(draft.c_str(), path_.c_str()) != 0) return failed(errno);
  const bool synced = SyncFolder(std::filesystem::path(path_).parent_path());
  return synced ? Ok() : Result<>(SystemError("can't reserve " + path_));
}

Result<> SlotFile::Write(std::string_view text) const {
  UniqueFd file(open(path_.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW));
  if (!file.valid() || !HasSlots(file.get(), size())) return Reserve(text);
  const Slot first = ReadSlot(file.get(), 0, slot_size_);
  const Slot second = ReadSlot(file.get(), 1, slot_size_);
  if (!Fits(text)) return Error{kCodeFailed, path_ + " has no room for it"};
  const bool to_first = first.number < second.number;
  const std::string bytes = Encoded(std::max(first.number, second.number) + 1, text);
  const off_t offset = to_first ? 0 : static_cast<off_t>(slot_size_);
  const ssize_t written = pwrite(file.get(), bytes.data(), bytes.size(), offset);
  if (written < 0) return SystemError("can't write " + path_);
  if (written != static_cast<ssize_t>(bytes.size())) {
    return SystemError("can't write " + path_, ENOSPC);
  }
  if (fdatasync(file.get()) != 0) return SystemError("can't write " + path_);
  return Ok();
}

std::optional<SlotFile::Content> SlotFile::Read() const {
  const UniqueFd file = OpenRegular(path_);
  if (!file.valid()) {
    // Where a folder is missing, or is a file, there is no stop.
    const bool missing = errno == ENOENT || errno == ENOTDIR;
    return missing ? std::nullopt : std::optional(Content{"", true, false, errno});
  }
  char probe = 0;
  if (pread(file.get(), &probe, 1, 0) < 0) return Content{"", true, false, errno};
  if (!HasSlots(file.get(), size())) {
    struct stat info {};
    fstat(file.get(), &info);
    const auto length = std::min(kLongestPlain, static_cast<std::size_t>(info.st_size));
    return Content{BytesAt(file.get(), 0, length), false, true};
  }
  const std::array<Slot, kSlotCount> slots = {ReadSlot(file.get(), 0, slot_size_),
                                              ReadSlot(file.get(), 1, slot_size_)};
  const Slot& newest = slots[0].number < slots[1].number ? slots[1] : slots[0];
  return Content{newest.text, slots[0].damaged || slots[1].damaged, false};
}

}  // namespace musher
