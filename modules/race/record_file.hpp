#pragma once
// The file of a recording. The one of the run before is kept once as FILE.before.
//
// Threads: one at a time.

#include <fstream>
#include <memory>
#include <string>
#include <string_view>

#include "musher/base/result.hpp"

namespace musher::race {

class RecordFile {
 public:
  // Fails when the file is not writable.
  static Result<std::unique_ptr<RecordFile>> Open(const std::string& path);

  // Flushed to disk at the latest when the state changes.
  void Write(std::string_view line);
  // False once a line could not be written: all later lines are lost.
  bool good() const { return stream_.good(); }

 private:
  explicit RecordFile(const std::string& path) : stream_(path) {}

  std::ofstream stream_;
};

}  // namespace musher::race
