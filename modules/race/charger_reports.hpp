#pragma once
// Whether the robot is on a charger, by the reports of all publishers of its battery. One is
// expected. Of several that disagree none is believed in turn: the robot is on a charger as long as
// one of them reports it. A publisher that is silent for kSilent while others report counts no
// longer: one that was restarted is another publisher.
//
// Pure: time is an argument.

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>

#include "musher/base/time.hpp"
#include "musher/transport/publisher_turns.hpp"

namespace musher::race {

class ChargerReports {
 public:
  static constexpr Duration kSilent = std::chrono::seconds(10);

  struct Change {
    // It was put on a charger, by a publisher that has not reported one before; or no publisher
    // reports one any more.
    std::optional<bool> on;
    bool doubled = false;  // several publishers are received in turn: once, until one is alone
  };

  Change Take(transport::EndpointId publisher, bool on, Time now) {
    std::erase_if(reports_, [&](const auto& report) {
      return report.first != publisher && now - report.second.at >= kSilent;
    });
    const auto known = reports_.find(publisher);
    const bool put_on = on && (known == reports_.end() ? !on_ : !known->second.on);
    reports_[publisher] = {on, now};
    const bool any =
        std::ranges::any_of(reports_, [](const auto& report) { return report.second.on; });
    Change change;
    if (put_on || any != on_) change.on = any;
    on_ = any;
    const bool several = reports_.size() > 1;
    change.doubled = turns_.Note(publisher) && several && !doubled_;
    doubled_ = several && (doubled_ || change.doubled);
    return change;
  }

 private:
  struct Report {
    bool on = false;
    Time at{};
  };

  std::map<transport::EndpointId, Report> reports_;
  transport::PublisherTurns turns_;
  bool on_ = false;
  bool doubled_ = false;
};

}  // namespace musher::race
