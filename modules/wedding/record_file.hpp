#pragma once
// The file that a recording goes to. One that is there already is kept beside it, once, as
// FILE.before: a show that was started again has not lost what came before its end.
//
// Threads: one at a time.

#include <fstream>
#include <memory>
#include <string>
#include <string_view>

#include "musher/lifecycle/result.hpp"

namespace musher::wedding {

class RecordFile {
 public:
  // Fails when it cannot be written to.
  static Result<std::unique_ptr<RecordFile>> Open(const std::string& path);

  // On the disk at the latest when the state changes.
  void Write(std::string_view line);
  // False once a line could not be written: what comes after it is lost.
  bool good() const { return stream_.good(); }

 private:
  explicit RecordFile(const std::string& path) : stream_(path) {}

  std::ofstream stream_;
};

}  // namespace musher::wedding
