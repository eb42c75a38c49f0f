#pragma once
// The progress of an upgrade: on a terminal one line that is redrawn, else a line for each step,
// with --json a document for each step.

#include <cstdint>
#include <string>

#include "musher/cli/console/console.hpp"

namespace musher::cli {

class OtaProgress {
 public:
  explicit OtaProgress(Console& console) : console_(console) {}
  ~OtaProgress() { Clear(); }
  OtaProgress(const OtaProgress&) = delete;
  OtaProgress& operator=(const OtaProgress&) = delete;

  // Begins the next step; `total_bytes` 0: it counts no bytes.
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
  int percent_ = -1;  // last drawn; -1: none
};

}  // namespace musher::cli
