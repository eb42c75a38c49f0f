// Preloaded where qemu-user runs programs of another processor: before 10.2 it does not know
// IP_MULTICAST_IF, without which Cyclone DDS joins no domain. In the namespace of scripts/roots,
// which has no interface but lo, there is no choice.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <netinet/in.h>
#include <sys/socket.h>

int setsockopt(int fd, int level, int option, const void* value, socklen_t size) {
  int (*next)(int, int, int, const void*, socklen_t) = dlsym(RTLD_NEXT, "setsockopt");
  const int result = next(fd, level, option, value, size);
  if (result != 0 && errno == ENOPROTOOPT && level == IPPROTO_IP && option == IP_MULTICAST_IF)
    return 0;
  return result;
}
