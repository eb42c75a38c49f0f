#pragma once
// Opens the domain of a process and takes part in it.

#include <memory>
#include <optional>
#include <string>

#include "musher/lifecycle/result.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/dds/entity.hpp"

namespace musher::transport::dds {

// The domain as this process knows it.
struct Domain {
  Entity entity;  // none where the user brings the configuration
  std::optional<Credentials> credentials;
};

// A participant and its part in the domain's configuration, which goes with the last participant.
struct Participant {
  std::shared_ptr<Domain> domain;
  Entity entity;
};

// Fails with Cyclone's own words. `settings` are Cyclone's XML; they are used by the first of the
// process in this domain and only when the user has not set CYCLONEDDS_URI. From any thread.
Result<Participant> OpenParticipant(int domain_id, const std::string& settings,
                                    const std::optional<Credentials>& credentials);

}  // namespace musher::transport::dds
