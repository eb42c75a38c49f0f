// Keeps a core busy until it is killed. It has a session of its own: a kernel that shares the CPU
// by session would else protect the robot from it.

#include <unistd.h>

#include <atomic>

int main() {
  setsid();
  std::atomic<unsigned> work = 0;
  while (true) ++work;
}
