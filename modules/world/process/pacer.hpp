#pragma once
// When the next step of a world is due, so that world time runs at a chosen factor of real time;
// and the factor that is reached.
//
// After a pause of the process it does not catch up: all but a little of the missed time is
// dropped, and world time is that much slower. Plain decisions; real time is an argument.

#include <optional>
#include <string>

#include "musher/base/time.hpp"

namespace musher::world {

class Pacer {
 public:
  // `step` of world time each, from `now` on.
  Pacer(Duration step, double factor, Time now);

  // A step is done; returns when the next one is due, in the past when it is late.
  Time Next(Time now);

  void SetFactor(double factor, Time now);
  // World time does not advance meanwhile; this does not count as slow.
  void SetPaused(bool paused, Time now);

  Time due() const { return due_; }  // the next step
  double factor() const { return factor_; }
  bool paused() const { return paused_; }

  // The factor over the last whole period of measurement; the requested one before the first is
  // over.
  double reached() const { return reached_.value_or(factor_); }

  // A line for the log: the factor cannot be reached, or is reached again. Once for each change.
  std::optional<std::string> TakeLogLine();

 private:
  Duration Period() const;
  void Measure(Time now);
  void MeasureFrom(Time now);

  Duration step_;
  double factor_;
  bool paused_ = false;
  Time due_;
  Time measured_since_;
  int steps_ = 0;  // since then
  std::optional<double> reached_;
  bool slow_ = false;
  std::optional<std::string> log_line_;
};

}  // namespace musher::world
