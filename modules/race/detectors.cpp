#include "musher/modules/race/detectors.hpp"

#include <utility>

namespace musher::race {

Detectors::Detectors(transport::Node& node, std::string name_space, const Course& course,
                     Handlers handlers)
    : node_(node),
      name_space_(std::move(name_space)),
      course_(course),
      handlers_(std::move(handlers)),
      wanted_(course.detectors.size()),
      open_(course.detectors.size()) {}

void Detectors::Watch(const std::vector<bool>& wanted) {
  wanted_ = wanted;
  Update();
}

void Detectors::OpenAll(bool open) {
  all_ = open;
  Update();
}

void Detectors::Update() {
  for (Index i = 0; i < open_.size(); ++i) {
    const bool wanted = all_ || wanted_[i];
    if (wanted && !open_[i].endpoints) Subscribe(i);
    if (!wanted) open_[i] = {};
  }
}

// Best effort, so that both kinds of publishers match.
void Detectors::Subscribe(Index detector) {
  const Detector& rule = course_.detectors[detector];
  Open& open = open_[detector];
  open.endpoints = std::make_unique<transport::Endpoints>(node_, name_space_);
  if (rule.kind == Detector::Kind::kSighting) {
    open.subscription = open.endpoints->Subscribe<msg::Sighting>(
        rule.topic,
        [this, detector](const msg::Sighting& sighting) {
          handlers_.on_sighting(detector, sighting);
        },
        transport::kSensorDataQos);
  } else if (rule.kind == Detector::Kind::kText) {
    open.subscription = open.endpoints->Subscribe<msg::String>(
        rule.topic,
        [this, detector](const msg::String& text) { handlers_.on_text(detector, text.data); },
        transport::kSensorDataQos);
  } else {
    open.subscription = open.endpoints->Subscribe<msg::YellowLines>(
        rule.topic,
        [this, detector](const msg::YellowLines& lines) { handlers_.on_lines(detector, lines); },
        transport::kSensorDataQos);
  }
  if (const Result<>& opened = open.endpoints->opened(); !opened) {
    handlers_.log("no subscription to " + rule.topic + ": " + opened.error().message);
  }
}

std::vector<std::string> Detectors::Missing() const {
  std::vector<std::string> missing;
  for (Index i = 0; i < open_.size(); ++i) {
    const bool found =
        open_[i].subscription != nullptr && open_[i].subscription->MatchedWriters() > 0;
    if (open_[i].endpoints && !found) missing.push_back(course_.detectors[i].topic);
  }
  return missing;
}

}  // namespace musher::race
