// Keeps a core busy until it is killed. A session of its own, or a kernel that shares the CPU by
// session would spare the robot.

#include <unistd.h>

#include <atomic>

int main() {
  setsid();
  std::atomic<unsigned> work = 0;
  while (true) ++work;
}
