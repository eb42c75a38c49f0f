#pragma once
// What Cyclone logs in a process that has joined its domain.

#include <dds/ddsrt/log.h>

#include <string>
#include <string_view>

namespace musher::transport::dds {

// What makes two lines of Cyclone's log the same message: the text, for a packet that could not be
// sent without its address. There is one for each process of another host, several times a second.
std::string LogKey(std::string_view text);

// A log sink of Cyclone that writes each message at most once a minute: an unauthenticated
// participant retries for ever, and a lost interface fails for ever, with a line for each attempt.
// From any thread.
void LogOnceAMinute(void* unused, const dds_log_data_t* data);

}  // namespace musher::transport::dds
