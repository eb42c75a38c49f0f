#pragma once
// Whether a topic has several publishers: a picture of one arrives between those of another. One
// that takes over, as after a restart, is alone; so is one beside a publisher that is silent. Pure.

#include <map>
#include <optional>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/transport/endpoint.hpp"

namespace musher::vision {

class PicturePublishers {
 public:
  static constexpr Duration kWithin = Milliseconds(2000);

  // A picture came from it.
  void Add(transport::EndpointId publisher, transport::ParticipantId participant, Time now);

  // Whether their pictures were mixed within the last kWithin.
  bool AreSeveral(Time now) const { return mixed_at_ && now - *mixed_at_ < kWithin; }
  // Since when all pictures are of one; nothing before the first.
  std::optional<Time> alone_since() const { return alone_since_; }
  // Of the publishers within the last kWithin, each once.
  std::vector<transport::ParticipantId> Participants() const;

 private:
  struct Latest {
    transport::ParticipantId participant;
    Time at;
  };
  std::map<transport::EndpointId, Latest> latest_;
  transport::EndpointId newest_;
  std::optional<Time> alone_since_, mixed_at_;
};

}  // namespace musher::vision
