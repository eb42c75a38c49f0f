#pragma once
// A small text file that is also written when the disk is full, and that has one of its last two
// contents after a power cut. Its blocks are reserved beforehand, and it is overwritten in place:
// two slots of fixed size, each a line with its number and checksum and then the text. A write goes
// to the older slot, so an interrupted write leaves the newer slot whole.
//
// The state store has five: emergency_stop, and what else decides which actuators move after a
// restart of the controller: epoch, policy, actuators and processes.
//
// Threads: any, one at a time; Write() and Reserve() wait for the disk.

#include <optional>
#include <string>
#include <string_view>

#include "musher/base/result.hpp"

namespace musher {

class SlotFile {
 public:
  static constexpr std::size_t kSlotSize = 64 << 10;  // bytes, with the line
  static constexpr std::size_t kShortSlot = 4 << 10;  // a block of most disks

  struct Content {
    std::string text;      // of the newest whole slot; empty: none was written
    bool damaged = false;  // a slot is neither whole nor empty: perhaps it was the newest
    bool plain = false;    // the file has no slots: it was written by another program or version
    int error = 0;         // why it cannot be read, as errno; it is damaged then
  };

  explicit SlotFile(std::string path, std::size_t slot_size = kSlotSize)
      : path_(std::move(path)), slot_size_(slot_size) {}

  // Whether a slot has room for it.
  bool Fits(std::string_view text) const;
  // What a file without slots holds never has this size, which distinguishes them.
  std::size_t size() const;
  // Makes the file with its blocks. A file without slots is replaced by one with `text`. One that
  // has its blocks is not touched.
  Result<> Reserve(std::string_view text) const;
  // Overwrites the older slot. Makes the file first where it is missing.
  Result<> Write(std::string_view text) const;
  // nullopt: there is no file. A file that cannot be read, or is no regular file, is damaged.
  std::optional<Content> Read() const;

 private:
  std::string path_;
  std::size_t slot_size_;
};

}  // namespace musher
