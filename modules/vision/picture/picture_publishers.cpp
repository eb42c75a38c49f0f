#include "musher/modules/vision/picture/picture_publishers.hpp"

#include <algorithm>

namespace musher::vision {

void PicturePublishers::Add(transport::EndpointId publisher, transport::ParticipantId participant,
                            Time now) {
  std::erase_if(latest_, [now](const auto& each) { return now - each.second.at >= kWithin; });
  const bool is_known = latest_.contains(publisher);
  if (publisher != newest_ && is_known) mixed_at_ = now;
  if (publisher != newest_ || !alone_since_) alone_since_ = now;
  latest_[publisher] = {participant, now};
  newest_ = publisher;
}

std::vector<transport::ParticipantId> PicturePublishers::Participants() const {
  std::vector<transport::ParticipantId> all;
  for (const auto& [publisher, latest] : latest_) {
    if (std::ranges::find(all, latest.participant) == all.end()) all.push_back(latest.participant);
  }
  return all;
}

}  // namespace musher::vision
