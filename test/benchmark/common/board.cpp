#include "musher/test/benchmark/common/board.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <thread>

#include "musher/test/benchmark/common/child.hpp"

namespace musher::benchmark {

Board& OpenBoard(const std::string& file) {
  static_assert(std::atomic<std::int64_t>::is_always_lock_free);
  const int fd = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (fd < 0 || ftruncate(fd, sizeof(Board)) != 0) Fail("no board " + file);
  void* memory = mmap(nullptr, sizeof(Board), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  close(fd);
  if (memory == MAP_FAILED) Fail("no board " + file);
  return *static_cast<Board*>(memory);  // atomics of zeros are what the file holds
}

void AwaitCheckpoint(const Board& board) {
  const std::int64_t now = NowOnBoard();
  while (board.checkpoint_at < now) std::this_thread::sleep_for(Milliseconds(1));
}

}  // namespace musher::benchmark
