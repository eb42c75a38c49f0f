#pragma once
// Writes metrics as text for Prometheus and everything that reads its formats: OpenMetrics 1.0, or
// Prometheus' own text format 0.0.4. Knows no robot.
//
//   Exposition text(Format::kOpenMetrics);
//   text.BeginCounter({"musher_switches", "Switches that ended."});
//   text.Add(7, {{"target", "Active"}});
//   std::string page = std::move(text).Finish();
//
// The families and, within them, the samples are in the order of the calls. Names, helps and units
// are the program's own and are not checked; label values may be any bytes: what is not UTF-8
// becomes U+FFFD. A family without samples is written too, so that its help can be read.
//
// Threads: any, one at a time; no clock, no IO.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace musher::view {

enum class MetricsFormat { kOpenMetrics, kPrometheus };

// For the header Content-Type.
std::string_view ContentTypeOf(MetricsFormat format);
// The format that a client with this header Accept gets: OpenMetrics, unless it prefers text/plain,
// or text/html, as a browser does.
MetricsFormat FormatFor(std::string_view accept);

struct Label {
  std::string_view name;
  std::string_view value;
};
using Labels = std::span<const Label>;

// In OpenMetrics the name of a counter has no "_total" and that of an info no "_info"; their
// samples have. A unit is the end of the name.
struct Family {
  std::string_view name;
  std::string_view help;
  std::string_view unit = {};
};

// How often something took how long, in seconds, in buckets of fixed bounds.
class DurationHistogram {
 public:
  static constexpr std::array kBounds = {0.005, 0.01, 0.025, 0.05, 0.1,  0.25,
                                         0.5,   1.0,  2.5,   5.0,  10.0, 30.0};

  // Not negative.
  void Observe(double seconds);

  double sum() const { return sum_; }
  std::uint64_t count() const { return count_; }
  // Counts by bound, each without the one before; the last is for everything above.
  const std::array<std::uint64_t, kBounds.size() + 1>& counts() const { return counts_; }

 private:
  std::array<std::uint64_t, kBounds.size() + 1> counts_{};
  std::uint64_t count_ = 0;
  double sum_ = 0;
};

class Exposition {
 public:
  explicit Exposition(MetricsFormat format) : format_(format) {}

  // Each begins a family, to which the following Add…() belong.
  void BeginGauge(const Family& family) { Begin(family, "gauge", "gauge", ""); }
  void BeginCounter(const Family& family) { Begin(family, "counter", "counter", "_total"); }
  void BeginInfo(const Family& family) { Begin(family, "info", "gauge", "_info"); }
  void BeginStateSet(const Family& family) { Begin(family, "stateset", "gauge", ""); }
  void BeginHistogram(const Family& family) { Begin(family, "histogram", "histogram", ""); }

  // A sample of a gauge or counter; of an info the value is 1.
  void Add(double value, std::initializer_list<Label> labels = {});
  void Add(std::uint64_t value, std::initializer_list<Label> labels = {});
  void Add(bool value, std::initializer_list<Label> labels = {}) {
    Add(std::uint64_t{value}, labels);
  }
  // One sample for each state: 1 for `present`, else 0. Their label has the name of the family.
  void AddStates(std::span<const std::string_view> states, std::string_view present,
                 std::initializer_list<Label> labels = {});
  void AddHistogram(const DurationHistogram& histogram, std::initializer_list<Label> labels = {});

  std::string Finish() &&;

 private:
  void Begin(const Family& family, std::string_view type, std::string_view prometheus_type,
             std::string_view suffix);
  // A line up to its value; `last` after the labels, unless its name is empty.
  void Line(std::string_view suffix, std::initializer_list<Label> labels, const Label& last);
  void Put(double value);
  void Put(std::uint64_t value);
  void PutEscaped(std::string_view text, bool quotes);
  void PutLabel(const Label& label);

  const MetricsFormat format_;
  std::string text_;
  std::string name_;    // of the present family
  std::string suffix_;  // of its samples
};

}  // namespace musher::view
