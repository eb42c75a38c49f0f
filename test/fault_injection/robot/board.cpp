#include "musher/test/fault_injection/robot/board.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <iterator>
#include <system_error>

namespace musher::fault_injection {

std::int32_t IndexOfState(const std::string& state) {
  for (std::size_t i = 0; i < std::size(kStates); ++i) {
    if (state == kStates[i]) return static_cast<std::int32_t>(i + 1);
  }
  return 0;
}

Board& OpenBoard(const std::string& file) {
  static_assert(std::atomic<End>::is_always_lock_free);
  const int fd = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  void* memory = MAP_FAILED;
  if (fd >= 0 && ftruncate(fd, sizeof(Board)) == 0) {
    memory = mmap(nullptr, sizeof(Board), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  }
  const int error = errno;
  if (fd >= 0) close(fd);
  if (memory == MAP_FAILED) throw std::system_error(error, std::generic_category(), file);
  return *static_cast<Board*>(memory);  // atomics of zeros are what the file holds
}

void ClearFaults(Board& board) {
  board.end = End::kNot;
  board.end_in = 0;
  board.hang_in = 0;
  board.fail_in = 0;
  board.callback_ms = 0;
  board.silent = false;
}

}  // namespace musher::fault_injection
