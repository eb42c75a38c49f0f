#include "musher/modules/race/detectors.hpp"

#include <utility>

namespace musher::race {
namespace {

// Beside the sightings of musher-vision-manager; another node may publish none.
std::optional<std::string> DoubtTopicOf(const std::string& sightings) {
  constexpr std::string_view kLast = "/sighting";
  if (!sightings.ends_with(kLast)) return std::nullopt;
  return sightings.substr(0, sightings.size() - kLast.size()) + "/doubt";
}

}  // namespace

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

template <msg::Message M>
void Detectors::Subscribe(Index detector, std::function<void(const M&)> handler) {
  Open& open = open_[detector];
  open.subscription = open.endpoints->SubscribeEach<M>(
      course_.detectors[detector].topic,
      [this, detector, handler = std::move(handler)](const M& sample,
                                                     transport::EndpointId publisher) {
        if (open_[detector].publishers.Note(publisher)) handlers_.on_two_publishers(detector);
        handler(sample);
      },
      [](transport::EndpointId) {}, transport::kSensorDataQos);
}

// Best effort, so that both kinds of publishers match.
void Detectors::Subscribe(Index detector) {
  const Detector& rule = course_.detectors[detector];
  Open& open = open_[detector];
  open.endpoints = std::make_unique<transport::Endpoints>(node_, name_space_);
  if (rule.kind == Detector::Kind::kSighting) {
    Subscribe<msg::Sighting>(detector, [this, detector](const msg::Sighting& sighting) {
      handlers_.on_sighting(detector, sighting);
    });
    if (const auto topic = DoubtTopicOf(rule.topic)) {
      open.endpoints->Subscribe<msg::String>(
          *topic,
          [this, detector](const msg::String& why) { handlers_.on_doubt(detector, why.data); },
          transport::kSensorDataQos);
    }
  } else if (rule.kind == Detector::Kind::kText) {
    Subscribe<msg::String>(detector, [this, detector](const msg::String& text) {
      handlers_.on_text(detector, text.data);
    });
  } else {
    Subscribe<msg::YellowLines>(detector, [this, detector](const msg::YellowLines& lines) {
      handlers_.on_lines(detector, lines);
    });
  }
  if (const Result<>& opened = open.endpoints->opened(); !opened) {
    handlers_.log("no subscription to " + rule.topic + ": " + opened.error().message);
  }
}

std::vector<std::string> Detectors::TopicsWith(
    const std::function<bool(int publishers)>& fits) const {
  std::vector<std::string> topics;
  for (Index i = 0; i < open_.size(); ++i) {
    const transport::Subscription* subscription = open_[i].subscription;
    const int publishers = subscription == nullptr ? 0 : subscription->MatchedWriters();
    if (open_[i].endpoints && fits(publishers)) topics.push_back(course_.detectors[i].topic);
  }
  return topics;
}

std::vector<std::string> Detectors::Missing() const {
  return TopicsWith([](int publishers) { return publishers == 0; });
}

std::vector<std::string> Detectors::Doubled() const {
  return TopicsWith([](int publishers) { return publishers > 1; });
}

}  // namespace musher::race
