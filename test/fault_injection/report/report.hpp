#pragma once
// The report of the fault-injection suite, as tables and as a picture.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "musher/test/fault_injection/fault_run.hpp"

namespace musher::fault_injection {

// Milliseconds from the fault; count 0: not measured.
struct Figures {
  std::size_t count = 0;
  double p50 = 0;
  double p99 = 0;
  double max = 0;
};

struct KindFigures {
  std::string kind;
  std::string family;
  std::string about;
  std::size_t count = 0;
  std::size_t failed = 0;
  Figures detection;
  Figures recovery;
};

class Report {
 public:
  Report(std::vector<Outcome> outcomes, std::uint64_t seed, std::vector<std::string> skipped);

  // Writes report.md, report.json and report.svg into this folder, which it makes. Throws when it
  // cannot write them.
  void Write(const std::filesystem::path& folder) const;

  std::size_t failed() const;
  std::string Summary() const;  // a line
  const std::vector<KindFigures>& kinds() const { return kinds_; }

 private:
  std::string Markdown() const;
  std::string Json() const;

  std::vector<Outcome> outcomes_;
  std::uint64_t seed_;
  std::vector<std::string> skipped_;
  std::vector<KindFigures> kinds_;
};

// Detection and recovery of each kind on a logarithmic axis.
std::string Svg(const std::vector<KindFigures>& kinds, const std::string& title);

// The command that repeats one fault alone.
std::string ReplayCommand(const Outcome& outcome);

}  // namespace musher::fault_injection
