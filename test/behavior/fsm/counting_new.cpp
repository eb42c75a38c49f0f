#include "musher/test/behavior/fsm/counting_new.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<std::size_t> times{0};
std::atomic<std::size_t> bytes{0};
}  // namespace

namespace musher::testing {

Allocations AllocationsOfNew() {
  return {times, bytes};
}

}  // namespace musher::testing

void* operator new(std::size_t size) {
  ++times;
  bytes += size;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
