#pragma once
// Opens the domain of a process and takes part in it.

#include <memory>
#include <string>

#include "musher/lifecycle/result.hpp"
#include "musher/transport/dds/entity.hpp"

namespace musher::transport::dds {

// A participant and its part in the domain's configuration, which goes with the last participant.
struct Participant {
  std::shared_ptr<Entity> domain;
  Entity entity;
};

// Fails with Cyclone's own words. `settings` are Cyclone's XML; they are used by the first of the
// process in this domain and only when the user has not set CYCLONEDDS_URI. From any thread.
Result<Participant> OpenParticipant(int domain_id, const std::string& settings);

}  // namespace musher::transport::dds
