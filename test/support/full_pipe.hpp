#pragma once
// A descriptor that takes nothing, as the file of a log on a disk that does not answer.

#include <fcntl.h>
#include <unistd.h>

#include <string>

#include "musher/base/unique_fd.hpp"

namespace musher::testing {

class FullPipe {
 public:
  FullPipe() {
    int ends[2] = {-1, -1};
    if (pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0) return;
    reader_ = UniqueFd(ends[0]);
    writer_ = UniqueFd(ends[1]);
    fcntl(writer_.get(), F_SETPIPE_SZ, 4096);
    while (write(writer_.get(), "x", 1) == 1) {
    }
    fcntl(writer_.get(), F_SETFL, 0);
  }

  int writer() const { return writer_.get(); }
  // All that it has taken up to this text, once it is there.
  std::string ReadUntil(const std::string& end) const {
    fcntl(reader_.get(), F_SETFL, 0);
    std::string text;
    char byte = 0;
    while (!text.ends_with(end) && read(reader_.get(), &byte, 1) == 1) {
      if (byte != 'x') text += byte;
    }
    return text;
  }

 private:
  UniqueFd reader_;
  UniqueFd writer_;
};

}  // namespace musher::testing
