#pragma once
// How far an upgrade is: on a terminal one line that is redrawn, else a line for each step, with
// --json a document for each.

#include <cstdint>
#include <string>

#include "musher/controller/cli/console.hpp"

namespace musher::cli {

class OtaProgress {
 public:
  explicit OtaProgress(Console& console) : console_(console) {}
  ~OtaProgress() { Clear(); }
  OtaProgress(const OtaProgress&) = delete;
  OtaProgress& operator=(const OtaProgress&) = delete;

  // The next step; `total_bytes` 0: it has none to count.
  void Begin(std::string_view step, std::uint64_t total_bytes = 0);
  void Add(std::uint64_t bytes);
  void End();

 private:
  void Draw();
  void Clear();

  Console& console_;
  std::string step_;
  std::uint64_t total_bytes_ = 0;
  std::uint64_t bytes_ = 0;
  int percent_ = -1;  // drawn
};

}  // namespace musher::cli
