#pragma once
// A DDS type whose samples are plain bytes: the encapsulation header and the CDR that follows it,
// as they are on the wire. Keyless, XCDR version 1. Cyclone has only its name.
//
// Threads: any; samples are immutable and counted by Cyclone.

#include <dds/dds.h>

#include <cstddef>
#include <span>
#include <string>

#include "musher/messages/cdr.hpp"

struct ddsi_serdata;
struct ddsi_sertype;

namespace musher::transport::dds {

// Makes the topic `name` of type `type_name` on the participant: a dds_entity_t, negative on
// failure.
dds_entity_t CreateRawTopic(dds_entity_t participant, const std::string& name,
                            const std::string& type_name);

// The sample that dds_write() expects for a raw topic; moves the bytes out.
struct RawSample {
  msg::Bytes& bytes;
};

// The bytes of a sample from dds_takecdr(), valid as long as the sample is held.
std::span<const std::byte> BytesOf(const ddsi_serdata* sample);

}  // namespace musher::transport::dds
