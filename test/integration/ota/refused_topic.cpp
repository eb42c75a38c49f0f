// A service that its participant may not offer, for a process that preloads this library: the topic
// of set_state is refused once, by the process that can remove the file $MUSHER_REFUSES_WITH.

#include <dlfcn.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string_view>

extern "C" std::int32_t dds_create_topic_sertype(std::int32_t participant, const char* name,
                                                 void** type, const void* qos, const void* listener,
                                                 const void* parameters) {
  constexpr std::int32_t kNotAllowed = -13;               // DDS_RETCODE_NOT_ALLOWED_BY_SECURITY
  const char* file = std::getenv("MUSHER_REFUSES_WITH");  // NOLINT(concurrency-mt-unsafe)
  const bool refused = std::string_view(name).find("musher/set_state") != std::string_view::npos;
  if (refused && file != nullptr && unlink(file) == 0) return kNotAllowed;
  using Create = decltype(&dds_create_topic_sertype);
  static const auto create = reinterpret_cast<Create>(dlsym(RTLD_NEXT, "dds_create_topic_sertype"));
  return create(participant, name, type, qos, listener, parameters);
}
